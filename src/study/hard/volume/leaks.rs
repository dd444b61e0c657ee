// SPDX-License-Identifier: MIT OR Apache-2.0
//! Who gets through: bullets, sheets at every angle, corners, planes on the faces of cells, thin walls.

use super::{at, cells_of, ground, method_of, pure, seed, units, walls, CELL_M, DT_S, RADIUS_M};
use crate::{
    cells::Cells,
    gpu::Gpu,
    particles::{
        colliding::{Colliding, Method},
        Particle, Particles,
    },
    study::{
        arena::Arena,
        hard::{Context, Outcome},
        host_cells::rectangle,
        Error, Result,
    },
};
use glam::{dvec3, vec3, DVec3, Vec3};

/// How many of `thrown` are on the far side of the plane through `on` after `steps`, as a part.
fn through(
    gpu: &Gpu,
    cells: &Cells,
    (law, kernels): (Colliding, &Particles),
    thrown: &[Particle],
    (on, normal): (Vec3, Vec3),
    steps: u64,
) -> Result<f64> {
    let mut arena = Arena::new(gpu, kernels, cells, law, 3, thrown, 4096)?;
    arena.steps(steps, DT_S)?;
    let side = |it: &Particle| normal.dot(it.at_m - on);
    let gone =
        arena.particles()?.iter().zip(thrown).filter(|(now, then)| side(now) * side(then) < 0.0).count();
    Ok(gone as f64 / thrown.len() as f64)
}

pub fn bullets(gpu: &Gpu, method: Method) -> Result<f64> {
    let cells = cells_of(gpu, &ground(-0.513), false)?;
    let speed = 16.0 * CELL_M * 60.0;
    let thrown: Vec<_> = (0..400)
        .map(|i| {
            let [x, y, z, _] = units(1, i);
            at(vec3(0.8 * x, 0.2 + 0.5 * y, 0.8 * z), vec3(0.02 * z, -1.0, 0.02 * x) * speed)
        })
        .collect();
    let kernels = Arena::kernels(gpu, method)?;
    through(gpu, &cells, (pure(RADIUS_M), &kernels), &thrown, (Vec3::Y * -0.513, Vec3::Y), 1)
}

/// Sheets at angles to the ground, thrown at along their normals at 0.7 cells a step; the seed's from its own slices.
pub fn marked(
    context: &Context<'_>,
    name: &'static str,
    variant: &str,
    angles: &[f64],
    shift_m: f64,
) -> Result<Outcome> {
    let gpu = context.gpu;
    let worst = |method: Method, is_layered: bool| -> Result<f64> {
        let kernels = Arena::kernels(gpu, method)?;
        angles.iter().try_fold(0.0f64, |worst, degrees| {
            let (sin, cos) = degrees.to_radians().sin_cos();
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
            Ok(worst.max(through(gpu, &cells, (pure(0.01), &kernels), &thrown, plane, 12)?))
        })
    };
    let outcome = Outcome::of(worst(method_of(variant), false)?);
    seeds(outcome, seed(context, name, || worst(Method::Seed, true)))
}

/// The seed's figure, if the device draws layers.
fn seeds(outcome: Outcome, seed: Result<f64>) -> Result<Outcome> {
    match seed {
        Ok(seed) => Ok(outcome.seed(seed)),
        Err(Error::Gpu(error)) => Ok(outcome.note(format!("the seed's not: {error}"))),
        Err(error) => Err(error),
    }
}

pub fn corners(gpu: &Gpu, method: Method, degrees: f64) -> Result<f64> {
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

pub fn on_faces(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let gpu = context.gpu;
    let worst = |method: Method, is_layered: bool| -> Result<f64> {
        let kernels = Arena::kernels(gpu, method)?;
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
            Ok(worst.max(through(gpu, &cells, (pure(0.01), &kernels), &thrown, plane, 8)?))
        })
    };
    let outcome = Outcome::of(worst(method_of(variant), false)?);
    seeds(outcome, seed(context, "V7", || worst(Method::Seed, true)))
}

pub fn behind(gpu: &Gpu, method: Method) -> Result<f64> {
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
    let kernels = Arena::kernels(gpu, method)?;
    Ok(through(gpu, &cells, (law, &kernels), &placed, plane, 30)? * placed.len() as f64)
}
