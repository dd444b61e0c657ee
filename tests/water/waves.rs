// SPDX-License-Identifier: MIT OR Apache-2.0
//! `book` and `waves` against their twins, exact solutions, and what must hold whatever the numbers.

use crate::{
    common::{distance, gpu, Distance, TestGpu},
    rounds_twice, GRIDS, ODD, TUNING,
};
use glam::{uvec2, vec2, UVec2};
use whitecap::{
    gpu::Access,
    water::{
        cpu, cpu_disturb, oracle,
        starts::{self, Start},
        Book, BookState, Counts, Disturb, DisturbParams, Disturbance, Error, Model, Tuning, Walls, Waves,
        WavesState, LAND_M,
    },
};

fn waves_state(gpu: &TestGpu, tuning: Tuning, start: &Start) -> WavesState {
    let has_land = start.height_m.contains(&LAND_M);
    let state = Waves::new(gpu, tuning, has_land).unwrap().state(start.model.cells).unwrap();
    let velocity: Vec<f32> = vec![0.0; start.height_m.len()];
    state.upload(gpu, &start.height_m, &velocity).unwrap();
    state
}

pub fn run_waves(gpu: &TestGpu, tuning: Tuning, start: &Start, steps: u32) -> (Vec<f32>, Vec<f32>) {
    let mut state = waves_state(gpu, tuning, start);
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

fn book_state(gpu: &TestGpu, start: &Start) -> BookState {
    let state = Book::new(gpu).unwrap().state(start.model.cells).unwrap();
    state.upload(gpu, &start.height_m).unwrap();
    state
}

fn run_book(gpu: &TestGpu, start: &Start, steps: u32) -> Vec<f32> {
    let mut state = book_state(gpu, start);
    let params = start.model.params(state.pitch());
    gpu.once(|rec| {
        for _ in 0..steps {
            state.record(rec, &params);
            rec.barrier(Book::EXIT, Book::ENTRY);
        }
    })
    .unwrap();
    state.download(gpu).unwrap().iter().map(|column| column.height_m).collect()
}

pub fn twin<T: cpu::Real>(start: &Start, steps: u32) -> cpu::Waves<T> {
    let mut twin = cpu::Waves::at_rest(&start.model, &start.height_m);
    (0..steps).for_each(|_| twin.step());
    twin
}

/// The twin that rounds as the device does.
fn same(gpu: &TestGpu, start: &Start, steps: u32) -> cpu::Waves<f32> {
    let twin = cpu::Waves::at_rest(&start.model, &start.height_m);
    let mut twin = if rounds_twice(gpu) { twin } else { twin.fused() };
    (0..steps).for_each(|_| twin.step());
    twin
}

/// What 40 steps may differ from f64: each rounds heights by 2^-24 of their size at most, and smooth velocities are up to
/// a hundred times smaller than the heights whose differences they sum, so 3e-5 relative; squared.
const ROUNDING: f64 = 1e-9;

/// The twin in f64 within rounding, and in f32 to the bit where the driver rounds as the CPU does.
fn assert_same(gpu: &TestGpu, what: &str, got: &[f32], exact: &[f64], same: &[f32]) {
    let d = distance(got, exact);
    assert!(d.relative_power < ROUNDING, "{what}: {d:?} from the f64 twin");
    if gpu.is_exact() {
        assert_eq!(distance(got, same).ulp, 0, "{what}: not the f32 twin");
    }
}

#[test]
fn waves_do_what_the_twin_does_on_grids_of_every_shape() {
    let gpu = gpu();
    for cells in GRIDS {
        for (diagonal, walls) in
            [(0.0, Walls::Folded), (0.25, Walls::Folded), (1.0, Walls::Dropped), (0.7, Walls::Folded)]
        {
            let start = starts::hump(Model { walls, ..starts::model(cells, diagonal) });
            let (height, velocity) = run_waves(&gpu, TUNING, &start, 40);
            let (exact, same) = (twin::<f64>(&start, 40), same(&gpu, &start, 40));
            let what = format!("{cells}, w = {diagonal}, {walls:?}");
            assert_same(&gpu, &what, &height, &exact.height_m, &same.height_m);
            if cells != UVec2::ONE {
                assert_same(&gpu, &what, &velocity, &exact.velocity_mps, &same.velocity_mps);
            }
        }
    }
}

#[test]
fn waves_round_islands_do_what_the_twin_does() {
    let gpu = gpu();
    for cells in GRIDS.into_iter().filter(|cells| cells.element_product() > 100) {
        for (diagonal, walls) in [(0.25, Walls::Folded), (1.0, Walls::Folded), (1.0, Walls::Dropped)] {
            let start = starts::islands(Model { walls, ..starts::model(cells, diagonal) });
            assert!(start.height_m.contains(&LAND_M), "{cells}");
            let (height, velocity) = run_waves(&gpu, TUNING, &start, 40);
            let (exact, same) = (twin::<f64>(&start, 40), same(&gpu, &start, 40));
            let wet =
                |h: &[f32]| -> Vec<f32> { h.iter().map(|&h| if h == LAND_M { 0.0 } else { h }).collect() };
            let exact_wet: Vec<f64> =
                exact.height_m.iter().map(|&h| if h == f64::from(LAND_M) { 0.0 } else { h }).collect();
            assert_same(&gpu, &format!("{cells}"), &wet(&height), &exact_wet, &wet(&same.height_m));
            assert_same(&gpu, &format!("{cells}"), &velocity, &exact.velocity_mps, &same.velocity_mps);
            let land = |h: &[f32]| -> Vec<bool> { h.iter().map(|&h| h == LAND_M).collect() };
            assert_eq!(land(&height), land(&start.height_m), "{cells}: the shore moved");
        }
    }
}

#[test]
fn a_basin_built_for_land_is_the_same_without_any() {
    let gpu = gpu();
    let start = starts::hump(starts::model(ODD, 0.25));
    let mut state = Waves::new(&gpu, TUNING, true).unwrap().state(ODD).unwrap();
    state.upload(&gpu, &start.height_m, &vec![0.0; start.height_m.len()]).unwrap();
    let params = start.model.params(state.pitch());
    gpu.once(|rec| {
        for _ in 0..50 {
            state.record(rec, &params);
            rec.barrier(Waves::EXIT, Waves::ENTRY);
        }
    })
    .unwrap();
    let d = distance(&state.download(&gpu).unwrap().0, &run_waves(&gpu, TUNING, &start, 50).0);
    assert!(d.relative_power < 1e-12, "{d:?}");
}

#[test]
fn the_book_does_what_its_twin_does_on_grids_of_every_shape() {
    let gpu = gpu();
    for cells in GRIDS {
        for diagonal in [1.0, 0.25] {
            let model = Model { walls: Walls::Dropped, ..starts::model(cells, diagonal) };
            let start = starts::hump(model);
            let got = run_book(&gpu, &start, 40);
            let mut exact = cpu::Book::<f64>::at_rest(&model, &start.height_m);
            let mut same = cpu::Book::<f32>::at_rest(&model, &start.height_m);
            for _ in 0..40 {
                exact.step();
                same.step();
            }
            assert_same(&gpu, &format!("{cells}"), &got, &exact.height_m, &same.height_m);
        }
    }
}

#[test]
fn waves_are_the_book_with_its_flows_summed() {
    let gpu = gpu();
    let model = Model { walls: Walls::Dropped, damping_per_s: 0.03, ..starts::model(uvec2(96, 80), 1.0) };
    let start = starts::hump(model);
    let (waves, _) = run_waves(&gpu, TUNING, &start, 2000);
    let book = run_book(&gpu, &start, 2000);
    let worst = waves.iter().zip(&book).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let amplitude = start.height_m.iter().fold(0f32, |m, h| m.max(h.abs()));
    println!("after 2000 steps: {worst:e} m apart, amplitude {amplitude} m");
    assert!(worst <= 1e-5 * amplitude);
    // In exact arithmetic they are one scheme.
    let mut exact = cpu::Book::<f64>::at_rest(&model, &start.height_m);
    (0..2000).for_each(|_| exact.step());
    let twin = twin::<f64>(&start, 2000);
    let apart = twin.height_m.iter().zip(&exact.height_m).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-12, "{apart:e}");
}

