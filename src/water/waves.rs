// SPDX-License-Identifier: MIT OR Apache-2.0
//! `waves`: two floats a column, one step a dispatch. Reads `glsl/water/waves_pass.glsl`.

use super::{
    planes::{Planes, Rates},
    Error, Params,
};
use crate::{
    gpu::{Access, Buffer, Gpu, Kernel, KernelInfo, Recorder, Result},
    shaders,
};
use glam::UVec2;
use std::{ffi::CStr, ops::Deref};

/// How the grid is cut up. It changes the speed, never the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tuning {
    /// Workgroup, in invocations.
    pub group: UVec2,
    /// Rows that an invocation walks down; it is four columns wide.
    pub rows: u32,
}

impl Tuning {
    /// The fastest of `whitecap bench --tune` (docs/results): wide groups, and as few loads as leave every lane of the
    /// device something to do.
    pub fn for_grid(gpu: &Gpu, cells: UVec2) -> Self {
        let (group, rows, fewest) = match gpu.adapter().is_software() {
            true => (UVec2::new(128, 1), 16, 1),
            false => (UVec2::new(128, 2), 2, 1 << 16),
        };
        let fours = u64::from(cells.x.div_ceil(4));
        Self { group, rows: (u64::from(cells.y) * fours / fewest).clamp(1, rows) as u32 }
    }
}

/// The kernel. It holds no basin, so one steps any number of them.
pub struct Waves {
    step: Kernel,
    rows: u32,
    has_land: bool,
    gpu: Gpu,
}

impl Waves {
    /// What the state must be visible to before [`WavesState::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`WavesState::record`] touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// `has_land` says whether basins may have land in them: without, nothing looks for it.
    ///
    /// # Errors
    /// If the device does not take the tuning.
    ///
    /// # Panics
    /// If an invocation is to walk down no rows.
    pub fn new(gpu: &Gpu, tuning: Tuning, has_land: bool) -> Result<Self> {
        assert!(tuning.rows > 0, "{tuning:?}");
        let info = KernelInfo {
            name: c"water.waves",
            spv: shaders::WATER_WAVES_COMP,
            blocks: &["Height", "Velocity", "NewHeight"],
            constants: &[tuning.group.x, tuning.group.y, tuning.rows, u32::from(has_land)],
        };
        Ok(Self { step: Kernel::new::<Params>(gpu, &info)?, rows: tuning.rows, has_land, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet: [`WavesState::upload`], or write [`Planes::height`] and
    /// [`WavesState::velocity`] as a caller likes.
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    ///
    /// # Panics
    /// If there are no cells.
    pub fn state(&self, cells: UVec2) -> Result<WavesState> {
        WavesState::of(&self.step, &self.gpu, cells, self.rows, self.has_land)
    }
}

/// One basin: a plane of heights, one of velocities.
pub struct WavesState {
    planes: Planes,
    rows: u32,
}

impl WavesState {
    /// For `step`, whose blocks are `Height`, `Velocity` and `NewHeight`.
    pub(super) fn of(step: &Kernel, gpu: &Gpu, cells: UVec2, rows: u32, has_land: bool) -> Result<Self> {
        let rates = Rates { names: ["water.velocity_mps", ""], blocks: &["Velocity"], planes: 1, bytes: 4 };
        Ok(Self { planes: Planes::new(gpu, &[(step, None)], cells, &rates, has_land)?, rows })
    }

    /// Records one step. Submits nothing, waits for nothing, allocates nothing. The barriers from and to the rest of the
    /// frame are the caller's: from [`Waves::EXIT`] to [`Waves::ENTRY`] where another step follows.
    ///
    /// # Panics
    /// If `params` are of another grid.
    pub fn record(&mut self, rec: &mut Recorder<'_>, params: &Params) {
        self.record_as(rec, c"water.waves", (params.cells, params.pitch), params);
    }

    /// One step of whichever kernel the state was made for.
    pub(super) fn record_as<P: bytemuck::Pod>(
        &mut self,
        rec: &mut Recorder<'_>,
        name: &'static CStr,
        grid: (UVec2, u32),
        params: &P,
    ) {
        let threads = UVec2::new(self.pitch() / 4, self.cells().y.div_ceil(self.rows));
        self.planes.dispatch(rec, name, threads, grid, params);
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
        self.planes.upload_moving(gpu, height_m, velocity_mps)
    }

    /// Heights (m above rest) and velocities (m/s), without padding.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu) -> Result<(Vec<f32>, Vec<f32>)> {
        self.planes.download_moving(gpu)
    }
}

impl Deref for WavesState {
    type Target = Planes;
    fn deref(&self) -> &Planes {
        &self.planes
    }
}
