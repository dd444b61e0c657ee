// SPDX-License-Identifier: MIT OR Apache-2.0
//! Closed-form effects: age from the clock, age that is summed, flight that is summed; and what the frame rate does to births
//! and directions of the book's emitter.

use super::{
    bench::ballistic::time,
    hard::ballistic::{densities, off_rate, seed_births, unhalved, velocities, SeedTexture},
    runs::{self, larger, Effort},
    shapes::{finite, Headline, Point, StudyResult},
    Found, OnProgress, Progress, Result,
};
use crate::{
    ballistic::{cpu, stored::Particle, Builtin, Effect, GroundGrid, Moment, Params, StoredEffect, Vertex},
    gpu::{Access, Gpu, Kernel, KernelInfo},
    shaders,
};
use glam::{vec3, vec4, DVec3, Vec3, Vec4};

/// As results name it.
pub const NAME: &str = "ballistic";

const SEED: u32 = 5;
const LIFE_S: u64 = 3;
/// Births of a second, of the emission and the directions that are studied.
const NOMINAL: u32 = 200;

/// Particles of fire that live for 3 s under the pull of rain.
fn effect(live: u32) -> Effect {
    Effect {
        rate_per_s: f64::from(live) / LIFE_S as f64,
        life_s: LIFE_S as f64,
        acceleration_mps2: vec3(-1.0, -9.8, 0.0),
        ..Builtin::Fire.effect()
    }
}

fn params(effect: &Effect, now: Moment) -> Params {
    effect.params(now, SEED, 0, &GroundGrid::FLAT, u32::MAX)
}

fn birth(p: &Params, i: u32) -> (cpu::Birth, u64) {
    let (who, back) = cpu::who(p, i);
    (cpu::birth(Builtin::Fire, p, who, cpu::emitter_at(p, cpu::age_of(p, back))), who.serial)
}

fn exact(effect: &Effect, birth: &cpu::Birth, age_s: f64) -> DVec3 {
    let pull = effect.acceleration_mps2.as_dvec3();
    cpu::position_f64(birth.at_m.as_dvec3(), birth.velocity_mps.as_dvec3(), pull, age_s, 0.0)
}

fn farthest(distances: impl Iterator<Item = f64>) -> f64 {
    distances.fold(0.0, |most, d| if d.is_finite() { most.max(d) } else { f64::INFINITY })
}

