// SPDX-License-Identifier: MIT OR Apache-2.0
//! `fourth`: the state of `waves`, fourth order in space and time, one step a dispatch. Reads `glsl/water/fourth.comp`.
//!
//! The stencil's symbol `S` with `w = 1/4` is `k^2 (1 - k^2 / 12)` in every direction, and a step turns a wave by
//! `2 asin(courant sqrt(S) / 2)`. With `S (1 + (1 - courant^2) S / 12)` for `S` both leading errors are gone, and what is
//! left is of fourth order. It is the stencil run over `g = h - (1 - courant^2) / (12 (1 + 2 w)) L h` instead of `h`, so
//! walls and shores, which are in `L`, stay the mirrors that they are, and every cosine mode of the basin an eigenvector.

use super::{Invalid, Model, Tuning, Walls, WavesState};
use crate::{
    check::hold,
    gpu::{Access, Gpu, Kernel, KernelInfo, Recorder, Result},
    shaders,
};
use glam::UVec2;
use std::ops::Deref;

/// Push constants: `Push` in `glsl/water/fourth.comp`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct FourthParams {
    /// Size of the grid.
    pub cells: UVec2,
    /// Columns from one row to the next.
    pub pitch: u32,
    /// Step (s).
    pub dt_s: f32,
    /// What a unit of the stencil's sum adds to the velocity (1/s).
    pub pull: f32,
    /// `exp(-gamma dt)`.
    pub keep: f32,
    /// Weight of the second stencil.
    pub sharpen: f32,
    /// Unused.
    pub reserved: u32,
}

impl FourthParams {
    /// For the first step from a start at rest: see [`Params::first_from_rest`](super::Params::first_from_rest).
    pub fn first_from_rest(self) -> Self {
        Self { pull: 0.5 * self.pull, ..self }
    }
}

impl Model {
    /// [`Model::courant_limit`] of the fourth order. `nu^2 S (1 + (1 - nu^2) S / 12) <= 4` where `S` is largest, `4 / nu_2^2`
    /// with the second order's limit `nu_2`; the left side grows with `S` and with `nu`, so the limit is its smaller root,
    /// `sqrt((13 - sqrt(61)) / 8) = 0.8054` for `w = 1/4`. It holds for every shore, as the second order's does.
    pub fn fourth_order_limit(&self) -> f64 {
        let a = 4.0 / self.courant_limit().powi(2) / 12.0;
        (((1.0 + a) - ((1.0 + a).powi(2) - 4.0 / 3.0).sqrt()) / (2.0 * a)).sqrt()
    }

    /// [`Model::check`] for the fourth order, which has one diagonal weight, 1/4, and walls that are mirrors.
    ///
    /// # Errors
    /// The first parameter that is out of range.
    pub fn check_fourth_order(&self) -> Result<(), Invalid> {
        self.check_below(self.fourth_order_limit() * self.cell_m / self.speed_mps)?;
        let allowed = "0.25: no other stencil has the same error in all directions";
        hold(self.diagonal == 0.25, "diagonal", self.diagonal, allowed)?;
        let walls = format!("{:?}", self.walls);
        hold(self.walls == Walls::Folded, "walls", walls, "Folded: other walls are first order")
    }

    pub(super) fn fourth_order_sharpen(&self) -> f64 {
        (1.0 - self.courant().powi(2)) / (12.0 * (1.0 + 2.0 * self.diagonal))
    }

    /// Push constants of a state with `pitch` columns from row to row.
    pub fn fourth_order_params(&self, pitch: u32) -> FourthParams {
        FourthParams {
            cells: self.cells,
            pitch,
            dt_s: self.dt_s as f32,
            pull: self.pull() as f32,
            keep: (-self.damping_per_s * self.dt_s).exp() as f32,
            sharpen: self.fourth_order_sharpen() as f32,
            reserved: 0,
        }
    }
}

/// The kernel. It holds no basin, so one steps any number of them.
pub struct Fourth {
    step: Kernel,
    rows: u32,
    has_land: bool,
    gpu: Gpu,
}

impl Fourth {
    /// What the state must be visible to before [`FourthState::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`FourthState::record`] touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// As [`Waves::new`](super::Waves::new).
    ///
    /// # Errors
    /// If the device does not take the tuning.
    ///
    /// # Panics
    /// If an invocation is to walk down no rows.
    pub fn new(gpu: &Gpu, tuning: Tuning, has_land: bool) -> Result<Self> {
        assert!(tuning.rows > 0, "{tuning:?}");
        let info = KernelInfo {
            name: c"water.fourth",
            spv: shaders::WATER_FOURTH_COMP,
            blocks: &["Height", "Velocity", "NewHeight"],
            constants: &[tuning.group.x, tuning.group.y, tuning.rows, u32::from(has_land)],
        };
        let step = Kernel::new::<FourthParams>(gpu, &info)?;
        Ok(Self { step, rows: tuning.rows, has_land, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet, as [`Waves::state`](super::Waves::state).
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    ///
    /// # Panics
    /// If there are no cells.
    pub fn state(&self, cells: UVec2) -> Result<FourthState> {
        WavesState::of(&self.step, &self.gpu, cells, self.rows, self.has_land).map(FourthState)
    }
}

/// One basin: a [`WavesState`] that steps by the fourth order.
pub struct FourthState(WavesState);

impl FourthState {
    /// Records one step, as [`WavesState::record`] does.
    ///
    /// # Panics
    /// If `params` are of another grid.
    pub fn record(&mut self, rec: &mut Recorder<'_>, params: &FourthParams) {
        self.0.record_as(rec, c"water.fourth", (params.cells, params.pitch), params);
    }
}

impl Deref for FourthState {
    type Target = WavesState;
    fn deref(&self) -> &WavesState {
        &self.0
    }
}