#[test]
fn the_comparison_can_fail() {
    let gpu = gpu();
    let start = starts::hump(starts::model(ODD, 0.25));
    let (height, _) = run_waves(&gpu, TUNING, &start, 100);
    let off = |model: Model| {
        let Distance { relative_power, .. } =
            distance(&height, &twin::<f64>(&Start { model, ..start.clone() }, 100).height_m);
        relative_power
    };
    let m = start.model;
    for (what, model) in [
        ("speed 0.1 %", Model { speed_mps: 1.001 * m.speed_mps, ..m }),
        ("damping", Model { damping_per_s: 1.01 * m.damping_per_s, ..m }),
        ("diagonal", Model { diagonal: 0.26, ..m }),
        ("walls", Model { walls: Walls::Dropped, ..m }),
        ("step", Model { dt_s: 1.001 * m.dt_s, ..m }),
    ] {
        assert!(off(model) > 10.0 * ROUNDING, "{what}: {:e} is not seen", off(model));
    }
}

#[test]
fn the_tuning_does_not_change_a_bit() {
    let gpu = gpu();
    for start in [starts::hump(starts::model(ODD, 0.25)), starts::islands(starts::model(ODD, 1.0))] {
        let want = run_waves(&gpu, TUNING, &start, 30);
        for (group, rows) in [(uvec2(1, 1), 1), (uvec2(32, 1), 7), (uvec2(16, 4), 2), (uvec2(64, 2), 64)] {
            assert_eq!(run_waves(&gpu, Tuning { group, rows }, &start, 30), want, "{group} {rows}");
        }
    }
}