/// Runs it: positions, births and directions.
///
/// # Errors
/// The device's.
pub fn study(gpu: &Gpu, quick: bool, progress: OnProgress<'_>) -> Result<Found> {
    let live = if quick || gpu.adapter().is_software() { 1 << 14 } else { 1 << 22 };
    let rates: &[u32] = if quick { &[24, 60] } else { &[24, 60, 144, 240, 1000] };
    let effort = Effort { budget_s: 0.5, ..Effort::full(gpu) };
    let (mut done, of) = (0, 3 * rates.len());
    let mut step = |what: &str, fps: u32| {
        progress(Progress { done, of, now: &format!("{NAME}: {what}, {fps} frames a second") });
        done += 1;
    };
    let point = |variant: &str, fps: u32, size: u32, error: f64, metric: &str, ms: f64| Point {
        variant: variant.into(),
        step: 1.0 / f64::from(fps),
        size,
        error: finite(error),
        metric: metric.into(),
        ms_per_sim_second: ms * f64::from(fps),
        ns_per_item: 1e6 * ms / f64::from(size),
        pareto: false,
    };
    let effect = effect(live);
    let stateless_ms = time(gpu, "stateless/materialise", &effect, effort)?.median_ms;
    let stored_ms = time(gpu, "stored/append", &effect, effort)?.median_ms;

    let metric = "largest distance (m)";
    let mut positions = Vec::new();
    for &fps in rates {
        step("positions", fps);
        positions.push(point("stateless", fps, live, stateless(gpu, &effect, fps)?, metric, stateless_ms));
        positions.push(point("stored", fps, live, stored(gpu, &effect, fps)?, metric, stored_ms));
        let (error, ms) = integrated(gpu, &effect, live, fps, effort)?;
        positions.push(point("integrated", fps, live, error, metric, ms));
    }

    // The book's births are fewer, and so is the work: it is timed with as many as there are.
    let (texture, even) = (SeedTexture::new(), even_directions(gpu)?);
    let metric = ["births off the nominal, part of it", "density of directions off the mean, part of it"];
    let (mut births, mut directions) = (Vec::new(), Vec::new());
    for &fps in rates {
        step("births", fps);
        let off = |variant: &str| -> Result<f64> {
            Ok(off_rate(gpu, variant, &effect_at(NOMINAL), &[fps])? / f64::from(NOMINAL))
        };
        let [ours, listed]: [Result<f64>; 2] = ["stateless", "stored"].map(off);
        let share = f64::from(seed_births(1.0 / NOMINAL as f32, fps, 1)) / f64::from(NOMINAL);
        let fewer = Effect { rate_per_s: effect.rate_per_s * share, ..effect.clone() };
        let book_ms = time(gpu, "stored/append", &fewer, effort)?.median_ms;
        for (variant, error, ms) in [
            ("stateless", ours?, stateless_ms),
            ("stored", listed?, stored_ms),
            ("seed", (share - 1.0).abs(), book_ms),
        ] {
            births.push(point(variant, fps, live, error, metric[0], ms));
        }
        step("directions", fps);
        let seeds = seed_directions(&texture, fps);
        for (variant, error, ms) in [("stateless", even, stateless_ms), ("seed", seeds, book_ms)] {
            directions.push(point(variant, fps, live, error, metric[1], ms));
        }
    }

    let headline = |what: &str, value: Option<f64>, unit: &str, note: &str| Headline {
        sim: NAME.into(),
        study: "positions".into(),
        what: what.into(),
        value,
        unit: unit.into(),
        note: note.into(),
    };
    let errors = positions.iter().filter(|p| p.variant == "stateless").map(|p| p.error.unwrap_or(f64::NAN));
    let worst = errors.fold(0.0, larger);
    let headlines = vec![
        headline(
            "time of the stored list / time without one, of as many particles",
            finite(stored_ms / stateless_ms),
            "times",
            "the list's particles are aged and appended, and not placed yet; the others are placed vertices",
        ),
        headline("largest error without a list, at any frame rate", finite(worst), "m", "up to 45 m of fall"),
    ];
    let result = |study: &str, reference: &str, points, tolerances: &[f64], seed: &str| {
        let mut result = StudyResult {
            sim: NAME.into(),
            study: study.into(),
            reference: reference.into(),
            points,
            cheapest: Vec::new(),
        };
        result.mark_pareto();
        result.cheapest = result.cheapest_for(tolerances, seed);
        result
    };
    let studies = vec![
        result(
            "positions",
            "closed form in f64, of the same births; `stored` is aged and appended and not placed yet",
            positions,
            &[0.1, 1e-3, 1e-5],
            "stored",
        ),
        result(
            "emission",
            "200 births a second, scaled up to as many as live",
            births,
            &[0.1, 0.01, 0.0],
            "seed",
        ),
        result(
            "directions",
            "even density in 26 cones of 6 degrees, 400000 births: chance alone is about 0.08",
            directions,
            &[0.5, 0.1],
            "seed",
        ),
    ];
    Ok(Found { studies, headlines, parts: Vec::new() })
}

fn effect_at(rate_per_s: u32) -> Effect {
    Effect { rate_per_s: f64::from(rate_per_s), ..Builtin::Fire.effect() }
}

/// Largest error of vertices (m).
fn stateless(gpu: &Gpu, effect: &Effect, fps: u32) -> Result<f64> {
    let now = Moment::of_frame(2 * LIFE_S * u64::from(fps), fps);
    let p = params(effect, now);
    let vertices = Builtin::Fire.materialise(gpu)?.vertices(p.births, None)?;
    gpu.once(|rec| {
        vertices.record_params(rec, &p);
    })?;
    let all: Vec<Vertex> = vertices.download(gpu, p.births)?;
    let apart = |(i, vertex): (usize, &Vertex)| {
        let (birth, serial) = birth(&p, i as u32);
        let want = exact(effect, &birth, effect.emission().age_s(now, serial));
        (Vec3::from(vertex.at_m).as_dvec3() - want).length()
    };
    Ok(farthest(all.iter().enumerate().map(apart)))
}

