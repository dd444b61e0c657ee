// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pipes against their twin, against the other models, and several steps a dispatch against one.

use crate::{
    common::{distance, gpu, TestGpu},
    rounds_twice, GRIDS, ODD, TUNING,
};
use glam::{uvec2, vec2, UVec2};
use whitecap::{
    gpu::Access,
    water::{
        book::Column,
        cpu, cpu_pipes, oracle,
        starts::{self, Start},
        Disturb, DisturbParams, Disturbance, Fused, FusedTuning, Model, Pipes, PipesState, PipesTuning,
        Tuning, Walls, LAND_M,
    },
};

const WEIGHTS: [(f64, Walls); 5] = [
    (0.0, Walls::Folded),
    (0.25, Walls::Folded),
    (1.0, Walls::Folded),
    (0.25, Walls::Dropped),
    (1.0, Walls::Dropped),
];
const ONE_STEP: PipesTuning = PipesTuning::OneStep(TUNING);
const WAVES: FusedTuning = FusedTuning { group: uvec2(8, 8), rows: 4, steps: 6, buffers: 1 };
const FUSED: PipesTuning = fused(8, 8, 4, 5, 1);

const fn fused(x: u32, y: u32, rows: u32, steps: u32, buffers: u32) -> PipesTuning {
    PipesTuning::Fused(FusedTuning { group: uvec2(x, y), rows, steps, buffers })
}

fn pipes_state(gpu: &TestGpu, tuning: PipesTuning, start: &Start) -> PipesState {
    let has_land = start.height_m.contains(&LAND_M);
    let kernel = Pipes::new(gpu, tuning, start.model.diagonal > 0.0, has_land).unwrap();
    let state = kernel.state(start.model.cells).unwrap();
    state.upload(gpu, &start.height_m).unwrap();
    state
}

fn run(gpu: &TestGpu, tuning: PipesTuning, start: &Start, steps: u32) -> Vec<Column> {
    let mut state = pipes_state(gpu, tuning, start);
    let params = start.model.params(state.pitch());
    gpu.once(|rec| state.record(rec, &params, steps)).unwrap();
    state.download(gpu).unwrap()
}

fn twin<T: cpu::Real>(start: &Start, steps: u32) -> cpu_pipes::Pipes<T> {
    let mut twin = cpu_pipes::Pipes::at_rest(&start.model, &start.height_m);
    (0..steps).for_each(|_| twin.step());
    twin
}

/// The twin that rounds as the device does.
fn same(gpu: &TestGpu, start: &Start, steps: u32) -> cpu_pipes::Pipes<f32> {
    let twin = cpu_pipes::Pipes::at_rest(&start.model, &start.height_m);
    let mut twin = if rounds_twice(gpu) { twin } else { twin.fused() };
    (0..steps).for_each(|_| twin.step());
    twin
}

fn starts_of(cells: UVec2) -> impl Iterator<Item = Start> {
    WEIGHTS.into_iter().flat_map(move |(diagonal, walls)| {
        let model = Model { walls, ..starts::model(cells, diagonal) };
        let land = (cells.element_product() > 20).then(|| starts::islands(model));
        [Some(starts::hump(model)), land].into_iter().flatten()
    })
}

fn name(start: &Start) -> String {
    let Model { cells, diagonal, walls, .. } = start.model;
    format!("{} on {cells}, w = {diagonal}, {walls:?}", start.name)
}

fn heights(columns: &[Column]) -> Vec<f32> {
    columns.iter().map(|c| if c.height_m == LAND_M { 0.0 } else { c.height_m }).collect()
}

fn largest<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> f64 {
    numbers.into_iter().fold(0.0, |most, number| most.max(number.abs()))
}

#[test]
fn pipes_do_what_the_twin_does_on_grids_of_every_shape() {
    let gpu = gpu();
    for start in GRIDS.into_iter().flat_map(starts_of) {
        let got = run(&gpu, ONE_STEP, &start, 40);
        let (exact, same) = (twin::<f64>(&start, 40), same(&gpu, &start, 40));
        let land = f64::from(LAND_M);
        let wet: Vec<f64> = exact.height_m.iter().map(|&h| if h == land { 0.0 } else { h }).collect();
        let d = distance(&heights(&got), &wet);
        assert!(d.relative_power < 1e-9, "{}: {d:?}", name(&start));
        let flows: Vec<f64> = exact.flow_mps.as_flattened().to_vec();
        if largest(&flows) > 0.0 {
            let got: Vec<f32> = got.iter().flat_map(|c| c.flow_mps).collect();
            let d = distance(&got, &flows);
            assert!(d.relative_power < 1e-9, "flows of {}: {d:?}", name(&start));
        }
        if gpu.is_exact() {
            let bits = |h: f32, flow: [f32; 4]| (h.to_bits(), flow.map(f32::to_bits));
            let same = same.height_m.iter().zip(&same.flow_mps).map(|(&h, &flow)| bits(h, flow));
            let differ = got.iter().zip(same).position(|(c, same)| bits(c.height_m, c.flow_mps) != same);
            let differs = differ.map(|i| (i, got[i]));
            assert_eq!(differs, None, "{}: not the f32 twin", name(&start));
        }
    }
}

