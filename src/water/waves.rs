// SPDX-License-Identifier: MIT OR Apache-2.0
//! `waves`: two floats a column, one step a dispatch. Reads `glsl/water/waves.comp`.

use super::{check_heights, Error, Params, Surface};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};
use glam::UVec2;
use std::ffi::CStr;

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

    /// A basin whose memory is not set yet: [`WavesState::upload`], or write [`WavesState::height`] and
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

/// One basin. Row by row, rows padded to a multiple of four columns: column `(x, y)` is at `y * pitch + x`.
pub struct WavesState {
    heights: [Buffer; 2],
    velocity: Buffer,
    steps: [Bound; 2],
    current: usize,
    cells: UVec2,
    pitch: u32,
    rows: u32,
    has_land: bool,
}

impl WavesState {
    /// For `step`, whose blocks are `Height`, `Velocity` and `NewHeight`.
    pub(super) fn of(step: &Kernel, gpu: &Gpu, cells: UVec2, rows: u32, has_land: bool) -> Result<Self> {
        let pitch = cells.x.next_multiple_of(4);
        let bytes = 4 * u64::from(pitch) * u64::from(cells.y);
        let buffer = |name: &str| Buffer::new(gpu, name, bytes, Residence::Device);
        let heights = [buffer("water.height_m.0")?, buffer("water.height_m.1")?];
        let velocity = buffer("water.velocity_mps")?;
        let bind = |from: usize| {
            step.bind(&[
                ("Height", (&heights[from]).into()),
                ("Velocity", (&velocity).into()),
                ("NewHeight", (&heights[1 - from]).into()),
            ])
        };
        let steps = [bind(0)?, bind(1)?];
        Ok(Self { heights, velocity, steps, current: 0, cells, pitch, rows, has_land })
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
        assert_eq!(grid, (self.cells, self.pitch), "grid of the parameters and of the state");
        let threads = [self.pitch / 4, self.cells.y.div_ceil(self.rows), 1];
        rec.span(name, |rec| rec.dispatch(&self.steps[self.current], threads, params));
        self.current = 1 - self.current;
    }

    /// `f32` a column (m above rest): the surface after the steps recorded so far.
    pub fn height(&self) -> &Buffer {
        &self.heights[self.current]
    }

    /// `f32` a column (m/s): how fast it rises, half a step before the heights.
    pub fn velocity(&self) -> &Buffer {
        &self.velocity
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

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        3 * self.velocity.bytes()
    }

    /// Sets heights (m above rest, [`LAND_M`](super::LAND_M) for land) and velocities (m/s), without padding.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite or the sizes differ, else the device's.
    pub fn upload(&self, gpu: &Gpu, height_m: &[f32], velocity_mps: &[f32]) -> Result<(), Error> {
        check_heights("height_m", height_m, self.cells, self.has_land)?;
        check_heights("velocity_mps", velocity_mps, self.cells, false)?;
        gpu.upload_to(self.height(), &padded(height_m, self.cells, self.pitch))?;
        gpu.upload_to(&self.velocity, &padded(velocity_mps, self.cells, self.pitch))?;
        Ok(())
    }

    /// Heights (m above rest) and velocities (m/s), without padding.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu) -> Result<(Vec<f32>, Vec<f32>)> {
        let read = |buffer| gpu.download(buffer).map(|all| plain(&all, self.cells, self.pitch));
        Ok((read(self.height())?, read(&self.velocity)?))
    }
}

/// Rows of `cells.x` numbers, each filled up to `pitch`.
pub(super) fn padded(plain: &[f32], cells: UVec2, pitch: u32) -> Vec<f32> {
    let mut padded = vec![0.0; pitch as usize * cells.y as usize];
    let rows = plain.chunks_exact(cells.x as usize);
    for (to, from) in padded.chunks_exact_mut(pitch as usize).zip(rows) {
        to[..from.len()].copy_from_slice(from);
    }
    padded
}

/// The inverse of [`padded`].
pub(super) fn plain(padded: &[f32], cells: UVec2, pitch: u32) -> Vec<f32> {
    padded.chunks_exact(pitch as usize).flat_map(|row| &row[..cells.x as usize]).copied().collect()
}
