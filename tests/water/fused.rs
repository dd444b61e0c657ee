// SPDX-License-Identifier: MIT OR Apache-2.0
//! Several steps a dispatch against one step a dispatch, to the bit.

use crate::{
    common::{gpu, TestGpu},
    GRIDS,
};
use glam::{dvec3, uvec2, vec2, DVec3};
use whitecap::{
    gpu::Access,
    water::{
        bodies::{Path, Pose, Shape},
        starts::{self, Start},
        Bodies, Body, BodyParams, Disturb, DisturbParams, Disturbance, Disturbances, Fused, FusedState,
        FusedTuning, Model, Walls, Waves, WavesState, LAND_M,
    },
};

const TUNING: FusedTuning = FusedTuning { group: uvec2(8, 4), rows: 8, steps: 6, buffers: 1 };

const fn tuning(x: u32, y: u32, rows: u32, steps: u32, buffers: u32) -> FusedTuning {
    FusedTuning { group: uvec2(x, y), rows, steps, buffers }
}

fn fused_state(gpu: &TestGpu, tuning: FusedTuning, start: &Start) -> FusedState {
    let has_land = start.height_m.contains(&LAND_M);
    let state =
        Fused::new(gpu, tuning, start.model.walls, has_land).unwrap().state(start.model.cells).unwrap();
    state.upload(gpu, &start.height_m, &rising(start)).unwrap();
    state
}

fn waves_state(gpu: &TestGpu, start: &Start) -> WavesState {
    let has_land = start.height_m.contains(&LAND_M);
    let state = Waves::new(gpu, crate::TUNING, has_land).unwrap().state(start.model.cells).unwrap();
    state.upload(gpu, &start.height_m, &rising(start)).unwrap();
    state
}

/// Not at rest, so that velocities have to be read from the right place at once.
fn rising(start: &Start) -> Vec<f32> {
    (0..start.height_m.len()).map(|i| 1e-3 * (i % 7) as f32).collect()
}

type Surface = (Vec<f32>, Vec<f32>);

fn by_one(gpu: &TestGpu, start: &Start, steps: u32) -> Surface {
    let mut state = waves_state(gpu, start);
    let params = start.model.params(state.pitch());
    gpu.once(|rec| {
        for _ in 0..steps {
            state.record(rec, &params);
            rec.barrier(Waves::EXIT, Waves::ENTRY);
        }
    })
    .unwrap();
    state.download(gpu).unwrap()
}

fn fused(gpu: &TestGpu, tuning: FusedTuning, start: &Start, steps: u32) -> Surface {
    let mut state = fused_state(gpu, tuning, start);
    let params = start.model.params(state.pitch());
    gpu.once(|rec| state.record(rec, &params, steps)).unwrap();
    state.download(gpu).unwrap()
}

fn bits(surface: &Surface) -> Vec<u32> {
    surface.0.iter().chain(&surface.1).map(|x| x.to_bits()).collect()
}

fn assert_same_bits(what: &str, got: &Surface, want: &Surface) {
    assert!(want.0.iter().all(|h| h.is_finite()), "{what}: not finite");
    let (got, want) = (bits(got), bits(want));
    if let Some(i) = (0..want.len()).find(|&i| got[i] != want[i]) {
        let [a, b] = [got[i], want[i]].map(f32::from_bits);
        let count = (0..want.len()).filter(|&i| got[i] != want[i]).count();
        panic!("{what}: {count} of {} numbers differ, first {i}: {a:e}, not {b:e}", want.len());
    }
}

#[test]
fn fused_steps_are_single_steps_on_grids_of_every_shape() {
    let gpu = gpu();
    for cells in GRIDS {
        for (diagonal, walls) in [
            (0.0, Walls::Folded),
            (0.25, Walls::Folded),
            (1.0, Walls::Folded),
            (0.25, Walls::Dropped),
            (1.0, Walls::Dropped),
        ] {
            let start = starts::hump(Model { walls, ..starts::model(cells, diagonal) });
            let what = format!("{cells}, w = {diagonal}, {walls:?}");
            assert_same_bits(&what, &fused(&gpu, TUNING, &start, 31), &by_one(&gpu, &start, 31));
        }
    }
}

#[test]
fn fused_steps_round_islands_are_single_steps() {
    let gpu = gpu();
    for cells in GRIDS.into_iter().filter(|cells| cells.element_product() > 20) {
        for (diagonal, walls) in
            [(0.0, Walls::Folded), (0.25, Walls::Folded), (1.0, Walls::Folded), (1.0, Walls::Dropped)]
        {
            let start = starts::islands(Model { walls, ..starts::model(cells, diagonal) });
            let what = format!("{cells}, w = {diagonal}, {walls:?}");
            assert_same_bits(&what, &fused(&gpu, TUNING, &start, 31), &by_one(&gpu, &start, 31));
        }
    }
}

