// SPDX-License-Identifier: MIT OR Apache-2.0
//! `shallow`: the shallow-water equations, one step a dispatch. Reads `glsl/water/shallow.comp`. The same kernel leaves
//! out advection when asked to: face velocities that carry the depth of upstream, between `wet` and the whole equations,
//! for studies of what advection is worth.

use super::{
    depth::{Buffers, DepthParams, DepthState, Tier},
    Tuning,
};
use crate::{
    gpu::{self, Gpu, Kernel, KernelInfo, Result},
    shaders,
};
use glam::UVec2;

/// The kernel. It holds no basin, so one steps any number of them.
pub struct Shallow {
    step: Kernel,
    tuning: Tuning,
    gpu: Gpu,
}

/// Shared memory of a lane (bytes).
const SHARED_BYTES: u32 = 4 * (16 + 8 + 8 + 8 + 4) + 2 * (4 + 4 + 4);

impl Shallow {
    /// A workgroup is one lane high and `tuning.group.x` lanes of four columns wide, of which two are not its own.
    ///
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
        let (UVec2 { x: lanes, y: high }, allowed) =
            (tuning.group, gpu.limits().max_compute_shared_memory_size);
        let refused = |what| Err(gpu::Error::Interface { kernel: "water.shallow".into(), what });
        if high != 1 || lanes < 3 || tuning.rows == 0 {
            let rows = tuning.rows;
            return refused(format!(
                "{lanes} x {high} lanes and {rows} rows: allowed are 3 x 1 and up, and rows"
            ));
        }
        if lanes * SHARED_BYTES > allowed {
            let needed = lanes * SHARED_BYTES;
            return refused(format!("{needed} bytes of shared memory, and {} allows {allowed}", gpu.name()));
        }
        let info = KernelInfo {
            name: c"water.shallow",
            spv: shaders::WATER_SHALLOW_COMP,
            blocks: &["Bed", "Rise", "Before", "Speed", "NewRise", "NewBefore", "NewSpeed"],
            constants: &[lanes, lanes, tuning.rows, u32::from(has_advection)],
        };
        Ok(Self { step: Kernel::new::<DepthParams>(gpu, &info)?, tuning, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet: [`DepthState::upload`].
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn state(&self, cells: UVec2) -> Result<DepthState> {
        let Tuning { group: UVec2 { x: lanes, .. }, rows } = self.tuning;
        let threads =
            |pitch: u32| UVec2::new((pitch / 4).div_ceil(lanes - 2) * lanes, cells.y.div_ceil(rows));
        DepthState::new(&self.gpu, (Tier::Shallow, c"water.shallow"), cells, threads, |b: &Buffers<'_>| {
            self.step.bind(&[
                ("Bed", b.bed.into()),
                ("Rise", b.rise.into()),
                ("Before", b.before.into()),
                ("Speed", b.flow.into()),
                ("NewRise", b.new_rise.into()),
                ("NewBefore", b.new_before.into()),
                ("NewSpeed", b.new_flow.into()),
            ])
        })
    }
}
