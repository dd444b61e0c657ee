// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hard cases of particles in a voxelised scene: V1 to V10. Beside each stands the figure of the sample of 2007: its response
//! (`seed`), and where marking is the matter (V2, V3, V7) its slices drawn from above.

use super::{Case, Context, Outcome};
use crate::{
    cells::{Cells, Grid},
    gpu::Gpu,
    impact::Stream,
    particles::{
        colliding::{Colliding, Method, Surroundings},
        Emitter, Particle, Particles, PoolInfo, Step, Thrown,
    },
    random,
    study::{
        arena::Arena,
        host_cells::{fill, mesh, rectangle, Triangle},
        Error, Result,
    },
};
use glam::{dvec3, uvec3, vec3, DVec3, Vec3};

const DT_S: f64 = 1.0 / 60.0;
const CELL_M: f32 = 0.0625;
/// The seed's.
const RADIUS_M: f32 = 0.1;
const SWEPT: &[&str] = &["dda2"];
const BOTH: &[&str] = &["dda1", "dda2"];

/// The table.
pub const CASES: &[Case] = &[
    Case {
        id: "V1",
        title: "bullets of 16 cells a step do not go through the ground",
        variants: BOTH,
        unit: "of the particles gone through",
        limit: 0.0,
        run: |context, variant| compare(context, variant, bullets),
    },
    Case {
        id: "V2",
        title: "a vertical wall stops what is thrown at it",
        variants: BOTH,
        unit: "of the particles gone through",
        limit: 0.0,
        run: |context, variant| marked(context, variant, |_| vec![90.0], 0.0),
    },
    Case {
        id: "V3",
        title: "slopes of 0 to 89 degrees stop what comes along their normal",
        variants: BOTH,
        unit: "of the particles gone through, at the worst slope",
        limit: 0.0,
        run: |context, variant| {
            marked(context, variant, |_| vec![0., 20., 40., 50., 60., 70., 80., 85., 89.], 0.0131)
        },
    },
    Case {
        id: "V4",
        title: "a corner of 90 degrees keeps its particles at 0.27 to 16 cells a step",
        variants: SWEPT,
        unit: "of the particles gone through, at the worst step",
        limit: 0.0,
        run: |context, variant| compare(context, variant, |gpu, method| corners(gpu, method, 90.0)),
    },
    Case {
        id: "V4",
        title: "a corner of 60 degrees keeps its particles at 0.27 to 16 cells a step",
        variants: SWEPT,
        unit: "of the particles gone through, at the worst step",
        limit: 0.0,
        run: |context, variant| compare(context, variant, |gpu, method| corners(gpu, method, 60.0)),
    },
    Case {
        id: "V4",
        title: "a right angle sends a particle back with -v",
        variants: SWEPT,
        unit: "of the speed",
        limit: 1e-6,
        run: |context, variant| compare(context, variant, right_angle),
    },
    Case {
        id: "V5",
        title: "a ball lies still for 60 s, and gains no energy",
        variants: BOTH,
        unit: "radii from its lowest to its highest",
        limit: 0.01,
        run: resting,
    },
    Case {
        id: "V6",
        title: "pistons of 0.01 to 2 m/s, coming and going, give twice their velocity",
        variants: BOTH,
        unit: "m/s off",
        limit: 1e-5,
        run: |context, variant| compare(context, variant, pistons),
    },
    Case {
        id: "V7",
        title: "planes exactly on the faces of cells stop what comes from both sides",
        variants: BOTH,
        unit: "of the particles gone through, at the worst axis",
        limit: 0.0,
        run: on_faces,
    },
    Case {
        id: "V8",
        title: "behind a thin wall, and in reach of it, a particle stays behind",
        variants: BOTH,
        unit: "particles on the other side",
        limit: 0.0,
        run: |context, variant| compare(context, variant, behind),
    },
    Case {
        id: "V9",
        title: "an elastic ball keeps its energy over 1000 bounces (the seed's: 10 s)",
        variants: SWEPT,
        unit: "of the energy",
        limit: 1e-4,
        run: elastic,
    },
    Case {
        id: "V10",
        title: "births with nothing left of their step, and particles beside the volume, stay as they are",
        variants: &["dda2", "seed"],
        unit: "particles moved or no numbers",
        limit: 0.0,
        run: edges,
    },
];

fn method_of(variant: &str) -> Method {
    Method::of(variant).unwrap_or_default()
}

