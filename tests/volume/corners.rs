// SPDX-License-Identifier: MIT OR Apache-2.0
//! Corners of thin walls: more planes pass there than a cell holds. If the back of a wall, 180 degrees from its front, came
//! before the other walls, 4 of 512 points would leave the room.

use super::*;
use common::gpu;
use whitecap::{
    particles::{
        colliding::{Colliding, Method},
        Particle,
    },
    study::arena::Arena,
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