#[test]
fn flat_water_stays_flat_to_the_bit() {
    let gpu = gpu();
    for diagonal in [0.0, 0.25, 1.0] {
        let start = starts::flat(starts::model(ODD, diagonal), 0.3);
        assert_eq!(run_waves(&gpu, TUNING, &start, 200).0, start.height_m);
        assert_eq!(run_book(&gpu, &start, 200), start.height_m);
    }
}

/// Each column of one row of neighbours, and nothing else, moves when one column is raised.
#[test]
fn a_spike_reaches_its_neighbours_and_nobody_else() {
    let gpu = gpu();
    let cells = uvec2(35, 20);
    for at in [
        uvec2(0, 0),
        uvec2(34, 0),
        uvec2(0, 19),
        uvec2(34, 19),
        uvec2(34, 7),
        uvec2(0, 7),
        uvec2(16, 0),
        uvec2(15, 16),
    ] {
        let mut start = starts::flat(starts::model(cells, 1.0), 0.0);
        start.height_m[(at.y * cells.x + at.x) as usize] = 1.0;
        let (waves, book) = (run_waves(&gpu, TUNING, &start, 1).0, run_book(&gpu, &start, 1));
        for y in 0..cells.y {
            for x in 0..cells.x {
                let near = x.abs_diff(at.x) <= 1 && y.abs_diff(at.y) <= 1;
                let i = (y * cells.x + x) as usize;
                assert_eq!((waves[i] != 0.0, book[i] != 0.0), (near, near), "spike at {at}, column {x}, {y}");
            }
        }
    }
}

#[test]
fn volume_is_conserved() {
    let gpu = gpu();
    for start in [
        starts::hump(starts::model(uvec2(128, 96), 0.25)),
        starts::islands(starts::model(uvec2(128, 96), 1.0)),
    ] {
        let (height, _) = run_waves(&gpu, TUNING, &start, 10_000);
        let drift =
            (oracle::volume(&height) - oracle::volume(&start.height_m)) / oracle::volume(&start.height_m);
        println!("{}: volume drift after 10000 steps: {drift:e}", start.name);
        assert!(drift.abs() < 1e-6);
    }
}

/// Oracle: with folded walls a cosine is an eigenvector of the scheme, and swings at its discrete frequency.
#[test]
fn a_standing_wave_swings_at_the_frequency_of_the_scheme() {
    let gpu = gpu();
    for (diagonal, m) in [(0.0, uvec2(3, 2)), (0.25, uvec2(5, 1)), (1.0, uvec2(1, 7)), (0.25, uvec2(95, 63))]
    {
        let model = Model { damping_per_s: 0.0, ..starts::model(uvec2(96, 64), diagonal) };
        let start = starts::standing(model, m, 0.1);
        let steps = (40..400).max_by_key(|&n| {
            (1e6 * oracle::swing(oracle::turn(&model, m), n, false).abs()) as u64
            // not near a node
        });
        let steps = steps.unwrap();
        let want = oracle::swing(oracle::turn(&model, m), steps, false);
        let (height, _) = run_waves(&gpu, TUNING, &start, steps);
        let want: Vec<f64> = start.height_m.iter().map(|&h| f64::from(h) * want).collect();
        let d = distance(&height, &want);
        println!("w = {diagonal}, mode {m}, {steps} steps: {d:?}");
        assert!(d.relative_power < 1e-10, "{d:?}");
    }
}

