// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hard cases of the black hole. Beside each number, the book's: its step in `f32`, and its test of the place before.

use super::{Case, Context, Outcome};
use crate::{
    particles::{
        black_hole::{Hole, Integrator},
        black_hole_fate::Fates,
        cpu_black_hole::{book_step, Body},
        oracle::Orbit,
    },
    random,
    study::{
        black_hole::{ellipses, emitted, fates, hole, law, mistaken, orbit, HORIZON_M, MU_M3PS2},
        runs::larger,
        Result,
    },
};
use glam::{dvec3, DVec3};

const FATES: &[&str] = &["leapfrog/x64", "rk4/x32", "logh/x256", "kepler", "kepler-stateless"];

/// The table.
pub const CASES: &[Case] = &[
    Case {
        id: "B1",
        title: "who falls straight in at steps of 0.2 s is swallowed",
        variants: FATES,
        unit: "share never removed in 60 s",
        limit: 0.0,
        run: never_removed,
    },
    Case {
        id: "B1",
        title: "who falls straight in at steps of 0.2 s is swallowed on time",
        variants: FATES,
        unit: "s from the exact crossing",
        limit: 1e-3,
        run: swallowed_on_time,
    },
    Case {
        id: "B2",
        title: "of 20 000 emitted, the right ones are swallowed at steps of 1/60 to 0.2 s",
        variants: &["leapfrog/rule", "rk4/rule", "kepler", "kepler-stateless"],
        unit: "share mistaken",
        limit: 1e-3,
        run: emission,
    },
    Case {
        id: "B3",
        title: "orbits that graze the horizon, at 0.999 and 1.001 of it, end on the right side",
        variants: &["leapfrog/x16", "rk4/x4", "logh/x64", "kepler", "kepler-stateless"],
        unit: "share on the wrong side",
        limit: 1e-3,
        run: grazing,
    },
    Case {
        id: "B4",
        title: "an orbit of eccentricity 0.99 is where it ought to be after 10 turns",
        variants: &["logh/x64", "kepler", "kepler-stateless"],
        unit: "of the semi-major axis",
        limit: 1e-3,
        run: eccentric,
    },
    Case {
        id: "B5",
        title: "a particle at the centre, or without a place, is removed, and no number is spoiled",
        variants: &["euler", "half-kick", "leapfrog", "forest-ruth", "rk4", "logh", "kepler"],
        unit: "particles left, or not numbers",
        limit: 0.0,
        run: at_the_centre,
    },
    Case {
        id: "B6",
        title: "hyperbolas keep their energy at steps of half a second",
        variants: &["logh/x1", "logh/x8", "kepler"],
        unit: "of the energy",
        limit: 1e-4,
        run: hyperbolas,
    },
    Case {
        id: "B7",
        title: "angular momentum holds for 600 s in single precision",
        variants: &["leapfrog", "forest-ruth", "kepler"],
        unit: "of the angular momentum",
        limit: 5e-5,
        run: momentum,
    },
    Case {
        id: "B7",
        title: "energy does not creep for 600 s in single precision",
        variants: &["leapfrog", "forest-ruth", "kepler"],
        unit: "of the energy in 600 s",
        limit: 1e-4,
        run: energy,
    },
];

fn wide(v: [f32; 3]) -> DVec3 {
    DVec3::from_array(v.map(f64::from))
}

/// When the book removes a particle (s): at the end of the step that began within the horizon.
fn removed_by_the_book(body: &Body<f32>, dt_ticks: u32, steps: u32) -> Option<f64> {
    let dt_s = dt_ticks as f32 / 65536.0;
    let (hole, mut body) = (hole(), *body);
    (1..=steps).find_map(|i| (!book_step(&hole, &mut body, dt_s)).then(|| f64::from(i) * f64::from(dt_s)))
}

/// A step of 0.2 s, and 60 s of them.
const LONG_TICKS: u32 = 13107;
const MINUTE: u32 = 300;