/// Largest error of a list whose ages are sums over a whole life, placed as the shader does (m).
fn stored(gpu: &Gpu, effect: &Effect, fps: u32) -> Result<f64> {
    let emit = shaders::BALLISTIC_FIRE_EMIT_COMP;
    let room = effect.most_particles() as u32;
    let room = room + room / 16 + 64;
    let mut list = StoredEffect::new(gpu, c"ballistic.fire_emit", emit, effect, room)?;
    let last = 2 * LIFE_S * u64::from(fps);
    let mut frame = LIFE_S * u64::from(fps);
    while frame <= last {
        let batch = (frame + 500).min(last + 1);
        gpu.once(|rec| {
            for frame in frame..batch {
                list.record(rec, Moment::of_frame(frame, fps), SEED, 0);
                rec.barrier(StoredEffect::EXIT, StoredEffect::ENTRY);
                rec.barrier(StoredEffect::EXIT, Access::IndirectRead);
            }
        })?;
        frame = batch;
    }
    let now = Moment::of_frame(last, fps);
    let p = params(effect, now);
    let all = list.download(gpu)?.0;
    // Rounding may end those of one frame too early; who else is missing has been lost.
    if all.len() as u64 + u64::from(p.births) / (LIFE_S * u64::from(fps)) + 1 < u64::from(p.births) {
        return Ok(f64::INFINITY);
    }
    // By age, the youngest last: sums may keep or end a few too many at the other end.
    let apart = |(back, particle): (usize, &Particle)| {
        let i = p.births - 1 - back as u32;
        let (birth, serial) = birth(&p, i);
        let want = exact(effect, &birth, effect.emission().age_s(now, serial));
        let [x, y, z, age] = particle.at_age;
        let [u, v, w, _] = particle.velocity;
        let r = cpu::reach_of(cpu::Wide { high: age, low: 0.0 }, 0.0);
        let at = cpu::position(vec3(x, y, z), vec3(u, v, w), effect.acceleration_mps2, &r);
        (at.as_dvec3() - want).length()
    };
    Ok(farthest(all.iter().rev().take(p.births as usize).enumerate().map(apart)))
}

/// `Push` of `glsl/ballistic/integrate.comp`.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct StepParams {
    acceleration: Vec4,
    dt_s: f32,
    count: u32,
    row: u32,
    reserved: u32,
}

pub(super) fn integrate_kernel(gpu: &Gpu) -> Result<Kernel> {
    let info = KernelInfo {
        name: c"ballistic.integrate",
        spv: shaders::BALLISTIC_INTEGRATE_COMP,
        blocks: &["Flying"],
        constants: &[256],
    };
    Ok(Kernel::new::<StepParams>(gpu, &info)?)
}

/// Largest error of flight by steps of frames, 3 s long (m), and the time of a step (ms).
fn integrated(gpu: &Gpu, effect: &Effect, count: u32, fps: u32, effort: Effort) -> Result<(f64, f64)> {
    const ROW: u32 = 1 << 20;
    let p = params(effect, Moment::from_s(2.0 * LIFE_S as f64));
    let count = count.min(p.births);
    let births: Vec<cpu::Birth> = (0..count).map(|i| birth(&p, i).0).collect();
    let start: Vec<Particle> = births
        .iter()
        .map(|birth| Particle {
            at_age: birth.at_m.extend(0.0).to_array(),
            velocity: birth.velocity_mps.extend(0.0).to_array(),
        })
        .collect();
    let flying = gpu.upload("ballistic.flying", &start)?;
    let bound = integrate_kernel(gpu)?.bind(&[("Flying", (&flying).into())])?;
    let pull = effect.acceleration_mps2;
    let row = count.min(ROW);
    let params = StepParams {
        acceleration: vec4(pull.x, pull.y, pull.z, 0.0),
        dt_s: 1.0 / fps as f32,
        count,
        row,
        reserved: 0,
    };
    let threads = [row, count.div_ceil(row), 1];
    gpu.once(|rec| {
        for _ in 0..LIFE_S * u64::from(fps) {
            rec.dispatch(&bound, threads, &params);
            rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        }
    })?;
    let all: Vec<Particle> = gpu.download(&flying)?;
    let apart = |(particle, birth): (&Particle, &cpu::Birth)| {
        let [x, y, z, _] = particle.at_age;
        (vec3(x, y, z).as_dvec3() - exact(effect, birth, LIFE_S as f64)).length()
    };
    let error = farthest(all.iter().zip(&births).map(apart));
    let timing = runs::time(gpu, effort, |rec| {
        rec.dispatch(&bound, threads, &params);
        rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
    })?;
    Ok((error, timing.median_ms))
}

const BIRTHS: u32 = 400_000;

fn off_even(ways: impl Iterator<Item = DVec3>) -> f64 {
    densities(ways).into_iter().map(|density| (density - 1.0).abs()).fold(0.0, f64::max)
}

/// Of as many of the device's births: no frame is in them.
fn even_directions(gpu: &Gpu) -> Result<f64> {
    let all = velocities(gpu, 0)?;
    Ok(off_even(all.into_iter().take(BIRTHS as usize).map(|v| unhalved(v.as_dvec3()))))
}

/// Of the book's, at the times of the frames that bear one.
fn seed_directions(texture: &SeedTexture, fps: u32) -> f64 {
    let (mut age_s, mut frame, mut left) = (0.0f32, 0u32, BIRTHS);
    off_even(std::iter::from_fn(|| {
        left = left.checked_sub(1)?;
        loop {
            frame += 1;
            age_s += 1.0 / fps as f32;
            if age_s > 1.0 / NOMINAL as f32 {
                age_s = 0.0;
                return Some(texture.direction(frame as f32 / fps as f32).as_dvec3());
            }
        }
    }))
}
