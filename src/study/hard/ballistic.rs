// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hard cases of closed-form effects. The seed is the book's: the emitter's age decides once a frame, directions come from a
//! texture that is read at the game's time.

use super::{Case, Context, Outcome};
use crate::{
    ballistic::{
        cpu, stored::Particle, Builtin, Effect, Emission, GroundGrid, Moment, Params, StoredEffect, Vertex,
    },
    gpu::{Access, Gpu, Kernel, KernelInfo},
    shaders,
    study::{
        runs::{larger, Uniform},
        Result,
    },
};
use glam::{dvec3, vec3, DVec3, Vec3};
use std::collections::HashSet;

/// The table.
pub const CASES: &[Case] = &[
    Case {
        id: "P1",
        title: "fire bears 200 a second at 24, 60, 240 and 500 frames a second",
        variants: &["stateless", "stored"],
        unit: "births per second off 200",
        limit: 1.0,
        run: fire_per_second,
    },
    Case {
        id: "P2",
        title: "rain bears 500 bursts a second at 24, 60, 240, 500 and 1000 frames a second",
        variants: &["stateless", "stored"],
        unit: "bursts per second off 500",
        limit: 1.0,
        run: bursts_per_second,
    },
    Case {
        id: "P3",
        title: "directions are as even after 1, 6 and 24 hours as at the start",
        variants: &["stateless"],
        unit: "standard errors of mean and square",
        limit: 4.0,
        run: late_statistics,
    },
    Case {
        id: "P4",
        title: "no direction comes twice in a million births",
        variants: &["stored"],
        unit: "repeats",
        limit: 0.0,
        run: repeats,
    },
    Case {
        id: "P5",
        title: "directions are as dense in cones of 6 degrees at faces, edges and corners",
        variants: &["stored"],
        unit: "density / mean, less 1",
        limit: 0.05,
        run: density,
    },
    Case {
        id: "P6",
        title: "rain is where it is in f64, up to 3 s of fall, and a day after the start",
        variants: &["stateless"],
        unit: "ulp of the distance from the origin",
        limit: 4.0,
        run: closed_form,
    },
    Case {
        id: "P7",
        title: "the time of a fall is right where it grazes",
        variants: &["ground hit"],
        unit: "of the time",
        limit: 3e-7,
        run: ground_hit,
    },
    Case {
        id: "P8",
        title: "what a fast emitter bears lies evenly on its path at 20 frames a second",
        variants: &["stateless", "stored"],
        unit: "gap / even gap, less 1",
        limit: 0.01,
        run: fast_emitter,
    },
];

const SEED: u32 = 11;
const RATES: [u32; 4] = [24, 60, 240, 500];
const UNTOUCHED: u32 = 0x7fc0_1234;

/// Births in the second `second` of a game by the book: one when the emitter is older than `interval_s`, and no more a frame.
pub(in crate::study) fn seed_births(interval_s: f32, fps: u32, second: u32) -> u32 {
    let (mut age_s, mut births) = (0.0f32, 0);
    for frame in 0..fps * (second + 1) {
        age_s += 1.0 / fps as f32;
        if age_s > interval_s {
            age_s = 0.0;
            births += u32::from(frame >= fps * second);
        }
    }
    births
}

/// What the GPU writes of an effect at a moment: as many vertices as it touched.
fn materialise(gpu: &Gpu, effect: &Effect, now: Moment) -> Result<(Params, Vec<Vertex>)> {
    let room = effect.most_particles() as u32;
    let ground = gpu.upload("ballistic.ground_m", &[-1e6f32])?;
    let builtin = Builtin::named(&effect.name).expect("a built-in effect");
    let vertices = builtin.materialise(gpu)?.vertices(room, Some(&ground))?;
    gpu.once(|rec| {
        rec.fill(vertices.buffer(), UNTOUCHED);
        rec.barrier(Access::FillWrite, Access::ComputeWrite);
        vertices.record(rec, effect, now, SEED, 0, &GroundGrid::FLAT);
    })?;
    let mut all = vertices.download(gpu, room)?;
    all.retain(|vertex| vertex.at_m[0].to_bits() != UNTOUCHED);
    Ok((effect.params(now, SEED, 0, &GroundGrid::FLAT, room), all))
}

