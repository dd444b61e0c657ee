// SPDX-License-Identifier: MIT OR Apache-2.0
//! Heightfield water: columns of water joined by virtual pipes (Zink, Pettineo and Hoxley, "Practical Rendering and
//! Computation with Direct3D 11", 2011, section 12.1; O'Brien and Hodgins, "Dynamic Simulation of Splashing Fluids",
//! 1995).
//!
//! | kernel                | reads                                 | writes                  | CPU twin                 |
//! | --------------------- | ------------------------------------- | ----------------------- | ------------------------ |
//! | `water.book`          | columns                               | new columns             | [`cpu::Book`]            |
//! | `water.waves`         | height, velocity                      | velocity, new height    | [`cpu::Waves`]           |
//! | `water.fused`         | height, velocity                      | new height and velocity | [`cpu::Waves`]           |
//! | `water.waves_f16`     | height, velocity                      | velocity, new height    |                          |
//! | `water.fused_f16`     | height, velocity                      | new height and velocity |                          |
//! | `water.pack`          | floats                                | halves                  |                          |
//! | `water.unpack`        | halves                                | floats                  |                          |
//! | `water.fourth`        | height, velocity                      | velocity, new height    | [`cpu_fourth::Fourth`]   |
//! | `water.pipes`         | height, flow                          | new height and flow     | [`cpu_pipes::Pipes`]     |
//! | `water.pipes_fused`   | height, flow                          | new height and flow     | [`cpu_pipes::Pipes`]     |
//! | `water.wet`           | ground, rise, flows                   | new rise, new flows     | [`cpu_wet::Depths`]      |
//! | `water.shallow`       | ground, rise, rise before, velocities | new rise and velocities | [`cpu_wet::Depths`]      |
//! | `water.absorb`        | height, velocity                      | height, velocity        | [`cpu_absorb::absorb`]   |
//! | `water.draught`       | height, poses                         | poses                   | [`cpu_bodies::draught`]  |
//! | `water.body`          | poses                                 | height                  | [`cpu_bodies::body`]     |
//! | `water.weigh`         | height, disturbances                  | disturbances, counters  | [`cpu_disturb::weigh`]   |
//! | `water.disturb`       | disturbances                          | height, velocity        | [`cpu_disturb::disturb`] |
//! | `water.splash`        | impacts, height                       | disturbances, counters  | [`cpu_splash::splash`]   |
//!
//! [`book`], [`waves`], [`fused`] and [`pipes`] solve the linear wave equation `h_tt + gamma h_t = c^2 laplace(h)` on a grid
//! of square columns in a closed
//! basin, `h` as deviation from rest (m). [`book`] stores the flow of four pipes a column, as the book does, and is there
//! to be read; [`waves`] sums the pipes before they are stored, which is exact on an even, wet bottom, and reads and
//! writes 16 bytes a column instead of 40 or more; [`fused`] does the same, several steps at a time. [`pipes`] keeps the
//! flows for whoever needs them, and with them the volume. Taking the new flow makes all a leapfrog: second order, with the
//! flow half a step behind, and stable up to [`Model::longest_stable_s`].
//!
//! They leave out advection and ground that falls dry: a trough deeper than the water is not physical there. [`wet`] steps
//! water over ground that floods and falls dry, [`shallow`] with advection as well, so that dam breaks and bores come out
//! right: [`depth`] says how both store a column, [`dam`] has the exact solutions that they are held against.

pub mod absorb;
pub mod bodies;
pub mod book;
pub mod cpu;
pub mod cpu_absorb;
pub mod cpu_bodies;
pub mod cpu_disturb;
pub mod cpu_fourth;
pub mod cpu_pipes;
pub mod cpu_splash;
pub mod cpu_wet;
pub mod dam;
pub mod depth;
pub mod disturb;
pub mod draw;
pub mod fourth;
pub mod fused;
pub mod halves;
pub mod oracle;
pub mod pipes;
pub mod planes;
pub mod shallow;
pub mod splash;
pub mod starts;
mod tiles;
pub mod waves;
pub mod wet;