/// From rest or thrown inwards, 20 to 100 m away.
fn falling() -> Vec<Body<f32>> {
    let body = |serial| {
        let [u, v, r, s] = random::units(random::bits(23, 0, serial, 0));
        let way = random::direction_of([u, v]);
        let (at, velocity) = ((20.0 + 80.0 * r) * way, -20.0 * s * way);
        Body { at_m: at.into(), velocity_mps: velocity.into(), born: 0 }
    };
    (0..2000).map(body).collect()
}

fn never_removed(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let bodies = falling();
    let ends = fates(context.gpu, variant, hole(), &bodies, (LONG_TICKS, MINUTE))?;
    let left = ends.iter().filter(|(_, end)| end.is_none()).count();
    let by_the_book =
        bodies.iter().filter(|body| removed_by_the_book(body, LONG_TICKS, MINUTE).is_none()).count();
    let share = |count: usize| count as f64 / bodies.len() as f64;
    Ok(Outcome::of(share(left)).seed(share(by_the_book)))
}

fn swallowed_on_time(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let bodies = falling();
    let ends = fates(context.gpu, variant, hole(), &bodies, (LONG_TICKS, MINUTE))?;
    let exact = |body: &Body<f32>| orbit(body).crossing_s(HORIZON_M).unwrap_or(f64::NAN);
    let off = |(body, (_, end)): (&Body<f32>, (Body<f32>, Option<f32>))| {
        end.map_or(f64::INFINITY, |end| (f64::from(end) - exact(body)).abs())
    };
    let late: Vec<f64> = bodies
        .iter()
        .filter_map(|body| Some(removed_by_the_book(body, LONG_TICKS, MINUTE)? - exact(body)))
        .collect();
    let mean = late.iter().sum::<f64>() / late.len() as f64;
    Ok(Outcome::of(bodies.iter().zip(ends).map(off).fold(0.0, larger))
        .seed(mean)
        .note("of the book: the mean of those it removes"))
}

/// Steps of 1/60, 1/30, 0.05, 0.1 and 0.2 s.
const STEPS_TICKS: [u32; 5] = [1092, 2185, 3277, 6554, LONG_TICKS];

/// Substeps as the rule has them: a tenth of a radian about the horizon for leapfrog, three for the fourth order.
fn by_rule(variant: &str, dt_ticks: u32) -> String {
    let Some(integrator) = variant.strip_suffix("/rule") else { return variant.to_owned() };
    let eta = f64::from(dt_ticks) / 65536.0 * (MU_M3PS2 / HORIZON_M.powi(3)).sqrt();
    let most = if integrator == "leapfrog" { 0.05 } else { 0.15 };
    format!("{integrator}/x{}", (eta / most).ceil())
}

fn emission(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let bodies = emitted(20_000);
    let (mut worst, mut book, mut words) = (0.0f64, 0.0f64, Vec::new());
    for dt_ticks in STEPS_TICKS {
        let wrong = mistaken(context.gpu, &by_rule(variant, dt_ticks), &bodies, dt_ticks)?;
        worst = worst.max(wrong);
        words.push(format!("{:.3} %", 100.0 * wrong));
        let steps = 655_360 / dt_ticks;
        let life = f64::from(steps * dt_ticks) / 65536.0;
        let is_wrong = |body: &&Body<f32>| {
            removed_by_the_book(body, dt_ticks, steps).is_some()
                != orbit(body).capture_s(HORIZON_M, life).is_some()
        };
        book = book.max(bodies.iter().filter(is_wrong).count() as f64 / bodies.len() as f64);
    }
    Ok(Outcome::of(worst).seed(book).note(format!("at 1/60, 1/30, 0.05, 0.1, 0.2 s: {}", words.join(", "))))
}

fn grazing(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let (dt_ticks, steps) = (1092, 480);
    let mut bodies = ellipses(5000, 0.999 * HORIZON_M, 60.0, false);
    bodies.extend(ellipses(5000, 1.001 * HORIZON_M, 60.0, false));
    let is_swallowed = |body: &Body<f32>| orbit(body).capture_s(HORIZON_M, 8.0).is_some();
    let ends = fates(context.gpu, variant, hole(), &bodies, (dt_ticks, steps))?;
    let wrong =
        bodies.iter().zip(ends).filter(|(body, (_, end))| is_swallowed(body) != end.is_some()).count();
    let by_the_book = bodies
        .iter()
        .filter(|body| is_swallowed(body) != removed_by_the_book(body, dt_ticks, steps).is_some())
        .count();
    let share = |count: usize| count as f64 / bodies.len() as f64;
    Ok(Outcome::of(share(wrong)).seed(share(by_the_book)))
}

