// SPDX-License-Identifier: MIT OR Apache-2.0
//! `wet`: pipes over ground that may be dry, one step a dispatch. Reads `glsl/water/wet.comp`.

use super::{
    depth::{kernel, Buffers, DepthState, Pass, Tier},
    Tuning,
};
use crate::{
    gpu::{Gpu, Kernel, Result},
    shaders,
};
use glam::UVec2;

/// The kernel. It holds no basin, so one steps any number of them.
pub struct Wet {
    step: Kernel,
    tuning: Tuning,
    gpu: Gpu,
}

impl Wet {
    /// # Errors
    /// If the device does not take the tuning.
    pub fn new(gpu: &Gpu, tuning: Tuning) -> Result<Self> {
        let blocks = ["Bed", "Rise", "Flow", "NewRise", "NewFlow"];
        let step = kernel(gpu, c"water.wet", shaders::WATER_WET_COMP, &blocks, tuning)?;
        Ok(Self { step, tuning, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet: [`DepthState::upload`].
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn state(&self, cells: UVec2) -> Result<DepthState> {
        DepthState::new(&self.gpu, Tier::Wet, cells, self.tuning.rows, |b: &Buffers<'_>| {
            let bound = self.step.bind(&[
                ("Bed", b.bed.into()),
                ("Rise", b.rise.into()),
                ("Flow", b.flow.into()),
                ("NewRise", b.new_rise.into()),
                ("NewFlow", b.new_flow.into()),
            ])?;
            Ok(vec![Pass { name: c"water.wet", bound }])
        })
    }
}
