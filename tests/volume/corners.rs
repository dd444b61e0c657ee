// SPDX-License-Identifier: MIT OR Apache-2.0
//! Corners of thin walls: more planes pass there than a cell holds. If the back of a wall, 180 degrees from its front, came
//! before the other walls, 4 of 512 points would leave the room.

use super::*;
use common::gpu;
use glam::dvec3;
use whitecap::cells::Plane;
use whitecap::{
    particles::{
        colliding::{Colliding, Method},
        Particle,
    },
    study::{
        arena::Arena,
        host_cells::{self, cuboid, fill, Triangle},
    },
};

/// Half of what the walls are thick: an eighth of a cell in all (m).
const HALF_M: f32 = 0.004;
/// Half of the room (m).
const ROOM_M: f32 = 0.641;

/// Six plates round a room, each a closed box; they meet at its edges.
fn room() -> Vec<Body> {
    let plate = |axis: usize, side: f32| {
        let mut half = Vec3::splat(ROOM_M + HALF_M);
        half[axis] = HALF_M;
        let mut at = Vec3::splat(0.013);
        at[axis] += side * ROOM_M;
        let world = Mat4::from_translation(at);
        Body { mesh: shapes::cuboid(half), world, moves: false }
    };
    (0..3).flat_map(|axis| [plate(axis, -1.0), plate(axis, 1.0)]).collect()
}

#[test]
fn cells_that_are_filled_on_the_host_hold_the_planes_that_the_kernels_keep() {
    let gpu = gpu();
    // A thin wall on a floor, a box that is turned, and a room: backs, corners, and what is parallel.
    let mut triangles = cuboid(dvec3(-0.4, 0.3, -1.1), dvec3(0.9, 1.5, 0.1), true);
    triangles.extend(cuboid(dvec3(0.11, 0.3, -1.0), dvec3(0.117, 0.9, -0.1), false));
    let turn = glam::DQuat::from_rotation_y(0.4) * glam::DQuat::from_rotation_x(0.3);
    triangles.extend(
        cuboid(dvec3(-0.1, -0.1, -0.1), dvec3(0.12, 0.05, 0.14), false)
            .into_iter()
            .map(|it| Triangle { corners_m: it.corners_m.map(|at| turn * at + dvec3(0.5, 0.8, -0.5)), ..it }),
    );
    let grid = grid(21, 0.0713);
    let filled = fill(&grid, &triangles);
    let (kept, _) = conservative(&gpu, grid, &[still(host_cells::mesh("host", &triangles).unwrap())]);
    let (mut cells, mut seconds) = (0, 0);
    for i in kept.marked() {
        cells += 1;
        let (got, want) = (filled.planes_of(i), kept.planes_of(i));
        assert_eq!(got.len(), want.len(), "cell {}", grid.cell(i));
        seconds += want.len() - 1;
        // Of what is as near, or as near a right angle, rounding takes one: what is compared is how good the second is.
        let merit = |planes: &[Plane]| {
            planes.get(1).map_or(0.0, |it| Vec3::from(it.normal).dot(planes[0].normal.into()).abs())
        };
        assert!((merit(got) - merit(want)).abs() < 1e-4, "cell {}: {got:?}, kept {want:?}", grid.cell(i));
        // Two triangles of a side are one plane.
        let has = |plane: &Plane| want.iter().any(|it| (it.triangle - 1) / 2 == (plane.triangle - 1) / 2);
        assert!(got.iter().any(has), "cell {}: {got:?}, kept {want:?}", grid.cell(i));
    }
    assert_eq!(filled.marked(), kept.marked());
    // Where both took the same triangles, the extents are the same but for rounding at an eighth of a cell.
    let same = kept.marked().into_iter().filter(|&i| {
        filled.planes_of(i).iter().zip(kept.planes_of(i)).all(|(a, b)| a.triangle == b.triangle)
    });
    let (alike, other): (Vec<usize>, Vec<usize>) = same.partition(|&i| filled.extents[i] == kept.extents[i]);
    assert!(
        alike.len() > 400 && other.len() * 50 < alike.len(),
        "{} alike, {} not",
        alike.len(),
        other.len()
    );
    assert!(cells > 500 && seconds > 50, "{cells} cells, {seconds} with a second plane");
}

#[test]
fn a_room_of_thin_walls_keeps_its_particles() {
    let gpu = gpu();
    let grid = Grid::new(Vec3::splat(-1.0), 0.0625, UVec3::splat(32));
    let meshes = Meshes::new(&gpu, &room()).unwrap();
    let cells = Cells::new(&gpu, grid).unwrap();
    Conservative::new(&gpu, &meshes, &cells).unwrap();
    for (radius_m, cells_a_step) in [(0.002, 0.3), (0.002, 3.0), (0.03, 0.9), (0.03, 6.0)] {
        let law = Colliding {
            restitution: 1.0,
            friction: 0.0,
            gravity_mps2: Vec3::ZERO,
            ..Colliding::new(grid, radius_m)
        };
        // Towards all eight corners, a little beside them.
        let thrown: Vec<Particle> = (0..512u32)
            .map(|i| {
                let corner = Vec3::new(1.0, 1.0, 1.0)
                    - 2.0 * vec3((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32);
                let beside = within(i, Vec3::splat(-0.05), Vec3::splat(0.05));
                let at_m = vec3(0.013, 0.013, 0.013) + corner * 0.4 + beside;
                let velocity_mps = corner / 3f32.sqrt() * cells_a_step * grid.cell_m * 60.0;
                Particle { at_m, velocity_mps, born: 0 }
            })
            .collect();
        let kernels = Arena::kernels(&gpu, Method::TwoPlanes).unwrap();
        let mut arena = Arena::new(&gpu, &kernels, &cells, law, 3, &thrown, 1 << 14).unwrap();
        arena.steps((24.0 / cells_a_step).ceil() as u64, 1.0 / 60.0).unwrap();
        let far = |it: &Particle| (it.at_m - 0.013).abs().max_element();
        let now = arena.particles().unwrap();
        let out = now.iter().filter(|it| far(it) > ROOM_M + HALF_M).count();
        let turned = now.iter().zip(&thrown).filter(|(a, b)| a.velocity_mps != b.velocity_mps).count();
        // Where a cell knows only the back of a wall, they are turned there: within what it is thick.
        assert_eq!((out, turned), (0, thrown.len()), "{radius_m} m, {cells_a_step} cells a step");
    }
}