/// A number of the method, and that of the seed's.
fn compare(
    context: &Context<'_>,
    variant: &str,
    run: impl Fn(&Gpu, Method) -> Result<f64>,
) -> Result<Outcome> {
    Ok(Outcome::of(run(context.gpu, method_of(variant))?).seed(run(context.gpu, Method::Seed)?))
}

fn units(seed: u32, i: u32) -> [f32; 4] {
    random::units(random::bits(seed, 0, i, 0)).map(|u| 2.0 * u - 1.0)
}

fn at(at_m: Vec3, velocity_mps: Vec3) -> Particle {
    Particle { at_m, velocity_mps, born: 0 }
}

/// The seed's volume: a box of two metres, here round the origin.
fn grid() -> Grid {
    Grid::new(Vec3::splat(-1.0), CELL_M, uvec3(32, 32, 32))
}

/// Without friction, losses and gravity.
fn pure(radius_m: f32) -> Colliding {
    let law = Colliding::new(grid(), radius_m);
    Colliding { restitution: 1.0, friction: 0.0, gravity_mps2: Vec3::ZERO, ..law }
}

fn ground(height_m: f64) -> Vec<Triangle> {
    rectangle(dvec3(-1.0, height_m, -1.0), DVec3::Z * 2.0, DVec3::X * 2.0).to_vec()
}

/// Cells of triangles, filled on the host.
fn host(gpu: &Gpu, grid: Grid, triangles: &[Triangle]) -> Result<Cells> {
    let cells = Cells::new(gpu, grid)?;
    Arena::upload(gpu, &cells, &fill(&grid, triangles))?;
    Ok(cells)
}

fn cells_of(gpu: &Gpu, triangles: &[Triangle], is_layered: bool) -> Result<Cells> {
    let mesh = mesh("walls", triangles).map_err(crate::mesh::MeshesError::from)?;
    Arena::voxelise(gpu, grid(), &[mesh], is_layered)
}

/// How many of `thrown` are on the far side of the plane through `on` after `steps`, as a part.
fn through(
    gpu: &Gpu,
    cells: &Cells,
    (law, method): (Colliding, Method),
    thrown: &[Particle],
    (on, normal): (Vec3, Vec3),
    steps: u64,
) -> Result<f64> {
    let kernels = Arena::kernels(gpu, method)?;
    let mut arena = Arena::new(gpu, &kernels, cells, law, 3, thrown, 4096)?;
    arena.steps(steps, DT_S)?;
    let side = |it: &Particle| normal.dot(it.at_m - on);
    let gone =
        arena.particles()?.iter().zip(thrown).filter(|(now, then)| side(now) * side(then) < 0.0).count();
    Ok(gone as f64 / thrown.len() as f64)
}

fn bullets(gpu: &Gpu, method: Method) -> Result<f64> {
    let cells = cells_of(gpu, &ground(-0.513), false)?;
    let speed = 16.0 * CELL_M * 60.0;
    let thrown: Vec<_> = (0..400)
        .map(|i| {
            let [x, y, z, _] = units(1, i);
            at(vec3(0.8 * x, 0.2 + 0.5 * y, 0.8 * z), vec3(0.02 * z, -1.0, 0.02 * x) * speed)
        })
        .collect();
    through(gpu, &cells, (pure(RADIUS_M), method), &thrown, (Vec3::Y * -0.513, Vec3::Y), 1)
}

/// Sheets at angles to the ground, thrown at along their normals at 0.7 cells a step; the seed's from its own slices.
fn marked(
    context: &Context<'_>,
    variant: &str,
    angles: impl Fn(()) -> Vec<f64>,
    shift_m: f64,
) -> Result<Outcome> {
    let gpu = context.gpu;
    let worst = |method: Method, is_layered: bool| -> Result<f64> {
        angles(()).into_iter().try_fold(0.0f64, |worst, degrees| {
            let (sin, cos) = f64::to_radians(degrees).sin_cos();
            let (along, normal) = (dvec3(cos, sin, 0.0), dvec3(-sin, cos, 0.0));
            let middle = dvec3(shift_m, 0.5 * shift_m, 0.003);
            let sheet = rectangle(middle - along * 0.8 - DVec3::Z * 0.8, DVec3::Z * 1.6, along * 1.6);
            let cells = cells_of(gpu, &sheet, is_layered)?;
            let thrown: Vec<_> = (0..400)
                .map(|i| {
                    let [a, b, c, _] = units(2, i);
                    let from = along.as_vec3() * (0.5 * a) + Vec3::Z * (0.5 * b);
                    let from = middle.as_vec3() + from + normal.as_vec3() * (0.2 + 0.05 * c);
                    at(from, normal.as_vec3() * (-0.7 * CELL_M * 60.0))
                })
                .collect();
            let plane = (middle.as_vec3(), normal.as_vec3());
            Ok(worst.max(through(gpu, &cells, (pure(0.01), method), &thrown, plane, 12)?))
        })
    };
    let outcome = Outcome::of(worst(method_of(variant), false)?);
    seeds(outcome, worst(Method::Seed, true))
}

