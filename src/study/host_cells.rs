// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cells filled on the host, in f64: scenes of a few triangles for hard cases and tests
//! that must not depend on a voxelisation.

use crate::{
    cells::{Grid, Plane, Read},
    mesh::{Mesh, MeshError},
};
use glam::{DVec3, IVec3, Vec3};

/// A triangle that moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triangle {
    /// Counter-clockwise, as its front sees it (m).
    pub corners_m: [DVec3; 3],
    /// (m/s).
    pub velocity_mps: DVec3,
}

impl Triangle {
    /// One at rest.
    pub fn new(corners_m: [DVec3; 3]) -> Self {
        Self { corners_m, velocity_mps: DVec3::ZERO }
    }

    /// Unit.
    pub fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners_m;
        (b - a).cross(c - a).normalize()
    }

    /// The plane, relative to `centre`.
    pub fn plane(&self, centre_m: DVec3, number: usize) -> Plane {
        let normal = self.normal();
        let own = normal.dot(centre_m - self.corners_m[0]);
        Plane {
            normal: normal.as_vec3().to_array(),
            distance_m: own as f32,
            velocity_mps: self.velocity_mps.as_vec3().to_array(),
            triangle: number as u32 + 1,
        }
    }

    /// Whether it touches the closed box: the thirteen axes (Akenine-Moeller, "Fast 3D Triangle-Box Overlap Testing", 2001).
    pub fn touches(&self, centre_m: DVec3, half_m: f64) -> bool {
        let at = self.corners_m.map(|it| it - centre_m);
        let edges = [at[1] - at[0], at[2] - at[1], at[0] - at[2]];
        let crossed = edges.into_iter().flat_map(|edge| DVec3::AXES.map(|axis| edge.cross(axis)));
        crossed.chain(DVec3::AXES).chain([edges[0].cross(edges[1])]).all(|axis| {
            let along = at.map(|it| it.dot(axis));
            let reach = half_m * axis.abs().element_sum() * (1.0 + 1e-12);
            along.into_iter().fold(f64::INFINITY, f64::min) <= reach
                && along.into_iter().fold(f64::NEG_INFINITY, f64::max) >= -reach
        })
    }
}

/// A rectangle with a corner at `at`, of two triangles; its front is where `one x other` points.
pub fn rectangle(at: DVec3, one: DVec3, other: DVec3) -> [Triangle; 2] {
    let far = at + one + other;
    [Triangle::new([at, at + one, far]), Triangle::new([at, far, at + other])]
}

/// A box with its faces outward, or inward for a room.
pub fn cuboid(low: DVec3, high: DVec3, is_room: bool) -> Vec<Triangle> {
    let side = high - low;
    let [x, y, z] = [DVec3::X * side.x, DVec3::Y * side.y, DVec3::Z * side.z];
    let faces = [(x, y, z), (y, z, x), (z, x, y)].map(|(a, b, c)| [(low, b, a), (low + c, a, b)]);
    let both = faces.into_iter().flatten();
    let turned = both.map(|(at, one, other)| if is_room { (at, other, one) } else { (at, one, other) });
    turned.flat_map(|(at, one, other)| rectangle(at, one, other)).collect()
}

/// Every cell that a triangle touches, its nearest plane and the one that differs most from it.
pub fn fill(grid: &Grid, triangles: &[Triangle]) -> Read {
    let none = Plane::default();
    let mut read =
        Read { occupied: vec![0; grid.count().div_ceil(32)], planes: vec![none; 2 * grid.count()] };
    let half = 0.5 * f64::from(grid.cell_m);
    for i in 0..grid.count() {
        let centre = centre_m(grid, grid.cell(i));
        let inside = triangles.iter().enumerate().filter(|(_, it)| it.touches(centre, half));
        let planes: Vec<Plane> = inside.map(|(number, it)| it.plane(centre, number)).collect();
        let nearest = planes.iter().min_by(|a, b| a.distance_m.abs().total_cmp(&b.distance_m.abs()));
        let Some(&first) = nearest else { continue };
        let normal = Vec3::from(first.normal);
        let turned = |it: &Plane| normal.dot(it.normal.into());
        let differs = |it: &&Plane| {
            let along = if turned(it) < 0.0 { -it.distance_m } else { it.distance_m };
            turned(it).abs() < 0.985 || (along - first.distance_m).abs() > 1e-4 * grid.cell_m
        };
        let second = planes.iter().filter(differs).min_by(|a, b| turned(a).total_cmp(&turned(b)));
        read.occupied[i / 32] |= 1 << (i % 32);
        read.planes[2 * i] = first;
        read.planes[2 * i + 1] = second.copied().unwrap_or_default();
    }
    read
}

/// The triangles as a mesh.
///
/// # Errors
/// If one is no triangle.
pub fn mesh(name: &str, triangles: &[Triangle]) -> Result<Mesh, MeshError> {
    let at_m = triangles.iter().flat_map(|it| it.corners_m.map(|corner| corner.as_vec3())).collect();
    let corners = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    Mesh::still(name, at_m, Vec::new(), corners)
}

/// As the shader has it: rounded like a place of the particle.
fn centre_m(grid: &Grid, cell: IVec3) -> DVec3 {
    grid.centre_m(cell).as_dvec3()
}