fn eccentric(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let a = 30.0;
    let bare = Hole { horizon_m: 0.0, ..hole() };
    let bodies = ellipses(64, 0.01 * a, 1.99 * a, false);
    let period = std::f64::consts::TAU * (a.powi(3) / MU_M3PS2).sqrt();
    let (dt_ticks, steps) = ((period * 655.36) as u32, 1000);
    let seconds = f64::from(dt_ticks * steps) / 65536.0;
    let off =
        |from: &Body<f32>, to: &Body<f32>| (wide(to.at_m) - orbit(from).after(seconds).at_m).length() / a;
    let ends = fates(context.gpu, variant, bare, &bodies, (dt_ticks, steps))?;
    let is_whole = ends.iter().all(|(_, end)| end.is_none());
    let worst = bodies.iter().zip(&ends).map(|(from, (to, _))| off(from, to)).fold(0.0, larger);
    let by_the_book = |from: &Body<f32>| {
        let mut body = *from;
        for _ in 0..steps {
            book_step(&bare, &mut body, dt_ticks as f32 / 65536.0);
        }
        off(from, &body)
    };
    Ok(Outcome::of(worst)
        .only_if(is_whole)
        .seed(bodies.iter().map(by_the_book).fold(0.0, f64::max))
        .note("100 steps a turn, worst of 64"))
}

fn at_the_centre(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let still = Body { at_m: [0.0; 3], velocity_mps: [0.0; 3], born: 0 };
    let places =
        [[0.0; 3], [1e-30, 0.0, 0.0], [0.0, -1e-7, 0.0], [f32::NAN, 0.0, 0.0], [0.0, f32::INFINITY, 0.0]];
    let mut bodies: Vec<_> = places.iter().map(|&at_m| Body { at_m, ..still }).collect();
    bodies.extend(places.iter().map(|&at_m| Body { at_m, velocity_mps: [3.0, -40.0, 0.5], born: 0 }));
    bodies.extend([f32::NAN, f32::INFINITY].map(|speed| Body {
        at_m: [30.0, 0.0, 0.0],
        velocity_mps: [0.0, speed, 0.0],
        born: 0,
    }));
    let mut bad = 0;
    for horizon_m in [HORIZON_M as f32, 0.0] {
        let bare = Hole { horizon_m, ..hole() };
        for (from, (to, end)) in bodies.iter().zip(fates(context.gpu, variant, bare, &bodies, (1092, 30))?) {
            // Who had no place or speed keeps none, and is gone.
            let is_finite = |it: &Body<f32>| it.at_m.iter().chain(&it.velocity_mps).all(|x| x.is_finite());
            bad += usize::from(is_finite(from) && !is_finite(&to)) + usize::from(end.is_none());
        }
    }
    let mut by_the_book = still;
    book_step(&hole(), &mut by_the_book, 1.0 / 60.0);
    let spoiled = by_the_book.at_m.iter().any(|x| x.is_nan());
    Ok(Outcome::of(bad as f64).seed(f64::from(u8::from(spoiled))).note("of the book: one at the centre"))
}

/// Leapfrog in its own time as it is found in books, with a step that nothing bounds: what it makes of the energy.
fn unbounded_logh(step: f64) -> f64 {
    let mut orbit = Orbit { mu_m3ps2: 1.0, at_m: dvec3(0.5, 0.0, 0.0), velocity_mps: DVec3::ZERO };
    orbit.velocity_mps = dvec3(0.0, (2.0 / 0.5 + 1.0f64).sqrt(), 0.0);
    let mut orbit = orbit.after(-20.0);
    let energy = orbit.energy();
    for _ in 0..(12.0 / step).ceil() as u32 {
        let drift = |orbit: &mut Orbit| {
            let kinetic = 0.5 * orbit.velocity_mps.length_squared() - energy;
            orbit.at_m += 0.5 * step / kinetic * orbit.velocity_mps;
        };
        drift(&mut orbit);
        orbit.velocity_mps -= step * orbit.at_m / orbit.at_m.length_squared();
        drift(&mut orbit);
    }
    orbit.energy() / energy - 1.0
}