/// The seed's figure, if the device draws layers.
fn seeds(outcome: Outcome, seed: Result<f64>) -> Result<Outcome> {
    match seed {
        Ok(seed) => Ok(outcome.seed(seed)),
        Err(Error::Gpu(error)) => Ok(outcome.note(format!("the seed's not: {error}"))),
        Err(error) => Err(error),
    }
}

/// Two walls along z, `degrees` apart, that meet off the faces of cells.
fn walls(degrees: f64) -> (Vec<Triangle>, Vec3) {
    let edge = dvec3(-0.713, -0.671, -1.0);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let mut walls = rectangle(edge, DVec3::Z * 2.0, DVec3::X * 3.0).to_vec();
    walls.extend(rectangle(edge, dvec3(3.0 * cos, 3.0 * sin, 0.0), DVec3::Z * 2.0));
    (walls, vec3(edge.x as f32, edge.y as f32, 0.0))
}

fn corners(gpu: &Gpu, method: Method, degrees: f64) -> Result<f64> {
    let (walls, edge) = walls(degrees);
    let cells = cells_of(gpu, &walls, false)?;
    let kernels = Arena::kernels(gpu, method)?;
    let (sin, cos) = (degrees.to_radians().sin() as f32, degrees.to_radians().cos() as f32);
    let half = (0.5 * degrees).to_radians();
    let middle = vec3(half.cos() as f32, half.sin() as f32, 0.0);
    [0.27, 1.0, 4.0, 16.0f32].into_iter().try_fold(0.0f64, |worst, step| {
        let thrown: Vec<_> = (0..500)
            .map(|i| {
                let [a, b, c, d] = units(3, i);
                let from = edge + middle * (0.7 + 0.1 * a) + vec3(-middle.y, middle.x, 0.0) * 0.1 * b;
                let to = edge + middle * (0.05 * c.abs()) + vec3(0.0, 0.0, 0.2 * d);
                at(from, (to - from).normalize() * (step * CELL_M * 60.0))
            })
            .collect();
        let mut arena = Arena::new(gpu, &kernels, &cells, pure(RADIUS_M), 3, &thrown, 4096)?;
        arena.steps((16.0 / step).ceil().max(2.0) as u64, DT_S)?;
        let is_out = |it: &&Particle| {
            let from = it.at_m - edge;
            from.y < 0.0 || vec3(sin, -cos, 0.0).dot(from) < 0.0
        };
        let out = arena.particles()?.iter().filter(is_out).count();
        Ok(worst.max(out as f64 / thrown.len() as f64))
    })
}

fn right_angle(gpu: &Gpu, method: Method) -> Result<f64> {
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
            worst.max(f64::from((now.velocity_mps - want).length() / want.length()))
        }))
    })
}