#[test]
fn fused_steps_are_single_steps() {
    let gpu = gpu();
    for start in GRIDS.into_iter().flat_map(starts_of) {
        let is_same = run(&gpu, FUSED, &start, 31) == run(&gpu, ONE_STEP, &start, 31);
        assert!(is_same, "{}", name(&start));
    }
}

#[test]
fn tiles_of_open_water_and_tiles_with_a_shore_are_single_steps() {
    let gpu = gpu();
    let start = starts::coast(starts::model(uvec2(255, 130), 0.25));
    assert!(run(&gpu, FUSED, &start, 25) == run(&gpu, ONE_STEP, &start, 25));
}

#[test]
fn the_tuning_does_not_change_a_bit() {
    let gpu = gpu();
    for start in starts_of(uvec2(131, 70)).filter(|start| start.model.diagonal != 1.0) {
        let want = run(&gpu, ONE_STEP, &start, 25);
        for tuning in [
            PipesTuning::OneStep(Tuning { group: uvec2(32, 1), rows: 7 }),
            fused(32, 4, 4, 4, 1),
            fused(16, 16, 2, 8, 2),
            fused(3, 9, 1, 4, 1),
            fused(6, 5, 7, 1, 2),
        ] {
            assert!(run(&gpu, tuning, &start, 25) == want, "{}, {tuning:?}", name(&start));
        }
    }
}

/// In exact arithmetic the three models are one scheme.
#[test]
fn pipes_are_the_book_and_waves() {
    for start in GRIDS.into_iter().filter(|cells| cells.x < 200).flat_map(starts_of) {
        let mut waves = cpu::Waves::<f64>::at_rest(&start.model, &start.height_m);
        let mut pipes = cpu_pipes::Pipes::<f64>::at_rest(&start.model, &start.height_m);
        let mut book = cpu::Book::<f64>::at_rest(&start.model, &start.height_m);
        waves.first_step_from_rest();
        pipes.first_step_from_rest();
        book.first_step_from_rest();
        for _ in 0..500 {
            waves.step();
            pipes.step();
            book.step();
        }
        let apart = |others: &[f64]| {
            largest(&pipes.height_m.iter().zip(others).map(|(a, b)| a - b).collect::<Vec<_>>())
        };
        assert!(apart(&waves.height_m) < 1e-12, "{}: {:e}", name(&start), apart(&waves.height_m));
        let rise: Vec<f64> = pipes.rise_mps().iter().zip(&waves.velocity_mps).map(|(a, b)| a - b).collect();
        assert!(largest(&rise) < 1e-11, "rise of {}: {:e}", name(&start), largest(&rise));
        if start.model.walls == Walls::Dropped && start.name == "hump" {
            assert!(apart(&book.height_m) < 1e-12, "{}: {:e}", name(&start), apart(&book.height_m));
        }
    }
}

/// Flows cancel, so all that is left is the rounding of heights; the velocities of `waves` do not, and volume drifts with
/// their sum where nothing damps it.
#[test]
fn what_one_column_gains_another_loses() {
    let gpu = gpu();
    let undamped = |diagonal| Model { damping_per_s: 0.0, ..starts::model(uvec2(128, 96), diagonal) };
    for start in [starts::hump(undamped(0.25)), starts::islands(undamped(1.0))] {
        let want = oracle::volume(&start.height_m);
        let drift = |height: &[f32]| (oracle::volume(height) - want) / want;
        let height: Vec<f32> = run(&gpu, FUSED, &start, 10_000).iter().map(|c| c.height_m).collect();
        let waves = Fused::new(&gpu, WAVES, Walls::Folded, start.name == "islands").unwrap();
        let mut waves = waves.state(start.model.cells).unwrap();
        waves.upload(&gpu, &start.height_m, &vec![0.0; height.len()]).unwrap();
        let params = start.model.params(waves.pitch());
        gpu.once(|rec| waves.record(rec, &params, 10_000)).unwrap();
        let (pipes, waves) = (drift(&height), drift(&waves.download(&gpu).unwrap().0));
        println!("{}: volume drift after 10000 steps: {pipes:e}, waves {waves:e}", start.name);
        assert!(pipes.abs() < 1e-7 && pipes.abs() < 0.1 * waves.abs());
    }
}

