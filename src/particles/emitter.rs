// SPDX-License-Identifier: MIT OR Apache-2.0
//! Emitters: where, how fast and when particles are born.

use super::{Invalid, TICKS_PER_S};
use crate::check::hold;
use glam::Vec3;

/// How an emitter throws.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Thrown {
    /// One by one, each in a direction of its own, all directions alike.
    #[default]
    Singly,
    /// Eight at a time, towards the corners of a cube that is turned at random, all turns alike: the book's burst without
    /// its bias.
    Corners,
}

/// Throws particles from a point that may move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// At the end of the step (m).
    pub at_m: Vec3,
    /// Of the emitter itself: its particles keep it (m/s).
    pub velocity_mps: Vec3,
    /// Of what it throws, against the emitter (m/s).
    pub speed_mps: f32,
    /// Particles a second. Particle n is born at n / rate, to 2^-48 s; 0: it is off.
    pub rate_per_s: f64,
    /// How.
    pub thrown: Thrown,
}

/// As the GPU has it: `Emitter` in `glsl/particles/step.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct EmitterWords {
    /// (m).
    pub at_m: Vec3,
    /// (m/s).
    pub speed_mps: f32,
    /// (m/s).
    pub velocity_mps: Vec3,
    /// From one batch to the next: 2^-32 ticks.
    pub period_low: u32,
    /// Ticks.
    pub period_high: u32,
    /// Particles thrown at once.
    pub batch: u32,
    /// 1: towards the corners of a cube.
    pub corners: u32,
    /// Of random numbers.
    pub stream: u32,
}

/// Where an emitter is in its series of births: `EmitterState` in `glsl/particles/step.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct EmitterState {
    /// When the next batch is born: 2^-32 ticks.
    pub next_low: u32,
    /// Ticks.
    pub next_high: u32,
    /// Of its first particle.
    pub serial: u32,
    /// Births of this step by the emitters before this one.
    pub first: u32,
    /// When the first batch of this step is born: 2^-32 ticks.
    pub from_low: u32,
    /// Ticks.
    pub from_high: u32,
    /// Of its first particle.
    pub from_serial: u32,
    /// Of this step, before any is dropped.
    pub births: u32,
}

impl Emitter {
    /// Most emitters of a pool: an invocation each.
    pub const MOST: usize = 256;
    /// Most particles a second of all emitters of a pool: the births of a step are counted in 32 bits.
    pub const MOST_PER_S: f64 = 1e9;
    /// Slowest rate that is not 0: a birth in nine hours, half a round of the clock.
    pub const FEWEST_PER_S: f64 = 2.0 * TICKS_PER_S as f64 / (1u64 << 32) as f64 * 8.0;

    /// Particles thrown at once.
    pub fn batch(&self) -> u32 {
        match self.thrown {
            Thrown::Singly => 1,
            Thrown::Corners => 8,
        }
    }

    /// From one batch to the next: 2^-32 ticks.
    pub fn period(&self) -> u64 {
        if self.rate_per_s == 0.0 {
            return 0;
        }
        let ticks = f64::from(self.batch()) * f64::from(TICKS_PER_S) / self.rate_per_s;
        (ticks * (1u64 << 32) as f64).round() as u64
    }

    /// # Errors
    /// The first number that is out of range.
    pub fn check(&self) -> Result<(), Invalid> {
        let finite = |key, v: Vec3| hold(v.is_finite(), key, v, "finite numbers");
        finite("at_m", self.at_m)?;
        finite("velocity_mps", self.velocity_mps)?;
        finite("speed_mps", Vec3::splat(self.speed_mps))?;
        let range = Self::FEWEST_PER_S..=Self::MOST_PER_S;
        let is_allowed = self.rate_per_s == 0.0 || range.contains(&self.rate_per_s);
        let allowed = format!("0, or {:e} to {:e} (1/s)", range.start(), range.end());
        hold(is_allowed, "rate_per_s", self.rate_per_s, allowed)
    }

    /// As the GPU has it. `stream` is no other emitter's.
    pub fn words(&self, stream: u32) -> EmitterWords {
        let period = self.period();
        EmitterWords {
            at_m: self.at_m,
            speed_mps: self.speed_mps,
            velocity_mps: self.velocity_mps,
            period_low: period as u32,
            period_high: (period >> 32) as u32,
            batch: self.batch(),
            corners: u32::from(self.thrown == Thrown::Corners),
            stream,
        }
    }

    /// Before its first birth, one period after tick `start`.
    pub fn state(&self, start: u32) -> EmitterState {
        let next = (u64::from(start) << 32).wrapping_add(self.period());
        EmitterState { next_low: next as u32, next_high: (next >> 32) as u32, ..Default::default() }
    }
}
