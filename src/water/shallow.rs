// SPDX-License-Identifier: MIT OR Apache-2.0
//! `shallow`: the shallow-water equations, one step in two dispatches. Reads `glsl/water/shallow_speed.comp` and
//! `glsl/water/shallow_depth.comp`. The same kernels leave out advection when asked to: face velocities that carry the
//! depth of upstream, between `wet` and the whole equations, for studies of what advection is worth.

use super::{
    depth::{kernel, Buffers, DepthParams, DepthState, Pass, Tier},
    Tuning,
};
use crate::{
    gpu::{Gpu, Kernel, KernelInfo, Result},
    shaders,
};
use glam::UVec2;

/// The kernels. They hold no basin, so they step any number of them.
pub struct Shallow {
    speed: Kernel,
    depth: Kernel,
    tuning: Tuning,
    gpu: Gpu,
}

impl Shallow {
    /// # Errors
    /// If the device does not take the tuning.
    pub fn new(gpu: &Gpu, tuning: Tuning) -> Result<Self> {
        Self::with(gpu, tuning, true)
    }

    /// Velocities that gravity alone changes: cheaper only in what is computed, not in what is read and written.
    ///
    /// # Errors
    /// If the device does not take the tuning.
    pub fn without_advection(gpu: &Gpu, tuning: Tuning) -> Result<Self> {
        Self::with(gpu, tuning, false)
    }

    fn with(gpu: &Gpu, tuning: Tuning, has_advection: bool) -> Result<Self> {
        let speed_blocks = ["Bed", "Rise", "Before", "Speed", "NewSpeed"];
        let depth_blocks = ["Bed", "Rise", "Flow", "NewRise"];
        let speed = KernelInfo {
            name: c"water.shallow_speed",
            spv: shaders::WATER_SHALLOW_SPEED_COMP,
            blocks: &speed_blocks,
            constants: &[tuning.group.x, tuning.group.y, tuning.rows, u32::from(has_advection)],
        };
        let depth = shaders::WATER_SHALLOW_DEPTH_COMP;
        Ok(Self {
            speed: Kernel::new::<DepthParams>(gpu, &speed)?,
            depth: kernel(gpu, c"water.shallow_depth", depth, &depth_blocks, tuning)?,
            tuning,
            gpu: gpu.clone(),
        })
    }

    /// A basin whose memory is not set yet: [`DepthState::upload`].
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn state(&self, cells: UVec2) -> Result<DepthState> {
        DepthState::new(&self.gpu, Tier::Shallow, cells, self.tuning.rows, |b: &Buffers<'_>| {
            let speed = self.speed.bind(&[
                ("Bed", b.bed.into()),
                ("Rise", b.rise.into()),
                ("Before", b.new_rise.into()), // not yet written over
                ("Speed", b.flow.into()),
                ("NewSpeed", b.new_flow.into()),
            ])?;
            let depth = self.depth.bind(&[
                ("Bed", b.bed.into()),
                ("Rise", b.rise.into()),
                ("Flow", b.new_flow.into()),
                ("NewRise", b.new_rise.into()),
            ])?;
            Ok(vec![
                Pass { name: c"water.shallow_speed", bound: speed },
                Pass { name: c"water.shallow_depth", bound: depth },
            ])
        })
    }
}
