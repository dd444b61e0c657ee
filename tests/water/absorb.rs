// SPDX-License-Identifier: MIT OR Apache-2.0
//! Borders that absorb: their twin, and how little comes back.

use crate::{
    common::{distance, gpu, TestGpu},
    rounds_twice, to_f32, wet, GRIDS, ODD, TUNING,
};
use glam::uvec2;
use whitecap::water::{
    cpu::{self, Real},
    cpu_absorb, oracle,
    starts::{self, Start},
    Absorb, Borders, Model, Waves, LAND_M,
};

const EVERY_SIDE: Borders = Borders { west: true, east: true, north: true, south: true, strip: 8 };

/// What 40 steps may differ from f64, relative power: ten times what waves without borders may, since what is left of them
/// is smaller.
const ROUNDING: f64 = 3e-8;

/// Steps of `waves` with borders that absorb.
fn run_absorbing(gpu: &TestGpu, start: &Start, borders: Borders, steps: u32) -> (Vec<f32>, Vec<f32>) {
    let has_land = start.height_m.contains(&LAND_M);
    let cells = start.model.cells;
    let mut state = Waves::new(gpu, TUNING, has_land).unwrap().state(cells).unwrap();
    state.upload(gpu, &start.height_m, &vec![0.0; start.height_m.len()]).unwrap();
    let absorb = Absorb::new(gpu).unwrap();
    let absorb = absorb.borders(&start.model, borders, state.surfaces(), state.velocity()).unwrap();
    let params = start.model.params(state.pitch());
    gpu.once(|rec| {
        for _ in 0..steps {
            state.record(rec, &params);
            rec.barrier(Waves::EXIT, Absorb::ENTRY);
            absorb.record(rec, &state.surface());
            rec.barrier(Absorb::EXIT, Waves::ENTRY);
        }
    })
    .unwrap();
    state.download(gpu).unwrap()
}

fn absorbed<T: Real>(mut twin: cpu::Waves<T>, model: &Model, borders: Borders, steps: u32) -> cpu::Waves<T> {
    for _ in 0..steps {
        twin.step();
        cpu_absorb::absorb(model, &borders, &mut twin.height_m, &mut twin.velocity_mps);
    }
    twin
}

fn twin_absorbing<T: Real>(start: &Start, borders: Borders, steps: u32) -> cpu::Waves<T> {
    absorbed(cpu::Waves::at_rest(&start.model, &start.height_m), &start.model, borders, steps)
}

#[test]
fn absorbing_borders_do_what_their_twin_does_on_grids_of_every_shape() {
    let gpu = gpu();
    let rounds_twice = rounds_twice(&gpu);
    let some = Borders { east: false, north: false, strip: 11, ..EVERY_SIDE };
    let one = Borders { east: true, strip: 20, ..Borders::default() };
    for cells in GRIDS {
        for (borders, start) in [
            (EVERY_SIDE, starts::hump(starts::model(cells, 0.25))),
            (some, starts::islands(starts::model(cells, 1.0))),
            (one, starts::hump(starts::model(cells, 0.0))),
        ] {
            if start.height_m.iter().all(|&h| h == LAND_M) {
                continue;
            }
            let (height, velocity) = run_absorbing(&gpu, &start, borders, 40);
            let exact = twin_absorbing::<f64>(&start, borders, 40);
            let d = distance(&to_f32(&wet(&height)), &wet(&exact.height_m));
            assert!(d.relative_power < ROUNDING, "{cells} {borders:?}: {d:?}");
            if gpu.is_exact() {
                let twin = cpu::Waves::<f32>::at_rest(&start.model, &start.height_m);
                let twin = if rounds_twice { twin } else { twin.fused() };
                let same = absorbed(twin, &start.model, borders, 40);
                assert_eq!(height, same.height_m, "{cells} {borders:?}: not the f32 twin");
                assert_eq!(velocity, same.velocity_mps, "{cells} {borders:?}: not the f32 twin");
            }
        }
    }
}

