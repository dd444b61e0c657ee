// SPDX-License-Identifier: MIT OR Apache-2.0
//! The black hole: integrator and substeps against the exact orbit. Particles with an apocentre of 60 m and one periapsis,
//! anywhere on their orbits, for 10 s at 60 steps a second about the book's hole; and those that the book emits, for who
//! is swallowed.

use super::{
    runs::{self, Effort, Timing},
    shapes::{finite, Point, StudyResult},
    OnProgress, Progress, Result,
};
use crate::{
    gpu::{Access, Buffer, Gpu, Residence},
    particles::{
        black_hole::{BlackHole, Hole, Integrator},
        black_hole_fate::Fates,
        cpu_black_hole::Body,
        kepler_stateless::{Fountain, Stateless},
        oracle::Orbit,
        Compaction, Options, Particle, Particles, PoolInfo, Step,
    },
    random,
};
use glam::{DVec3, Vec3};

/// As results name it.
pub const NAME: &str = "black hole";
/// The book's hole (m^3/s^2, m).
pub const MU_M3PS2: f64 = 1e4;
/// (m).
pub const HORIZON_M: f64 = 5.0;
/// Of a step: 60 a second, to the tick.
pub const FRAME_TICKS: u32 = 1092;
const FRAMES: u32 = 600;
const APOCENTRE_M: f64 = 60.0;

/// The book's hole at the origin.
pub fn hole() -> Hole {
    Hole::at([0.0; 3], MU_M3PS2 as f32, HORIZON_M as f32)
}

/// The law that a variant names: `leapfrog`, `leapfrog/x4`.
///
/// # Panics
/// If it names none: variants are written in tables of this crate.
pub fn law(variant: &str, hole: Hole) -> BlackHole {
    let mut parts = variant.split('/').skip_while(|part| *part == "law");
    let integrator = parts.next().and_then(Integrator::named);
    let substeps = parts.find_map(|part| part.strip_prefix('x')?.parse().ok()).unwrap_or(1);
    let integrator = integrator.unwrap_or_else(|| panic!("`{variant}` names no integrator"));
    BlackHole { holes: vec![hole], integrator, substeps }
}

/// What the oracle makes of a particle about a hole at the origin.
pub fn orbit(body: &Body<f32>) -> Orbit {
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    Orbit { mu_m3ps2: MU_M3PS2, at_m: wide(body.at_m), velocity_mps: wide(body.velocity_mps) }
}

/// Particles between periapsis and apocentre, turned every way; anywhere on their orbits, or all at the apocentre.
pub fn ellipses(count: u32, periapsis_m: f64, apocentre_m: f64, is_anywhere: bool) -> Vec<Body<f32>> {
    let speed = (2.0 * MU_M3PS2 * periapsis_m / (apocentre_m * (apocentre_m + periapsis_m))).sqrt();
    let body = |serial| {
        let [u, v, w, part] = random::units(random::bits(17, 0, serial, 0));
        let out = random::direction_of([u, v]).as_dvec3();
        let turn = random::cos_sin_of_turn(w).as_dvec2();
        let (a, b) = out.normalize().any_orthonormal_pair();
        let start = Orbit {
            mu_m3ps2: MU_M3PS2,
            at_m: apocentre_m * out.normalize(),
            velocity_mps: speed * (turn.x * a + turn.y * b),
        };
        let period = start.period_s().expect("an ellipse");
        let there = if is_anywhere { start.after(f64::from(part) * period) } else { start };
        Body { at_m: there.at_m.as_vec3().into(), velocity_mps: there.velocity_mps.as_vec3().into(), born: 0 }
    };
    (0..count).map(body).collect()
}

/// Particles as the book emits them, all at tick 0, as seen from the hole.
pub fn emitted(count: u32) -> Vec<Body<f32>> {
    let fountain = Fountain { period_ticks: 0, ..Fountain::book(1e9) };
    let seen = |n| {
        let birth = fountain.at_birth(n);
        let at: [f32; 3] = std::array::from_fn(|k| birth.at_m[k] - fountain.hole_m[k]);
        Body { at_m: at, born: 0, ..birth }
    };
    (0..count).map(seen).collect()
}

/// The variant that steps, or one flight in closed form from birth to the end: what the stateless kernel does.
pub fn fates(
    gpu: &Gpu,
    variant: &str,
    hole: Hole,
    bodies: &[Body<f32>],
    (dt_ticks, steps): (u32, u32),
) -> Result<Vec<(Body<f32>, Option<f32>)>> {
    if variant == "kepler-stateless" {
        return Ok(Fates::new(gpu, &law("kepler", hole), bodies)?.run(0, dt_ticks * steps, 1)?);
    }
    Ok(Fates::new(gpu, &law(variant, hole), bodies)?.run(0, dt_ticks, steps)?)
}