/// The list after `frames` frames, which begin at the start.
fn stored(gpu: &Gpu, effect: &Effect, frames: u64, fps: u32) -> Result<Vec<Particle>> {
    let emit = shaders::BALLISTIC_FIRE_EMIT_COMP;
    let room = effect.most_particles() as u32;
    let mut stored = StoredEffect::new(gpu, c"ballistic.fire_emit", emit, effect, room)?;
    gpu.once(|rec| {
        for frame in 0..=frames {
            stored.record(rec, Moment::of_frame(frame, fps), SEED, 0);
            rec.barrier(StoredEffect::EXIT, StoredEffect::ENTRY);
            rec.barrier(StoredEffect::EXIT, Access::IndirectRead);
        }
    })?;
    Ok(stored.download(gpu)?.0)
}

/// How far births of the last second are from the rate, at the worst frame rate, as a list of what lives for a second shows
/// them.
pub(in crate::study) fn off_rate(gpu: &Gpu, variant: &str, effect: &Effect, rates: &[u32]) -> Result<f64> {
    let mut worst = 0.0f64;
    for &fps in rates {
        let frames = 2 * u64::from(fps);
        let alive = match variant {
            "stored" => stored(gpu, effect, frames, fps)?.len(),
            _ => materialise(gpu, effect, Moment::of_frame(frames, fps))?.1.len(),
        };
        let births = alive as f64 / f64::from(effect.burst);
        worst = worst.max((births - effect.rate_per_s).abs());
    }
    Ok(worst)
}

fn fire_per_second(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let measured = off_rate(context.gpu, variant, &Builtin::Fire.effect(), &RATES)?;
    let seed = RATES.map(|fps| seed_births(0.005, fps, 1));
    let worst = seed.map(|births| f64::from(births.abs_diff(200))).into_iter().fold(0.0, f64::max);
    Ok(Outcome::of(measured).seed(worst).note(format!("the book: {seed:?} per s")))
}

fn bursts_per_second(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    // Bursts of five, which live for a second here: so many are born in one.
    let mut effect = Builtin::Fire.effect();
    (effect.rate_per_s, effect.burst) = (500.0, 5);
    const RATES: [u32; 5] = [24, 60, 240, 500, 1000];
    let measured = off_rate(context.gpu, variant, &effect, &RATES)?;
    let seed = RATES.map(|fps| seed_births(0.002, fps, 1));
    let worst = seed.map(|births| f64::from(births.abs_diff(500))).into_iter().fold(0.0, f64::max);
    Ok(Outcome::of(measured).seed(worst).note(format!("the book: {seed:?} per s")))
}

/// The book's directions: a texture of 1024 random vectors, read linearly at the time of the game, and normalised.
pub(in crate::study) struct SeedTexture(Vec<Vec3>);

impl SeedTexture {
    pub(in crate::study) fn new() -> Self {
        let mut uniform = Uniform(5).map(|u| (2.0 * u - 1.0) as f32);
        let mut next = || uniform.next().unwrap_or_default();
        Self((0..1024).map(|_| vec3(next(), next(), next())).collect())
    }

    pub(in crate::study) fn direction(&self, u: f32) -> Vec3 {
        let at = u.fract() * 1024.0 - 0.5;
        let (low, part) = (at.floor(), at - at.floor());
        let texel = |i: f32| self.0[i.rem_euclid(1024.0) as usize % 1024];
        texel(low).lerp(texel(low + 1.0), part).normalize_or(Vec3::Y)
    }
}

