// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a bounce does to velocity and energy, and who must not be moved at all.

use super::{at, cells_of, grid, ground, host, method_of, pure, seed, units, walls, CELL_M, DT_S, RADIUS_M};
use crate::{
    gpu::Gpu,
    impact::Stream,
    particles::{
        colliding::{Colliding, Method, Slabs, Surroundings},
        Emitter, Particle, Particles, PoolInfo, Step, Thrown,
    },
    study::{
        arena::Arena,
        hard::{Context, Outcome},
        host_cells::{rectangle, Triangle},
        runs::larger,
        Result,
    },
};
use glam::{dvec3, vec3, DVec3, Vec3};

pub fn right_angle(gpu: &Gpu, method: Method) -> Result<f64> {
    let (walls, edge) = walls(90.0);
    let cells = cells_of(gpu, &walls, false)?;
    let kernels = Arena::kernels(gpu, method)?;
    [0.27, 2.0, 16.0f32].into_iter().try_fold(0.0f64, |worst, step| {
        let thrown: Vec<_> = (0..100)
            .map(|i| {
                let [a, b, c, _] = units(5, i);
                let from = edge + vec3(0.5 + 0.1 * a, 0.5 + 0.1 * b, 0.0);
                let way = (edge + vec3(0.1, 0.1, 0.1 * c) - from).normalize();
                at(from, way * (step * CELL_M * 60.0))
            })
            .collect();
        let mut arena = Arena::new(gpu, &kernels, &cells, pure(0.03), 3, &thrown, 4096)?;
        arena.steps((24.0 / step).ceil() as u64, DT_S)?;
        Ok(arena.particles()?.iter().zip(&thrown).fold(worst, |worst, (now, then)| {
            let want = then.velocity_mps * vec3(-1.0, -1.0, 1.0);
            larger(worst, f64::from((now.velocity_mps - want).length() / want.length()))
        }))
    })
}

pub fn resting(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let gpu = context.gpu;
    // Peak to peak in radii over 60 s once a ball from half a metre has had time to lie, and the energy it gains (J/kg).
    let lies = |method: Method| -> Result<[f64; 2]> {
        let kernels = Arena::kernels(gpu, method)?;
        let mut worst = [0.0f64, f64::NEG_INFINITY];
        for height in [-0.5, -0.53, -0.56] {
            let cells = host(gpu, grid(), &ground(height))?;
            let gravity_mps2 =
                if method == Method::Seed { vec3(0.0, -0.5, 0.0) } else { vec3(0.0, -9.81, 0.0) };
            let law = Colliding { gravity_mps2, ..Colliding::new(grid(), RADIUS_M) };
            let ball = at(vec3(0.1, 0.0, 0.1), Vec3::ZERO);
            let mut arena = Arena::new(gpu, &kernels, &cells, law, 4, &[ball], 64)?;
            arena.steps(600, DT_S)?;
            let mut seen = Vec::new();
            for _ in 0..450 {
                arena.steps(8, DT_S)?;
                let it = arena.particles()?[0];
                let energy = 0.5 * it.velocity_mps.length_squared() - gravity_mps2.y * it.at_m.y;
                seen.push((f64::from(it.at_m.y), f64::from(energy)));
            }
            let highest = seen.iter().map(|it| it.0).fold(f64::NEG_INFINITY, f64::max);
            let lowest = seen.iter().map(|it| it.0).fold(f64::INFINITY, f64::min);
            let gained = seen.iter().map(|it| it.1 - seen[0].1).fold(f64::NEG_INFINITY, f64::max);
            worst = [worst[0].max((highest - lowest) / f64::from(RADIUS_M)), worst[1].max(gained)];
        }
        Ok(worst)
    };
    let [jitter, gained] = lies(method_of(variant))?;
    let note = format!("energy gained: {gained:.1e} J/kg");
    let of_seed = seed(context, "V5", || Ok(lies(Method::Seed)?[0]))?;
    Ok(Outcome::of(jitter).seed(of_seed).only_if(gained < 1e-6).note(note))
}

