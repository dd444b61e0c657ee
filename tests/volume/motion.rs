// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes that move: what is done again in a step, and the velocities in the cells.

use super::{conservative::same, *};
use common::gpu;
use glam::Quat;

/// Blocks and a lizard, every second of which moves.
fn scene() -> Vec<Body> {
    let at = |x: f32, y: f32, z: f32| Mat4::from_translation(vec3(x, y, z));
    let body = |mesh: Mesh, world: Mat4, moves: bool| Body { mesh, world, moves };
    vec![
        body(shapes::cuboid(vec3(0.4, 0.13, 0.4)), at(0.0, 0.5, -0.6), false),
        body(shapes::lizard(0.9), at(-0.1, 0.55, -0.55), true),
        body(shapes::cuboid(vec3(3.0, 0.002, 3.0)), at(0.0, 0.45, 0.0), false),
        body(shapes::sphere(0.25, 24), at(0.1, 0.7, -0.5), true),
        body(torus(2000), at(-0.1, 0.7, -0.6), false),
    ]
}

/// Where the bodies are at a time: those that move swing and turn.
fn worlds(bodies: &[Body], time_s: f32) -> Vec<Mat4> {
    bodies
        .iter()
        .map(|body| match body.moves {
            true => {
                let turn = Mat4::from_quat(Quat::from_rotation_y(0.7 * time_s));
                Mat4::from_translation(vec3(0.2 * (2.0 * time_s).sin(), 0.0, 0.1 * time_s))
                    * body.world
                    * turn
            }
            false => body.world,
        })
        .collect()
}

struct Rig {
    meshes: Meshes,
    cells: Cells,
    volume: Conservative,
}

impl Rig {
    fn new(gpu: &TestGpu, grid: Grid, bodies: &[Body]) -> Self {
        let meshes = Meshes::new(gpu, bodies).unwrap();
        let cells = Cells::new(gpu, grid).unwrap();
        let volume = Conservative::new(gpu, &meshes, &cells).unwrap();
        Self { meshes, cells, volume }
    }

    fn step(&self, gpu: &TestGpu, time_s: f64, dt_s: f64, worlds: &[[Mat4; 2]]) -> Read {
        gpu.once(|rec| {
            self.meshes.record(rec, time_s, dt_s, worlds);
            rec.barrier(Meshes::EXIT, Conservative::ENTRY);
            self.volume.record(rec);
            rec.barrier(Conservative::EXIT, Access::ComputeReadWrite);
        })
        .unwrap();
        self.cells.read(gpu).unwrap()
    }
}

#[test]
fn marking_what_moves_is_marking_all_to_the_bit() {
    let gpu = gpu();
    let grid = grid(24, 0.07);
    let bodies = scene();
    let all: Vec<Body> = bodies.iter().map(|body| Body { moves: true, ..body.clone() }).collect();
    let (part, whole) = (Rig::new(&gpu, grid, &bodies), Rig::new(&gpu, grid, &all));
    let (mut mixed, mut seconds, mut beside) = (0, 0, 0);
    let mut before: Option<Read> = None;
    for frame in 0..6 {
        let time_s = 0.15 * frame as f32;
        let now = worlds(&bodies, time_s);
        let last = worlds(&bodies, time_s - 0.15);
        let pairs: Vec<[Mat4; 2]> = now.iter().zip(&last).map(|(a, b)| [*a, *b]).collect();
        let got = part.step(&gpu, time_s.into(), 0.15, &pairs);
        let want = whole.step(&gpu, time_s.into(), 0.15, &pairs);
        assert!(same(&got, &want), "frame {frame}");
        // Cells whose first plane moves and whose second does not: what the still meshes had kept is no use there.
        let moves = |triangle: u32| {
            part.meshes.parts().iter().any(|it| it.moves && it.triangles.contains(&(triangle - 1)))
        };
        let count = |is: &dyn Fn(usize) -> bool| got.marked().iter().filter(|&&cell| is(cell)).count();
        let move_of =
            |cell: usize| got.planes_of(cell).iter().map(|it| moves(it.triangle)).collect::<Vec<_>>();
        mixed += count(&|cell| move_of(cell) == [true, false]);
        seconds += count(&|cell| move_of(cell) == [false, true]);
        if let Some(before) = before {
            assert_ne!(before.occupied, got.occupied, "nothing moves");
            // Both planes are the still meshes', and something that moves has come or gone.
            beside += count(&|cell| {
                !move_of(cell).contains(&true)
                    && before.planes_of(cell) == got.planes_of(cell)
                    && before.extents[cell] != got.extents[cell]
            });
        }
        before = Some(got);
    }
    assert!(mixed > 50, "{mixed} cells have a moving plane before one that does not");
    assert!(seconds > 10 && beside > 10, "{seconds} behind one, {beside} with what moves beside both");
}

