// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of voxelisation: a torus of so many triangles into a cube of 32 or 128 cells a side, everything that a step does
//! counted: clearing, marking, writing planes. `tenth`: only a tenth of the triangles moves; `large`: boxes, whose triangles
//! are 8 to 50 cells wide.

use super::{Measured, Suite};
use crate::{
    cells::{Cells, Grid},
    gpu::{self, Access, Gpu, Recorder},
    mesh::{shapes, Body, Mesh, Meshes, MeshesError},
    random,
    study::{must_be_within, runs, Error, Result},
    volume::{cpu, Conservative, Layered, Once, Router, Way},
};
use glam::{DVec2, Mat4, UVec3, Vec3};

/// Its rows.
pub const SUITE: Suite = Suite {
    sim: "volume",
    variants: &[
        "layered/vertex/32",
        "layered/geometry/32",
        "one-pass/32",
        "conservative/32",
        "one-pass/128",
        "conservative/128",
        "conservative/128/tenth",
        "conservative/128/large",
    ],
    sizes: &[10_000, 100_000, 1_000_000],
    largest_on_cpu: 10_000,
    label: |size| size.to_string(),
    run: |gpu, variant, size, effort| {
        must_be_within(variant, from_twin(gpu, variant)?, if is_drawn(variant) { 0.02 } else { 0.001 })?;
        let volume = Volume::new(gpu, variant, &bodies(variant, size))?;
        // Once, so that places are there.
        volume.pose(gpu)?;
        let timing = runs::time(gpu, effort, |rec| {
            volume.record(rec);
            rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
        })?;
        // Three indices, and of three vertices the places.
        Ok(Measured { timing, items: f64::from(volume.triangles), unit: "triangle", bytes_per_item: 48.0 })
    },
};

/// Builds what the rows voxelise with. What the device lacks is left out.
pub(in crate::study) fn build(gpu: &Gpu) -> Result<()> {
    for variant in SUITE.variants {
        match Volume::new(gpu, variant, &bodies(variant, 100)) {
            Err(Error::Lacks { .. } | Error::Gpu(gpu::Error::Lacks { .. })) => {}
            built => drop(built?),
        }
    }
    Ok(())
}

/// Side of the cube (m).
const SIDE_M: f32 = 1.5;

fn is_drawn(variant: &str) -> bool {
    !variant.starts_with("conservative")
}

fn grid(variant: &str) -> Grid {
    let cells = if variant.contains("/128") { 128 } else { 32 };
    Grid::new(Vec3::splat(-SIDE_M / 2.0), SIDE_M / cells as f32, UVec3::splat(cells))
}

fn bodies(variant: &str, triangles: u32) -> Vec<Body> {
    let torus = |triangles: u32| shapes::torus(0.5, 0.2, (triangles as f32 / 2.0).sqrt().round() as u32);
    // Turned, so that no row of triangles lies along cells.
    let world = Mat4::from_rotation_x(0.3) * Mat4::from_rotation_z(0.2);
    let body = |mesh: Mesh, moves: bool| Body { mesh, world, moves };
    if variant.ends_with("/large") {
        let boxes = (0..triangles.div_ceil(12)).map(|i| {
            let [x, y, z, size] = random::units(random::bits(3, 0, i, 0));
            let at = (Vec3::new(x, y, z) - 0.5) * (SIDE_M - 0.6);
            (at, Vec3::new(0.05 + 0.2 * size, 0.05 + 0.2 * x, 0.05 + 0.2 * y))
        });
        return vec![body(joined(boxes), true)];
    }
    if variant.ends_with("/tenth") {
        return vec![body(torus(triangles / 10 * 9), false), body(torus(triangles / 10), true)];
    }
    vec![body(torus(triangles), true)]
}

