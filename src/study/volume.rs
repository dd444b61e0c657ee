// SPDX-License-Identifier: MIT OR Apache-2.0
//! Particles and a voxelised scene: how a particle meets it, by the resolution of the volume, at four speeds. Balls are thrown
//! at a torus, elastic and without gravity. The reference is the mesh itself, in f64: a ball whose straight way hits a triangle
//! must be turned, and nobody may be inside.

use super::{
    arena::Arena,
    runs::{self, larger, Effort},
    shapes::{finite, Headline, Point, StudyResult},
    Found, OnProgress, Progress, Result,
};
use crate::{
    cells::Grid,
    gpu::Gpu,
    impact::cpu::nearest_weights,
    mesh::{shapes, Mesh},
    particles::{
        colliding::{Colliding, Method},
        Particle, Particles,
    },
    random,
};
use glam::{vec3, DVec3, UVec3, Vec3};

/// As results name it.
pub const NAME: &str = "volume";
const DT_S: f64 = 1.0 / 60.0;
const RING_M: f32 = 0.5;
const TUBE_M: f32 = 0.2;
const RADIUS_M: f32 = 0.02;
/// A quarter of a cell a step to two on grids of 16 to 128 along a side; half of one to 4; 1 to 8; 4 to 32.
const SPEEDS_MPS: [f32; 4] = [1.875, 3.75, 7.5, 30.0];

/// When the way from `at` along `way` first hits a triangle, in lengths of `way` (Moeller and Trumbore, "Fast, Minimum Storage
/// Ray/Triangle Intersection", 1997).
fn hit(mesh: &Mesh, at: DVec3, way: DVec3) -> Option<f64> {
    crossings(mesh, at, way).into_iter().reduce(f64::min)
}

fn crossings(mesh: &Mesh, at: DVec3, way: DVec3) -> Vec<f64> {
    let of = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|i| mesh.at_m[i as usize].as_dvec3());
        let (one, two) = (b - a, c - a);
        let across = way.cross(two);
        let scale = one.dot(across);
        let from = at - a;
        let u = from.dot(across) / scale;
        let along = from.cross(one);
        let (v, t) = (way.dot(along) / scale, two.dot(along) / scale);
        (scale != 0.0 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
    };
    mesh.triangles.iter().filter_map(of).collect()
}

fn is_inside(mesh: &Mesh, at: Vec3) -> bool {
    crossings(mesh, at.as_dvec3(), DVec3::new(0.5773, 0.5911, 0.5633)).len() % 2 == 1
}

/// From the nearest triangle (m).
fn distance(mesh: &Mesh, at: Vec3) -> f32 {
    let to = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|i| mesh.at_m[i as usize]);
        let weights = nearest_weights(at, a, b, c);
        (a * weights.x + b * weights.y + c * weights.z).distance(at)
    };
    mesh.triangles.iter().map(to).fold(f32::INFINITY, f32::min)
}

/// Thrown from round about at places within the ring's outline.
fn thrown(count: u32, speed_mps: f32) -> Vec<Particle> {
    let of = |i| {
        let [u, v, w, x] = random::units(random::bits(21, 0, i, 0));
        let [y, ..] = random::units(random::bits(21, 1, i, 0));
        let from = random::direction_of([u, v]) * 0.93;
        let turn = random::cos_sin_of_turn(w) * (RING_M + TUBE_M) * x.sqrt();
        let to = vec3(turn.x, TUBE_M * (2.0 * y - 1.0), turn.y);
        Particle { at_m: from, velocity_mps: (to - from).normalize() * speed_mps, born: 0 }
    };
    (0..count).map(of).collect()
}

/// `ask` of each, in their order: every triangle is looked at for each ball, which takes longer than its flight.
fn by_threads<T: Sync, R: Send>(all: &[T], ask: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let ask = |part: &[T]| part.iter().map(&ask).collect::<Vec<R>>();
    std::thread::scope(|scope| {
        let parts = all.chunks(all.len().div_ceil(threads).max(1));
        let asked: Vec<_> = parts.map(|part| scope.spawn(move || ask(part))).collect();
        asked.into_iter().flat_map(|it| it.join().expect("nothing panics")).collect()
    })
}

struct Seen {
    leaks: f64,
    /// How deep those outside lie in the surface at the most, in radii.
    deepest: f64,
}