/// Largest distance of the means of directions and of their squares from 0 and 1/3, in standard errors.
fn standard_errors(ways: &[DVec3]) -> f64 {
    let n = ways.len() as f64;
    let sum: DVec3 = ways.iter().sum();
    let squares: DVec3 = ways.iter().map(|&way| way * way).sum();
    let mean = (sum / n).abs().max_element() / (1.0 / (3.0 * n)).sqrt();
    let square = (squares / n - 1.0 / 3.0).abs().max_element() / (4.0 / 45.0 / n).sqrt();
    mean.max(square)
}

/// Direction of a velocity of fire, whose x and z are halved.
pub(in crate::study) fn unhalved(v: DVec3) -> DVec3 {
    (v * dvec3(2.0, 1.0, 2.0)).normalize_or(DVec3::ZERO)
}

fn late_statistics(context: &Context<'_>, _: &str) -> Result<Outcome> {
    let mut effect = Builtin::Fire.effect();
    (effect.acceleration_mps2, effect.emitter.at_m, effect.life_s) = (Vec3::ZERO, Vec3::ZERO, 100.0);
    let texture = SeedTexture::new();
    let (mut worst, mut seeds, mut distinct) = (0.0f64, 0.0f64, Vec::new());
    for hours in [0.03, 1.0, 6.0, 24.0] {
        let start_s = 3600.0 * hours;
        // Without acceleration, all fly straight from the origin.
        let (_, all) = materialise(context.gpu, &effect, Moment::from_s(start_s))?;
        let ways: Vec<DVec3> = all
            .iter()
            .map(|vertex| unhalved(Vec3::from(vertex.at_m).as_dvec3()))
            .filter(|way| *way != DVec3::ZERO)
            .collect();
        worst = larger(worst, if ways.len() < 19_900 { f64::NAN } else { standard_errors(&ways) });
        let seed: Vec<DVec3> = (0..20_000)
            .map(|i| texture.direction((start_s + 0.005 * f64::from(i)) as f32).as_dvec3())
            .collect();
        seeds = seeds.max(standard_errors(&seed));
        let words: HashSet<_> = seed.iter().map(|way| way.to_array().map(f64::to_bits)).collect();
        distinct.push(words.len());
    }
    let note =
        format!("the book: {distinct:?} distinct directions of 20000 at the start and after 1, 6, 24 h");
    Ok(Outcome::of(worst).seed(seeds).note(note))
}

/// Velocities of a million births from `first_s` on, as the GPU stores them.
pub(in crate::study) fn velocities(gpu: &Gpu, first_s: u64) -> Result<Vec<Vec3>> {
    let mut effect = Builtin::Fire.effect();
    effect.rate_per_s = 1e6;
    let emit = shaders::BALLISTIC_FIRE_EMIT_COMP;
    let mut stored = StoredEffect::new(gpu, c"ballistic.fire_emit", emit, &effect, 1_000_000)?;
    gpu.once(|rec| {
        stored.record(rec, Moment::from_s(first_s as f64 + 0.9999999), SEED, 0);
    })?;
    let list: Vec<Particle> = gpu.download(stored.list())?;
    Ok(list
        .iter()
        .map(|particle| vec3(particle.velocity[0], particle.velocity[1], particle.velocity[2]))
        .collect())
}

fn repeats(context: &Context<'_>, _: &str) -> Result<Outcome> {
    let all = velocities(context.gpu, 0)?;
    let distinct: HashSet<_> = all.iter().map(|v| v.to_array().map(f32::to_bits)).collect();
    let texture = SeedTexture::new();
    let seed: HashSet<_> = (0..1_000_000)
        .map(|frame| texture.direction(frame as f32 / 64.0).to_array().map(f32::to_bits))
        .collect();
    let note = format!("the book, at a fixed 1/64 s: {} distinct directions ever", seed.len());
    let missing = |n: usize| (1_000_000 - n) as f64;
    Ok(Outcome::of(missing(distinct.len()))
        .seed(missing(seed.len()))
        .only_if(all.len() == 1_000_000)
        .note(note))
}

