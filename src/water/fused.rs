// SPDX-License-Identifier: MIT OR Apache-2.0
//! `waves`, several steps a dispatch. Reads `glsl/water/fused.comp`.

use super::waves::{padded, plain};
use super::{check_heights, Error, Params, Surface, Walls};
use crate::{
    gpu::{self, Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};
use glam::UVec2;

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

    /// Columns and rows that it writes; none if the steps leave nothing of the tile.
    pub fn inner(&self) -> Option<UVec2> {
        let halo = UVec2::new(self.steps.next_multiple_of(4), self.steps);
        let inner = self.tile().checked_sub(2 * halo)?;
        (inner.min_element() > 0).then_some(inner)
    }

    /// Shared memory of a workgroup (bytes).
    pub fn shared_bytes(&self) -> u32 {
        self.group.element_product() * self.buffers * (8 * self.rows + 32)
    }

    /// Invocations that step `cells`.
    pub(super) fn threads(&self, cells: UVec2) -> UVec2 {
        let inner = self.inner().unwrap_or(UVec2::ONE); // `check` has refused tiles without an inside
        UVec2::new(cells.x.div_ceil(inner.x), cells.y.div_ceil(inner.y)) * self.group
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

/// Push constants of `glsl/water/fused.comp`.
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
    step: Kernel,
    tuning: FusedTuning,
    walls: Walls,
    has_land: bool,
    gpu: Gpu,
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
        tuning.check(gpu, "water.fused")?;
        let [x, y, lanes, rows, steps, buffers] = tuning.constants();
        let (land, drops) = (u32::from(has_land), u32::from(walls == Walls::Dropped && !has_land));
        let info = KernelInfo {
            name: c"water.fused",
            spv: shaders::WATER_FUSED_COMP,
            blocks: &["Height", "Velocity", "NewHeight", "NewVelocity"],
            constants: &[x, y, lanes, rows, steps, buffers, land, drops],
        };
        Ok(Self { step: Kernel::new::<FusedParams>(gpu, &info)?, tuning, walls, has_land, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet: [`FusedState::upload`].
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn state(&self, cells: UVec2) -> Result<FusedState> {
        let pitch = cells.x.next_multiple_of(4);
        let bytes = 4 * u64::from(pitch) * u64::from(cells.y);
        let buffer = |name: &str| Buffer::new(&self.gpu, name, bytes, Residence::Device);
        let heights = [buffer("water.height_m.0")?, buffer("water.height_m.1")?];
        let velocities = [buffer("water.velocity_mps.0")?, buffer("water.velocity_mps.1")?];
        let bind = |from: usize| {
            self.step.bind(&[
                ("Height", (&heights[from]).into()),
                ("Velocity", (&velocities[from]).into()),
                ("NewHeight", (&heights[1 - from]).into()),
                ("NewVelocity", (&velocities[1 - from]).into()),
            ])
        };
        let steps = [bind(0)?, bind(1)?];
        let Self { tuning, walls, has_land, .. } = *self;
        Ok(FusedState { heights, velocities, steps, current: 0, cells, pitch, tuning, walls, has_land })
    }
}

/// One basin, laid out as a [`WavesState`](super::WavesState), but heights and velocities both go to and fro: a tile needs
/// what was before around it.
pub struct FusedState {
    heights: [Buffer; 2],
    velocities: [Buffer; 2],
    steps: [Bound; 2],
    current: usize,
    cells: UVec2,
    pitch: u32,
    tuning: FusedTuning,
    walls: Walls,
    has_land: bool,
}

impl FusedState {
    /// Records `steps` steps, as few dispatches as the tuning allows, and the barriers between them. Submits nothing,
    /// waits for nothing, allocates nothing. The barriers from and to the rest of the frame are the caller's. Disturbances
    /// come between two calls; a first step from rest is a call of its own.
    ///
    /// # Panics
    /// If `params` are of another grid or of walls that the kernel was not built for.
    pub fn record(&mut self, rec: &mut Recorder<'_>, params: &Params, steps: u32) {
        assert_eq!(
            (params.cells, params.pitch, params.folded == 1),
            (self.cells, self.pitch, self.walls == Walls::Folded),
            "grid and walls of the parameters and of the state"
        );
        let threads = self.tuning.threads(self.cells);
        let mut left = steps;
        while left > 0 {
            let taken = left.min(self.tuning.steps);
            let params = FusedParams { water: *params, steps: taken };
            let bound = &self.steps[self.current];
            rec.span(c"water.fused", |rec| rec.dispatch(bound, [threads.x, threads.y, 1], &params));
            self.current = 1 - self.current;
            left -= taken;
            if left > 0 {
                rec.barrier(Fused::EXIT, Fused::ENTRY);
            }
        }
    }

    /// `f32` a column (m above rest): the surface after the steps recorded so far.
    pub fn height(&self) -> &Buffer {
        &self.heights[self.current]
    }

    /// `f32` a column (m/s): how fast it rises, half a step before the heights.
    pub fn velocity(&self) -> &Buffer {
        &self.velocities[self.current]
    }

    /// Columns from one row to the next.
    pub fn pitch(&self) -> u32 {
        self.pitch
    }

    /// The surface after the steps recorded so far, for drawing and disturbing.
    pub fn surface(&self) -> Surface<'_> {
        self.surfaces()[self.current]
    }

    /// The two between which the steps go to and fro.
    pub fn surfaces(&self) -> [Surface<'_>; 2] {
        [0, 1].map(|i| Surface {
            cells: self.cells,
            height_m: &self.heights[i],
            pitch: self.pitch,
            stride: 1,
        })
    }

    /// The velocities of each of [`FusedState::surfaces`], for [`Disturb::list_of`](super::Disturb::list_of).
    pub fn velocities(&self) -> [Option<&Buffer>; 2] {
        [0, 1].map(|i| Some(&self.velocities[i]))
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        4 * self.heights[0].bytes()
    }

    /// Sets heights (m above rest, [`LAND_M`](super::LAND_M) for land) and velocities (m/s), without padding.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite or the sizes differ, else the device's.
    pub fn upload(&self, gpu: &Gpu, height_m: &[f32], velocity_mps: &[f32]) -> Result<(), Error> {
        check_heights("height_m", height_m, self.cells, self.has_land)?;
        check_heights("velocity_mps", velocity_mps, self.cells, false)?;
        gpu.upload_to(self.height(), &padded(height_m, self.cells, self.pitch))?;
        gpu.upload_to(self.velocity(), &padded(velocity_mps, self.cells, self.pitch))?;
        Ok(())
    }

    /// Heights (m above rest) and velocities (m/s), without padding.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu) -> Result<(Vec<f32>, Vec<f32>)> {
        let read = |buffer| gpu.download(buffer).map(|all| plain(&all, self.cells, self.pitch));
        Ok((read(self.height())?, read(self.velocity())?))
    }
}