#[test]
fn tiles_of_open_water_and_tiles_with_a_shore_are_single_steps() {
    let gpu = gpu();
    let start = starts::coast(starts::model(uvec2(255, 130), 0.25));
    let land = start.height_m.iter().filter(|h| **h == LAND_M).count();
    assert!((1000..3000).contains(&land), "{land} columns of land");
    assert_same_bits("coast", &fused(&gpu, TUNING, &start, 25), &by_one(&gpu, &start, 25));
}

#[test]
fn the_tile_and_the_steps_a_dispatch_do_not_change_a_bit() {
    let gpu = gpu();
    let model = starts::model(uvec2(255, 130), 0.25);
    for start in [
        starts::hump(model),
        starts::islands(model),
        starts::hump(Model { walls: Walls::Dropped, ..starts::model(uvec2(130, 77), 1.0) }),
    ] {
        let want = by_one(&gpu, &start, 25);
        for tuning in [
            tuning(32, 1, 31, 4, 1),
            tuning(16, 4, 16, 6, 1),
            tuning(16, 8, 8, 8, 2),
            tuning(8, 16, 2, 5, 2),
            tuning(32, 4, 8, 1, 1),
            tuning(3, 9, 1, 4, 1),
            tuning(6, 2, 13, 8, 1),
            tuning(8, 3, 11, 12, 2),
        ] {
            let what = format!("{}, {tuning:?}", start.name);
            assert_same_bits(&what, &fused(&gpu, tuning, &start, 25), &want);
        }
    }
}

#[test]
fn any_number_of_steps_can_be_recorded_at_once() {
    let gpu = gpu();
    let start = starts::hump(starts::model(uvec2(77, 45), 0.25));
    for steps in [0, 1, 2, 5, 6, 7, 12, 13, 100] {
        let what = format!("{steps} steps");
        assert_same_bits(&what, &fused(&gpu, TUNING, &start, steps), &by_one(&gpu, &start, steps));
    }
}

#[test]
fn the_first_step_from_rest_is_a_block_of_its_own() {
    let gpu = gpu();
    let start = starts::hump(starts::model(uvec2(77, 45), 0.25));
    let mut by_one = waves_state(&gpu, &start);
    let mut state = fused_state(&gpu, TUNING, &start);
    let params = start.model.params(state.pitch());
    gpu.once(|rec| {
        by_one.record(rec, &params.first_from_rest());
        for _ in 0..13 {
            rec.barrier(Waves::EXIT, Waves::ENTRY);
            by_one.record(rec, &params);
        }
        state.record(rec, &params.first_from_rest(), 1);
        rec.barrier(Fused::EXIT, Fused::ENTRY);
        state.record(rec, &params, 13);
    })
    .unwrap();
    assert_same_bits("first step", &state.download(&gpu).unwrap(), &by_one.download(&gpu).unwrap());
}

#[test]
fn disturbances_fall_between_blocks_of_any_length() {
    let gpu = gpu();
    for islands in [false, true] {
        let model = starts::model(uvec2(77, 45), 0.25);
        let start = if islands { starts::islands(model) } else { starts::hump(model) };
        let mut by_one = waves_state(&gpu, &start);
        let mut state = fused_state(&gpu, TUNING, &start);
        let kernels = Disturb::new(&gpu).unwrap();
        let lists = [
            kernels.list(by_one.surfaces(), Some(by_one.velocity()), 4).unwrap(),
            kernels.list_of(state.surfaces(), state.velocities(), 4).unwrap(),
        ];
        let drop = |x: f32, volume_m3: f32, push_m3ps: f32| Disturbance {
            at_m: vec2(x, 9.0),
            radius_m: 2.0,
            volume_m3,
            push_m3ps,
            ..Default::default()
        };
        let params = model.params(state.pitch());
        let disturb = DisturbParams {
            cells: model.cells,
            pitch: state.pitch(),
            stride: 1,
            cell_m: model.cell_m as f32,
            limit_m: 10.0,
            has_velocity: 1,
        };
        for (i, steps) in [3u32, 7, 1, 12].into_iter().enumerate() {
            let items = [drop(5.0 + 6.0 * i as f32, 0.5, 0.0), drop(30.0, 0.0, 1.0)];
            let staged = [0, 1].map(|k: usize| lists[k].staging(&items).unwrap().0);
            gpu.once(|rec| {
                for (list, staging) in lists.iter().zip(&staged) {
                    rec.copy(staging, Disturbances::list(list));
                }
                rec.barrier(Access::CopyWrite, Disturb::ENTRY);
                lists[0].record(rec, &by_one.surface(), &disturb);
                lists[1].record(rec, &state.surface(), &disturb);
                rec.barrier(Disturb::EXIT, Fused::ENTRY);
                for _ in 0..steps {
                    by_one.record(rec, &params);
                    rec.barrier(Waves::EXIT, Waves::ENTRY);
                }
                state.record(rec, &params, steps);
                rec.barrier(Fused::EXIT, Fused::ENTRY);
            })
            .unwrap();
        }
        assert_eq!(lists[1].counts().unwrap().applied, 8);
        let what = format!("islands: {islands}");
        assert_same_bits(&what, &state.download(&gpu).unwrap(), &by_one.download(&gpu).unwrap());
    }
}