#[test]
fn even_water_and_its_pipes_stay_at_rest_to_the_bit() {
    let gpu = gpu();
    for (diagonal, walls) in WEIGHTS {
        let start = starts::flat(Model { walls, ..starts::model(ODD, diagonal) }, 0.3);
        for tuning in [ONE_STEP, FUSED] {
            let columns = run(&gpu, tuning, &start, 100);
            assert!(columns.iter().all(|c| *c == Column { height_m: 0.3, flow_mps: [0.0; 4] }));
        }
    }
}

#[test]
fn energy_is_conserved_when_nothing_damps() {
    let gpu = gpu();
    let model = Model { damping_per_s: 0.0, ..starts::model(uvec2(64, 64), 0.25) };
    let start = starts::hump(model);
    let energy = |steps| {
        let columns = run(&gpu, FUSED, &start, steps);
        let mut twin = cpu_pipes::Pipes::<f64>::at_rest(&model, &start.height_m);
        for (to, from) in twin.flow_mps.iter_mut().zip(&columns) {
            *to = from.flow_mps.map(f64::from);
        }
        let rise: Vec<f32> = twin.rise_mps().iter().map(|&v| v as f32).collect();
        oracle::energy(&model, &heights(&columns), &rise)
    };
    let drift = energy(10_000) / energy(10) - 1.0;
    println!("energy drift after 10000 steps: {drift:e}");
    assert!(drift.abs() < 1e-6);
}

/// Rain and sinks are volumes; a push has nothing to act on and is counted as rejected.
#[test]
fn rain_and_sinks_fall_between_blocks() {
    let gpu = gpu();
    let model = starts::model(ODD, 0.25);
    let start = starts::islands(model);
    let mut results = Vec::new();
    for tuning in [ONE_STEP, FUSED] {
        let mut state = pipes_state(&gpu, tuning, &start);
        let list = Disturb::new(&gpu).unwrap().list(state.surfaces(), None, 4).unwrap();
        let rain = Disturbance { at_m: vec2(9.0, 9.0), radius_m: 4.0, volume_m3: 1.5, ..Default::default() };
        let sink = Disturbance { at_m: vec2(30.0, 12.0), volume_m3: -0.5, ..rain };
        let push = Disturbance { push_m3ps: 1.0, ..rain };
        let (staging, _) = list.staging(&[rain, sink, push]).unwrap();
        let params = model.params(state.pitch());
        let disturb = DisturbParams {
            cells: ODD,
            pitch: state.pitch(),
            stride: 1,
            cell_m: 0.5,
            limit_m: 10.0,
            has_velocity: 0,
        };
        gpu.once(|rec| {
            rec.copy(&staging, list.list());
            rec.barrier(Access::CopyWrite, Disturb::ENTRY);
            for steps in [7, 1, 13] {
                list.record(rec, &state.surface(), &disturb);
                rec.barrier(Disturb::EXIT, Pipes::ENTRY);
                state.record(rec, &params, steps);
                rec.barrier(Pipes::EXIT, Pipes::ENTRY);
            }
        })
        .unwrap();
        let counts = list.counts().unwrap();
        assert_eq!((counts.applied, counts.rejected), (6, 3));
        let columns = state.download(&gpu).unwrap();
        let height: Vec<f32> = columns.iter().map(|c| c.height_m).collect();
        let gained = 0.25 * (oracle::volume(&height) - oracle::volume(&start.height_m));
        assert!((gained - 3.0).abs() < 1e-5, "{gained} m3, not 3");
        results.push(columns);
    }
    assert!(results[0] == results[1]);
}

#[test]
#[should_panic(expected = "diagonal pipes in a kernel without")]
fn diagonal_pipes_need_a_kernel_that_has_them() {
    let gpu = gpu();
    let mut state = pipes_state(&gpu, ONE_STEP, &starts::hump(starts::model(ODD, 0.0)));
    let params = starts::model(ODD, 0.25).params(state.pitch());
    let _ = gpu.once(|rec| state.record(rec, &params, 1));
}
