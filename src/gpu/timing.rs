// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which clock to believe. Some software drivers stamp a compute pass with times that have nothing to do with it, so the
//! timestamps are checked once against the fence, and every result names the clock that it was taken with.

use super::{
    error::Error,
    submit::{Submitter, Times},
    Access, Buffer, Gpu, Kernel, KernelInfo, Residence, Result,
};
use crate::shaders;

/// Clock of a timing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// Timestamps of the GPU.
    Gpu,
    /// The host's clock, from submission to fence, one submission a pass.
    Fence,
}

impl Clock {
    /// As results name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gpu => "gpu",
            Self::Fence => "fence",
        }
    }
}

/// How far timestamps may be from the fence: a submission costs the host some time of its own.
const AGREEMENT: f64 = 0.15;
/// Long enough for that cost not to matter (ms).
const PROBE_MS: f64 = 8.0;

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Params {
    rounds: u32,
}

impl Gpu {
    /// Takes `clock` for the clock of this device, whatever a check would say: before the first [`Gpu::clock`].
    ///
    /// # Errors
    /// [`Error::NoClock`] if the device has no timestamps, or another clock has been chosen already.
    pub fn believe(&self, clock: Clock) -> Result<()> {
        let has_it = clock == Clock::Fence || self.0.adapter.timestamp_bits > 0;
        if !has_it || *self.0.clock.get_or_init(|| clock) != clock {
            return Err(Error::NoClock { device: self.name().into(), clock: clock.name() });
        }
        Ok(())
    }

    /// The clock of this device, found at the first call.
    ///
    /// # Errors
    /// If the probe cannot run.
    pub fn clock(&self) -> Result<Clock> {
        if let Some(clock) = self.0.clock.get() {
            return Ok(*clock);
        }
        let clock = probe(self)?;
        Ok(*self.0.clock.get_or_init(|| clock))
    }
}

fn probe(gpu: &Gpu) -> Result<Clock> {
    if gpu.0.adapter.timestamp_bits == 0 {
        return Ok(Clock::Fence);
    }
    let info =
        KernelInfo { name: c"gpu.spin", spv: shaders::GPU_SPIN_COMP, blocks: &["Sink"], constants: &[] };
    let kernel = Kernel::new::<Params>(gpu, &info)?;
    let sink = Buffer::new(gpu, "gpu.spin.sink", 4 * 64, Residence::Device)?;
    let bound = kernel.bind(&[("Sink", (&sink).into())])?;
    let mut submitter = Submitter::with_clock(gpu, 2, Clock::Gpu)?;
    // A long pass and a short one: a clock may also give the time of one pass to the next.
    let mut spin = |rounds: u32| {
        submitter.run(|rec| {
            rec.span(c"gpu.spin", |rec| rec.dispatch(&bound, [64, 1, 1], &Params { rounds }));
            rec.barrier(Access::ComputeWrite, Access::ComputeWrite);
            rec.span(c"gpu.spin.short", |rec| {
                rec.dispatch(&bound, [64, 1, 1], &Params { rounds: rounds / 16 })
            });
        })
    };
    let mut rounds = 1 << 12;
    let mut times = spin(rounds)?;
    while times.wall_ms < PROBE_MS && rounds < 1 << 28 {
        rounds *= 2;
        times = spin(rounds)?;
    }
    // The best of three: a host that wakes late says nothing of the GPU's clock.
    let mut is_believed = believes(&times);
    for _ in 0..2 {
        is_believed = is_believed || believes(&spin(rounds)?);
    }
    Ok(if is_believed { Clock::Gpu } else { Clock::Fence })
}

/// Whether both passes together took what the host saw, and the short one about its share.
fn believes(times: &Times) -> bool {
    let (long, short) = (times.of(c"gpu.spin"), times.of(c"gpu.spin.short"));
    let (together, share) = ((long + short) / times.wall_ms, 16.0 * short / long);
    (together - 1.0).abs() <= AGREEMENT && (share - 1.0).abs() <= 0.5
}