/// Density of directions in cones of half angle 6 degrees round faces, edges and corners of a cube, and of mean.
pub(in crate::study) fn densities(ways: impl Iterator<Item = DVec3>) -> [f64; 26] {
    let mut axes = Vec::new();
    for x in -1..=1 {
        for y in -1..=1 {
            for z in -1..=1 {
                axes.push(dvec3(x.into(), y.into(), z.into()).normalize_or(DVec3::ZERO));
            }
        }
    }
    axes.retain(|axis| *axis != DVec3::ZERO);
    let cos = 6f64.to_radians().cos();
    let (mut counts, mut n) = ([0.0; 26], 0.0);
    for way in ways {
        n += 1.0;
        for (count, axis) in counts.iter_mut().zip(&axes) {
            *count += f64::from(u8::from(axis.dot(way) > cos));
        }
    }
    counts.map(|count| count / n / (0.5 * (1.0 - cos)))
}

fn density(context: &Context<'_>, _: &str) -> Result<Outcome> {
    // 4 million: some 11000 a cone, so that three standard errors are 0.03.
    let mut ways = Vec::new();
    for batch in 0..4 {
        ways.extend(velocities(context.gpu, batch)?.into_iter().map(|v| unhalved(v.as_dvec3())));
    }
    let n = ways.len() as u32;
    let worst = |of: [f64; 26]| of.into_iter().map(|d| (d - 1.0).abs()).fold(0.0, f64::max);
    let measured = worst(densities(ways.into_iter()));
    let mut uniform = Uniform(7).map(|u| 2.0 * u - 1.0);
    let mut next = || uniform.next().unwrap_or_default();
    let cube = (0..1_000_000).map(|_| dvec3(next(), next(), next()).normalize_or(DVec3::Y));
    let seed = densities(cube);
    let (least, most) = seed.iter().fold((f64::MAX, 0.0f64), |(a, b), &d| (a.min(d), b.max(d)));
    let note = format!("the book: {least:.2} at faces to {most:.2} at corners");
    Ok(Outcome::of(measured).seed(worst(seed)).only_if(n == 4_000_000).note(note))
}

fn ulp_of(length: f64) -> f64 {
    let length = length as f32;
    f64::from(f32::from_bits(length.to_bits() + 1) - length)
}

fn closed_form(context: &Context<'_>, _: &str) -> Result<Outcome> {
    let effect = Builtin::Rain.effect();
    let (pull, emission) = (effect.acceleration_mps2.as_dvec3(), effect.emission());
    let (mut worst, mut whole) = (0.0f64, true);
    for time_s in [3.0, 1000.3, 86_400.77] {
        let now = Moment::from_s(time_s);
        let (params, all) = materialise(context.gpu, &effect, now)?;
        whole &= all.len() as u32 == params.births * params.burst;
        for (i, vertex) in all.iter().enumerate() {
            let (who, back) = cpu::who(&params, i as u32);
            let emitter = cpu::emitter_at(&params, cpu::age_of(&params, back));
            let start = cpu::birth(Builtin::Rain, &params, who, emitter);
            let (p0, v0) = (start.at_m.as_dvec3(), start.velocity_mps.as_dvec3());
            let want = cpu::position_f64(p0, v0, pull, emission.age_s(now, who.serial), 0.0);
            let apart = (Vec3::from(vertex.at_m).as_dvec3() - want).length();
            worst = larger(worst, apart / ulp_of(want.length()));
        }
    }
    // Stepped at 60 frames a second, position first: half a step of fall behind at every step.
    let (mut at, mut v, dt) = (vec3(0.0, 30.0, 0.0), Vec3::ZERO, 1.0 / 60.0f32);
    for _ in 0..180 {
        at += v * dt;
        v += effect.acceleration_mps2 * dt;
    }
    let want = cpu::position_f64(dvec3(0.0, 30.0, 0.0), DVec3::ZERO, pull, 3.0, 0.0);
    let apart = (at.as_dvec3() - want).length();
    let note = format!("stepped at 60 fps: {apart:.3} m off after 3 s");
    Ok(Outcome::of(worst).seed(apart / ulp_of(want.length())).only_if(whole).note(note))
}

