// SPDX-License-Identifier: MIT OR Apache-2.0
//! The fourth order against its twin, its symbol and its limit.

use crate::{
    common::{distance, gpu, TestGpu},
    to_f32, wet, GRIDS, ODD, TUNING,
};
use glam::{uvec2, UVec2};
use whitecap::water::{
    cpu::Real,
    cpu_fourth, oracle,
    starts::{self, Start},
    Fourth, Model, Tuning, Walls, LAND_M,
};

fn model(cells: UVec2) -> Model {
    let model = starts::model(cells, 0.25);
    model.with_courant(0.95 * model.fourth_order_limit())
}

/// Steps from rest, the first with half the pull.
fn run_tuned(
    gpu: &TestGpu,
    tuning: Tuning,
    has_land: bool,
    start: &Start,
    steps: u32,
) -> (Vec<f32>, Vec<f32>) {
    start.model.check_fourth_order().unwrap();
    let mut state = Fourth::new(gpu, tuning, has_land).unwrap().state(start.model.cells).unwrap();
    state.upload(gpu, &start.height_m, &vec![0.0; start.height_m.len()]).unwrap();
    let params = start.model.fourth_order_params(state.pitch());
    gpu.once(|rec| {
        for step in 0..steps {
            state.record(rec, &if step == 0 { params.first_from_rest() } else { params });
            rec.barrier(Fourth::EXIT, Fourth::ENTRY);
        }
    })
    .unwrap();
    state.download(gpu).unwrap()
}

fn run(gpu: &TestGpu, start: &Start, steps: u32) -> (Vec<f32>, Vec<f32>) {
    run_tuned(gpu, TUNING, start.height_m.contains(&LAND_M), start, steps)
}

fn twin<T: Real>(start: &Start, steps: u32) -> cpu_fourth::Fourth<T> {
    let mut twin = cpu_fourth::Fourth::at_rest(&start.model, &start.height_m);
    twin.first_step_from_rest();
    (1..steps).for_each(|_| twin.step());
    twin
}

/// What 40 steps may differ from f64: each rounds heights and `g` by 2^-24 of their size, a velocity sums differences that
/// are up to a hundred times smaller, and roundings add up as a random walk at most: sqrt(80) 2^-24 100 = 5e-5; squared.
const ROUNDING: f64 = 3e-9;

#[test]
fn fourth_order_waves_do_what_the_twin_does_on_grids_of_every_shape() {
    let gpu = gpu();
    for cells in GRIDS {
        for start in [starts::hump(model(cells)), starts::islands(model(cells))] {
            if start.height_m.iter().all(|&h| h == LAND_M) {
                continue;
            }
            let (height, velocity) = run(&gpu, &start, 40);
            let (exact, same) = (twin::<f64>(&start, 40), twin::<f32>(&start, 40));
            let d = distance(&to_f32(&wet(&height)), &wet(&exact.height_m));
            assert!(d.relative_power < ROUNDING, "{} {cells}: {d:?}", start.name);
            let land = |h: &[f32]| -> Vec<bool> { h.iter().map(|&h| h == LAND_M).collect() };
            assert_eq!(land(&height), land(&start.height_m), "{cells}: the shore moved");
            if gpu.is_exact() {
                assert_eq!(height, same.height_m, "{} {cells}: not the f32 twin", start.name);
                assert_eq!(velocity, same.velocity_mps, "{} {cells}: not the f32 twin", start.name);
            }
        }
    }
}

#[test]
fn the_comparison_can_fail() {
    let start = starts::hump(model(ODD));
    let want = twin::<f64>(&start, 100).height_m;
    let m = start.model;
    for (what, model) in [
        ("speed", Model { speed_mps: 1.0001 * m.speed_mps, ..m }),
        ("damping", Model { damping_per_s: 1.01 * m.damping_per_s, ..m }),
        ("step", Model { dt_s: 1.001 * m.dt_s, ..m }),
    ] {
        let got = twin::<f64>(&Start { model, ..start.clone() }, 100).height_m;
        let d = distance(&to_f32(&got), &want);
        assert!(d.relative_power > 10.0 * ROUNDING, "{what}: {d:?} is not seen");
    }
}