/// Oracle: one step of any wave multiplies it by the symbol.
#[test]
fn one_step_is_the_discrete_symbol() {
    let gpu = gpu();
    for diagonal in [0.0, 0.25, 0.5, 1.0] {
        for m in [uvec2(0, 1), uvec2(2, 0), uvec2(31, 17), uvec2(63, 47)] {
            let model = Model { damping_per_s: 0.0, ..starts::model(uvec2(64, 48), diagonal) };
            let start = starts::standing(model, m, 1.0);
            let (height, _) = run_waves(&gpu, TUNING, &start, 1);
            let shape = oracle::mode(model.cells, m);
            let got = oracle::amplitude(&height, &shape);
            let want =
                1.0 - model.courant().powi(2) * oracle::symbol(oracle::mode_k(model.cells, m), diagonal);
            assert!((got - want).abs() < 2e-6, "w = {diagonal}, mode {m}: {got}, not {want}");
        }
    }
}

/// A damped wave keeps its speed, whatever the step: half of what a step takes from its own kick is given back.
#[test]
fn damped_waves_do_not_depend_on_the_step() {
    let gpu = gpu();
    let m = uvec2(2, 0);
    let at_2_s = |steps_per_s: f64| {
        let model =
            Model { damping_per_s: 2.0, dt_s: 1.0 / steps_per_s, ..starts::model(uvec2(64, 4), 0.25) };
        let start = starts::standing(model, m, 1.0);
        let (height, _) = run_waves(&gpu, TUNING, &start, (2.0 * steps_per_s) as u32);
        oracle::amplitude(&height, &oracle::mode(model.cells, m))
    };
    // The start counts as half a step late (no half kick here), so the step is extrapolated away: first order in it.
    let (coarse, fine, finest) = (at_2_s(20.0), at_2_s(40.0), at_2_s(80.0));
    println!("after 2 s: {coarse} at 20, {fine} at 40, {finest} at 80 steps a second");
    assert!((2.0 * fine - coarse - (2.0 * finest - fine)).abs() < 2e-3);
}

#[test]
fn energy_is_conserved_when_nothing_damps() {
    let gpu = gpu();
    let model = Model { damping_per_s: 0.0, ..starts::model(uvec2(64, 64), 0.25) };
    let dropped = Model { walls: Walls::Dropped, ..model };
    for start in [starts::hump(model), starts::hump(dropped), starts::islands(model)] {
        energy_is_conserved(&gpu, &start);
    }
}

fn energy_is_conserved(gpu: &TestGpu, start: &Start) {
    let model = start.model;
    let energy = |(h, v): (Vec<f32>, Vec<f32>)| oracle::energy(&model, &h, &v);
    let (early, late) =
        (energy(run_waves(gpu, TUNING, start, 10)), energy(run_waves(gpu, TUNING, start, 10_000)));
    println!("energy drift after 10000 steps: {:e}", late / early - 1.0);
    assert!((late / early - 1.0).abs() < 1e-6);
}

#[test]
fn the_documented_step_is_the_longest_stable_one() {
    let gpu = gpu();
    for land in [false, true] {
        for diagonal in [0.0, 0.25, 1.0] {
            let mut model = Model { damping_per_s: 0.0, ..starts::model(uvec2(32, 32), diagonal) };
            let mut highest = |share: f64| {
                model = model.with_courant(share * model.courant_limit());
                let mut start = starts::noise(model);
                if land {
                    let islands = starts::islands(model).height_m;
                    start
                        .height_m
                        .iter_mut()
                        .zip(islands)
                        .filter(|(_, i)| *i == LAND_M)
                        .for_each(|(h, _)| *h = LAND_M);
                }
                let (height, _) = run_waves(&gpu, TUNING, &start, 4000);
                height.iter().filter(|h| **h != LAND_M).fold(0f32, |m, h| {
                    if h.is_finite() {
                        m.max(h.abs())
                    } else {
                        f32::MAX
                    }
                })
            };
            let (below, above) = (highest(0.99), highest(1.01));
            println!("w = {diagonal}, land {land}: {below} m at 0.99, {above:e} m at 1.01 of the longest stable step");
            assert!(below < 0.02);
            // Islands cut off some of the shortest waves: the limit holds, but need not be sharp.
            assert!(land || above > 1e6);
        }
    }
}