pub(in crate::study) fn fall_kernel(gpu: &Gpu) -> Result<Kernel> {
    let info = KernelInfo {
        name: c"ballistic.fall",
        spv: shaders::BALLISTIC_FALL_COMP,
        blocks: &["Falls", "Times"],
        constants: &[64],
    };
    Ok(Kernel::new::<Params>(gpu, &info)?)
}

fn ground_hit(context: &Context<'_>, _: &str) -> Result<Outcome> {
    let mut falls = Vec::new();
    for above in [1e-6f32, 3e-6, 1e-5, 3e-5, 1e-4, 1e-2, 0.3, 1.0, 20.0, 900.0] {
        for rise in [-80.0f32, -29.4, -3.0, -1e-3, 0.0, 1e-3, 2.0, 30.0] {
            falls.extend([-9.8f32, -1.6, -1e-3].map(|pull| [above, rise, pull, 0.0]));
        }
    }
    let (gpu, count) = (context.gpu, falls.len() as u32);
    let (from, to) =
        (gpu.upload("ballistic.falls", &falls)?, gpu.upload("ballistic.times_s", &vec![0f32; falls.len()])?);
    let bound = fall_kernel(gpu)?.bind(&[("Falls", (&from).into()), ("Times", (&to).into())])?;
    let params = Builtin::Rain.effect().params(Moment::default(), SEED, 0, &GroundGrid::FLAT, count);
    gpu.once(|rec| rec.dispatch(&bound, [count, 1, 1], &params))?;
    let times: Vec<f32> = gpu.download(&to)?;
    let (mut worst, mut naive) = (0.0f64, 0.0f64);
    for ([above, rise, pull, _], got) in falls.into_iter().zip(times) {
        let want = cpu::fall_time_f64(above.into(), rise.into(), pull.into());
        worst = larger(worst, (f64::from(got) / want - 1.0).abs());
        let root = (-rise - (rise * rise - 2.0 * pull * above).sqrt()) / pull;
        naive = naive.max((f64::from(root) / want - 1.0).abs());
    }
    Ok(Outcome::of(worst).seed(naive).note("the root (-v - s) / a beside"))
}

fn fast_emitter(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let mut effect = Builtin::Fire.effect();
    let speed = 60.0;
    (effect.emitter.velocity_mps, effect.acceleration_mps2) = (vec3(speed, 0.0, 0.0), Vec3::ZERO);
    let (frames, fps) = (27, 20);
    let starts_m: Vec<f64> = if variant == "stored" {
        stored(context.gpu, &effect, frames, fps)?
            .iter()
            .map(|particle| f64::from(particle.at_age[0]))
            .collect()
    } else {
        let (params, all) = materialise(context.gpu, &effect, Moment::of_frame(frames, fps))?;
        let start = |(i, vertex): (usize, &Vertex)| {
            let (who, back) = cpu::who(&params, i as u32);
            // Where it was born is what is left without its own flight.
            let birth = cpu::birth(Builtin::Fire, &params, who, Vec3::ZERO);
            f64::from(vertex.at_m[0])
                - f64::from(birth.velocity_mps.x) * f64::from(cpu::age_of(&params, back).high)
        };
        all.iter().enumerate().map(start).collect()
    };
    let even =
        f64::from(speed) * Emission::new(effect.rate_per_s, 1.0).map_or(f64::NAN, Emission::interval_s);
    let worst = |starts: &[f64]| {
        starts.windows(2).map(|pair| ((pair[1] - pair[0]) / even - 1.0).abs()).fold(0.0, larger)
    };
    // The book: one a frame, where the emitter is at its end.
    let seed: Vec<f64> = (0..20).map(|frame| f64::from(frame) * f64::from(speed) / f64::from(fps)).collect();
    // A sum of ages may keep, or end, the one whose life ends at this very moment.
    Ok(Outcome::of(worst(&starts_m)).seed(worst(&seed)).only_if((199..=201).contains(&starts_m.len())))
}