pub fn pistons(gpu: &Gpu, method: Method) -> Result<f64> {
    let kernels = Arena::kernels(gpu, method)?;
    [-2.0, -1.0, -0.1, -0.01, 0.01, 0.1, 1.0, 2.0].into_iter().try_fold(0.0f64, |worst, u| {
        let moving = |it: Triangle| Triangle { velocity_mps: DVec3::Y * u, ..it };
        let cells = host(gpu, grid(), &ground(0.0).into_iter().map(moving).collect::<Vec<_>>())?;
        let law = Colliding { surface_mps: 2.0, ..pure(0.02) };
        let start = at(vec3(0.01, 0.021, 0.02), vec3(0.3, -3.0, 0.0));
        let mut arena = Arena::new(gpu, &kernels, &cells, law, 3, &[start], 64)?;
        arena.steps(1, DT_S)?;
        let want = vec3(0.3, 2.0 * u as f32 + 3.0, 0.0);
        Ok(larger(worst, f64::from((arena.particles()?[0].velocity_mps - want).length())))
    })
}

pub fn elastic(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let gpu = context.gpu;
    let ratio = |method: Method, steps: u64| -> Result<(f64, u64)> {
        let height = -0.53;
        let cells = host(gpu, grid(), &ground(height))?;
        let gravity_mps2 = vec3(0.0, -9.81, 0.0);
        let law = Colliding { gravity_mps2, ..pure(RADIUS_M) };
        let kernels = Arena::kernels(gpu, method)?;
        let ball = at(vec3(0.1, height as f32 + RADIUS_M + 0.3, 0.1), Vec3::ZERO);
        let mut arena = Arena::new(gpu, &kernels, &cells, law, 4, &[ball], 64)?;
        arena.steps(steps, DT_S)?;
        let energy = |it: &Particle| {
            let up = f64::from(it.at_m.y) - height - f64::from(RADIUS_M);
            0.5 * it.velocity_mps.as_dvec3().length_squared() + 9.81 * up
        };
        Ok((energy(&arena.particles()?[0]) / energy(&ball) - 1.0, arena.stream.counts()?.stored()))
    };
    // From 30 cm it comes back every 0.495 s.
    let (off, bounces) = ratio(method_of(variant), 29_750)?;
    let seed = ratio(Method::Seed, 600)?.0;
    Ok(Outcome::of(off).seed(seed).only_if(bounces >= 1000).note(format!("{bounces} bounces")))
}

pub fn edges(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let gpu = context.gpu;
    let method = method_of(variant);
    // A birth exactly at the end of the step, in a cell of the ground; and a wall at the border of the volume, with a
    // particle outside, out of its reach: a lookup that clamps would have the wall go on for ever.
    let mut scene = ground(-0.5);
    scene.extend(rectangle(dvec3(0.99, -1.0, -1.0), DVec3::Y * 2.0, DVec3::Z * 2.0));
    let cells = host(gpu, grid(), &scene)?;
    let law = pure(0.05);
    let surroundings = Surroundings::new(gpu, &cells, 3, Slabs::OfEight)?;
    gpu.once(|rec| surroundings.record(rec))?;
    let stream = Stream::new(gpu, 64)?;
    let from = vec3(0.1, -0.49, 0.1);
    let emitters = [Emitter {
        at_m: from,
        velocity_mps: Vec3::ZERO,
        speed_mps: 1.0,
        rate_per_s: 64.0,
        thrown: Thrown::Singly,
    }];
    let info = PoolInfo {
        capacity: 64,
        life_s: 100.0,
        seed: 1,
        start: 0,
        emitters: &emitters,
        law: bytemuck::bytes_of(&law),
    };
    let kernels = Arena::kernels(gpu, method)?;
    let mut pool = kernels.pool_with(&info, &surroundings.resources(&stream))?;
    let beside = at(vec3(1.06, 0.3, 0.0), Vec3::ZERO);
    pool.upload(&[beside])?;
    gpu.once(|rec| {
        pool.record(rec, &Step::between(0, 1024));
        rec.barrier(Particles::EXIT, Particles::ENTRY);
    })?;
    let all = pool.living()?;
    let is_wrong = |it: &&Particle| {
        let moved = (it.at_m - beside.at_m).length().min((it.at_m - from).length());
        // A birth at the start of the step has flown.
        !it.at_m.is_finite() || !it.velocity_mps.is_finite() || (moved > 1e-6 && it.born == 1024)
    };
    let still = all.iter().filter(|it| it.born == 1024).count();
    let bad = all.iter().filter(is_wrong).count() + usize::from(all.first() != Some(&beside));
    Ok(Outcome::of(bad as f64).only_if(still > 0).note(format!("{still} births at the very end")))
}