#[test]
fn walls_and_bodies_between_blocks_are_those_between_single_steps() {
    let gpu = gpu();
    let model = Model { walls: Walls::Dropped, ..starts::model(uvec2(77, 45), 1.0) };
    for start in [starts::hump(model), starts::islands(starts::model(uvec2(77, 45), 0.25))] {
        let (mut by_one, mut state) = (waves_state(&gpu, &start), fused_state(&gpu, TUNING, &start));
        let params = start.model.params(state.pitch());
        let from = BodyParams::new(&state.surface(), start.model.cells, start.model.cell_m, 1);
        let bodies = Bodies::new(&gpu).unwrap();
        let mut lists = [by_one.surfaces(), state.surfaces()].map(|both| bodies.list(both, from, 3).unwrap());
        let path = Path::Keys(vec![(0.0, dvec3(6.0, 0.2, 7.0)), (3.0, dvec3(30.0, -0.5, 15.0))]);
        let body = Body { shape: Shape::Sphere(2.2), path, yaw_rad: 0.0 };
        let poses: Vec<_> = (0..4).map(|t| body.pose(f64::from(t), DVec3::ZERO)).collect();
        let staged = [0, 1].map(|k: usize| lists[k].staging(poses.clone()).unwrap());
        gpu.once(|rec| {
            for (list, staging) in lists.iter().zip(&staged) {
                rec.copy(staging, list.poses());
            }
            rec.barrier(Access::CopyWrite, Bodies::ENTRY);
            lists[0].record_draughts(rec, &by_one.surface());
            lists[1].record_draughts(rec, &state.surface());
            rec.barrier(Bodies::EXIT, Bodies::ENTRY);
            for (moved, steps) in [5, 1, 8].into_iter().enumerate() {
                lists[0].record(rec, &by_one.surface(), moved as u32);
                lists[1].record(rec, &state.surface(), moved as u32);
                rec.barrier(Bodies::EXIT, Fused::ENTRY);
                for _ in 0..steps {
                    by_one.record(rec, &params);
                    rec.barrier(Waves::EXIT, Waves::ENTRY);
                }
                state.record(rec, &params, steps);
                rec.barrier(Fused::EXIT, Bodies::ENTRY);
            }
        })
        .unwrap();
        let raised = gpu.download::<Pose>(lists[1].poses()).unwrap();
        assert!(raised.iter().all(|pose| pose.displaced_m3 > 0.1), "the body is in the water: {raised:?}");
        assert_same_bits(start.name, &state.download(&gpu).unwrap(), &by_one.download(&gpu).unwrap());
    }
}

#[test]
fn flat_water_stays_flat_to_the_bit() {
    let gpu = gpu();
    for (diagonal, walls) in [(0.0, Walls::Folded), (0.25, Walls::Folded), (1.0, Walls::Dropped)] {
        let start = starts::flat(Model { walls, ..starts::model(uvec2(77, 45), diagonal) }, 0.3);
        let state = fused_state(&gpu, TUNING, &start);
        state.upload(&gpu, &start.height_m, &vec![0.0; start.height_m.len()]).unwrap();
        let mut state = state;
        let params = start.model.params(state.pitch());
        gpu.once(|rec| state.record(rec, &params, 200)).unwrap();
        assert_eq!(state.download(&gpu).unwrap().0, start.height_m);
    }
}

#[test]
fn a_tuning_that_leaves_nothing_of_a_tile_is_refused() {
    let gpu = gpu();
    let refused = |tuning| Fused::new(&gpu, tuning, Walls::Folded, false).err().unwrap().to_string();
    assert_eq!(
        refused(tuning(8, 1, 8, 4, 1)),
        "kernel `water.fused`: 4 steps leave nothing of a tile of [32, 8]"
    );
    assert_eq!(
        refused(tuning(4, 8, 8, 8, 1)),
        "kernel `water.fused`: 8 steps leave nothing of a tile of [16, 64]"
    );
    assert_eq!(refused(tuning(8, 8, 32, 4, 1)), "kernel `water.fused`: 32 rows: allowed are 1 to 31");
    let huge = refused(tuning(32, 32, 31, 4, 2));
    assert!(huge.starts_with("kernel `water.fused`: 573440 bytes of shared memory, and "), "{huge}");
}

#[test]
#[should_panic(expected = "walls of the parameters")]
fn parameters_of_other_walls_are_refused() {
    let gpu = gpu();
    let start = starts::hump(starts::model(uvec2(17, 33), 0.25));
    let mut state = fused_state(&gpu, TUNING, &start);
    let params = Model { walls: Walls::Dropped, ..start.model }.params(state.pitch());
    let _ = gpu.once(|rec| state.record(rec, &params, 1));
}
