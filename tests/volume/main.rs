// SPDX-License-Identifier: MIT OR Apache-2.0
//! Voxelisation: the cells that triangles mark, the planes and velocities in them, against twins in f64.
#![allow(missing_docs)]

#[path = "../common/mod.rs"]
mod common;
mod conservative;
mod corners;
mod layouts;
mod motion;
mod raster;

use common::TestGpu;
use glam::{vec3, Mat4, UVec3, Vec3};
use whitecap::{
    cells::{Cells, Extent, Grid, Read},
    gpu::Access,
    mesh::{shapes, Body, Mesh, Meshes},
    random,
    volume::{cpu, Conservative, Counts},
};

/// A mesh that does not move, and has no texture coordinates.
pub fn mesh(name: &str, at_m: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh::still(name, at_m, Vec::new(), triangles).unwrap()
}

/// Three corners a triangle.
pub fn soup(name: &str, corners: &[[Vec3; 3]]) -> Mesh {
    let triangles = (0..corners.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    mesh(name, corners.as_flattened().to_vec(), triangles)
}

pub fn still(mesh: Mesh) -> Body {
    Body { mesh, world: Mat4::IDENTITY, moves: false }
}

pub fn moving(mesh: Mesh) -> Body {
    Body { mesh, world: Mat4::IDENTITY, moves: true }
}

pub fn grid(cells: u32, cell_m: f32) -> Grid {
    Grid::new(vec3(-0.7, 0.2, -1.3), cell_m, UVec3::splat(cells))
}

/// Cells of the meshes as they are put, by compute.
pub fn conservative(gpu: &TestGpu, grid: Grid, bodies: &[Body]) -> (Read, Counts) {
    let meshes = Meshes::new(gpu, bodies).unwrap();
    let cells = Cells::new(gpu, grid).unwrap();
    let volume = Conservative::new(gpu, &meshes, &cells).unwrap();
    gpu.once(|rec| {
        meshes.record(rec, 0.0, 0.0, &[]);
        rec.barrier(Meshes::EXIT, Conservative::ENTRY);
        volume.record(rec);
        rec.barrier(Conservative::EXIT, Access::ComputeReadWrite);
    })
    .unwrap();
    (cells.read(gpu).unwrap(), volume.counts(gpu).unwrap())
}

/// Places as they are put, and triangles of all meshes.
pub fn as_one(bodies: &[Body]) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let (mut at, mut triangles) = (Vec::new(), Vec::new());
    for body in bodies {
        let first = at.len() as u32;
        let joints = body.mesh.rig.pose(0.0);
        let posed = whitecap::mesh::cpu::pose(&body.mesh, &joints, &joints, &joints, 0.0);
        at.extend(posed.iter().map(|(at, _)| body.world.transform_point3(*at)));
        triangles.extend(body.mesh.triangles.iter().map(|corners| corners.map(|i| i + first)));
    }
    (at, triangles)
}

/// What is compared, and how much of it single precision cannot decide.
#[derive(Debug, Default, PartialEq)]
pub struct Compared {
    pub marked: usize,
    pub undecided: usize,
    pub undecided_extents: usize,
    pub wrong: Vec<String>,
}

