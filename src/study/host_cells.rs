// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cells filled on the host, in f64, by the twin of `volume`: scenes of a few triangles for hard cases and tests that must
//! not depend on a device.

use crate::{
    cells::{Extent, Grid, Plane, Read},
    mesh::{Mesh, MeshError},
    volume::cpu,
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

/// Every cell that a triangle touches, with the planes that `volume` keeps of those in it: the choice is its twin's.
pub fn fill(grid: &Grid, triangles: &[Triangle]) -> Read {
    let mut read = Read {
        occupied: vec![0; grid.count().div_ceil(32)],
        planes: vec![Plane::default(); 2 * grid.count()],
        extents: vec![[Extent::default(); 3]; grid.count()],
    };
    let at_m: Vec<Vec3> = triangles.iter().flat_map(|it| it.corners_m.map(|at| at.as_vec3())).collect();
    let voxels = cpu::mark(grid, &at_m, &corners(triangles));
    for i in 0..grid.count() {
        let centre = centre_m(grid, grid.cell(i));
        let plane = |number: u32| triangles[number as usize].plane(centre, number as usize);
        let Some(first) = voxels.first(i) else { continue };
        read.occupied[i / 32] |= 1 << (i % 32);
        read.planes[2 * i] = plane(first);
        let second = voxels.second(grid, i);
        read.planes[2 * i + 1] = second.map(plane).unwrap_or_default();
        read.extents[i] = voxels.extents(grid, i, [Some(first), second], 0.0);
    }
    read
}

/// Three vertices of its own for each.
fn corners(triangles: &[Triangle]) -> Vec<[u32; 3]> {
    (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect()
}

/// The triangles as a mesh.
///
/// # Errors
/// If one is no triangle.
pub fn mesh(name: &str, triangles: &[Triangle]) -> Result<Mesh, MeshError> {
    let at_m = triangles.iter().flat_map(|it| it.corners_m.map(|corner| corner.as_vec3())).collect();
    Mesh::still(name, at_m, Vec::new(), corners(triangles))
}

/// As the shader has it: rounded like a place of the particle.
fn centre_m(grid: &Grid, cell: IVec3) -> DVec3 {
    grid.centre_m(cell).as_dvec3()
}
