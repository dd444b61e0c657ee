// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of closed-form effects: `stateless/materialise` writes a 16-byte vertex a particle; a frame of `stored/append`
//! or `stored/xfb` reads and writes 32 bytes a particle, and has not placed any yet. Of `kindled` see there.

use super::{kindled, Measured, Suite};
use crate::{
    ballistic::{
        cpu, stored::Particle, Builtin, Effect, GroundGrid, Materialise, Moment, StoredEffect,
        StreamedEffect, Vertex,
    },
    gpu::{Access, Gpu, Recorder},
    shaders,
    study::{
        must_be_within,
        runs::{self, Effort, Timing},
        Error, Result,
    },
};
use glam::Vec3;

/// Its rows.
pub const SUITE: Suite = Suite {
    sim: "ballistic",
    variants: &[
        "stateless/materialise",
        "stateless/materialise/x1",
        "stateless/materialise/x4",
        "stored/append",
        "stored/xfb",
        "kindled/step",
        "kindled/materialise",
    ],
    sizes: &[1 << 20, 1 << 24, 1 << 26],
    largest_on_cpu: 1 << 20,
    label: |size| size.to_string(),
    run: |gpu, variant, size, effort| {
        if variant.starts_with("kindled") {
            return kindled::run(gpu, variant, size, effort);
        }
        let bytes_per_item = if variant.starts_with("stateless") { 16.0 } else { 64.0 };
        must_be_within(variant, from_twin(gpu, variant)?, ROUNDING)?;
        let timing = time(gpu, variant, &fire(size), effort)?;
        Ok(Measured { timing, items: f64::from(size), unit: "particle", bytes_per_item })
    },
};

/// The kernel of fire that a variant names: `x4` has four particles an invocation.
fn materialise(gpu: &Gpu, variant: &str) -> Result<Materialise> {
    let items = variant.split('/').find_map(|option| option.strip_prefix('x')?.parse().ok());
    Ok(Builtin::Fire.materialise_by(gpu, items.unwrap_or(Materialise::ITEMS))?)
}

const SEED: u32 = 5;
const FPS: u32 = 60;
/// The first frame: late enough for all to live.
const FIRST: u64 = 3600;
/// Of the largest way: ages that are summed over 120 frames and velocities are off by some 2^-24 each, and no device's
/// directions by more than a few.
const ROUNDING: f64 = 1e-5;

/// Fire of which `live` particles live.
fn fire(live: u32) -> Effect {
    Effect { rate_per_s: f64::from(live), ..Builtin::Fire.effect() }
}

/// The list of a variant, whichever it is.
enum List {
    Compute(StoredEffect),
    Stream(StreamedEffect),
}

impl List {
    fn new(gpu: &Gpu, variant: &str, effect: &Effect) -> Result<Self> {
        let room = effect.most_particles() as u32;
        // Room for those that sums of ages keep a frame too long.
        let room = room + room / FPS + 64;
        Ok(if variant == "stored/xfb" {
            let vertex = shaders::BALLISTIC_FIRE_STREAM_VERT;
            if !gpu.has_transform_feedback() {
                return Err(Error::Lacks { variant: variant.into(), what: "transform feedback" });
            }
            Self::Stream(StreamedEffect::new(gpu, c"ballistic.stream", vertex, effect, room)?)
        } else {
            let emit = shaders::BALLISTIC_FIRE_EMIT_COMP;
            Self::Compute(StoredEffect::new(gpu, c"ballistic.fire_emit", emit, effect, room)?)
        })
    }

    fn record(&mut self, rec: &mut Recorder<'_>, frame: u64) {
        let now = Moment::of_frame(frame, FPS);
        match self {
            Self::Compute(list) => {
                list.record(rec, now, SEED, 0);
                rec.barrier(StoredEffect::EXIT, StoredEffect::ENTRY);
                rec.barrier(StoredEffect::EXIT, Access::IndirectRead);
            }
            Self::Stream(list) => {
                list.record(rec, now, SEED, 0);
                rec.barrier(StreamedEffect::EXIT, StreamedEffect::ENTRY);
            }
        }
    }

    fn download(&self, gpu: &Gpu) -> Result<Vec<Particle>> {
        Ok(match self {
            Self::Compute(list) => list.download(gpu)?.0,
            Self::Stream(list) => list.download(gpu)?,
        })
    }
}

/// Largest distance of a particle from the twin, of the largest distance from the emitter, after two lives.
fn from_twin(gpu: &Gpu, variant: &str) -> Result<f64> {
    let effect = fire(3001);
    let last = FIRST + 120;
    let now = Moment::of_frame(last, FPS);
    let params = effect.params(now, SEED, 0, &GroundGrid::FLAT, u32::MAX);
    let want: Vec<Vec3> =
        (0..params.births).filter_map(|i| Some(cpu::flight(Builtin::Fire, &params, None, i)?.at_m)).collect();
    let got: Vec<Vec3> = if variant.starts_with("stateless") {
        let vertices = materialise(gpu, variant)?.vertices(params.births, None)?;
        gpu.once(|rec| {
            vertices.record_params(rec, &params);
        })?;
        let all: Vec<Vertex> = vertices.download(gpu, params.births)?;
        all.iter().map(|vertex| Vec3::from(vertex.at_m)).collect()
    } else {
        let mut list = List::new(gpu, variant, &effect)?;
        gpu.once(|rec| (FIRST..=last).for_each(|frame| list.record(rec, frame)))?;
        let place = |particle: &Particle| {
            let [x, y, z, age] = particle.at_age;
            let [u, v, w, _] = particle.velocity;
            let r = cpu::reach_of(cpu::Wide { high: age, low: 0.0 }, 0.0);
            cpu::position(Vec3::new(x, y, z), Vec3::new(u, v, w), effect.acceleration_mps2, &r)
        };
        let mut all: Vec<Vec3> = list.download(gpu)?.iter().map(place).collect();
        all.drain(..all.len().saturating_sub(want.len()).min(1)); // at the end of its life, to rounding
        all
    };
    if got.len() != want.len() {
        return Ok(f64::INFINITY);
    }
    let largest = want.iter().map(|at| at.length()).fold(0.0, f32::max);
    let apart = got.iter().zip(&want).map(|(a, b)| (a - b).length());
    Ok(f64::from(apart.fold(0.0, |a: f32, b| if b.is_nan() { f32::INFINITY } else { a.max(b) }) / largest))
}

/// Time of a frame of an effect. Every frame is another: the clock goes on.
pub(in crate::study) fn time(gpu: &Gpu, variant: &str, effect: &Effect, effort: Effort) -> Result<Timing> {
    let mut frame = FIRST;
    if variant.starts_with("stateless") {
        let vertices = materialise(gpu, variant)?.vertices(effect.most_particles() as u32, None)?;
        return runs::time(gpu, effort, |rec| {
            vertices.record(rec, effect, Moment::of_frame(frame, FPS), SEED, 0, &GroundGrid::FLAT);
            rec.barrier(Access::ComputeWrite, Access::ComputeWrite);
            frame += 1;
        });
    }
    let mut list = List::new(gpu, variant, effect)?;
    gpu.once(|rec| list.record(rec, frame))?;
    runs::time(gpu, effort, |rec| {
        frame += 1;
        list.record(rec, frame);
    })
}
