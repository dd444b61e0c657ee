// SPDX-License-Identifier: MIT OR Apache-2.0
//! Particle systems (Zink, Pettineo and Hoxley, "Practical Rendering and Computation with Direct3D 11", 2011, section
//! 12.2): a pool with a law.
//!
//! | kernel              | reads                                        | writes                                | CPU twin               |
//! | ------------------- | -------------------------------------------- | ------------------------------------- | ---------------------- |
//! | `particles.prepare` | emitters, counts                             | births, counts, arguments             | [`cpu::Pool::prepare`] |
//! | `particles.near`    | cells                                        | how far corners are from occupied     | [`cpu_near::near`]     |
//! | `particles.LAW`     | particles, emitters, births, law, counts     | new particles, places, counts         | [`cpu::Pool::advance`] |
//! | `.._deferred`       | those that the law has put off               | the same, moved                       | of the law             |
//!
//! The pool owns memory, counts, births, compaction and the arguments of indirect dispatches and draws; all of that stays on
//! the GPU, the host neither reads nor guesses a count. A law is a function in GLSL that moves a particle by a time and says
//! whether it goes on ([`Law`]): [`drag`] is one, a user's own is another.
//!
//! A step is two dispatches, three if the law puts some off. `particles.prepare`, one workgroup, counts the births of the step
//! and adds up how many live in each tile of slots. `particles.LAW` takes a tile a workgroup: it reads, takes in births, moves, and writes survivors
//! without gaps, in their order ([`Compaction::Stable`]), so that a run is the same to the bit whenever it is repeated.
//! Who ends in a step is written once more, as old as a life, and left out by the next: whether it lives is then known as soon
//! as it is read, and the places of all survivors before any is moved.
//!
//! Time is counted in ticks of 2^-16 s, in integers: births are at whole multiples of the emitter's period, whatever the
//! steps are, and lives end on their tick. What is left out: particles do not see each other.

pub mod balls;
pub mod black_hole;
pub mod black_hole_fate;
pub mod choose;
pub mod colliding;
pub mod cpu;
pub mod cpu_black_hole;
pub mod cpu_colliding;
pub mod cpu_near;
pub mod drag;
pub mod emitter;
pub mod info;
pub mod kepler;
pub mod kepler_stateless;
pub mod law;
pub mod layout;
pub mod options;
pub mod oracle;
pub mod pool;
pub mod state;

pub use colliding::{Colliding, Slabs, Surroundings};
pub use drag::Drag;
pub use emitter::{Emitter, EmitterState, EmitterWords, Thrown};
pub use info::PoolInfo;
#[cfg(feature = "tools")]
pub use law::compile_law;
pub use law::Law;
pub use layout::Layout;
pub use options::{Compaction, Options, Tuning};
pub use pool::{Particles, Pool};
pub use state::{Counts, PoolState, Snapshot};

pub use crate::check::Invalid;
use crate::gpu;
use glam::Vec3;

/// Ticks of the clock of particles in a second.
pub const TICKS_PER_S: u32 = 1 << 16;

/// A particle: `Particle` in `glsl/particles/particle.glsl`, 28 bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Particle {
    /// (m).
    pub at_m: Vec3,
    /// (m/s).
    pub velocity_mps: Vec3,
    /// Tick of birth, on a clock that wraps: its age is `now - born`.
    pub born: u32,
}

/// One step of time: from `now - dt_ticks` to `now`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Tick at its end, on a clock that wraps.
    pub now: u32,
    /// Its length, 1 to [`Step::MOST_TICKS`].
    pub dt_ticks: u32,
    /// Its length as the law has it (s).
    pub dt_s: f32,
}

impl Step {
    /// A second: no effect is stepped more coarsely, and the births of a step stay countable.
    pub const MOST_TICKS: u32 = TICKS_PER_S;

    /// Step `index` of a clock with steps of `dt_s` (s), the first of which is 0. Its ends are rounded to ticks, so that
    /// the clock never drifts; the law gets `dt_s`.
    ///
    /// # Panics
    /// If `dt_s` is not between two ticks and a second.
    pub fn nth(index: u64, dt_s: f64) -> Self {
        assert!((2.0 / f64::from(TICKS_PER_S)..=1.0).contains(&dt_s), "a step of {dt_s} s");
        let tick = |index: u64| (index as f64 * dt_s * f64::from(TICKS_PER_S)).round() as u64;
        let (from, to) = (tick(index), tick(index + 1));
        Self { now: to as u32, dt_ticks: (to - from) as u32, dt_s: dt_s as f32 }
    }

    /// A step from one tick to another: of any length, as frames are.
    ///
    /// # Panics
    /// If it is not 1 to [`Step::MOST_TICKS`] long.
    pub fn between(from: u32, to: u32) -> Self {
        let dt_ticks = to.wrapping_sub(from);
        assert!((1..=Self::MOST_TICKS).contains(&dt_ticks), "a step of {dt_ticks} ticks");
        Self { now: to, dt_ticks, dt_s: dt_ticks as f32 / TICKS_PER_S as f32 }
    }
}

/// Push constants of every pass of a step: `StepParams` in `glsl/particles/step.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct StepParams {
    /// Tick at the end of the step.
    pub now: u32,
    /// Length of the step.
    pub dt_ticks: u32,
    /// The same, as the law has it (s).
    pub dt_s: f32,
    /// Of every particle.
    pub life_ticks: u32,
    /// Of the births.
    pub seed: u32,
    /// Most particles.
    pub capacity: u32,
    /// Words from one plane to the next.
    pub stride: u32,
    /// How many.
    pub emitters: u32,
}

/// What can go wrong with a pool.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Bad input.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The device's.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
}