struct Setting<'a> {
    gpu: &'a Gpu,
    mesh: &'a Mesh,
    cells: &'a crate::cells::Cells,
    kernels: &'a Particles,
}

impl Setting<'_> {
    fn law(&self) -> Colliding {
        let law = Colliding::new(self.cells.grid(), RADIUS_M);
        Colliding { restitution: 1.0, friction: 0.0, gravity_mps2: Vec3::ZERO, ..law }
    }

    fn arena(&self, particles: &[Particle], speed_mps: f32) -> Result<Arena> {
        let reach = self.law().reach_of(speed_mps, DT_S as f32).min(3);
        Arena::new(self.gpu, self.kernels, self.cells, self.law(), reach, particles, 1 << 14)
    }

    fn watch(&self, count: u32, speed: f32) -> Result<Seen> {
        let start = thrown(count, speed);
        let mut arena = self.arena(&start, speed)?;
        // Until the straight ways are through.
        let steps = (1.6 / f64::from(speed) / DT_S).ceil().max(1.0) as u64;
        let mut deepest = 0.0f64;
        let mut now = start.clone();
        let looks = steps.min(6);
        for look in 0..looks {
            let (from, to) = (steps * look / looks, steps * (look + 1) / looks);
            arena.steps(to - from, DT_S)?;
            now = arena.particles()?;
            let depth = |it: &Particle| {
                let is_asked = it.at_m.length() < 0.9 && !is_inside(self.mesh, it.at_m);
                is_asked.then(|| f64::from((RADIUS_M - distance(self.mesh, it.at_m)) / RADIUS_M))
            };
            deepest = by_threads(&now, depth).into_iter().flatten().fold(deepest, f64::max);
        }
        let both: Vec<(Particle, Particle)> = now.into_iter().zip(start).collect();
        let leaks = by_threads(&both, |(now, start)| {
            let way = start.velocity_mps.as_dvec3();
            // Who has hit two parallel facets goes on as before, but elsewhere; who is pushed out of a plane, a little beside.
            let flown = start.at_m + start.velocity_mps * (steps as f32 * DT_S as f32);
            let is_turned = (now.velocity_mps - start.velocity_mps).length() > 1e-3 * speed
                || now.at_m.distance(flown) > 5.0 * RADIUS_M;
            let must = hit(self.mesh, start.at_m.as_dvec3(), way).is_some_and(|t| t * f64::from(speed) < 1.5);
            is_inside(self.mesh, now.at_m) || (must && !is_turned)
        });
        let leaks = leaks.into_iter().filter(|is_leak| *is_leak).count();
        Ok(Seen { leaks: leaks as f64 / f64::from(count), deepest })
    }

    /// Time of a step of so many (ms).
    fn step_ms(&self, count: u32, speed: f32, effort: Effort) -> Result<f64> {
        let mut arena = self.arena(&thrown(count, speed), speed)?.rewinds()?;
        // The same metre of flight again and again; to put the particles back is no part of a step.
        let once = (1.0 / f64::from(speed) / DT_S).ceil().max(1.0) as u64;
        let mut at = 0;
        let steps = runs::time(self.gpu, effort, |rec| {
            if at % once == 0 {
                arena.restart(rec);
            }
            at += 1;
            arena.record(rec, DT_S);
        })?;
        let back = runs::time(self.gpu, effort, |rec| arena.restart(rec))?;
        Ok(steps.median_ms - back.median_ms / once as f64)
    }
}