#[test]
fn a_step_above_the_limit_is_refused_with_the_limit() {
    let model = starts::model(ODD, 0.25);
    let long = model.with_courant(1.01 * model.courant_limit());
    let text = long.check().unwrap_err().to_string();
    assert!(text.starts_with("dt_s = 0.098"), "{text}");
    assert!(
        text.ends_with(
            "allowed is at most 0.097768 s, the longest stable step of 0.5 m cells and waves of 4.4290 m/s"
        ),
        "{text}"
    );
    assert_eq!(model.with_courant(model.courant_limit()).check(), Ok(()));
    for (bad, key) in [
        (Model { cells: uvec2(0, 4), ..model }, "cells"),
        (Model { cells: uvec2(4, 16385), ..model }, "cells"),
        (Model { cell_m: 0.0, ..model }, "cell_m"),
        (Model { speed_mps: f64::NAN, ..model }, "speed_mps"),
        (Model { dt_s: -1.0, ..model }, "dt_s"),
        (Model { damping_per_s: -0.1, ..model }, "damping_per_s"),
        (Model { diagonal: 1.5, ..model }, "diagonal"),
    ] {
        assert_eq!(bad.check().unwrap_err().key, key);
    }
}

#[test]
fn a_start_that_is_not_finite_is_refused() {
    let gpu = gpu();
    let start = starts::flat(starts::model(ODD, 0.25), 0.0);
    let state = waves_state(&gpu, TUNING, &start);
    for bad in [f32::NAN, f32::INFINITY, 1e30, LAND_M] {
        let mut height = start.height_m.clone();
        height[100] = bad;
        let error = state.upload(&gpu, &height, &start.height_m).unwrap_err();
        assert!(matches!(&error, Error::Invalid(it) if it.value.ends_with("in cell 100")), "{error}");
    }
    let error = state.upload(&gpu, &[0.0; 4], &start.height_m).unwrap_err().to_string();
    assert_eq!(error, "height_m = 4 numbers: allowed is one for each of [77, 45] cells");
}

fn disturb_params(model: &Model, pitch: u32, stride: u32) -> DisturbParams {
    let cell_m = model.cell_m as f32;
    DisturbParams {
        cells: model.cells,
        pitch,
        stride,
        cell_m,
        limit_m: 10.0,
        has_velocity: u32::from(stride == 1),
    }
}

/// Inside, across walls and shores, overlapping, smaller than a column, and what must not get in.
fn disturbances() -> Vec<Disturbance> {
    let d = |x, y, radius_m, volume_m3, push_m3ps| Disturbance {
        at_m: vec2(x, y),
        radius_m,
        volume_m3,
        push_m3ps,
        ..Default::default()
    };
    let mut list = vec![
        d(10.0, 8.0, 3.0, 2.0, 0.0),
        d(11.0, 9.0, 2.0, -1.0, 4.0),
        d(0.2, 0.2, 2.5, 1.0, 1.0),
        d(38.4, 22.4, 1.0, 0.5, 0.0),
        d(20.1, 11.1, 0.1, 0.01, 0.02),
        d(f32::NAN, 1.0, 1.0, 1.0, 0.0),
        d(5.0, 5.0, 1.0, 1e30, 0.0),
        d(5.0, 5.0, 1.0, f32::INFINITY, 0.0),
        d(5.0, 5.0, -1.0, 1.0, 0.0),
        d(500.0, 5.0, 2.0, 1.0, 0.0),
        d(-1e30, 5.0, 2.0, 1.0, 0.0),
    ];
    // More than one batch of a workgroup.
    list.extend((0..300).map(|i| d(0.11 * i as f32, 0.07 * i as f32, 0.3 + 0.01 * i as f32, 1e-3, 1e-3)));
    list
}