fn hyperbolas(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let a = 7.0;
    let mut bodies = Vec::new();
    for e in [1.02, 1.5, 3.0] {
        let r = a * (e - 1.0);
        let periapsis = Orbit {
            mu_m3ps2: MU_M3PS2,
            at_m: dvec3(0.6 * r, 0.8 * r, 0.0),
            velocity_mps: (2.0 * MU_M3PS2 / r + MU_M3PS2 / a).sqrt() * dvec3(-0.48, 0.36, 0.8),
        };
        for i in 0..50 {
            let start = periapsis.after(-3.0 - 0.01 * f64::from(i));
            let (at_m, velocity_mps) = (start.at_m.as_vec3().into(), start.velocity_mps.as_vec3().into());
            bodies.push(Body { at_m, velocity_mps, born: 0 });
        }
    }
    let bare = Hole { horizon_m: 0.0, ..hole() };
    let ends = fates(context.gpu, variant, bare, &bodies, (32768, 12))?;
    let lost = |(from, (to, _)): (&Body<f32>, &(Body<f32>, Option<f32>))| {
        (orbit(to).energy() / orbit(from).energy() - 1.0).abs()
    };
    let worst = bodies.iter().zip(&ends).map(lost).fold(0.0, larger);
    Ok(Outcome::of(worst)
        .only_if(ends.iter().all(|(_, end)| end.is_none()))
        .seed(unbounded_logh(4.0))
        .note("eccentricities 1.02, 1.5 and 3; of the simple method: logh with a step of 4, not bounded"))
}

/// Each 10 s for 600 s: energy and angular momentum, over their first values, of each particle.
fn long_run(context: &Context<'_>, variant: &str) -> Result<Vec<Vec<(f64, f64)>>> {
    let mut bodies = Vec::new();
    for (periapsis, apocentre) in [(20.0, 20.0), (15.0, 25.0), (20.0, 40.0), (12.0, 36.0)] {
        bodies.extend(ellipses(16, periapsis, apocentre, true));
    }
    let law = law(variant, hole());
    assert_ne!(law.integrator, Integrator::LogH, "it has no step of its own");
    let fates = Fates::new(context.gpu, &law, &bodies)?;
    let first: Vec<_> = bodies.iter().map(orbit).collect();
    let mut samples = vec![vec![(1.0, 1.0)]; bodies.len()];
    for batch in 0..60 {
        let steps = 600;
        let ends = fates.run(batch * steps * 1092, 1092, steps)?;
        for ((sample, first), (body, end)) in samples.iter_mut().zip(&first).zip(ends) {
            let now = orbit(&body);
            let momentum = now.angular_momentum().length() / first.angular_momentum().length();
            let is_whole = end.is_none();
            sample.push(if is_whole {
                (now.energy() / first.energy(), momentum)
            } else {
                (f64::NAN, f64::NAN)
            });
        }
        fates.carry_on()?;
    }
    Ok(samples)
}

fn momentum(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let samples = long_run(context, variant)?;
    let worst = samples.iter().flatten().map(|(_, l)| (l - 1.0).abs()).fold(0.0, larger);
    Ok(Outcome::of(worst))
}

fn energy(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let samples = long_run(context, variant)?;
    // The straight line through the samples: leapfrog's energy swings with the orbit, and only its creep counts.
    let slope = |sample: &Vec<(f64, f64)>| {
        let n = sample.len() as f64;
        let mean = sample.iter().map(|(e, _)| e).sum::<f64>() / n;
        let middle = 0.5 * (n - 1.0);
        let (mut up, mut across) = (0.0, 0.0);
        for (i, (e, _)) in sample.iter().enumerate() {
            let x = i as f64 - middle;
            up += x * (e - mean);
            across += x * x;
        }
        (up / across * (n - 1.0)).abs()
    };
    Ok(Outcome::of(samples.iter().map(slope).fold(0.0, larger)))
}
