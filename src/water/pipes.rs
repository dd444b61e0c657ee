// SPDX-License-Identifier: MIT OR Apache-2.0
//! `pipes`: three or five floats a column, for whoever needs the flows. Reads `glsl/water/pipes.comp` and
//! `glsl/water/pipes_fused.comp`.

use super::waves::{padded, plain};
use super::{book::Column, check_heights, Error, FusedParams, FusedTuning, Params, Surface, Tuning};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};
use glam::UVec2;

/// How many steps a dispatch takes, and how the grid is cut up. It changes the speed, never the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PipesTuning {
    /// `water.pipes`: one step, no shared memory.
    OneStep(Tuning),
    /// `water.pipes_fused`: several steps, in tiles.
    Fused(FusedTuning),
}

impl PipesTuning {
    /// The fastest of `whitecap bench --tune` (docs/results).
    pub fn for_grid(gpu: &Gpu, cells: UVec2) -> Self {
        Self::Fused(FusedTuning::for_pipes(gpu, cells))
    }

    /// Most steps a dispatch.
    pub fn steps(&self) -> u32 {
        match self {
            Self::OneStep(_) => 1,
            Self::Fused(tuning) => tuning.steps,
        }
    }

    /// Invocations that step `cells`.
    fn threads(&self, cells: UVec2) -> UVec2 {
        match self {
            Self::OneStep(tuning) => UVec2::new(cells.x.div_ceil(4), cells.y.div_ceil(tuning.rows)),
            Self::Fused(tuning) => tuning.threads(cells),
        }
    }
}

/// The kernel. It holds no basin, so one steps any number of them.
pub struct Pipes {
    step: Kernel,
    tuning: PipesTuning,
    has_diagonals: bool,
    has_land: bool,
    gpu: Gpu,
}

