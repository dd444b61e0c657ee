// SPDX-License-Identifier: MIT OR Apache-2.0
//! `waves`, several steps a dispatch. Reads `glsl/water/fused_pass.glsl`.

use super::{
    planes::{in_blocks, Planes, Rates},
    tiles::{TileKernels, Tiles},
    Error, Params, Walls,
};
use crate::{
    gpu::{self, Access, Buffer, Gpu, Recorder, Result},
    shaders,
};
use glam::UVec2;
use std::ops::Deref;

/// How the grid is cut into tiles. It changes the speed, never the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FusedTuning {
    /// Workgroup, in invocations: a tile is `4 group.x` columns wide and `group.y rows` high.
    pub group: UVec2,
    /// Rows that an invocation owns, at most 31; it is four columns wide.
    pub rows: u32,
    /// Most steps a dispatch: as many rows and columns on each side of a tile are computed for it alone.
    pub steps: u32,
    /// Copies of what is shared: 2 save one of two barriers a step.
    pub buffers: u32,
}

impl FusedTuning {
    /// The fastest of `whitecap bench --tune` (docs/results). A small grid is in the GPU's cache: there it is dispatches
    /// that cost, and more steps of each pay although more of a tile is computed twice.
    pub fn for_grid(gpu: &Gpu, cells: UVec2) -> Self {
        let is_cached = cells.as_u64vec2().element_product() <= 1 << 21;
        match is_cached && !gpu.adapter().is_software() {
            true => Self { group: UVec2::new(32, 8), rows: 8, steps: 12, buffers: 1 },
            false => Self { group: UVec2::new(16, 8), rows: 8, steps: 8, buffers: 1 },
        }
    }

    /// The same for `water.pipes_fused`.
    pub fn for_pipes(gpu: &Gpu, _cells: UVec2) -> Self {
        let wide = if gpu.adapter().is_software() { 16 } else { 32 };
        Self { group: UVec2::new(wide, 8), rows: 8, steps: 8, buffers: 1 }
    }

    /// Columns and rows that a workgroup loads.
    pub fn tile(&self) -> UVec2 {
        self.group * UVec2::new(4, self.rows)
    }

    /// Columns and rows on each side that it computes for itself alone.
    pub(super) fn halo(&self) -> UVec2 {
        UVec2::new(self.steps.next_multiple_of(4), self.steps)
    }

    /// Columns and rows that it writes; none if the steps leave nothing of the tile.
    pub fn inner(&self) -> Option<UVec2> {
        let inner = self.tile().checked_sub(2 * self.halo())?;
        (inner.min_element() > 0).then_some(inner)
    }

    /// Shared memory of a workgroup (bytes).
    pub fn shared_bytes(&self) -> u32 {
        self.group.element_product() * self.buffers * (8 * self.rows + 32)
    }

    /// Tiles of a grid.
    pub(super) fn groups(&self, cells: UVec2) -> UVec2 {
        let inner = self.inner().unwrap_or(UVec2::ONE); // `check` has refused tiles without an inside
        UVec2::new(cells.x.div_ceil(inner.x), cells.y.div_ceil(inner.y))
    }

    /// The first specialization constants of every kernel with such tiles.
    pub(super) fn constants(&self) -> [u32; 6] {
        [self.group.x, self.group.y, self.group.element_product(), self.rows, self.steps, self.buffers]
    }

    pub(super) fn check(&self, gpu: &Gpu, kernel: &str) -> Result<()> {
        let refused = |what| Err(gpu::Error::Interface { kernel: kernel.into(), what });
        let allowed = gpu.limits().max_compute_shared_memory_size;
        match () {
            () if !(1..=31).contains(&self.rows) => {
                refused(format!("{} rows: allowed are 1 to 31", self.rows))
            }
            () if !(1..=2).contains(&self.buffers) => refused(format!("{} buffers: 1 or 2", self.buffers)),
            () if self.steps == 0 || self.inner().is_none() => {
                refused(format!("{} steps leave nothing of a tile of {}", self.steps, self.tile()))
            }
            () if self.shared_bytes() > allowed => {
                let needed = self.shared_bytes();
                refused(format!("{needed} bytes of shared memory, and {} allows {allowed}", gpu.name()))
            }
            () => Ok(()),
        }
    }
}