#[test]
fn disturbances_do_what_their_twin_does_and_are_exact_in_volume() {
    let gpu = gpu();
    for islands in [false, true] {
        let model = starts::model(ODD, 0.25);
        let start = if islands { starts::islands(model) } else { starts::hump(model) };
        let state = waves_state(&gpu, TUNING, &start);
        let kernels = Disturb::new(&gpu).unwrap();
        let list = kernels.list(state.surfaces(), Some(state.velocity()), 512).unwrap();
        let params = disturb_params(&model, state.pitch(), 1);
        let (staging, dropped) = list.staging(&disturbances()).unwrap();
        assert_eq!(dropped, 0);
        gpu.once(|rec| {
            rec.copy(&staging, list.list());
            rec.barrier(Access::CopyWrite, Disturb::ENTRY);
            list.record(rec, &state.surface(), &params);
        })
        .unwrap();
        let (height, velocity) = state.download(&gpu).unwrap();

        let (mut items, mut counts) = (disturbances(), Counts::default());
        let plain = DisturbParams { pitch: ODD.x, ..params };
        cpu_disturb::weigh(&plain, &start.height_m, &mut items, &mut counts);
        let (mut want, mut want_velocity) = (start.height_m.clone(), vec![0.0; height.len()]);
        cpu_disturb::disturb(&plain, &items, &mut want, &mut want_velocity);
        assert_eq!(list.counts().unwrap(), counts);
        assert_eq!((counts.rejected, counts.missed), (4, if islands { 3 } else { 2 }));
        let wet = |h: &[f32]| -> Vec<f32> { h.iter().map(|&h| if h == LAND_M { 0.0 } else { h }).collect() };
        for d in [distance(&wet(&height), &wet(&want)), distance(&velocity, &want_velocity)] {
            assert!(d.relative_power < 1e-12, "{d:?}");
        }
        let area = f64::from(params.cell_m).powi(2);
        let applied = |d: &&Disturbance| d.scale > 0.0;
        let added: f64 = items.iter().filter(applied).map(|d| f64::from(d.volume_m3)).sum();
        let gained = area * (oracle::volume(&height) - oracle::volume(&start.height_m));
        println!("asked for {added} m3, gained {gained} m3");
        assert!((gained - added).abs() < 1e-5 * added);
        let pushed: f64 = items.iter().filter(applied).map(|d| f64::from(d.push_m3ps)).sum();
        assert!((area * oracle::volume(&velocity) - pushed).abs() < 1e-5 * pushed);
    }
}

#[test]
fn the_book_takes_volume_and_counts_pushes_as_rejected() {
    let gpu = gpu();
    let start = starts::flat(starts::model(ODD, 1.0), 0.25);
    let state = book_state(&gpu, &start);
    let list = Disturb::new(&gpu).unwrap().list(state.surfaces(), None, 4).unwrap();
    let drop = Disturbance { at_m: vec2(9.0, 9.0), radius_m: 2.0, volume_m3: 1.5, ..Default::default() };
    let push = Disturbance { push_m3ps: 1.0, ..drop };
    let (staging, dropped) = list.staging(&[drop, push, drop, drop, drop]).unwrap();
    assert_eq!(dropped, 1);
    gpu.once(|rec| {
        rec.copy(&staging, list.list());
        rec.barrier(Access::CopyWrite, Disturb::ENTRY);
        list.record(rec, &state.surface(), &disturb_params(&start.model, state.pitch(), 5));
    })
    .unwrap();
    assert_eq!(list.counts().unwrap(), Counts { applied: 3, rejected: 1, missed: 0 });
    let columns = state.download(&gpu).unwrap();
    let gained: f64 = columns.iter().map(|c| f64::from(c.height_m) - 0.25).sum::<f64>() * 0.25;
    assert!((gained - 4.5).abs() < 1e-5, "{gained}");
    assert!(columns.iter().all(|c| c.flow_mps == [0.0; 4]));
}

#[test]
fn one_kernel_steps_many_basins_and_the_same_start_gives_the_same_bits() {
    let gpu = gpu();
    let start = starts::islands(starts::model(uvec2(130, 70), 0.25));
    let kernel = Waves::new(&gpu, TUNING, true).unwrap();
    let mut states = [0; 2].map(|_| kernel.state(start.model.cells).unwrap());
    for state in &states {
        state.upload(&gpu, &start.height_m, &vec![0.0; start.height_m.len()]).unwrap();
    }
    gpu.once(|rec| {
        for _ in 0..100 {
            for state in &mut states {
                let params = start.model.params(state.pitch());
                state.record(rec, &params);
            }
            rec.barrier(Waves::EXIT, Waves::ENTRY);
        }
    })
    .unwrap();
    assert_eq!(states[0].download(&gpu).unwrap(), states[1].download(&gpu).unwrap());
}