/// Errors of the places, over the apocentre, smallest first; what was swallowed and ought not to have been is an apocentre
/// off.
fn errors(gpu: &Gpu, variant: &str, bodies: &[Body<f32>]) -> Result<Vec<f64>> {
    let seconds = f64::from(FRAME_TICKS * FRAMES) / 65536.0;
    let ends = fates(gpu, variant, hole(), bodies, (FRAME_TICKS, FRAMES))?;
    let error = |(from, (body, end)): (&Body<f32>, (Body<f32>, Option<f32>))| {
        let orbit = orbit(from);
        let there = DVec3::from_array(body.at_m.map(f64::from));
        let off = (there - orbit.after(seconds).at_m).length() / orbit.apocentre();
        if end.is_some() || !off.is_finite() {
            1.0
        } else {
            off
        }
    };
    let mut errors: Vec<f64> = bodies.iter().zip(ends).map(error).collect();
    errors.sort_by(f64::total_cmp);
    Ok(errors)
}

fn at(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

/// Share of those emitted for whom swallowed and not swallowed are mistaken, after as many whole steps as go into 10 s.
pub fn mistaken(gpu: &Gpu, variant: &str, bodies: &[Body<f32>], dt_ticks: u32) -> Result<f64> {
    let steps = 655_360 / dt_ticks;
    let life = f64::from(steps * dt_ticks) / 65536.0;
    let ends = fates(gpu, variant, hole(), bodies, (dt_ticks, steps))?;
    // Who is left without a place was not spared.
    let is_wrong = |(body, (to, end)): &(&Body<f32>, (Body<f32>, Option<f32>))| {
        let is_spared = end.is_none() && to.at_m.iter().all(|x| x.is_finite());
        orbit(body).capture_s(HORIZON_M, life).is_none() != is_spared
    };
    let wrong = bodies.iter().zip(ends).filter(|pair| is_wrong(pair)).count();
    Ok(wrong as f64 / bodies.len() as f64)
}

/// Time of a frame of `count` particles that a law moves in place, in a pool without births: those of `bodies` over and over,
/// for the ten seconds of the study again and again, so that a law is timed with the particles that it is judged by, and not
/// with those that its errors have left.
///
/// # Errors
/// The device's.
pub fn frame(gpu: &Gpu, law: &BlackHole, bodies: &[Body<f32>], count: u32, effort: Effort) -> Result<Timing> {
    let constants = law.constants();
    let options = Options { compaction: Compaction::InPlace, ..Options::for_device(gpu) };
    let kernels = Particles::new(gpu, &BlackHole::law(&constants), options)?;
    let info =
        PoolInfo { capacity: count, life_s: 3e4, seed: 0, start: 0, emitters: &[], law: law.numbers() };
    let mut pool = kernels.pool(&info)?;
    let particle = |body: &Body<f32>| Particle {
        at_m: Vec3::from_array(body.at_m),
        velocity_mps: Vec3::from_array(body.velocity_mps),
        born: 0,
    };
    let all: Vec<_> = bodies.iter().map(particle).cycle().take(count as usize).collect();
    pool.upload(&all)?;
    let start = Buffer::new(gpu, "bench.start", pool.particles().bytes(), Residence::Device)?;
    gpu.once(|rec| rec.copy(pool.particles(), &start))?;
    let mut frames = 0;
    runs::time(gpu, effort, |rec| {
        if frames % FRAMES == 0 {
            rec.barrier(Particles::EXIT, Access::CopyWrite);
            rec.copy(&start, pool.particles());
            rec.barrier(Access::CopyWrite, Particles::ENTRY);
        }
        frames += 1;
        let now = pool.now();
        pool.record(rec, &Step::between(now, now.wrapping_add(FRAME_TICKS)));
        rec.barrier(Particles::EXIT, Particles::ENTRY);
    })
}

/// Time to work out where `count` particles of a fountain are, once.
///
/// # Errors
/// The device's.
pub fn stateless_frame(gpu: &Gpu, count: u32, writes: bool, effort: Effort) -> Result<Timing> {
    // Ages from birth to 10 s, all alive but for those that are swallowed.
    let fountain = Fountain::book(f64::from(count) / 10.0);
    let kernel = Stateless::new(gpu, &fountain, count, writes)?;
    runs::time(gpu, effort, |rec| {
        kernel.record(rec, 655_359, 0, count);
        rec.barrier(Stateless::EXIT, Stateless::ENTRY);
    })
}

const STEPPED: [(&str, &[u32]); 7] = [
    ("euler", &[1, 4, 16, 64]),
    ("half-kick", &[1, 2, 4, 8, 16]),
    ("leapfrog", &[1, 2, 4, 8, 16]),
    ("forest-ruth", &[1, 2, 4]),
    ("rk4", &[1, 2, 4]),
    ("logh", &[4, 8, 16, 32, 64]),
    ("kepler", &[1]),
];
const PERIAPSES_M: [f64; 3] = [5.5, 10.0, 20.0];

/// Runs it: a study a periapsis of the 99 % error and of the median, and one of who is swallowed.
///
/// # Errors
/// The device's.
pub fn study(gpu: &Gpu, quick: bool, progress: OnProgress<'_>) -> Result<Vec<StudyResult>> {
    let is_software = gpu.adapter().is_software();
    let count = if is_software { 1 << 14 } else { 1 << 20 };
    let (orbits, thrown) = if quick { (300, 1000) } else { (4000, 20_000) };
    let effort = Effort { budget_s: if quick { 0.05 } else { 0.5 }, ..Effort::full(gpu) };
    let mut runs: Vec<(String, f64)> = Vec::new();
    for (name, substeps) in STEPPED {
        let taken = if quick { &substeps[..substeps.len().min(2)] } else { substeps };
        runs.extend(taken.iter().map(|n| (format!("{name}/x{n}"), f64::from(*n))));
    }
    runs.push(("kepler-stateless".into(), 1.0));
    let populations: Vec<_> =
        PERIAPSES_M.iter().map(|&periapsis| ellipses(orbits, periapsis, APOCENTRE_M, true)).collect();
    let emitted = emitted(thrown);
    let mut tables: Vec<Vec<Point>> = vec![Vec::new(); 2 * PERIAPSES_M.len() + 1];
    let metrics = ["place at 10 s / apocentre, 99 % of particles", "place at 10 s / apocentre, median"];
    let frame_s = f64::from(FRAME_TICKS) / 65536.0;
    let of = runs.len();
    for (done, (variant, substeps)) in runs.iter().enumerate() {
        progress(Progress { done, of, now: &format!("{NAME}: {variant}") });
        let time = |bodies: &[Body<f32>]| match variant.as_str() {
            "kepler-stateless" => stateless_frame(gpu, count, false, effort),
            stepped => frame(gpu, &law(stepped, hole()), bodies, count, effort),
        };
        let per_million = 1e6 / f64::from(count);
        let point = |metric: &str, error: f64, timing: Timing| Point {
            variant: variant.split('/').next().unwrap_or_default().into(),
            step: frame_s / substeps,
            size: count,
            error: finite(error),
            metric: metric.into(),
            ms_per_sim_second: timing.median_ms * per_million / frame_s,
            ns_per_item: timing.median_ms * per_million,
            pareto: false,
        };
        let timings = populations.iter().map(|bodies| time(bodies)).collect::<Result<Vec<_>>>()?;
        for (k, (bodies, &timing)) in populations.iter().zip(&timings).enumerate() {
            let errors = errors(gpu, variant, bodies)?;
            // A logarithmic axis has no zero: nobody is nearer than single precision tells.
            let off = |share| at(&errors, share).max(1e-9);
            tables[2 * k].push(point(metrics[0], off(0.99), timing));
            tables[2 * k + 1].push(point(metrics[1], off(0.5), timing));
        }
        let none = 0.5 / f64::from(thrown);
        let wrong = mistaken(gpu, variant, &emitted, FRAME_TICKS)?.max(none);
        // Who is swallowed costs nothing any more: the cost is that of a population of whom nobody is.
        let metric = "share of particles whose fate is mistaken";
        tables[2 * PERIAPSES_M.len()].push(point(metric, wrong, timings[PERIAPSES_M.len() - 1]));
    }
    let mut names = Vec::new();
    for periapsis in PERIAPSES_M {
        names.push(format!("{NAME}, periapsis {periapsis}"));
        names.push(format!("{NAME}, periapsis {periapsis}, median"));
    }
    names.push(format!("{NAME}, swallowed"));
    let result = |(study, points): (String, Vec<Point>)| {
        let mut result = StudyResult {
            sim: "particles".into(),
            study,
            reference: "the orbit in f64, by universal variables; costs are of 1e6 of the particles that the errors are of (of \
                        who is swallowed: of periapsis 20; of kepler-stateless: those that the book emits) at 60 steps a \
                        second, ns per item are ms per 1e6 particles and frame; kepler-stateless moves no memory, the \
                        others 56 bytes a particle and frame"
                .into(),
            points,
            cheapest: Vec::new(),
        };
        result.mark_pareto();
        result.cheapest = result.cheapest_for(&[0.01, 1e-3, 2e-4, 2e-5], "euler");
        result
    };
    Ok(names.into_iter().zip(tables).map(result).collect())
}