pub use absorb::{Absorb, Absorbing, Borders};
pub use bodies::{Bodies, Body, BodyList, BodyParams};
pub use book::{Book, BookState};
pub use depth::{Columns, DepthModel, DepthParams, DepthState, Rain, Tier};
pub use disturb::{Counts, Disturb, DisturbParams, Disturbance, Disturbances};
pub use fourth::{Fourth, FourthParams, FourthState};
pub use fused::{Fused, FusedParams, FusedState, FusedTuning};
pub use halves::{Halves, HalvesState};
pub use pipes::{Pipes, PipesState, PipesTuning};
pub use planes::Planes;
pub use shallow::Shallow;
pub use splash::{Splash, SplashCounts, SplashParams, Splashing};
pub use waves::{Tuning, Waves, WavesState};
pub use wet::Wet;

pub use crate::check::Invalid;
use crate::{
    check::{hold, positive},
    gpu::{self, Buffer},
};
use glam::UVec2;

/// Height of a column that is land, bit for bit: `LAND_M` in `glsl/water/land.glsl`.
pub const LAND_M: f32 = -1.0e30;

/// What a wall does to the diagonal pipes that it cuts off.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Walls {
    /// Their weight goes to the pipe along the wall (the wall is a mirror): second order.
    Folded,
    /// They are left out, as the book does: first order, and waves bend at walls.
    Dropped,
}

/// A basin and how it is stepped, in physical units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Columns along x and z.
    pub cells: UVec2,
    /// Edge of a column (m).
    pub cell_m: f64,
    /// Speed of long waves, `sqrt(g depth)` (m/s).
    pub speed_mps: f64,
    /// Rate at which flow dies away (1/s); a wave dies away half as fast.
    pub damping_per_s: f64,
    /// Weight of a diagonal pipe, 0 to 1: 0 is the 5-point stencil, 1/4 isotropic, 1 the book's.
    pub diagonal: f64,
    /// What a wall does to diagonal pipes.
    pub walls: Walls,
    /// Step (s), at most [`Model::longest_stable_s`].
    pub dt_s: f64,
}

/// Push constants of the water kernels: `WaterParams` in `glsl/water/water.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Params {
    /// Size of the grid.
    pub cells: UVec2,
    /// Cells from one row to the next.
    pub pitch: u32,
    /// Step (s).
    pub dt_s: f32,
    /// [`Model::pull`] (1/s).
    pub pull: f32,
    /// `exp(-gamma dt)`.
    pub keep: f32,
    /// Weight of a diagonal pipe.
    pub diagonal: f32,
    /// 1 if walls fold diagonal pipes, 0 if they drop them.
    pub folded: u32,
}

impl Model {
    /// Largest grid (columns along one axis).
    pub const MOST_CELLS: u32 = 16384;

    /// Courant number `c dt / dx` of the longest stable step: `2 / sqrt(max(4, 8 / (1 + 2 w)))`. It holds for every
    /// shape of shore: each block of 2 x 2 columns, with its share of the pipes, is bounded by the same eigenvalue,
    /// whichever of the four are land.
    pub fn courant_limit(&self) -> f64 {
        2.0 / f64::max(4.0, 8.0 / (1.0 + 2.0 * self.diagonal)).sqrt()
    }

    /// Beyond it the shortest waves grow at every step (s).
    pub fn longest_stable_s(&self) -> f64 {
        self.courant_limit() * self.cell_m / self.speed_mps
    }

    /// Courant number `c dt / dx` of the chosen step.
    pub fn courant(&self) -> f64 {
        self.speed_mps * self.dt_s / self.cell_m
    }

    /// The model with a step of `courant` cells.
    pub fn with_courant(self, courant: f64) -> Self {
        Self { dt_s: courant * self.cell_m / self.speed_mps, ..self }
    }

    /// # Errors
    /// The first parameter that is out of range.
    pub fn check(&self) -> Result<(), Invalid> {
        self.check_below(self.longest_stable_s())
    }

