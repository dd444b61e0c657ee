// SPDX-License-Identifier: MIT OR Apache-2.0
//! What becomes of particles about black holes: many steps in registers. Reads `glsl/particles/black_hole_fate.comp`.

use super::{black_hole::BlackHole, cpu_black_hole::Body};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};

/// Mirrors `FateParams` of the shader.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct FateParams {
    /// Tick at the start.
    pub now: u32,
    /// Length of a step.
    pub dt_ticks: u32,
    /// The same (s).
    pub dt_s: f32,
    /// To take.
    pub steps: u32,
    /// Particles.
    pub count: u32,
}

impl FateParams {
    /// `steps` steps of `dt_ticks` from tick `now`.
    pub fn new(now: u32, dt_ticks: u32, steps: u32, count: u32) -> Self {
        Self { now, dt_ticks, dt_s: dt_ticks as f32 / 65536.0, steps, count }
    }
}

/// Particles on the GPU, the law that moves them, and room for what becomes of them.
pub struct Fates {
    bound: Bound,
    law: Buffer,
    from: Buffer,
    to: Buffer,
    ends: Buffer,
    count: u32,
    gpu: Gpu,
}

/// Seven planes of words, as the pool has them.
pub fn planes(bodies: &[Body<f32>]) -> Vec<u32> {
    let mut words = Vec::with_capacity(7 * bodies.len());
    for k in 0..3 {
        words.extend(bodies.iter().map(|body| body.at_m[k].to_bits()));
    }
    for k in 0..3 {
        words.extend(bodies.iter().map(|body| body.velocity_mps[k].to_bits()));
    }
    words.extend(bodies.iter().map(|body| body.born));
    words
}

/// The particles of planes.
pub fn bodies(words: &[u32]) -> Vec<Body<f32>> {
    let count = words.len() / 7;
    let word = |i: usize, k: usize| words[k * count + i];
    let float = |i: usize, k: usize| f32::from_bits(word(i, k));
    let body = |i: usize| Body {
        at_m: [float(i, 0), float(i, 1), float(i, 2)],
        velocity_mps: [float(i, 3), float(i, 4), float(i, 5)],
        born: word(i, 6),
    };
    (0..count).map(body).collect()
}

impl Fates {
    /// What the state must be visible to before [`Fates::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Fates::record`] touched it last.
    pub const EXIT: Access = Access::ComputeWrite;
    const GROUP: u32 = 128;

    /// # Errors
    /// The device's.
    ///
    /// # Panics
    /// If the law does not pass its check, or there are no particles.
    pub fn new(gpu: &Gpu, law: &BlackHole, particles: &[Body<f32>]) -> Result<Self> {
        law.check().unwrap_or_else(|invalid| panic!("{invalid}"));
        assert!(!particles.is_empty(), "no particles");
        let [integrator, substeps, holes, moving] = law.constants();
        let info = KernelInfo {
            name: c"particles.black_hole_fate",
            spv: shaders::PARTICLES_BLACK_HOLE_FATE_COMP,
            blocks: &["Particles", "NewParticles", "Ends", "Law"],
            constants: &[Self::GROUP, integrator, substeps, holes, moving],
        };
        let kernel = Kernel::new::<FateParams>(gpu, &info)?;
        let law = gpu.upload("particles.law", &law.holes)?;
        let from = gpu.upload("particles.from", &planes(particles))?;
        let count = particles.len() as u32;
        let to = Buffer::new(gpu, "particles.to", from.bytes(), Residence::Device)?;
        let ends = Buffer::new(gpu, "particles.ends", 4 * u64::from(count), Residence::Device)?;
        let bound = kernel.bind(&[
            ("Particles", (&from).into()),
            ("NewParticles", (&to).into()),
            ("Ends", (&ends).into()),
            ("Law", (&law).into()),
        ])?;
        Ok(Self { bound, law, from, to, ends, count, gpu: gpu.clone() })
    }

    /// Records `steps` steps of `dt_ticks` from tick `now`.
    pub fn record(&self, rec: &mut Recorder<'_>, now: u32, dt_ticks: u32, steps: u32) {
        let params = FateParams::new(now, dt_ticks, steps, self.count);
        rec.span(c"particles.black_hole_fate", |rec| {
            rec.dispatch(&self.bound, [self.count, 1, 1], &params);
        });
    }

    /// Runs `steps` steps of `dt_ticks` from tick `now`: each particle, and when it was swallowed (s).
    ///
    /// # Errors
    /// The device's.
    pub fn run(&self, now: u32, dt_ticks: u32, steps: u32) -> Result<Vec<(Body<f32>, Option<f32>)>> {
        self.gpu.once(|rec| self.record(rec, now, dt_ticks, steps))?;
        let ends: Vec<f32> = self.gpu.download(&self.ends)?;
        let particles = bodies(&self.gpu.download(&self.to)?);
        let end = |end: f32| (end >= 0.0).then_some(end);
        Ok(particles.into_iter().zip(ends.into_iter().map(end)).collect())
    }

    /// What [`Fates::run`] left becomes what it starts from.
    ///
    /// # Errors
    /// The device's.
    pub fn carry_on(&self) -> Result<()> {
        self.gpu.once(|rec| {
            rec.barrier(Access::ComputeWrite, Access::CopyRead);
            rec.copy(&self.to, &self.from);
            rec.barrier(Access::CopyWrite, Access::ComputeReadWrite);
        })
    }

    /// The list of holes, for a caller that changes it.
    pub fn law(&self) -> &Buffer {
        &self.law
    }

    /// Where the particles are read from.
    pub fn from(&self) -> &Buffer {
        &self.from
    }
}