#[test]
fn neither_the_tuning_nor_looking_for_land_changes_a_bit() {
    let gpu = gpu();
    let start = starts::hump(model(ODD));
    let want = run(&gpu, &start, 30);
    for (group, rows) in [(uvec2(1, 1), 1), (uvec2(32, 1), 7), (uvec2(64, 2), 64)] {
        for has_land in [false, true] {
            let got = run_tuned(&gpu, Tuning { group, rows }, has_land, &start, 30);
            if gpu.is_exact() {
                assert_eq!(got, want, "{group} {rows} {has_land}");
            }
        }
    }
}

#[test]
fn flat_water_stays_flat_to_the_bit_and_volume_is_conserved() {
    let gpu = gpu();
    let start = starts::flat(model(ODD), 0.3);
    assert_eq!(run(&gpu, &start, 200).0, start.height_m);
    for start in [starts::hump(model(ODD)), starts::islands(model(ODD))] {
        let (height, _) = run(&gpu, &start, 5000);
        let drift = oracle::volume(&height) / oracle::volume(&start.height_m) - 1.0;
        println!("{}: volume drift after 5000 steps {drift:e}", start.name);
        assert!(drift.abs() < 2e-6);
    }
}

/// `nu^2 S (1 + (1 - nu^2) S / 12)`: what a step takes from a wave.
fn bend(model: &Model, m: UVec2) -> f64 {
    let s = oracle::symbol(oracle::mode_k(model.cells, m), 0.25);
    let courant = model.courant().powi(2);
    courant * s * (1.0 + (1.0 - courant) * s / 12.0)
}

/// Oracle: one step of any wave multiplies it by the symbol.
#[test]
fn one_step_of_the_fourth_order_is_its_symbol() {
    let gpu = gpu();
    for m in [uvec2(0, 1), uvec2(2, 0), uvec2(31, 17), uvec2(63, 47), uvec2(1, 47)] {
        let start = starts::standing(Model { damping_per_s: 0.0, ..model(uvec2(64, 48)) }, m, 1.0);
        let got = oracle::amplitude(&run(&gpu, &start, 1).0, &oracle::mode(start.model.cells, m));
        let want = 1.0 - 0.5 * bend(&start.model, m);
        assert!((got - want).abs() < 2e-6, "mode {m}: {got}, not {want}");
    }
}

/// Oracle: cosines are eigenvectors, walls included, and swing at the frequency of the scheme.
#[test]
fn a_standing_wave_keeps_its_shape_and_swings_at_the_frequency_of_the_fourth_order() {
    let gpu = gpu();
    for m in [uvec2(3, 2), uvec2(5, 1), uvec2(0, 7), uvec2(95, 63)] {
        let start = starts::standing(Model { damping_per_s: 0.0, ..model(uvec2(96, 64)) }, m, 0.1);
        let turn = 2.0 * (0.5 * bend(&start.model, m).sqrt()).asin();
        let away = |n: &u32| (1e6 * oracle::swing(turn, *n, true).abs()) as u64; // from a node
        let steps = (300..400).max_by_key(away).unwrap();
        let swing = oracle::swing(turn, steps, true);
        let want: Vec<f64> = start.height_m.iter().map(|&h| f64::from(h) * swing).collect();
        let d = distance(&run(&gpu, &start, steps).0, &want);
        println!("mode {m}, {steps} steps: {d:?}");
        assert!(d.relative_power < 1e-9, "{d:?}");
    }
}

/// A hill that crosses the basin and comes back, against the exact solution.
fn error(gpu: &TestGpu, size: u32, courant: f64, sigma: f32) -> f64 {
    let steps = (2.0 * f64::from(size) / courant).ceil();
    let model = Model { damping_per_s: 0.0, ..model(UVec2::splat(size)) };
    let start = starts::gauss(model.with_courant(2.0 * f64::from(size) / steps), sigma);
    let exact = oracle::Exact::new(model.cells, &start.height_m).after(2.0 * f64::from(size));
    oracle::relative_l2(&run(gpu, &start, steps as u32).0, &exact)
}

