// SPDX-License-Identifier: MIT OR Apache-2.0
//! What water has beyond its two models: the fourth order, borders that absorb, moving bodies.
#![allow(missing_docs)]

mod common;

use common::{distance, gpu, TestGpu};
use glam::{dvec3, uvec2, DVec3, UVec2};
use whitecap::gpu::Access;
use whitecap::water::{
    bodies::{Path, Pose, Shape},
    cpu::{self, Real},
    cpu_absorb, cpu_bodies, cpu_fourth, oracle,
    starts::{self, Start},
    Absorb, Bodies, Body, BodyParams, Borders, Fourth, Model, Tuning, Walls, Waves, LAND_M,
};

/// Grids that no workgroup and no vector divides, and the smallest there are.
const GRIDS: [UVec2; 14] = [
    uvec2(1, 1),
    uvec2(1, 2),
    uvec2(2, 1),
    uvec2(1, 40),
    uvec2(40, 1),
    uvec2(2, 2),
    uvec2(3, 5),
    uvec2(6, 4),
    uvec2(7, 3),
    uvec2(17, 33),
    uvec2(64, 16),
    uvec2(77, 45),
    uvec2(255, 257),
    uvec2(1000, 3),
];
const ODD: UVec2 = uvec2(77, 45);
const TUNING: Tuning = Tuning { group: uvec2(8, 8), rows: 4 };

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

fn wet<T: Real + Into<f64>>(heights: &[T]) -> Vec<f64> {
    heights.iter().map(|&h| h.into()).map(|h: f64| if h == f64::from(LAND_M) { 0.0 } else { h }).collect()
}

fn to_f32(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|&n| n as f32).collect()
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

const EVERY_SIDE: Borders = Borders { west: true, east: true, north: true, south: true, strip: 8 };

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

