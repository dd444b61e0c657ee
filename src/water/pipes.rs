// SPDX-License-Identifier: MIT OR Apache-2.0
//! `pipes`: three or five floats a column, for whoever needs the flows. Reads `glsl/water/pipes.comp` and
//! `glsl/water/pipes_fused.comp`.

use super::{
    book::Column,
    planes::{in_blocks, Planes, Rates},
    tiles::{Step, TileKernels, Tiles},
    Error, FusedParams, FusedTuning, Params, Tuning,
};
use crate::{
    gpu::{Access, Buffer, Gpu, Kernel, KernelInfo, Recorder, Result},
    shaders,
};
use glam::UVec2;
use std::ops::Deref;

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
    pub(super) fn threads(&self, cells: UVec2) -> UVec2 {
        match self {
            Self::OneStep(tuning) => UVec2::new(cells.x.div_ceil(4), cells.y.div_ceil(tuning.rows)),
            Self::Fused(tuning) => tuning.groups(cells) * tuning.group,
        }
    }
}

/// The kernel. It holds no basin, so one steps any number of them.
pub struct Pipes {
    step: Step,
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
        let blocks = ["Height", "Flow", "NewHeight", "NewFlow"];
        let step = match tuning {
            PipesTuning::OneStep(Tuning { group, rows }) => {
                let constants = [group.x, group.y, rows, u32::from(has_land), u32::from(has_diagonals)];
                let (name, spv) = (c"water.pipes", shaders::WATER_PIPES_COMP);
                let info = KernelInfo { name, spv, blocks: &blocks, constants: &constants };
                Step::One(Kernel::new::<Params>(gpu, &info)?)
            }
            PipesTuning::Fused(tuning) => {
                let what = (c"water.pipes_fused", shaders::WATER_PIPES_FUSED_COMP);
                Step::Tiles(TileKernels::new(gpu, what, blocks, tuning, has_land, has_diagonals)?)
            }
        };
        Ok(Self { step, tuning, has_diagonals, has_land, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet: [`PipesState::upload`].
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn state(&self, cells: UVec2) -> Result<PipesState> {
        let rates = Rates {
            names: ["water.flow_mps.0", "water.flow_mps.1"],
            blocks: &["Flow", "NewFlow"],
            planes: if self.has_diagonals { 4 } else { 2 },
            bytes: 4,
        };
        let (planes, tiles) = self.step.state(&self.gpu, cells, &rates, self.has_land)?;
        Ok(PipesState { planes, tiles, tuning: self.tuning, has_diagonals: self.has_diagonals })
    }
}

/// One basin: a plane of heights, and two or four of flows.
pub struct PipesState {
    planes: Planes,
    tiles: Option<Tiles>,
    tuning: PipesTuning,
    has_diagonals: bool,
}

impl PipesState {
    /// Records `steps` steps, as [`FusedState::record`](super::FusedState::record) does.
    ///
    /// # Panics
    /// If `params` are of another grid, or have diagonal pipes that the kernel was not built for.
    pub fn record(&mut self, rec: &mut Recorder<'_>, params: &Params, steps: u32) {
        assert!(self.has_diagonals || params.diagonal == 0.0, "diagonal pipes in a kernel without");
        in_blocks(rec, steps, self.tuning.steps(), |rec, steps| match (&self.tiles, self.tuning) {
            (Some(tiles), _) => tiles.record(rec, &mut self.planes, &FusedParams { water: *params, steps }),
            (None, tuning) => {
                let (threads, grid) = (tuning.threads(self.planes.cells()), (params.cells, params.pitch));
                self.planes.dispatch(rec, c"water.pipes", threads, grid, params);
            }
        });
    }

    /// Planes of `f32` a column: what flows in from the right, from below, and with diagonal pipes from the lower right
    /// and the lower left, as rise of the surface (m/s), half a step before the heights.
    pub fn flow(&self) -> &Buffer {
        self.planes.rate()
    }

    /// Sets heights (m above rest, [`LAND_M`](super::LAND_M) for land), without padding, with all pipes at rest.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite or the sizes differ, else the device's.
    pub fn upload(&self, gpu: &Gpu, height_m: &[f32]) -> Result<(), Error> {
        self.planes.upload_heights(gpu, height_m)?;
        self.tiles.as_ref().map_or(Ok(()), |tiles| tiles.set(gpu, height_m))?;
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
        let (heights, flows) = self.planes.download_all(gpu)?;
        let flow = |plane: usize, i: usize| flows.get(plane).map_or(0.0, |plane| plane[i]);
        let column = |(i, &height_m): (usize, &f32)| Column {
            height_m,
            flow_mps: [flow(0, i), flow(2, i), flow(1, i), flow(3, i)],
        };
        Ok(heights.iter().enumerate().map(column).collect())
    }
}

impl Deref for PipesState {
    type Target = Planes;
    fn deref(&self) -> &Planes {
        &self.planes
    }
}