#[test]
fn the_error_falls_by_the_fourth_power() {
    let gpu = gpu();
    let errors = [32, 64, 128].map(|size| error(&gpu, size, 0.6, 0.1));
    let orders = [errors[0] / errors[1], errors[1] / errors[2]].map(f64::log2);
    println!("errors {errors:?}, orders {orders:?}");
    assert!((orders[0] - 4.0).abs() < 0.2 && (orders[1] - 4.0).abs() < 0.1, "{orders:?}");
    let study = error(&gpu, 128, 0.8, 0.05);
    println!("128 x 128, courant 0.8, sigma 0.05: {study:e}");
    assert!((2.5e-4..3.3e-4).contains(&study), "{study:e}");
}

/// Oracle: the rate of decay and the frequency of `h_tt + gamma h_t = c^2 laplace(h)`.
#[test]
fn damping_neither_slows_waves_to_first_order_nor_moves_the_limit() {
    let (m, gamma) = (uvec2(2, 1), 0.4);
    let off = |cells: UVec2| {
        let model = Model { damping_per_s: gamma, cell_m: 32.0 / f64::from(cells.x), ..model(cells) };
        // 28 steps of the coarse grid, courant 0.79, so that all end at the same time.
        let steps = f64::from(cells.x) / 32.0 * 28.0;
        let model = Model { dt_s: 5.0 / steps, ..model };
        let [kx, ky] = oracle::mode_k(cells, m).map(|k| k / model.cell_m);
        let turns = (model.speed_mps * kx.hypot(ky)).powi(2) - 0.25 * gamma * gamma;
        let t = steps * model.dt_s;
        // The flow of the first step is damped from the middle of the step on.
        let want = (-0.5 * gamma * t).exp()
            * ((turns.sqrt() * t).cos() + 0.5 * gamma / turns.sqrt() * (turns.sqrt() * t).sin());
        let got = twin::<f64>(&starts::standing(model, m, 1.0), steps as u32);
        (oracle::amplitude(&to_f32(&got.height_m), &oracle::mode(cells, m)) - want).abs()
    };
    let errors = [off(uvec2(32, 16)), off(uvec2(64, 32)), off(uvec2(128, 64))];
    println!("damped: {errors:?}");
    assert!(errors[0] / errors[1] > 3.5 && errors[1] / errors[2] > 3.5, "{errors:?}");
}

#[test]
fn the_documented_limit_of_the_fourth_order_is_sharp() {
    let limit = model(ODD).fourth_order_limit();
    assert!((limit - ((13.0 - 61f64.sqrt()) / 8.0).sqrt()).abs() < 1e-12, "{limit}");
    for (land, damping_per_s) in [(false, 0.0), (false, 2.0), (true, 0.0)] {
        let highest = |share: f64| {
            let model = Model { damping_per_s, ..model(uvec2(32, 32)) }.with_courant(share * limit);
            let mut start = starts::noise(model);
            if land {
                let islands = starts::islands(model).height_m;
                let shore = start.height_m.iter_mut().zip(islands).filter(|(_, i)| *i == LAND_M);
                shore.for_each(|(h, _)| *h = LAND_M);
            }
            let mut twin = cpu_fourth::Fourth::<f32>::at_rest(&model, &start.height_m);
            (0..4000).for_each(|_| twin.step());
            wet(&twin.height_m)
                .iter()
                .fold(0f64, |m, h| if h.is_finite() { m.max(h.abs()) } else { f64::MAX })
        };
        let (below, above) = (highest(0.999), highest(1.01));
        println!("land {land}, damping {damping_per_s}: {below} m below, {above:e} m above the limit");
        assert!(below < 0.05);
        // Islands cut off some of the shortest waves: the limit holds, but need not be sharp.
        assert!(land || above > 1e6);
    }
    let model = model(ODD);
    assert_eq!(model.with_courant(limit).check_fourth_order(), Ok(()));
    for (bad, key) in [
        (model.with_courant(1.001 * limit), "dt_s"),
        (Model { diagonal: 0.3, ..model }, "diagonal"),
        (Model { walls: Walls::Dropped, ..model }, "walls"),
    ] {
        assert_eq!(bad.check_fourth_order().unwrap_err().key, key);
    }
}