impl Pipes {
    /// What the state must be visible to before [`PipesState::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`PipesState::record`] touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// `has_diagonals` says whether models have diagonal pipes (two flows more a column), `has_land` whether basins may
    /// have land in them.
    ///
    /// # Errors
    /// If the device does not take the tuning.
    pub fn new(gpu: &Gpu, tuning: PipesTuning, has_diagonals: bool, has_land: bool) -> Result<Self> {
        let blocks = &["Height", "Flow", "NewHeight", "NewFlow"];
        let (land, diagonals) = (u32::from(has_land), u32::from(has_diagonals));
        let step = match tuning {
            PipesTuning::OneStep(Tuning { group, rows }) => {
                let info = KernelInfo {
                    name: c"water.pipes",
                    spv: shaders::WATER_PIPES_COMP,
                    blocks,
                    constants: &[group.x, group.y, rows, land, diagonals],
                };
                Kernel::new::<Params>(gpu, &info)?
            }
            PipesTuning::Fused(tuning) => {
                tuning.check(gpu, "water.pipes_fused")?;
                let [x, y, lanes, rows, steps, buffers] = tuning.constants();
                let info = KernelInfo {
                    name: c"water.pipes_fused",
                    spv: shaders::WATER_PIPES_FUSED_COMP,
                    blocks,
                    constants: &[x, y, lanes, rows, steps, buffers, land, diagonals],
                };
                Kernel::new::<FusedParams>(gpu, &info)?
            }
        };
        Ok(Self { step, tuning, has_diagonals, has_land, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet: [`PipesState::upload`].
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn state(&self, cells: UVec2) -> Result<PipesState> {
        let pitch = cells.x.next_multiple_of(4);
        let bytes = 4 * u64::from(pitch) * u64::from(cells.y);
        let planes = if self.has_diagonals { 4 } else { 2 };
        let buffer = |name: &str, bytes: u64| Buffer::new(&self.gpu, name, bytes, Residence::Device);
        let heights = [buffer("water.height_m.0", bytes)?, buffer("water.height_m.1", bytes)?];
        let flows =
            [buffer("water.flow_mps.0", planes * bytes)?, buffer("water.flow_mps.1", planes * bytes)?];
        let bind = |from: usize| {
            self.step.bind(&[
                ("Height", (&heights[from]).into()),
                ("Flow", (&flows[from]).into()),
                ("NewHeight", (&heights[1 - from]).into()),
                ("NewFlow", (&flows[1 - from]).into()),
            ])
        };
        let steps = [bind(0)?, bind(1)?];
        let Self { tuning, has_diagonals, has_land, .. } = *self;
        Ok(PipesState { heights, flows, steps, current: 0, cells, pitch, tuning, has_diagonals, has_land })
    }
}

/// One basin. Rows are padded to a multiple of four columns: column `(x, y)` is at `y * pitch + x` of each plane.
pub struct PipesState {
    heights: [Buffer; 2],
    flows: [Buffer; 2],
    steps: [Bound; 2],
    current: usize,
    cells: UVec2,
    pitch: u32,
    tuning: PipesTuning,
    has_diagonals: bool,
    has_land: bool,
}

impl PipesState {
    /// Records `steps` steps, as [`FusedState::record`](super::FusedState::record) does.
    ///
    /// # Panics
    /// If `params` are of another grid, or have diagonal pipes that the kernel was not built for.
    pub fn record(&mut self, rec: &mut Recorder<'_>, params: &Params, steps: u32) {
        assert_eq!(
            (params.cells, params.pitch),
            (self.cells, self.pitch),
            "grid of the parameters and of the state"
        );
        assert!(self.has_diagonals || params.diagonal == 0.0, "diagonal pipes in a kernel without");
        let UVec2 { x, y } = self.tuning.threads(self.cells);
        let mut left = steps;
        while left > 0 {
            let taken = left.min(self.tuning.steps());
            let bound = &self.steps[self.current];
            match self.tuning {
                PipesTuning::OneStep(_) => {
                    rec.span(c"water.pipes", |rec| rec.dispatch(bound, [x, y, 1], params));
                }
                PipesTuning::Fused(_) => {
                    let params = FusedParams { water: *params, steps: taken };
                    rec.span(c"water.pipes_fused", |rec| rec.dispatch(bound, [x, y, 1], &params));
                }
            }
            self.current = 1 - self.current;
            left -= taken;
            if left > 0 {
                rec.barrier(Pipes::EXIT, Pipes::ENTRY);
            }
        }
    }

    /// `f32` a column (m above rest): the surface after the steps recorded so far.
    pub fn height(&self) -> &Buffer {
        &self.heights[self.current]
    }

    /// Planes of `f32` a column: what flows in from the right, from below, and with diagonal pipes from the lower right
    /// and the lower left, as rise of the surface (m/s), half a step before the heights.
    pub fn flow(&self) -> &Buffer {
        &self.flows[self.current]
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
        2 * (self.heights[0].bytes() + self.flows[0].bytes())
    }

    /// Sets heights (m above rest, [`LAND_M`](super::LAND_M) for land), without padding, with all pipes at rest.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite or the sizes differ, else the device's.
    pub fn upload(&self, gpu: &Gpu, height_m: &[f32]) -> Result<(), Error> {
        check_heights("height_m", height_m, self.cells, self.has_land)?;
        gpu.upload_to(self.height(), &padded(height_m, self.cells, self.pitch))?;
        gpu.once(|rec| {
            rec.barrier(Access::ComputeReadWrite, Access::FillWrite);
            rec.fill(self.flow(), 0);
            rec.barrier(Access::FillWrite, Pipes::ENTRY);
        })?;
        Ok(())
    }

    /// The columns, without padding.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu) -> Result<Vec<Column>> {
        let heights = plain(&gpu.download(self.height())?, self.cells, self.pitch);
        let flows: Vec<f32> = gpu.download(self.flow())?;
        let size = self.pitch as usize * self.cells.y as usize;
        let planes: Vec<_> =
            flows.chunks_exact(size).map(|plane| plain(plane, self.cells, self.pitch)).collect();
        let flow = |plane: usize, i: usize| planes.get(plane).map_or(0.0, |plane| plane[i]);
        let column = |(i, &height_m): (usize, &f32)| Column {
            height_m,
            flow_mps: [flow(0, i), flow(2, i), flow(1, i), flow(3, i)],
        };
        Ok(heights.iter().enumerate().map(column).collect())
    }
}