/// Push constants of `glsl/water/fused_pass.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct FusedParams {
    /// As of every water kernel.
    pub water: Params,
    /// Steps of this dispatch.
    pub steps: u32,
}

/// The kernel. It holds no basin, so one steps any number of them.
pub struct Fused {
    kernels: TileKernels,
    walls: Walls,
}

impl Fused {
    /// What the state must be visible to before [`FusedState::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`FusedState::record`] touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// For basins with these walls; `has_land` says whether they may have land in them.
    ///
    /// # Errors
    /// If the device does not take the tuning.
    pub fn new(gpu: &Gpu, tuning: FusedTuning, walls: Walls, has_land: bool) -> Result<Self> {
        let blocks = ["Height", "Velocity", "NewHeight", "NewVelocity"];
        let drops = walls == Walls::Dropped && !has_land;
        let what = (c"water.fused", shaders::WATER_FUSED_COMP);
        Ok(Self { kernels: TileKernels::new(gpu, what, blocks, tuning, has_land, drops)?, walls })
    }

    /// A basin whose memory is not set yet: [`FusedState::upload`].
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn state(&self, cells: UVec2) -> Result<FusedState> {
        let rates = Rates {
            names: ["water.velocity_mps.0", "water.velocity_mps.1"],
            blocks: &["Velocity", "NewVelocity"],
            planes: 1,
            bytes: 4,
        };
        let (planes, tiles) = self.kernels.state(cells, &rates)?;
        Ok(FusedState { planes, tiles, walls: self.walls })
    }
}

/// One basin: as a [`WavesState`](super::WavesState), but heights and velocities both go to and fro: a tile needs what was
/// before around it.
pub struct FusedState {
    planes: Planes,
    tiles: Tiles,
    walls: Walls,
}

impl FusedState {
    /// Records `steps` steps, as few dispatches as the tuning allows, and the barriers between them. Submits nothing,
    /// waits for nothing, allocates nothing. The barriers from and to the rest of the frame are the caller's. Disturbances
    /// come between two calls; a first step from rest is a call of its own.
    ///
    /// # Panics
    /// If `params` are of another grid or of walls that the kernel was not built for.
    pub fn record(&mut self, rec: &mut Recorder<'_>, params: &Params, steps: u32) {
        let walls = if params.folded == 1 { Walls::Folded } else { Walls::Dropped };
        assert_eq!(walls, self.walls, "walls of the parameters and of the state");
        in_blocks(rec, steps, self.tiles.steps(), |rec, steps| {
            self.tiles.record(rec, &mut self.planes, &FusedParams { water: *params, steps });
        });
    }

    /// `f32` a column (m/s): how fast it rises, half a step before the heights.
    pub fn velocity(&self) -> &Buffer {
        self.planes.rate()
    }

    /// The velocities of each of [`Planes::surfaces`], for [`Disturb::list_of`](super::Disturb::list_of).
    pub fn velocities(&self) -> [Option<&Buffer>; 2] {
        self.planes.rates()
    }

    /// Sets heights (m above rest, [`LAND_M`](super::LAND_M) for land) and velocities (m/s), without padding.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite or the sizes differ, else the device's.
    pub fn upload(&self, gpu: &Gpu, height_m: &[f32], velocity_mps: &[f32]) -> Result<(), Error> {
        self.planes.upload_moving(gpu, height_m, velocity_mps)?;
        Ok(self.tiles.set(gpu, height_m)?)
    }

    /// Heights (m above rest) and velocities (m/s), without padding.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu) -> Result<(Vec<f32>, Vec<f32>)> {
        self.planes.download_moving(gpu)
    }
}

#[cfg(test)]
impl FusedState {
    /// Every number that the next step writes is `with` before it.
    pub(super) fn spoil(&self, gpu: &Gpu, with: f32) {
        self.planes.spoil(gpu, with);
    }

    /// A step of the tiles of one list alone: of open water, or with a shore.
    pub(super) fn record_list(&mut self, rec: &mut Recorder<'_>, of: usize, params: &FusedParams) {
        self.tiles.record_list(rec, &mut self.planes, of, params);
    }
}

impl Deref for FusedState {
    type Target = Planes;
    fn deref(&self) -> &Planes {
        &self.planes
    }
}
