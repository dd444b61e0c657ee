// SPDX-License-Identifier: MIT OR Apache-2.0
//! The scene in a volume: which cells of a grid its triangles pass through, and up to two planes of them in each, with the
//! velocity of the surface. The source is the sample "AdvancedParticles" of the DirectX SDK (2007), whose way is kept as
//! [`Layered`]; the default, [`Conservative`], loses no wall.
//!
//! | kernel                  | reads                                        | writes                     | CPU twin                                  |
//! | ----------------------- | -------------------------------------------- | -------------------------- | ----------------------------------------- |
//! | `volume.begin`          | keys of still meshes                         | keys, list                 |                                           |
//! | `volume.mark`           | places, triangles                            | first keys, normals, list  | [`cpu::mark`]                             |
//! | `volume.mark_large`     | places, triangles, list                      | first keys                 | [`cpu::mark`]                             |
//! | `volume.second`         | places, triangles, normals, first keys       | second keys                | [`Voxels::second`](cpu::Voxels::second)   |
//! | `volume.second_large`   | the same, list                               | second keys                | [`Voxels::second`](cpu::Voxels::second)   |
//! | `volume.extend`         | places, triangles, normals, keys             | extents                    | [`Voxels::extents`](cpu::Voxels::extents) |
//! | `volume.extend_large`   | the same, list                               | extents                    | [`Voxels::extents`](cpu::Voxels::extents) |
//! | `volume.keep`           | keys, extents                                | those of still meshes      |                                           |
//! | `volume.resolve`        | places, triangles, keys, extents             | cells                      | [`Voxels::plane`](cpu::Voxels::plane)     |
//! | `volume.resolve_slices` | images that `volume.slices` drew             | cells                      |                                           |
//! | `volume.resolve_once`   | places, triangles, keys of `volume.once`     | cells                      | [`cpu::texel`]                            |
//!
//! All three fill the same [`Cells`](crate::cells::Cells):
//!
//! ```text
//! conservative   begin --B-- mark, mark_large --B-- second, second_large --B-- extend, extend_large --B-- resolve
//! layered        slices (drawn once for each layer, clipped to it) --B-- resolve_slices
//! one-pass       once (drawn once, each fragment finds its layer) --B-- resolve_once
//! ```
//!
//! Rasterizing samples the middle of a texel from one direction: what is steep to it loses cells, and a vertical wall has
//! none. Compute asks of every cell that a triangle may touch whether it does. The nearest triangle of a cell wins by a
//! minimum of integer keys, so the order of threads decides nothing: two runs are equal to the bit.
//!
//! Left out: the inside of closed meshes, and more than two planes a cell: where three faces of a box meet in a cell, it
//! knows two of them.

mod conservative;
pub mod cpu;
mod layered;
mod once;

pub use crate::mesh::{Body, Meshes, MeshesError, Part};
pub use conservative::{Conservative, Counts};
pub use layered::{Layered, Router};
pub use once::Once;

use crate::{cells::Grid, gpu};

/// Which way most particles go, for what is drawn: of several surfaces in a cell, the one that they meet first is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// +x.
    AlongX,
    /// +y.
    AlongY,
    /// +z.
    AlongZ,
    /// -x.
    DownX,
    /// -y: the seed's, as its particles fall.
    DownY,
    /// -z.
    DownZ,
}

impl Way {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::AlongX, Self::AlongY, Self::AlongZ, Self::DownX, Self::DownY, Self::DownZ];

    /// The axis that slices lie across.
    pub fn axis(self) -> usize {
        self as usize % 3
    }

    fn word(self) -> u32 {
        self as u32
    }

    /// Columns, rows and slices.
    fn turned(self, cells: [u32; 3]) -> [u32; 3] {
        let axis = self.axis();
        [cells[(axis + 1) % 3], cells[(axis + 2) % 3], cells[axis]]
    }
}

/// Push constants of every pass: `VolumeParams` in `glsl/volume/params.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct VolumeParams {
    /// The cells.
    pub grid: Grid,
    /// First of the triangles at hand.
    pub first: u32,
    /// Triangles at hand.
    pub triangles: u32,
    /// Of a key, that say which triangle.
    pub bits: u32,
    /// 1 to look only at cells that are not the still meshes' own: `second` by their first plane, `extend` by both.
    pub only_changed: u32,
    /// Most workgroups that a large triangle is shared by.
    pub rows: u32,
    /// That most particles go, for what is drawn: an axis, plus 3 if down it.
    pub way: u32,
}

impl VolumeParams {
    fn new(grid: Grid, meshes: &Meshes) -> Self {
        let [x, y, z] = grid.cells;
        let columns = (x * y).max(y * z).max(z * x);
        Self {
            grid: Grid { mesh_triangles: meshes.count(), ..grid },
            first: 0,
            triangles: meshes.count(),
            bits: cpu::key_bits(meshes.count()),
            only_changed: 0,
            rows: columns.div_ceil(1024).clamp(1, 64),
            way: 0,
        }
    }
}

/// Invocations that reach `count` items, in rows of no more workgroups than every device takes.
fn spread(count: u32, group: u32) -> [u32; 3] {
    let row = group << 15;
    [count.min(row), count.div_ceil(row), 1]
}

/// Where a kernel's source is, and which blocks it has.
fn kernel(gpu: &gpu::Gpu, name: &std::ffi::CStr, spv: &[u8], blocks: &[&str]) -> gpu::Result<gpu::Kernel> {
    gpu::Kernel::new::<VolumeParams>(gpu, &gpu::KernelInfo { name, spv, blocks, constants: &[] })
}