fn resting(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let gpu = context.gpu;
    // Peak to peak in radii over 60 s once a ball from half a metre has had time to lie, and the energy it gains (J/kg).
    let lies = |method: Method| -> Result<[f64; 2]> {
        let mut worst = [0.0f64, f64::NEG_INFINITY];
        for height in [-0.5, -0.53, -0.56] {
            let cells = host(gpu, grid(), &ground(height))?;
            let gravity_mps2 =
                if method == Method::Seed { vec3(0.0, -0.5, 0.0) } else { vec3(0.0, -9.81, 0.0) };
            let law = Colliding { gravity_mps2, ..Colliding::new(grid(), RADIUS_M) };
            let kernels = Arena::kernels(gpu, method)?;
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
    Ok(Outcome::of(jitter).seed(lies(Method::Seed)?[0]).only_if(gained < 1e-6).note(note))
}

fn pistons(gpu: &Gpu, method: Method) -> Result<f64> {
    let kernels = Arena::kernels(gpu, method)?;
    [-2.0, -1.0, -0.1, -0.01, 0.01, 0.1, 1.0, 2.0].into_iter().try_fold(0.0f64, |worst, u| {
        let moving = |it: Triangle| Triangle { velocity_mps: DVec3::Y * u, ..it };
        let cells = host(gpu, grid(), &ground(0.0).into_iter().map(moving).collect::<Vec<_>>())?;
        let law = Colliding { surface_mps: 2.0, ..pure(0.02) };
        let start = at(vec3(0.01, 0.021, 0.02), vec3(0.3, -3.0, 0.0));
        let mut arena = Arena::new(gpu, &kernels, &cells, law, 3, &[start], 64)?;
        arena.steps(1, DT_S)?;
        let want = vec3(0.3, 2.0 * u as f32 + 3.0, 0.0);
        Ok(worst.max(f64::from((arena.particles()?[0].velocity_mps - want).length())))
    })
}

fn on_faces(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let gpu = context.gpu;
    let worst = |method: Method, is_layered: bool| -> Result<f64> {
        (0..3).try_fold(0.0f64, |worst, axis| {
            let (one, other) = (DVec3::AXES[(axis + 1) % 3], DVec3::AXES[(axis + 2) % 3]);
            let wall = rectangle((one + other) * -0.75, one * 1.5, other * 1.5);
            let cells = cells_of(gpu, &wall, is_layered)?;
            let normal = Vec3::AXES[axis];
            let thrown: Vec<_> = (0..400)
                .map(|i| {
                    let [a, b, c, d] = units(6, i);
                    let side = if i % 2 == 0 { 1.0 } else { -1.0 };
                    let from = one.as_vec3() * (0.6 * a) + other.as_vec3() * (0.6 * b);
                    let from = from + normal * (side * (0.2 + 0.05 * c));
                    at(from, normal * (-side * (1.0 + 0.5 * d) * CELL_M * 60.0))
                })
                .collect();
            let plane = (Vec3::ZERO, normal);
            Ok(worst.max(through(gpu, &cells, (pure(0.01), method), &thrown, plane, 8)?))
        })
    };
    let outcome = Outcome::of(worst(method_of(variant), false)?);
    seeds(outcome, worst(Method::Seed, true))
}

fn behind(gpu: &Gpu, method: Method) -> Result<f64> {
    // A wall of two sheets, 1 cm apart, its front to +y; a ball may be nearer to it than its radius.
    let sheets = [(0.013, DVec3::Z, DVec3::X), (0.003, DVec3::X, DVec3::Z)];
    let wall: Vec<_> = sheets
        .into_iter()
        .flat_map(|(y, one, other)| rectangle(dvec3(-0.8, y, -0.8), one * 1.6, other * 1.6))
        .collect();
    let cells = cells_of(gpu, &wall, false)?;
    let placed: Vec<_> = (0..200)
        .map(|i| {
            let [a, b, c, d] = units(7, i);
            let side = if i % 2 == 0 { 1.0 } else { -1.0 };
            let y = if side > 0.0 { 0.014 + 0.06 * c.abs() } else { 0.002 - 0.06 * c.abs() };
            at(vec3(0.5 * a, y, 0.5 * b), vec3(0.2 * b, -side * 0.5 * d, 0.2 * a))
        })
        .collect();
    let plane = (Vec3::Y * 0.008, Vec3::Y);
    let law = Colliding { restitution: 0.5, ..pure(RADIUS_M) };
    Ok(through(gpu, &cells, (law, method), &placed, plane, 30)? * placed.len() as f64)
}

fn elastic(context: &Context<'_>, variant: &str) -> Result<Outcome> {
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

fn edges(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let gpu = context.gpu;
    let method = method_of(variant);
    // A birth exactly at the end of the step, in a cell of the ground; and a wall at the border of the volume, with a
    // particle outside, out of its reach: a lookup that clamps would have the wall go on for ever.
    let mut scene = ground(-0.5);
    scene.extend(rectangle(dvec3(0.99, -1.0, -1.0), DVec3::Y * 2.0, DVec3::Z * 2.0));
    let cells = host(gpu, grid(), &scene)?;
    let law = pure(0.05);
    let surroundings = Surroundings::new(gpu, &cells, 3)?;
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