/// Boxes about places, of half sides, as one mesh.
fn joined(boxes: impl Iterator<Item = (Vec3, Vec3)>) -> Mesh {
    let mut all = shapes::cuboid(Vec3::ONE);
    let one = all.clone();
    for list in [&mut all.at_m, &mut all.normals] {
        list.clear();
    }
    (all.uv, all.hold, all.triangles) = (Vec::new(), Vec::new(), Vec::new());
    for (at, half) in boxes {
        let first = all.at_m.len() as u32;
        all.at_m.extend(one.at_m.iter().map(|corner| at + *corner * half));
        all.normals.extend(&one.normals);
        all.hold.extend(&one.hold);
        all.triangles.extend(one.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
    }
    all
}

enum Pass {
    Layered(Layered),
    Once(Once),
    Conservative(Conservative),
}

/// A variant with its meshes and cells.
struct Volume {
    meshes: Meshes,
    cells: Cells,
    pass: Pass,
    triangles: u32,
}

impl Volume {
    fn new(gpu: &Gpu, variant: &str, bodies: &[Body]) -> Result<Self> {
        let meshes = Meshes::new(gpu, bodies).map_err(|error| match error {
            MeshesError::Gpu(error) => Error::Gpu(error),
            MeshesError::Mesh(error) => {
                Error::NoSuch { what: "mesh", wanted: error.to_string(), have: Vec::new() }
            }
        })?;
        let cells = Cells::new(gpu, grid(variant))?;
        let way = Way::DownY;
        let pass = match variant.split('/').collect::<Vec<_>>()[..] {
            ["layered", "vertex", ..] => {
                Pass::Layered(Layered::new(gpu, &meshes, &cells, way, Router::Vertex)?)
            }
            ["layered", ..] => Pass::Layered(Layered::new(gpu, &meshes, &cells, way, Router::Geometry)?),
            ["one-pass", ..] => Pass::Once(Once::new(gpu, &meshes, &cells, way)?),
            _ => Pass::Conservative(Conservative::new(gpu, &meshes, &cells)?),
        };
        let triangles = meshes.count();
        Ok(Self { meshes, cells, pass, triangles })
    }

    /// Places as they are put.
    fn pose(&self, gpu: &Gpu) -> Result<()> {
        gpu.once(|rec| {
            self.meshes.record(rec, 0.0, 0.0, &[]);
            for reader in [Access::ComputeReadWrite, Access::GraphicsRead] {
                rec.barrier(Meshes::EXIT, reader);
            }
        })?;
        Ok(())
    }

    fn record(&self, rec: &mut Recorder<'_>) {
        match &self.pass {
            Pass::Layered(pass) => pass.record(rec),
            Pass::Once(pass) => pass.record(rec),
            Pass::Conservative(pass) => pass.record(rec),
        }
    }
}

/// Cells that are marked and should not be, or the other way round, or whose first plane is not that of its triangle, of those
/// that should be marked: a smaller scene.
fn from_twin(gpu: &Gpu, variant: &str) -> Result<f64> {
    let bodies = bodies(variant, 3000);
    let volume = Volume::new(gpu, variant, &bodies)?;
    volume.pose(gpu)?;
    gpu.once(|rec| {
        volume.record(rec);
        rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
    })?;
    let (got, grid) = (volume.cells.read(gpu)?, volume.cells.grid());
    let shapes = bodies.iter().flat_map(|body| {
        let at: Vec<Vec3> = body.mesh.at_m.iter().map(|at| body.world.transform_point3(*at)).collect();
        let corners = body.mesh.triangles.iter().map(move |it| it.map(|corner| at[corner as usize]));
        corners.map(move |corners| cpu::Shape::new(&grid, corners).ok()).collect::<Vec<_>>()
    });
    let shapes: Vec<_> = shapes.collect();
    let mut want = vec![false; grid.count()];
    for shape in shapes.iter().flatten() {
        let cells = if is_drawn(variant) {
            texels(shape)
        } else {
            shape.cells().into_iter().map(|it| it.0).collect()
        };
        cells.iter().filter_map(|&cell| grid.index(cell)).for_each(|cell| want[cell] = true);
    }
    let is_plane = |cell: usize| {
        let Some(plane) = got.planes_of(cell).first() else { return true };
        let shape = shapes.get(plane.triangle as usize - 1).and_then(Option::as_ref);
        shape.is_some_and(|shape| {
            let distance = shape.distance(grid.cell(cell).as_dvec3() + 0.5);
            let off = (f64::from(plane.distance_m / grid.cell_m) - distance).abs();
            off < 1e-3 && Vec3::from(plane.normal).distance(shape.normal.as_vec3()) < 1e-3
        })
    };
    let is_wrong = |&(cell, want): &(usize, &bool)| got.is_occupied(cell) != *want || !is_plane(cell);
    let wrong = want.iter().enumerate().filter(is_wrong).count();
    Ok(wrong as f64 / want.iter().filter(|want| **want).count() as f64)
}

/// Cells whose texels a triangle covers, seen along y.
fn texels(shape: &cpu::Shape) -> Vec<glam::IVec3> {
    let mut cells = Vec::new();
    for x in shape.low.x..=shape.high.x {
        for z in shape.low.z..=shape.high.z {
            let centre = DVec2::new(f64::from(z), f64::from(x)) + 0.5;
            if let Some(height) = cpu::texel(shape, 1, centre) {
                cells.push(glam::IVec3::new(x, height.floor() as i32, z));
            }
        }
    }
    cells
}