/// Whether the driver rounds `fma` twice: GLSL leaves it to the driver, and one step shows.
fn rounds_twice(gpu: &TestGpu) -> bool {
    let probe = starts::noise(starts::model(uvec2(17, 33), 0.25));
    let mut twin = cpu::Waves::<f32>::at_rest(&probe.model, &probe.height_m);
    twin.step();
    run_absorbing(gpu, &probe, Borders { west: true, strip: 1, ..Borders::default() }, 1).0[1..17]
        == twin.height_m[1..17]
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
            assert!(d.relative_power < 10.0 * ROUNDING, "{cells} {borders:?}: {d:?}");
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

/// Across the middle, round in circles, down and up, partly outside, and turned; in a basin of 38.5 x 22.5 m.
fn fleet() -> Vec<Body> {
    let sphere = |radius: f64, path| Body { shape: Shape::Sphere(radius), path, yaw_rad: 0.0 };
    let hull = |half, yaw_rad, path| Body { shape: Shape::Box(half), path, yaw_rad };
    vec![
        sphere(2.2, Path::Keys(vec![(0.0, dvec3(6.0, 0.5, 7.0)), (1.0, dvec3(30.0, -0.5, 15.0))])),
        sphere(1.5, Path::Swing { at_m: dvec3(15.3, 1.0, 4.0), by_m: dvec3(0.0, 2.5, 0.0), period_s: 1.0 }),
        hull(
            dvec3(3.0, 0.6, 1.0),
            0.0,
            Path::Circle { centre_m: dvec3(20.0, 0.2, 11.0), radius_m: 6.0, period_s: 3.0, start_rad: 1.0 },
        ),
        hull(
            dvec3(4.0, 1.0, 1.3),
            0.7,
            Path::Keys(vec![(0.0, dvec3(-5.0, 0.1, 3.0)), (2.0, dvec3(12.0, 0.1, 21.0))]),
        ),
    ]
}

fn poses(fleet: &[Body], times: &[f64]) -> Vec<Pose> {
    times.iter().flat_map(|&t| fleet.iter().map(move |body| body.pose(t, DVec3::ZERO))).collect()
}

/// Moves a fleet through water at rest that does not step: heights, and poses with their draughts.
fn sail(gpu: &TestGpu, start: &Start, fleet: &[Body], times: &[f64]) -> (Vec<f32>, Vec<Pose>) {
    let cells = start.model.cells;
    let state = Waves::new(gpu, TUNING, true).unwrap().state(cells).unwrap();
    state.upload(gpu, &start.height_m, &vec![0.0; start.height_m.len()]).unwrap();
    let params = BodyParams::new(&state.surface(), cells, start.model.cell_m, fleet.len() as u32);
    let steps = times.len() as u32 - 1;
    let mut list = Bodies::new(gpu).unwrap().list(state.surfaces(), params, steps).unwrap();
    let staging = list.staging(poses(fleet, times)).unwrap();
    gpu.once(|rec| {
        rec.copy(&staging, list.poses());
        rec.barrier(Access::CopyWrite, Bodies::ENTRY);
        list.record_draughts(rec, &state.surface());
        for step in 0..steps {
            rec.barrier(Bodies::EXIT, Bodies::ENTRY);
            list.record(rec, &state.surface(), step);
        }
    })
    .unwrap();
    (state.download(gpu).unwrap().0, gpu.download(list.poses()).unwrap())
}

#[test]
fn bodies_do_what_their_twin_does_and_raise_exactly_their_volume() {
    let gpu = gpu();
    let (fleet, times) = (fleet(), [0.0, 0.1, 0.3, 0.8]);
    for start in [starts::hump(starts::model(ODD, 0.25)), starts::islands(starts::model(ODD, 0.25))] {
        let (height, got) = sail(&gpu, &start, &fleet, &times);
        let params = BodyParams {
            cells: ODD,
            origin: UVec2::ZERO,
            size: ODD,
            pitch: ODD.x,
            stride: 1,
            first: 0,
            count: 4,
            cell_m: start.model.cell_m as f32,
        };
        let (mut want, mut height_m) = (poses(&fleet, &times), start.height_m.clone());
        cpu_bodies::draught(&params, &start.height_m, &mut want);
        for step in 0..3 {
            cpu_bodies::body(
                &params,
                &mut height_m,
                &want[4 * step..4 * step + 4],
                &want[4 * step + 4..4 * step + 8],
            );
        }
        let rose =
            |h: &[f32]| -> Vec<f64> { wet(h).iter().zip(wet(&start.height_m)).map(|(a, b)| a - b).collect() };
        let d = distance(&to_f32(&rose(&height)), &rose(&height_m));
        assert!(d.relative_power < 1e-11, "{}: {d:?}", start.name);
        let displaced = |poses: &[Pose]| poses.iter().map(|pose| f64::from(pose.displaced_m3)).sum::<f64>();
        let gained = start.model.cell_m.powi(2) * (oracle::volume(&height) - oracle::volume(&start.height_m));
        let told = displaced(&got[12..]) - displaced(&got[..4]);
        println!("{}: {gained} m3 gained, {told} m3 displaced", start.name);
        assert!((gained - told).abs() < 1e-4);
        // Where all is water, that is the volume below the level.
        if start.name == "hump" {
            for (pose, body) in got.iter().zip(fleet.iter().cycle()).filter(|(pose, _)| pose.at_m.x > 5.0) {
                let submerged = body.shape.submerged_m3(pose.at_m.y.into());
                assert!(
                    (f64::from(pose.displaced_m3) - submerged).abs() < 1e-5 * submerged.max(1.0),
                    "{pose:?}"
                );
                assert!(pose.submerged_m3 == 0.0 || (pose.scale - 1.0).abs() < 0.1, "{pose:?}");
            }
        }
    }
}

#[test]
fn a_closed_passage_leaves_nothing_behind() {
    let gpu = gpu();
    let out = |place: DVec3| (0.0, place);
    let round = Path::Keys(vec![
        out(dvec3(-20.0, 0.0, 9.0)),
        (1.0, dvec3(15.0, -0.4, 11.0)),
        (2.0, dvec3(22.0, 0.3, 14.0)),
        (3.0, dvec3(60.0, 0.0, 3.0)),
    ]);
    let fleet = [Shape::Sphere(3.0), Shape::Box(dvec3(4.0, 1.0, 1.5))].map(|shape| Body {
        shape,
        path: round.clone(),
        yaw_rad: 0.3,
    });
    let times: Vec<f64> = (0..=150).map(|i| 0.02 * f64::from(i)).collect();
    for start in [starts::flat(starts::model(ODD, 0.25), 0.0), starts::islands(starts::model(ODD, 0.25))] {
        let (height, poses) = sail(&gpu, &start, &fleet, &times);
        let most = poses.iter().map(|pose| f64::from(pose.displaced_m3)).fold(0.0, f64::max);
        let left = start.model.cell_m.powi(2) * (oracle::volume(&height) - oracle::volume(&start.height_m));
        let worst =
            wet(&height).iter().zip(wet(&start.height_m)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{}: of {most} m3, {left:e} m3 are left, {worst:e} m at most", start.name);
        assert!(left.abs() < 1e-5 * most && worst < 1e-5);
    }
}

#[test]
fn paths_go_through_their_keys_and_circles_close() {
    let keys = Path::Keys(vec![(1.0, dvec3(0.0, 1.0, 2.0)), (3.0, dvec3(4.0, 1.0, 0.0))]);
    let places = [0.0, 1.0, 2.0, 3.0, 9.0].map(|t| keys.at(t).0);
    assert_eq!(places[..2], [dvec3(0.0, 1.0, 2.0); 2]);
    assert_eq!(places[2..], [dvec3(2.0, 1.0, 1.0), dvec3(4.0, 1.0, 0.0), dvec3(4.0, 1.0, 0.0)]);
    let circle = Path::Circle { centre_m: DVec3::Y, radius_m: 2.0, period_s: 4.0, start_rad: 0.0 };
    assert!(circle.at(1.0).0.distance(dvec3(0.0, 1.0, 2.0)) < 1e-12);
    assert_eq!(circle.at(0.0), circle.at(4e6));
    let swing = Path::Swing { at_m: DVec3::X, by_m: DVec3::Y, period_s: 2.0 };
    assert!(swing.at(0.5).0.distance(dvec3(1.0, 1.0, 0.0)) < 1e-12);
    assert_eq!(Shape::Sphere(1.0).submerged_m3(-1.0), 4.0 / 3.0 * std::f64::consts::PI);
    assert_eq!(Shape::Box(dvec3(1.0, 2.0, 3.0)).submerged_m3(1.0), 12.0);
    assert_eq!(Shape::Box(dvec3(1.0, 2.0, 3.0)).submerged_m3(-9.0), 48.0);
}
