// SPDX-License-Identifier: MIT OR Apache-2.0
//! `waves` with halves for floats: a preview, whose error is known.

use crate::{
    common::{gpu, TestGpu},
    waves::{run_waves, twin},
    GRIDS, ODD, TUNING,
};
use glam::{uvec2, vec2};
use whitecap::{
    gpu::Access,
    water::{
        oracle,
        starts::{self, Start},
        Disturb, DisturbParams, Disturbance, Fused, FusedTuning, Halves, HalvesState, Model, PipesTuning,
        Walls,
    },
};

const ONE_STEP: PipesTuning = PipesTuning::OneStep(TUNING);
const FUSED: PipesTuning =
    PipesTuning::Fused(FusedTuning { group: uvec2(8, 8), rows: 4, steps: 8, buffers: 1 });
/// Of a number of 11 bits, rounded to the nearest or toward zero: GLSL leaves it to the driver.
const UNIT: f64 = 1.0 / 1024.0;

fn state(gpu: &TestGpu, tuning: PipesTuning, start: &Start) -> HalvesState {
    let state = Halves::new(gpu, tuning, start.model.walls).unwrap().state(start.model.cells).unwrap();
    state.upload(gpu, &start.height_m, &vec![0.0; start.height_m.len()]).unwrap();
    state
}

fn run(gpu: &TestGpu, tuning: PipesTuning, start: &Start, steps: u32) -> (Vec<f32>, Vec<f32>) {
    let mut state = state(gpu, tuning, start);
    let params = start.model.params(state.pitch());
    gpu.once(|rec| state.record(rec, &params, steps)).unwrap();
    state.download(gpu).unwrap()
}

/// Heights that halves hold: multiples of 2^-10 below 1 m.
fn representable(start: Start) -> Start {
    let height_m = start.height_m.iter().map(|h| (h * 512.0).round() / 1024.0).collect();
    Start { height_m, ..start }
}

#[test]
fn halves_come_back_as_they_were_sent() {
    let gpu = gpu();
    for cells in GRIDS {
        let start = representable(starts::noise(starts::model(cells, 0.25)));
        assert!(start.height_m.iter().all(|h| h.abs() < 1.0));
        assert_eq!(run(&gpu, ONE_STEP, &start, 0).0, start.height_m, "{cells}");
    }
}

#[test]
fn one_dispatch_is_that_of_floats_rounded() {
    let gpu = gpu();
    for cells in GRIDS {
        for walls in [Walls::Folded, Walls::Dropped] {
            let start = representable(starts::noise(Model { walls, ..starts::model(cells, 1.0) }));
            for (tuning, steps) in [(ONE_STEP, 1), (FUSED, 8)] {
                let (got, want) = (run(&gpu, tuning, &start, steps), run_waves(&gpu, TUNING, &start, steps));
                for (got, want) in got.0.iter().zip(&want.0).chain(got.1.iter().zip(&want.1)) {
                    let rounding = f64::from(want.abs()) * UNIT + 6.0e-8; // below 6e-5 units are no smaller
                    let apart = (f64::from(*got) - f64::from(*want)).abs();
                    assert!(apart <= rounding, "{cells}, {walls:?}, {steps} steps: {got:e}, not {want:e}");
                }
            }
        }
    }
}

/// Relative L2 after 300 steps of a hill of 1 m, 8 columns wide: a wave has crossed the basin twice. Of floats, if there is no
/// tuning of halves.
fn error(gpu: &TestGpu, halves: Option<PipesTuning>) -> f64 {
    let model = starts::model(uvec2(96, 80), 0.25);
    let model = Model { damping_per_s: 0.0, ..model.with_courant(0.95 * model.courant_limit()) };
    let start = starts::gauss(model, 0.08);
    let got = match halves {
        Some(tuning) => run(gpu, tuning, &start, 300).0,
        None => run_waves(gpu, TUNING, &start, 300).0,
    };
    oracle::relative_l2(&got, &twin::<f64>(&start, 300).height_m)
}