    /// [`Model::check`] with another longest stable step (s).
    fn check_below(&self, limit: f64) -> Result<(), Invalid> {
        check_cells(self.cells)?;
        positive("cell_m", self.cell_m)?;
        positive("speed_mps", self.speed_mps)?;
        positive("dt_s", self.dt_s)?;
        hold(
            (0.0..=1e6).contains(&self.damping_per_s),
            "damping_per_s",
            self.damping_per_s,
            "0 to 1e6 (1/s)",
        )?;
        hold((0.0..=1.0).contains(&self.diagonal), "diagonal", self.diagonal, "0 to 1")?;
        let is_crossed = (self.pull() as f32).is_normal();
        hold(is_crossed, "cell_m", self.cell_m, "a size that waves can cross in an f32 of steps")?;
        // A step computed as exactly the limit may come out above it by rounding.
        let allowed = format!(
            "at most {limit:.6} s, the longest stable step of {} m cells and waves of {:.4} m/s",
            self.cell_m, self.speed_mps
        );
        hold(self.dt_s <= limit * (1.0 + 1e-12), "dt_s", self.dt_s, allowed)
    }

    /// `c^2 dt / (dx^2 (1 + 2 w)) exp(gamma dt / 2)` (1/s). The last factor undoes half of the damping that a step does
    /// to its own kick: without it damped waves are slower, the more so the longer the step.
    pub fn pull(&self) -> f64 {
        let stencil = self.cell_m.powi(2) * (1.0 + 2.0 * self.diagonal);
        self.speed_mps.powi(2) * self.dt_s / stencil * (0.5 * self.damping_per_s * self.dt_s).exp()
    }

    /// Push constants of a state with `pitch` cells from row to row.
    pub fn params(&self, pitch: u32) -> Params {
        Params {
            cells: self.cells,
            pitch,
            dt_s: self.dt_s as f32,
            pull: self.pull() as f32,
            keep: (-self.damping_per_s * self.dt_s).exp() as f32,
            diagonal: self.diagonal as f32,
            folded: u32::from(self.walls == Walls::Folded),
        }
    }
}

impl Params {
    /// For the first step from a start at rest: half the pull brings the flow to the middle of the step, where the
    /// leapfrog wants it. Without it the start counts as half a step late, which is a first-order error.
    pub fn first_from_rest(self) -> Self {
        Self { pull: 0.5 * self.pull, ..self }
    }
}

/// Where the heights of a surface lie: all that drawing and disturbing need to know of a model.
#[derive(Clone, Copy)]
pub struct Surface<'a> {
    /// Size of the grid.
    pub cells: UVec2,
    /// `f32` (m above rest), [`LAND_M`] where there is none; others may lie between.
    pub height_m: &'a Buffer,
    /// Columns from one row to the next.
    pub pitch: u32,
    /// Floats from one column to the next.
    pub stride: u32,
}

/// What can go wrong with a basin.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Bad input.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The device's.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
}

fn check_cells(cells: UVec2) -> Result<(), Invalid> {
    let most = Model::MOST_CELLS;
    let fits = cells.min_element() > 0 && cells.max_element() <= most;
    hold(fits, "cells", cells, format!("1 to {most} along each axis"))
}

/// Refuses numbers that would spread through a basin: one a column, finite, and not absurd.
fn check_heights(key: &'static str, numbers: &[f32], cells: UVec2, allows_land: bool) -> Result<(), Invalid> {
    let invalid = |value: String, allowed: String| Err(Invalid { key, value, allowed });
    if numbers.len() != cells.as_usizevec2().element_product() {
        return invalid(format!("{} numbers", numbers.len()), format!("one for each of {cells} cells"));
    }
    match numbers.iter().position(|h| !(h.abs() < 1e6 || (allows_land && *h == LAND_M))) {
        Some(i) => invalid(
            format!("{} in cell {i}", numbers[i]),
            "within 1e6, and land only where the kernel is built for it".into(),
        ),
        None => Ok(()),
    }
}
