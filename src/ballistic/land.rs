// SPDX-License-Identifier: MIT OR Apache-2.0
//! What of an effect lands in a step, as impacts. Reads `glsl/ballistic/land.glsl`.
//!
//! Nothing is stored, so the steps are whoever asks for them: those of a water that the drops fall into. Each particle lands
//! in just one of steps that follow each other, however long they are. Ages in floats, from the end of each step, would not
//! see to that, as two steps round them differently. So times are counted from an epoch, a birth whose number is a multiple
//! of a power of two: of a particle all that the comparison goes by is a function of its number alone, and the end of
//! one step is the begin of the next, to the bit.

use super::{
    cpu::{age_of, birth, emitter_before, moved, position, reach_of, velocity, Flight, Who, Wide},
    effect::wide,
    Builtin, Effect, Ground, GroundGrid, Moment, Params,
};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Result},
    impact::{Impact, Stream, NO_MESH},
};
use glam::{vec2, vec3, Vec2, Vec4};
use std::{ffi::CStr, ops::Range};

/// Push constants: `Landing` in `glsl/ballistic/land.glsl`. Births after one epoch, in a step.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct LandParams {
    /// xyz: where the emitter was at the epoch, without its circling; w: radius of the circle (m).
    pub emitter_m: Vec4,
    /// Begin of the step, since the epoch, in two floats (s).
    pub from_s: Vec2,
    /// Its end (s).
    pub to_s: Vec2,
    /// Where on the circle the emitter was at the epoch (turns).
    pub turn: f32,
    /// Serial number of the birth that is the epoch, low word.
    pub epoch: u32,
    /// Its high word.
    pub epoch_high: u32,
    /// The first birth that may land, after the epoch.
    pub first: u32,
    /// Particles of it and of those after it.
    pub particles: u32,
    /// Particles of this step in other [`LandParams`].
    pub before: u32,
    /// Of the impacts.
    pub source: u32,
    /// Unused.
    pub reserved: u32,
}

/// An effect that lands, on the host.
#[derive(Clone, Debug, PartialEq)]
pub struct Landing {
    /// Its numbers; its emitter may be moved.
    pub effect: Effect,
    /// As impacts name it.
    pub source: u32,
}

impl Landing {
    /// Most particles at once: numbers of impacts are of 32 bits.
    pub const MOST: u64 = 1 << 28;

    /// Births of an epoch: as many as live, up to a power of two. Ages are as exact as those that are drawn, and a step has
    /// births of few epochs.
    pub fn epoch(&self) -> u64 {
        self.effect.emission().most().max(1).next_power_of_two()
    }

    /// What may land after `after`, from the start if that is `None`, and up to `by`.
    pub fn parts(&self, after: Option<Moment>, by: Moment) -> impl Iterator<Item = LandParams> + '_ {
        let emission = self.effect.emission();
        let (epoch, burst) = (self.epoch(), self.effect.burst);
        let Range { start, end } = emission.ending(after, by);
        let mut before = 0;
        (start / epoch..end.div_ceil(epoch)).map(move |number| {
            let serial = number * epoch;
            let (first, last) = (start.max(serial), end.min(serial + epoch));
            // From the epoch to a moment, rounded once; twice less the same is the same.
            let since_s = |moment| Vec2::from(wide(emission.age_s(moment, serial)));
            let at_s = serial as f64 * emission.interval_s();
            let emitter = &self.effect.emitter;
            let at_m = emitter.at_m.as_dvec3() + emitter.velocity_mps.as_dvec3() * at_s;
            let particles = last.saturating_sub(first) as u32 * burst;
            let part = LandParams {
                emitter_m: at_m.as_vec3().extend(emitter.circle_m),
                from_s: after.map_or(vec2(f32::NEG_INFINITY, 0.0), since_s),
                to_s: since_s(by),
                turn: (emitter.turns_per_s * at_s).rem_euclid(1.0) as f32,
                epoch: serial as u32,
                epoch_high: (serial >> 32) as u32,
                first: first.saturating_sub(serial) as u32,
                particles,
                before,
                source: self.source,
                reserved: 0,
            };
            before += particles;
            part
        })
    }

    /// What all parts have in common: [`Params`] without a moment.
    pub fn params(&self, seed: u32, stream: u32, ground: &GroundGrid) -> Params {
        let at_start = self.effect.params(Moment::default(), seed, stream, ground, 0);
        Params { since_s: 0.0, since_low_s: 0.0, newest: 0, newest_high: 0, births: 0, ..at_start }
    }
}

/// The kernel of an effect, and its numbers.
pub struct Land {
    bound: Bound,
    landing: Landing,
}