#[test]
fn the_error_of_halves_is_the_one_that_is_stated() {
    let gpu = gpu();
    let [one, fused, floats] = [Some(ONE_STEP), Some(FUSED), None].map(|halves| error(&gpu, halves));
    println!("relative L2: {one:.1e} with a step a dispatch, {fused:.1e} with 8, {floats:.1e} of floats");
    assert!(one > fused && fused > 100.0 * floats);
    // Half as much is measured where halves are rounded to the nearest.
    assert!(one < 9e-3 && fused < 4e-3);
}

#[test]
fn halves_can_be_disturbed() {
    let gpu = gpu();
    let start = starts::flat(starts::model(ODD, 0.25), 0.0);
    let mut state = state(&gpu, FUSED, &start);
    let list = Disturb::new(&gpu).unwrap();
    let list = list.list([state.surface(); 2], Some(state.velocity()), 1).unwrap();
    let drop = Disturbance { at_m: vec2(9.0, 9.0), radius_m: 3.0, volume_m3: 2.0, ..Disturbance::default() };
    let staging = list.staging(&[drop]).unwrap().0;
    let disturb = DisturbParams {
        cells: ODD,
        pitch: state.pitch(),
        stride: 1,
        cell_m: start.model.cell_m as f32,
        limit_m: 10.0,
        has_velocity: 1,
    };
    let params = start.model.params(state.pitch());
    gpu.once(|rec| {
        rec.copy(&staging, list.list());
        rec.barrier(Access::CopyWrite, Disturb::ENTRY);
        state.record(rec, &params, 3); // nothing moves, but the planes change places
        rec.barrier(Halves::EXIT, Halves::ENTRY);
        state.unpack(rec);
        rec.barrier(Halves::EXIT, Disturb::ENTRY);
        list.record(rec, &state.surface(), &disturb);
        rec.barrier(Disturb::EXIT, Halves::ENTRY);
        state.pack(rec);
    })
    .unwrap();
    let volume = oracle::volume(&state.download(&gpu).unwrap().0) * start.model.cell_m.powi(2);
    assert!((volume / 2.0 - 1.0).abs() < UNIT, "{volume}");
}

#[test]
fn what_no_half_can_hold_is_refused() {
    let gpu = gpu();
    let start = starts::flat(starts::model(ODD, 0.25), 0.0);
    let state = state(&gpu, ONE_STEP, &start);
    let rest = vec![0.0; start.height_m.len()];
    for (bad, allowed) in [(f32::NAN, "1e6"), (7e4, "60000"), (whitecap::water::LAND_M, "1e6")] {
        let heights: Vec<f32> =
            rest.iter().enumerate().map(|(i, _)| if i == 9 { bad } else { 0.0 }).collect();
        for error in [state.upload(&gpu, &heights, &rest), state.upload(&gpu, &rest, &heights)] {
            let error = error.unwrap_err().to_string();
            assert!(error.contains("in cell 9") && error.contains(allowed), "{error}");
        }
    }
}

/// Why scene files do not offer them (docs/water.md): what is drawn and disturbed is floats.
#[test]
fn a_basin_of_halves_takes_no_less_memory_than_one_of_floats() {
    let gpu = gpu();
    let (cells, PipesTuning::Fused(tuning)) = (uvec2(640, 480), FUSED) else { unreachable!("it is fused") };
    let floats = Fused::new(&gpu, tuning, Walls::Folded, false).unwrap().state(cells).unwrap();
    let heights: u64 = floats.surfaces().iter().map(|surface| surface.height_m.bytes()).sum();
    let velocities: u64 = floats.velocities().iter().flatten().map(|velocity| velocity.bytes()).sum();
    let halves = Halves::new(&gpu, FUSED, Walls::Folded).unwrap().state(cells).unwrap();
    assert!(halves.bytes() >= heights + velocities, "{} {heights} {velocities}", halves.bytes());
}