/// A packet of waves, `length` columns long and at `degrees` to the border, runs to the absorbing west border between two
/// mirrors: how much of its amplitude comes back, by what is left in the basin.
fn reflected(gpu: &TestGpu, length: f64, degrees: f64, share_of_limit: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    let (sin, cos) = degrees.to_radians().sin_cos();
    // A whole number of half waves fits between the mirrors.
    let rows = if degrees == 0.0 { 4 } else { (4.0 * length / sin).round() as u32 };
    let ky = if degrees == 0.0 { 0.0 } else { PI * 8.0 / f64::from(rows) };
    let kx = TAU / length * cos;
    let wide = 3.0 * length / cos;
    let middle = 32.0 + 4.0 * wide;
    let cells = uvec2((middle + 6.0 * wide) as u32, rows);
    let model = Model { damping_per_s: 0.0, cell_m: 1.0, speed_mps: 1.0, ..starts::model(cells, 0.25) };
    let model = model.with_courant(share_of_limit * model.courant_limit());
    let bend = model.courant() * oracle::symbol([kx, ky], 0.25).sqrt();
    let omega = 2.0 * (0.5 * bend).asin() / model.dt_s;
    let packet = |x: f64, y: u32, t: f64| {
        let from = x - middle + t * cos;
        (-0.5 * (from / wide).powi(2)).exp() * (kx * x + omega * t).cos() * (ky * (f64::from(y) + 0.5)).cos()
    };
    let at = |t: f64| -> Vec<f64> {
        (0..rows).flat_map(|y| (0..cells.x).map(move |x| packet(f64::from(x), y, t))).collect()
    };
    let (now, before) = (at(0.0), at(-model.dt_s));
    let velocity: Vec<f32> = now.iter().zip(&before).map(|(a, b)| ((a - b) / model.dt_s) as f32).collect();
    let mut state = Waves::new(gpu, TUNING, false).unwrap().state(cells).unwrap();
    state.upload(gpu, &to_f32(&now), &velocity).unwrap();
    let borders = Borders { west: true, strip: Borders::STRIP, ..Borders::default() };
    let absorb = Absorb::new(gpu).unwrap();
    let absorb = absorb.borders(&model, borders, state.surfaces(), state.velocity()).unwrap();
    let params = model.params(state.pitch());
    // There, and half the way back.
    let steps = ((middle + 4.0 * wide) / cos / model.dt_s) as u32;
    gpu.once(|rec| {
        for _ in 0..steps {
            state.record(rec, &params);
            rec.barrier(Waves::EXIT, Absorb::ENTRY);
            absorb.record(rec, &state.surface());
            rec.barrier(Absorb::EXIT, Waves::ENTRY);
        }
    })
    .unwrap();
    let power = |h: &[f64]| h.iter().map(|h| h * h).sum::<f64>();
    let left = state.download(gpu).unwrap().0;
    (power(&wet(&left)) / power(&now)).sqrt()
}

#[test]
fn little_of_a_wave_comes_back_from_an_absorbing_border() {
    let gpu = gpu();
    for (degrees, most) in [(0.0, 0.012), (45.0, 0.035)] {
        for length in [8.0, 12.0, 16.0, 24.0] {
            for share in [0.95, 0.4] {
                let back = reflected(&gpu, length, degrees, share);
                println!("{degrees} degrees, {length} columns, {share} of the limit: {:.2} %", 100.0 * back);
                assert!(back < most, "{degrees} degrees, {length} columns: {back}");
            }
        }
    }
    println!("twice the strip: {:.0} %", 100.0 * reflected(&gpu, 64.0, 0.0, 0.95));
}

#[test]
fn an_absorbing_border_leaves_level_water_and_the_longest_step_as_they_are() {
    let gpu = gpu();
    let start = starts::flat(starts::model(ODD, 0.25), 0.3);
    assert_eq!(run_absorbing(&gpu, &start, EVERY_SIDE, 200).0, start.height_m);
    for diagonal in [0.0, 0.25, 1.0] {
        let model = Model { damping_per_s: 0.0, ..starts::model(uvec2(32, 32), diagonal) };
        let start = starts::noise(model.with_courant(0.999 * model.courant_limit()));
        let twin = twin_absorbing::<f32>(&start, EVERY_SIDE, 4000);
        let highest = twin.height_m.iter().fold(0f32, |m, h| m.max(h.abs()));
        println!("w = {diagonal}: {highest:e} m after 4000 steps");
        assert!(highest < 1e-3);
    }
}

/// Oracle: `gamma(x)` does not depend on the step, so neither does what is left, but for the border column.
#[test]
fn absorbing_does_not_depend_on_the_step() {
    let left = |share: f64| {
        let model = Model { damping_per_s: 0.0, ..starts::model(uvec2(96, 64), 0.25) };
        let model = model.with_courant(share * model.courant_limit());
        let start = starts::gauss(model, 0.1);
        let twin =
            twin_absorbing::<f64>(&start, Borders { strip: 20, ..EVERY_SIDE }, (6.0 / model.dt_s) as u32);
        twin.height_m.iter().map(|h| h * h).sum::<f64>().sqrt()
    };
    let (long, short) = (left(0.8), left(0.1));
    println!("left: {long} with long steps, {short} with short ones");
    assert!((long / short - 1.0).abs() < 0.05);
}