impl Land {
    /// What the stream must be visible to before [`Land::record`]: [`Stream::record_begin`] sees to it.
    pub const ENTRY: Access = Stream::ENTRY;
    /// How [`Land::record`] touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// Of an effect with a ground, whose samples are `ground_m`, by the SPIR-V of its landings; `seed` and `emitter` are those
    /// that it is drawn with.
    ///
    /// # Errors
    /// If the SPIR-V is no such kernel, or the device has no room.
    ///
    /// # Panics
    /// If more particles live than there are numbers for.
    pub fn new(
        gpu: &Gpu,
        (name, spv): (&CStr, &[u8]),
        landing: Landing,
        (seed, emitter): (u32, u32),
        (ground_m, grid): (&Buffer, &GroundGrid),
        stream: &Stream,
    ) -> Result<Self> {
        let most = landing.effect.most_particles();
        assert!(most <= Landing::MOST, "{most} particles of `{}`", landing.effect.name);
        let blocks = &["Impacts", "Count", "Effects", "Ground"];
        let kernel = Kernel::new::<LandParams>(gpu, &KernelInfo { name, spv, blocks, constants: &[] })?;
        let effect = gpu.upload("ballistic.effect", &[landing.params(seed, emitter, grid)])?;
        let bound = kernel.bind(&[
            ("Impacts", stream.impacts().into()),
            ("Count", stream.count().into()),
            ("Effects", (&effect).into()),
            ("Ground", ground_m.into()),
        ])?;
        Ok(Self { bound, landing })
    }

    /// Records what lands after `after`, from the start if that is `None`, and up to `by`. Submits nothing, waits for
    /// nothing, allocates nothing.
    pub fn record(&self, rec: &mut Recorder<'_>, after: Option<Moment>, by: Moment) {
        // Rows, as devices count few workgroups along one axis.
        const ROW: u32 = 1 << 12;
        for part in self.landing.parts(after, by).filter(|part| part.particles > 0) {
            let groups = part.particles.div_ceil(64);
            let threads = [groups.min(ROW) * 64, groups.div_ceil(ROW), 1];
            rec.span(c"ballistic.land", |rec| rec.dispatch(&self.bound, threads, &part));
        }
    }

    /// On the host: its emitter may be moved.
    pub fn landing_mut(&mut self) -> &mut Landing {
        &mut self.landing
    }
}

/// Twin of `glsl/ballistic/land.glsl`: the impacts of a part, by [`Impact::order`]. `p` is [`Landing::params`].
pub fn landings(effect: Builtin, p: &Params, ground: &Ground<'_>, part: &LandParams) -> Vec<Impact> {
    (0..part.particles).filter_map(|i| landing(effect, p, ground, part, i)).collect()
}

fn later(a: Wide, s: f32) -> Wide {
    let high = a.high + s;
    let back = high - a.high;
    let low = (a.high - (high - back)) + (s - back) + a.low;
    let sum = high + low;
    Wide { high: sum, low: low - (sum - high) }
}

fn is_after(a: Wide, b: Vec2) -> bool {
    a.high > b.x || a.high == b.x && a.low > b.y
}

fn landing(effect: Builtin, p: &Params, ground: &Ground<'_>, part: &LandParams, i: u32) -> Option<Impact> {
    let back = part.first + i / p.burst;
    let epoch = u64::from(part.epoch) | u64::from(part.epoch_high) << 32;
    let who = Who { serial: epoch + u64::from(back), member: i % p.burst };
    let since = age_of(p, back);
    let ago = Wide { high: -since.high, low: -since.low };
    let start = birth(effect, p, who, emitter_before(p, part.emitter_m, part.turn, ago));
    let end = ground.hit(p, &start);
    let delay_s = start.delay_s.max(0.0);
    let share = (delay_s + end) * p.lives_per_s;
    let landed = later(later(since, delay_s), end);
    if end <= 0.0
        || share.is_nan()
        || share >= 1.0
        || !is_after(landed, part.from_s)
        || is_after(landed, part.to_s)
    {
        return None;
    }
    let r = reach_of(Wide { high: end, low: 0.0 }, p.acceleration.w);
    let pull = p.acceleration.truncate();
    let at_m = position(start.at_m, start.velocity_mps, pull, &r);
    let v = velocity(start.velocity_mps, pull, &r);
    let flight = Flight { at_m, velocity_mps: v, age_s: end, share, down_s: 0.0 };
    let seen = moved(effect, p, who, &flight);
    let xz = vec2(seen.x, seen.z);
    let normal = ground.normal(p, xz);
    let into = -((v.x * normal.x + v.y * normal.y) + v.z * normal.z);
    Some(Impact {
        at_m: vec3(xz.x, ground.height(p, xz), xz.y),
        order: 8 * (part.before + i),
        normal,
        impulse_mps: into.max(0.0),
        velocity_mps: v,
        mesh: NO_MESH,
        source: part.source,
        ..Impact::default()
    })
}
