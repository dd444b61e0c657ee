// SPDX-License-Identifier: MIT OR Apache-2.0
//! `wet`: pipes over ground that may be dry, one step a dispatch. Reads `glsl/water/wet.comp`.

use super::{
    depth::{Buffers, DepthParams, DepthState, Tier},
    Tuning,
};
use crate::{
    gpu::{Gpu, Kernel, KernelInfo, Result},
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
        let info = KernelInfo {
            name: c"water.wet",
            spv: shaders::WATER_WET_COMP,
            blocks: &["Bed", "Rise", "Flow", "NewRise", "NewFlow"],
            constants: &[tuning.group.x, tuning.group.y, tuning.rows],
        };
        Ok(Self { step: Kernel::new::<DepthParams>(gpu, &info)?, tuning, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet: [`DepthState::upload`].
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn state(&self, cells: UVec2) -> Result<DepthState> {
        let threads = |pitch| UVec2::new(pitch / 4, cells.y.div_ceil(self.tuning.rows));
        DepthState::new(&self.gpu, (Tier::Wet, c"water.wet"), cells, threads, |b: &Buffers<'_>| {
            self.step.bind(&[
                ("Bed", b.bed.into()),
                ("Rise", b.rise.into()),
                ("Flow", b.flow.into()),
                ("NewRise", b.new_rise.into()),
                ("NewFlow", b.new_flow.into()),
            ])
        })
    }
}
