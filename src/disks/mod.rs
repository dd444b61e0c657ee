// SPDX-License-Identifier: MIT OR Apache-2.0
//! Disks and spheres that collide elastically (Diligent Engine, tutorial 14, "Compute shader", whose method is kept as
//! [`List`] and [`Response::Seed`]).
//!
//! | kernel                  | reads                                  | writes                          | CPU twin                 |
//! | ----------------------- | -------------------------------------- | ------------------------------- | ------------------------ |
//! | `disks.travel`          | disks, starts, partners                | new disks, keys, counts         | `cpu::Disks::travel`     |
//! | `prims.reduce`, `.scan` | counts                                 | starts, counts                  | `cpu::Disks::sort`       |
//! | `disks.slot`            | keys, starts                           | slots                           | `cpu::Disks::sort`       |
//! | `disks.gather`          | slots, starts, new disks               | disks                           | `cpu::Disks::sort`       |
//! | `disks.contacts`        | disks, starts                          | partners, hits                  | `cpu::Disks::contacts`   |
//! | `disks.propose`         | disks, starts, partners                | partners                        | `cpu::Disks::propose`    |
//! | `disks.collide`         | disks, starts, partners                | disks, wakes, hits              | `cpu::Disks::collide`    |
//! | `disks.sweep`           | disks, starts                          | disks, hits                     | `cpu::Disks::settle`     |
//! | `disks.xpbd_*`          | disks, starts                          | disks, hits                     | `cpu::Disks::xpbd`       |
//! | `disks.list_*`          | records, heads, next                   | records, heads, next            | `cpu::Disks`             |
//!
//! A step of [`Sorted`] moves every disk, sorts all into cells of about one disk, and lets contacts respond:
//!
//! ```text
//! travel --B-- sums --B-- starts --B-- slot --B-- gather --B-- contacts                                    (seed)
//!                                                        --B-- sweep x 9 colours                           (gauss-seidel)
//!                                                        --B-- (propose --B-- collide --B--) x rounds      (matching)
//!                                          --B-- part x 9 --B-- derive --B-- bounce x 9 colours             (xpbd)
//! ```
//!
//! What a step leaves undone, the seed's response and overlaps to be parted, the next `travel` does on its way: no pass
//! is paid for it. [`Response::Matching`] is the default: every update is an exact collision of two bodies at the time at
//! which they met, so that energy and momentum hold by construction, and the pressure is that of hard disks.
//! [`Model::substeps`] says how far a step may go. The kernels for spheres have the same names with `_solid` after them.
//!
//! Left out: friction, rotation, restitution below 1, and shapes other than the box.

pub mod cpu;
pub mod draw;
pub mod edmd;
mod list;
mod model;
pub mod oracle;
mod sorted;
pub mod starts;

pub use crate::check::Invalid;
pub use list::{List, ListDisk, ListState};
pub use model::{Borders, Disk, Grid, Model, Response, Space, Stir};
pub use sorted::{Sorted, SortedState};

use crate::gpu;

/// Push constants: `DisksParams` in `glsl/disks/disks.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Params {
    /// The box, from the origin (m).
    pub size_m: [f32; 4],
    /// Along x, y and z.
    pub cells: [u32; 4],
    /// Along x, y and z (1/m): so that every pass finds a disk in the same cell, no matter how it divides.
    pub cells_per_m: [f32; 4],
    /// Along x, y and z (m/s^2), and the speed to which stirring may bring a disk (m/s).
    pub gravity_mps2: [f32; 4],
    /// x, y, z, and how far it reaches (m).
    pub stir_at_m: [f32; 4],
    /// (m/s^2); 0 if nothing is stirred.
    pub stir_mps2: f32,
    /// Step (s).
    pub dt_s: f32,
    /// How many.
    pub disks: u32,
    /// Of these, how many are in no cell.
    pub large: u32,
    /// Radius of the largest of the others (m).
    pub small_m: f32,
    /// Number of this step, from 1.
    pub step: u32,
    /// Of the cells that `disks.sweep` is at.
    pub color: u32,
    /// 1 in the first round of `disks.propose`.
    pub is_first: u32,
}

/// What can go wrong with a box.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Bad input.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The device's.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
}

impl Params {
    fn new(model: &Model, grid: &Grid, disks: &[Disk]) -> Self {
        let four = |v: glam::DVec3| v.as_vec3().extend(0.0).to_array();
        let stirred_mps = model.stirred_mps(disks) as f32;
        Self {
            size_m: four(model.size_m),
            cells: grid.cells.extend(0).to_array(),
            cells_per_m: four(grid.cells.as_dvec3() / model.size_m),
            gravity_mps2: model.gravity_mps2.as_vec3().extend(stirred_mps).to_array(),
            stir_at_m: [0.0; 4],
            stir_mps2: 0.0,
            dt_s: model.dt_s as f32,
            disks: disks.len() as u32,
            large: grid.large,
            small_m: grid.small_m as f32,
            step: 0,
            color: 0,
            is_first: 0,
        }
    }

    fn stirred(self, stir: Option<&Stir>) -> Self {
        stir.map_or(self, |stir| Self {
            stir_at_m: stir.at_m.as_vec3().extend(stir.radius_m as f32).to_array(),
            stir_mps2: stir.push_mps2 as f32,
            ..self
        })
    }
}

/// Invocations that reach `count` items, in rows of no more workgroups than every device takes.
fn spread(count: u64, group: u32) -> [u32; 3] {
    let row = u64::from(group) << 15;
    [count.min(row) as u32, count.div_ceil(row) as u32, 1]
}