/// Cells of the device against the twin's: occupancy, planes, which triangles they are of, and where those lie in them. A cell is undecided if f64
/// finds the triangle within rounding of touching its box.
pub fn compare(grid: &Grid, (at, triangles): &(Vec<Vec3>, Vec<[u32; 3]>), read: &Read) -> Compared {
    let voxels = cpu::mark(grid, at, triangles);
    let bits = cpu::key_bits(triangles.len() as u32);
    let step = 1.0 / f64::from((1u32 << (32 - bits)) - 1);
    let mut out = Compared::default();
    for cell in 0..grid.count() {
        let (want, planes) = (&voxels.cells[cell], read.planes_of(cell));
        let centre = grid.cell(cell).as_dvec3() + 0.5;
        let gap = |t: u32| {
            voxels.shapes[t as usize].as_ref().map_or(f64::INFINITY, |s| s.gap(grid.cell(cell)) - s.slack)
        };
        let is_close = |gap: f64| gap.abs() < 5e-5;
        if planes.is_empty() != want.is_empty() {
            let near = want.iter().map(|&(t, _)| t).chain(planes.first().map(|plane| plane.triangle - 1));
            if near.clone().all(|t| is_close(gap(t))) {
                out.undecided += 1;
            } else {
                out.wrong.push(format!("cell {cell}: {} planes, {want:?}", planes.len()));
            }
            continue;
        }
        let Some(first) = planes.first() else { continue };
        out.marked += 1;
        let t = first.triangle - 1;
        let mut fail = |what: String| out.wrong.push(format!("cell {cell}: {what}"));
        if gap(t) > 5e-5 {
            fail(format!("triangle {t} is {} cells off", gap(t)));
            continue;
        }
        // The nearest, to a step of the key; of those in one step, the first.
        let distance = |t: u32| {
            let shape = voxels.shapes[t as usize].as_ref().unwrap();
            (shape.nearest(centre).0 - centre).length()
        };
        let is_sure = |t: u32| gap(t) < -5e-5;
        let least = want.iter().filter(|it| is_sure(it.0)).map(|it| it.1).fold(f64::INFINITY, f64::min);
        if distance(t) > least + 0.875 * step + 1e-4 {
            fail(format!("triangle {t} is {} from the centre, the nearest {least}", distance(t)));
        }
        let beside: Vec<(u32, f64)> =
            want.iter().filter_map(|&(other, _)| Some((other, voxels.beside(centre, t, other)?))).collect();
        let best = beside.iter().filter(|it| is_sure(it.0)).map(|it| it.1).fold(f64::INFINITY, f64::min);
        match planes.get(1) {
            Some(second) => {
                let other = second.triangle - 1;
                // Angles and distances at their bounds are decided either way.
                let normal = |t: u32| voxels.shapes[t as usize].as_ref().unwrap().normal;
                let cosine = normal(t).dot(normal(other)).abs();
                if gap(other) > 5e-5 || cosine > best.min(1.0) + step + 1e-5 {
                    fail(format!("{other} beside {t}: {cosine}, best {best}, gap {}", gap(other)));
                }
            }
            None => {
                let planes_apart = |other: u32| {
                    let [mine, first] =
                        [other, t].map(|t| voxels.shapes[t as usize].as_ref().unwrap().distance(centre));
                    (mine - first).abs()
                };
                let sure = |&(other, cosine): &(u32, f64)| {
                    // Of the back of a wall as well.
                    let is_parallel = cosine > 0.99986 && planes_apart(other) > 0.0635;
                    is_sure(other) && (cosine < 0.9847 || is_parallel)
                };
                if let Some((other, cosine)) = beside.iter().find(|it| sure(it)) {
                    fail(format!("no second plane beside {t}; {other} is at {cosine}"));
                }
            }
        }
        for plane in planes {
            let t = plane.triangle - 1;
            let shape = voxels.shapes[t as usize].as_ref().unwrap();
            let want = voxels.plane(grid, cell, t, [Vec3::ZERO; 3]);
            let apart = (Vec3::from(plane.normal).as_dvec3() - shape.normal).length();
            let off =
                (f64::from(plane.distance_m) - f64::from(want.distance_m)).abs() / f64::from(grid.cell_m);
            // A needle's normal is known to what its corners are.
            let sine = sine(shape);
            if apart > 1e-5 + 4e-7 / sine || off > 1e-4 + 1e-6 / sine {
                fail(format!("plane of {t}: {plane:?}, want {want:?}"));
            }
        }
        let of = |slot: usize| planes.get(slot).map(|plane| plane.triangle - 1);
        let within = |more: f64| voxels.extents(grid, cell, [of(0), of(1)], more);
        let (got, least, most) = (read.extents[cell], within(-2e-3), within(2e-3));
        let all = |extents: [Extent; 3]| extents.iter().fold(0, |all, extent| all | extent.0);
        let is_between = |least: u32, got: u32, most: u32| least & !got == 0 && got & !most == 0;
        if !(0..3).all(|k| is_between(least[k].0, got[k].0, most[k].0)) {
            // To which of two planes a triangle is nearer, and whether one that touches the cell is in it, may be undecided.
            let touches = want.iter().any(|&(t, _)| is_close(gap(t)));
            if touches || is_between(all(least), all(got), all(most)) {
                out.undecided_extents += 1;
            } else {
                fail(format!("extents {got:x?}, want {least:x?} to {most:x?}"));
            }
        }
    }
    out
}

fn sine(shape: &cpu::Shape) -> f64 {
    let [a, b, c] = shape.corners;
    let extent = (b - a).abs().max_element().max((c - a).abs().max_element());
    (b - a).cross(c - a).length() / (extent * extent)
}

/// A point of a box (m), by number.
pub fn within(serial: u32, low: Vec3, high: Vec3) -> Vec3 {
    let [x, y, z, _] = random::units(random::bits(11, 0, serial, 0));
    low + (high - low) * vec3(x, y, z)
}

/// A torus of about so many triangles.
pub fn torus(triangles: usize) -> Mesh {
    shapes::torus(0.5, 0.2, (triangles as f32 / 2.0).sqrt().round() as u32)
}