#[test]
fn a_step_without_movers_leaves_the_cells_as_they_are() {
    let gpu = gpu();
    let bodies: Vec<Body> = scene().into_iter().filter(|body| !body.moves).collect();
    let rig = Rig::new(&gpu, grid(24, 0.07), &bodies);
    let once = rig.cells.read(&gpu).unwrap();
    assert!(once.marked().len() > 500);
    assert!(same(&once, &rig.step(&gpu, 0.5, 0.1, &[])));
}

/// Largest velocity of a plane (m/s), all of which must be finite.
fn fastest(read: &Read) -> f32 {
    let speeds = read.marked().into_iter().flat_map(|cell| {
        read.planes_of(cell).iter().map(|plane| Vec3::from(plane.velocity_mps).length()).collect::<Vec<_>>()
    });
    let speeds: Vec<f32> = speeds.collect();
    assert!(!speeds.is_empty() && speeds.iter().all(|speed| speed.is_finite()), "velocities are no numbers");
    speeds.into_iter().fold(0.0, f32::max)
}

#[test]
fn velocities_are_finite_at_the_first_frame_without_a_step_and_where_a_loop_jumps_v10() {
    let gpu = gpu();
    let world = Mat4::from_translation(vec3(0.1, 0.5, -0.5));
    let lizard = [Body { mesh: shapes::lizard(1.0), world, moves: true }];
    let rig = Rig::new(&gpu, grid(24, 0.07), &lizard);
    let walking = fastest(&rig.step(&gpu, 0.4, 1.0 / 60.0, &[]));
    assert!((0.05..3.0).contains(&walking), "{walking} m/s");
    for (what, time_s, dt_s) in [
        ("the first frame", 0.0, 1.0 / 60.0),
        ("no step", 0.4, 0.0),
        ("the seam", 1.0, 1.0 / 60.0),
        ("just behind the seam", 1.0 + 1e-9, 1.0 / 60.0),
        ("a thousandth behind it", 3.001, 1.0 / 60.0),
        ("a step longer than the loop", 0.7, 5.0),
    ] {
        let fastest = fastest(&rig.step(&gpu, time_s, dt_s, &[]));
        assert!(fastest < 3.0 * walking, "{what}: {fastest} m/s");
    }
    // A body that was put elsewhere without a step does not move.
    let block = [Body { mesh: shapes::cuboid(Vec3::splat(0.2)), world, moves: true }];
    let rig = Rig::new(&gpu, grid(24, 0.07), &block);
    let away = Mat4::from_translation(vec3(0.4, 0.9, -0.5));
    assert_eq!(fastest(&rig.step(&gpu, 0.0, 0.0, &[[away, world]])), 0.0);
    let fast = fastest(&rig.step(&gpu, 0.0, 0.5, &[[away, world]]));
    assert!((fast - 1.0).abs() < 1e-5, "0.5 m in 0.5 s: {fast} m/s");
}

#[test]
fn a_turning_plate_has_the_velocity_of_its_points() {
    let gpu = gpu();
    let grid = Grid::new(Vec3::splat(-0.8), 0.1, UVec3::splat(16));
    let plate = [Body { mesh: shapes::cuboid(vec3(0.6, 0.01, 0.6)), world: Mat4::IDENTITY, moves: true }];
    let rig = Rig::new(&gpu, grid, &plate);
    let (rate, dt_s) = (2.0f32, 1e-3f32);
    let turned = |time_s: f32| Mat4::from_rotation_y(rate * time_s);
    let read = rig.step(&gpu, 0.0, dt_s.into(), &[[turned(0.0), turned(-dt_s)]]);
    let (at, triangles) = as_one(&plate);
    let voxels = cpu::mark(&grid, &at, &triangles);
    for cell in read.marked() {
        for plane in read.planes_of(cell) {
            let t = plane.triangle - 1;
            let velocities = triangles[t as usize].map(|corner| Vec3::Y.cross(at[corner as usize]) * rate);
            let want = voxels.plane(&grid, cell, t, velocities).velocity_mps;
            let apart = (Vec3::from(plane.velocity_mps) - Vec3::from(want)).length();
            assert!(apart < 0.005, "{plane:?}, want {want:?}");
        }
    }
    assert!((fastest(&read) - rate * 0.6 * 2f32.sqrt()).abs() < 0.2);
}