/// Runs it: a study of leaks and one of depth at each speed, and what no leaks cost beside the seed's update.
///
/// # Errors
/// The device's.
pub fn study(gpu: &Gpu, quick: bool, progress: OnProgress<'_>) -> Result<Found> {
    let is_software = gpu.adapter().is_software();
    let timed = if is_software { 1 << 12 } else { 1 << 20 };
    let count = if quick { 200 } else { 2000 };
    let effort = Effort { budget_s: if quick { 0.05 } else { 0.5 }, ..Effort::full(gpu) };
    let sizes: &[u32] = if quick { &[16, 32] } else { &[16, 32, 64, 128] };
    let speeds = if quick { &SPEEDS_MPS[1..3] } else { &SPEEDS_MPS[..] };
    let mesh = shapes::torus(RING_M, TUBE_M, if quick { 24 } else { 48 });
    let mut tables: Vec<_> = speeds.iter().map(|_| (Vec::new(), Vec::new())).collect();
    let (mut done, of) = (0, Method::ALL.len() * sizes.len());
    for method in Method::ALL {
        let kernels = Particles::new(gpu, &Colliding::law(method), Colliding::options(gpu))?;
        for &size in sizes {
            progress(Progress { done, of, now: &format!("{NAME}: {}, {size}^3", method.name()) });
            done += 1;
            let grid = Grid::new(Vec3::splat(-1.0), 2.0 / size as f32, UVec3::splat(size));
            let cells = Arena::voxelise(gpu, grid, std::slice::from_ref(&mesh), false)?;
            let setting = Setting { gpu, mesh: &mesh, cells: &cells, kernels: &kernels };
            for (&speed, (leaks, depths)) in speeds.iter().zip(&mut tables) {
                let seen = setting.watch(count, speed)?;
                let step_ms = setting.step_ms(timed, speed, effort)?;
                let point = |metric: &str, error: f64| Point {
                    variant: method.name().into(),
                    step: DT_S,
                    size,
                    error: finite(error),
                    metric: metric.into(),
                    ms_per_sim_second: step_ms * 1e6 / f64::from(timed) / DT_S,
                    ns_per_item: step_ms * 1e6 / f64::from(timed),
                    pareto: false,
                };
                // A logarithmic axis has no zero: less than half a particle is none.
                leaks.push(point("share of particles leaked", seen.leaks.max(0.5 / f64::from(count))));
                depths.push(point("depth in the surface, radii, deepest", seen.deepest.max(1e-4)));
            }
        }
    }
    let all: Vec<&Point> = tables.iter().flat_map(|(leaks, _)| leaks).collect();
    let settings = format!("{sizes:?} cells a side, {speeds:?} m/s");
    let headlines = headlines(&all, 0.5 / f64::from(count), &settings);
    let of = |(speed, (leaks, depths))| studies_at(speed, leaks, depths);
    Ok(Found { headlines, studies: speeds.iter().zip(tables).flat_map(of).collect(), ..Found::default() })
}

/// Of leaks and of depth. Other speeds are other problems: they share no front and no table.
fn studies_at(speed: &f32, leaks: Vec<Point>, depths: Vec<Point>) -> [StudyResult; 2] {
    let result = |study: String, points| {
        let mut result = StudyResult {
            sim: "particles".into(),
            study,
            reference: "straight ways against the triangles in f64, and parity for who is inside; a size is the cells along a \
                        side, a speed is in m/s; costs are of 1e6 particles at 60 steps a second"
                .into(),
            points,
            cheapest: Vec::new(),
        };
        result.mark_pareto();
        result.cheapest = result.cheapest_for(&[0.1, 0.01, 0.001], "seed");
        result
    };
    [
        result(format!("{NAME}, leaks, speed {speed}"), leaks),
        result(format!("{NAME}, depth, speed {speed}"), depths),
    ]
}

/// The worst leak of the default at all sizes and speeds, and its time over the seed's.
fn headlines(points: &[&Point], none: f64, settings: &str) -> Vec<Headline> {
    let of = |method: &str| points.iter().filter(|it| it.variant == method).collect::<Vec<_>>();
    let (swept, seed) = (of("dda2"), of("seed"));
    let worst = swept.iter().map(|it| it.error.unwrap_or(f64::NAN)).fold(0.0, larger);
    let costs: Vec<f64> = swept.iter().zip(&seed).map(|(a, b)| a.ns_per_item / b.ns_per_item).collect();
    let mut sorted = costs.clone();
    sorted.sort_by(f64::total_cmp);
    let headline = |what: &str, value: f64, unit: &str, note: String| Headline {
        sim: "particles".into(),
        study: NAME.into(),
        what: what.into(),
        value: finite(value),
        unit: unit.into(),
        note,
    };
    let leaked = if worst <= none { 0.0 } else { 100.0 * worst };
    let seeds = 100.0 * seed.iter().filter_map(|it| it.error).fold(0.0f64, f64::max);
    vec![
        headline(
            "leaks of dda2, worst of all sizes and speeds",
            leaked,
            "%",
            format!("{settings}; the seed's worst: {seeds:.0} %"),
        ),
        headline(
            "time of dda2 over that of the seed's update",
            sorted.get(sorted.len() / 2).copied().unwrap_or(f64::NAN),
            "times",
            format!("median of the settings; at the worst {:.2}", sorted.last().copied().unwrap_or(f64::NAN)),
        ),
    ]
}
