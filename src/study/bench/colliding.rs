// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of the law `colliding`: a room with a torus in it, elastic and without gravity. `free`: 128 cells a side, 99
//! of 100 particles have nothing in the way; `busy`: 24 cells, a twelfth is close to a wall or the torus. Counted is a whole step:
//! births, law, and the end of the impact stream. After a second of simulation all begin again where they began, since a
//! method that leaks would else empty its room while it is timed. `near/REACH`: what a change of the scene costs beside,
//! an item a cell of a cube of them; `still`: with the slabs of cells that stay.

use super::{Effort, Measured, Suite};
use crate::{
    cells::{Cells, Grid},
    gpu::Gpu,
    mesh::shapes,
    particles::{
        colliding::{Colliding, Method, Slabs, Surroundings},
        cpu_colliding::{self, Law, Scene},
        Options, Particle, Particles, Tuning,
    },
    random,
    study::{
        arena::Arena,
        host_cells::{cuboid, mesh},
        runs, Error, Result,
    },
};
use glam::{vec3, DVec3, UVec3, Vec3};

/// Its rows.
pub const SUITE: Suite = Suite {
    sim: "particles",
    variants: &[
        "colliding/free",
        "colliding/free/256x1",
        "colliding/free/seed",
        "colliding/busy",
        "colliding/busy/dda1",
        "colliding/busy/seed",
        "near/2",
        "near/14",
        "near/2/still",
    ],
    sizes: &[1 << 20, 1 << 24],
    largest_on_cpu: 1 << 16,
    label: |size| size.to_string(),
    run: |gpu, variant, size, effort| {
        if let Some(reach) = variant.strip_prefix("near/") {
            return near(gpu, reach, size, effort);
        }
        check(gpu, variant)?;
        let mut arena = room(gpu, variant, size)?.rewinds()?;
        let mut at = 0;
        let timing = runs::time(gpu, effort, |rec| {
            if at % STEPS_A_SECOND == 0 {
                arena.restart(rec);
            }
            at += 1;
            arena.record(rec, DT_S);
        })?;
        Ok(Measured { timing, items: f64::from(size), unit: "particle", bytes_per_item: 56.0 })
    },
};

const STEPS_A_SECOND: u64 = 60;
const DT_S: f64 = 1.0 / STEPS_A_SECOND as f64;
const HALF_M: f32 = 0.97;
/// Cells that are looked at round the middle of a step's way.
const REACH: u32 = 2;

fn method_of(variant: &str) -> Method {
    variant.split('/').find_map(Method::of).unwrap_or_default()
}

fn grid(variant: &str) -> Grid {
    let cells = if variant.contains("free") { 128 } else { 24 };
    Grid::new(Vec3::splat(-1.0), 2.0 / cells as f32, UVec3::splat(cells))
}

/// A quarter of a cell large and half a cell a step fast, at the most, outside the torus.
fn crowd(grid: &Grid, count: u32) -> Vec<Particle> {
    let of = |i: u32| {
        let units = |k| random::units(random::bits(11, k, i, 0)).map(|u| 2.0 * u - 1.0);
        let ([x, y, z, _], [u, v, w, _]) = (units(0), units(1));
        let mut at_m = vec3(x, y, z) * (HALF_M - grid.cell_m);
        if at_m.y.abs() < 0.2 {
            at_m.y = at_m.y.signum() * (0.2 + at_m.y.abs());
        }
        Particle { at_m, velocity_mps: vec3(u, v, w) * (0.5 * grid.cell_m / DT_S as f32), born: 0 }
    };
    (0..count).map(of).collect()
}

fn law(grid: Grid) -> Colliding {
    let law = Colliding::new(grid, 0.25 * grid.cell_m);
    Colliding { restitution: 1.0, friction: 0.0, gravity_mps2: Vec3::ZERO, ..law }
}

fn scene(gpu: &Gpu, grid: Grid) -> Result<Cells> {
    let half = DVec3::splat(f64::from(HALF_M));
    let walls = mesh("room", &cuboid(-half, half, true)).map_err(crate::mesh::MeshesError::from)?;
    Arena::voxelise(gpu, grid, &[walls, shapes::torus(0.5, 0.12, 64)], false)
}

fn near(gpu: &Gpu, variant: &str, count: u32, effort: Effort) -> Result<Measured> {
    let (reach, slabs) = match variant.split_once('/') {
        Some((reach, _)) => (reach, Slabs::OfAll),
        None => (variant, Slabs::OfEight),
    };
    let reach = reach.parse().expect("a number of cells");
    let side = f64::from(count).cbrt().round() as u32;
    let grid = Grid::new(Vec3::splat(-1.0), 2.0 / side as f32, UVec3::splat(side));
    let surroundings = Surroundings::new(gpu, &scene(gpu, grid)?, reach, slabs)?;
    let timing = runs::time(gpu, effort, |rec| {
        surroundings.record(rec);
        rec.barrier(Surroundings::EXIT, Surroundings::ENTRY);
    })?;
    // A bit, four bits written and read three times, and five words.
    Ok(Measured { timing, items: f64::from(side).powi(3), unit: "cell", bytes_per_item: 0.125 + 3.0 + 20.0 })
}

fn room(gpu: &Gpu, variant: &str, count: u32) -> Result<Arena> {
    let grid = grid(variant);
    let cells = scene(gpu, grid)?;
    let mut options = Colliding::options(gpu);
    for (group, items) in variant.split('/').filter_map(|option| option.split_once('x')) {
        if let (Ok(group), Ok(items)) = (group.parse(), items.parse()) {
            options = Options { tuning: Tuning { group, items, ..options.tuning }, ..options };
        }
    }
    let kernels = Particles::new(gpu, &Colliding::law(method_of(variant)), options)?;
    Arena::new(gpu, &kernels, &cells, law(grid), REACH, &crowd(&grid, count), count.max(1024))
}

/// Whether a few particles are where the twin has them after 30 steps: but for rounding, which decides at rims and edges.
fn check(gpu: &Gpu, variant: &str) -> Result<()> {
    const STEPS: u64 = 30;
    let mut arena = room(gpu, variant, 2048)?;
    arena.steps(STEPS, DT_S)?;
    let (law, read) = (*arena.law(), arena.surroundings.cells().read(gpu)?);
    let near = cpu_colliding::near(&law.grid, &read, REACH, Slabs::OfAll);
    let scene = Scene { occupied: &read.occupied, planes: &read.planes, near: &near };
    let twin = Law { law: &law, method: method_of(variant), scene, tick: 0, step_s: DT_S as f32 };
    let mut want = crowd(&law.grid, 2048);
    for it in &mut want {
        (0..STEPS).for_each(|_| {
            twin.advance(it, DT_S as f32, 0, &mut Vec::new());
        });
    }
    let got = arena.particles()?;
    let is_off = |(a, b): &(&Particle, &Particle)| (a.at_m - b.at_m).abs().max_element() > 1e-3;
    let off = got.iter().zip(&want).filter(is_off).count();
    let (apart, allowed) = (off as f64 / want.len() as f64, 0.02);
    if got.len() != want.len() || apart > allowed {
        return Err(Error::Wrong { variant: variant.into(), apart, allowed });
    }
    Ok(())
}
