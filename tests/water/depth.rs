// SPDX-License-Identifier: MIT OR Apache-2.0
//! Water over ground against its twins, exact solutions, and what must hold whatever the numbers.

use crate::{
    common::{distance, gpu, TestGpu},
    GRIDS, ODD,
};
use glam::{dvec2, uvec2, vec2, UVec2};
use std::mem::{offset_of, size_of};
use whitecap::{
    gpu::{reflect::reflect, Access},
    shaders,
    water::{
        cpu_wet::Depths,
        dam::{steps_to, Bowl, DamBreak, Swing},
        Columns, Counts, DepthModel, DepthParams, DepthState, Disturb, DisturbParams, Disturbance, Error,
        Rain, Shallow, Tier, Tuning, Wet, LAND_M,
    },
};

/// Small groups, so that grids have several; those of shallow water are one lane high.
fn tuning(tier: Tier) -> Tuning {
    match tier {
        Tier::Wet => crate::TUNING,
        Tier::Shallow => Tuning { group: uvec2(8, 1), rows: 7 },
    }
}
const TIERS: [Tier; 2] = [Tier::Wet, Tier::Shallow];

fn model(tier: Tier, cells: UVec2) -> DepthModel {
    let model = DepthModel {
        cells,
        cell_m: 0.5,
        gravity_mps2: 9.81,
        deepest_m: 2.5,
        fastest_mps: 3.0,
        damping_per_s: 0.2,
        thin_m: 1e-5,
        dt_s: 1.0,
    };
    model.with_courant(tier, 0.9 * tier.courant_limit())
}

/// Hills out of the water, a column of water on the left, a film on a slope, walls alone and in a row.
fn landscape(cells: UVec2) -> Columns {
    let at = |i: usize| dvec2((i as u32 % cells.x) as f64, (i as u32 / cells.x) as f64);
    let count = cells.element_product() as usize;
    let bed: Vec<f64> = (0..count)
        .map(|i| {
            let at = at(i);
            1.4 * (0.31 * at.x).sin() * (0.23 * at.y + 1.0).cos() - 0.5 + 0.004 * at.x
        })
        .collect();
    let surface = |i: usize| {
        let at = at(i);
        let high = if at.x < 0.3 * f64::from(cells.x) && at.y > 0.4 * f64::from(cells.y) { 0.9 } else { 0.0 };
        let film = if (at.x as u32).is_multiple_of(7) { bed[i] + 0.01 } else { -9.0 };
        f64::max(high + 0.05 * (0.7 * at.x).sin(), film)
    };
    let mut columns = Columns::at_rest(&bed, surface);
    for i in (0..count).filter(|i| count > 100 && (i % 53 == 11 || (i / cells.x as usize == 20 && i % 9 < 4)))
    {
        columns.rise_m[i] = LAND_M;
    }
    columns
}

fn state(gpu: &TestGpu, tier: Tier, tuning: Tuning, columns: &Columns, cells: UVec2) -> DepthState {
    let state = match tier {
        Tier::Wet => Wet::new(gpu, tuning).unwrap().state(cells).unwrap(),
        Tier::Shallow => Shallow::new(gpu, tuning).unwrap().state(cells).unwrap(),
    };
    state.upload(gpu, columns).unwrap();
    state
}

fn steps(gpu: &TestGpu, state: &mut DepthState, params: &DepthParams, count: u32) {
    gpu.once(|rec| {
        for _ in 0..count {
            state.record(rec, params);
            rec.barrier(DepthState::EXIT, DepthState::ENTRY);
        }
    })
    .unwrap();
}

fn run(
    gpu: &TestGpu,
    tier: Tier,
    tuning: Tuning,
    model: &DepthModel,
    start: &Columns,
    count: u32,
) -> Columns {
    let mut state = state(gpu, tier, tuning, start, model.cells);
    let params = model.params(state.pitch());
    steps(gpu, &mut state, &params, count);
    state.columns(gpu).unwrap()
}

/// What [`STEPS`] steps may differ from f64, of the largest number, with u = 2^-24. A step rounds some 20 times on the way
/// from one state to the next, none of them worth more than u of the largest number, and at the Courant number of these
/// steps an error in a flow is at most passed on whole: 20 u a step, once wrong in the rise and once in the flow that the
/// rise drives, if all had one sign.
const ROUNDING: f64 = 2.0 * 20.0 * STEPS as f64 / (1 << 24) as f64;
const STEPS: u32 = 20;

/// The twin in f64 within rounding, and in f32 to the bit where the driver rounds as the CPU does.
fn assert_same(
    gpu: &TestGpu,
    what: &str,
    got: &Columns,
    exact: &Depths<f64>,
    same: &Depths<f32>,
    tier: Tier,
    width: usize,
) {
    // The velocity of a film is the ratio of two small numbers, and a face opens at once when it is no longer thin: what
    // has to agree is the momentum.
    let weight = |i: usize, next: usize| {
        let next = (i + next).min(got.rise_m.len() - 1);
        if tier == Tier::Wet {
            1.0
        } else {
            0.5 * (exact.depth_m(i).max(0.0) + exact.depth_m(next).max(0.0))
        }
    };
    let fields = [
        ("rise", &got.rise_m, &exact.rise_m, &same.rise_m, None),
        ("east", &got.east, &exact.east, &same.east, Some(1)),
        ("south", &got.south, &exact.south, &same.south, Some(width)),
    ];
    for (name, got, exact, same, next) in fields {
        let water = |i: &usize| got[*i] != LAND_M;
        let highest = (0..got.len()).filter(water).map(|i| exact[i].abs()).fold(0.0, f64::max);
        let apart =
            |i: usize| (f64::from(got[i]) - exact[i]).abs() * next.map_or(1.0, |next| weight(i, next));
        let worst = (0..got.len()).filter(water).map(apart).fold(0.0, f64::max);
        println!("{what}: {name} {:e} of {ROUNDING:e}", worst / highest);
        assert!(worst <= ROUNDING * highest, "{what}: {name} is {worst:e} of {highest:e} from the f64 twin");
        if gpu.is_exact() && highest > 0.0 {
            assert_eq!(distance(got, same).ulp, 0, "{what}: {name} is not the f32 twin's");
        }
    }
}

#[test]
fn water_over_ground_does_what_the_twin_does_on_grids_of_every_shape() {
    let gpu = gpu();
    for tier in TIERS {
        for cells in GRIDS {
            let (model, start) = (model(tier, cells), landscape(cells));
            let got = run(&gpu, tier, tuning(tier), &model, &start, STEPS);
            let mut exact = Depths::<f64>::new(tier, &model, &start);
            let mut same = Depths::<f32>::new(tier, &model, &start);
            for _ in 0..STEPS {
                exact.step();
                same.step();
            }
            assert_same(&gpu, &format!("{tier:?} {cells}"), &got, &exact, &same, tier, cells.x as usize);
        }
    }
}

#[test]
fn depth_structs() {
    for spv in [shaders::WATER_WET_COMP, shaders::WATER_SHALLOW_COMP] {
        let interface = reflect(spv, &[8, 8, 4]).unwrap();
        let glsl = &interface.structs["DepthParams"];
        let fields: Vec<_> = glsl.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
        macro_rules! offsets {
            ($($field:ident),*) => { [$((stringify!($field), offset_of!(DepthParams, $field))),*] };
        }
        assert_eq!(
            fields,
            offsets!(cells, pitch, reach, pull, keep, rain_m, thin_m, fastest_mps),
            "fields of DepthParams"
        );
        assert_eq!(glsl.bytes, size_of::<DepthParams>());
    }
}

/// Loops that the optimizer unrolls lose the decoration in all but the first copy: then a driver may contract.
#[test]
fn every_sum_and_product_is_exact_in_the_spirv() {
    const DECORATE: u32 = 71;
    const NO_CONTRACTION: u32 = 42;
    for spv in [shaders::WATER_WET_COMP, shaders::WATER_SHALLOW_COMP] {
        let words: Vec<u32> =
            spv.chunks_exact(4).map(|w| u32::from_le_bytes(w.try_into().unwrap())).collect();
        let (mut exact, mut sums, mut at) = (Vec::new(), Vec::new(), 5);
        while at < words.len() {
            let (length, op) = ((words[at] >> 16) as usize, words[at] & 0xffff);
            match op {
                DECORATE if words[at + 2] == NO_CONTRACTION => exact.push(words[at + 1]),
                129 | 131 | 133 | 136 | 142 => sums.push(words[at + 2]), // add, sub, mul, div, vector times scalar
                _ => {}
            }
            at += length;
        }
        assert!(sums.len() > 20);
        let free = sums.iter().filter(|id| !exact.contains(id)).count();
        assert_eq!(free, 0, "of {} sums and products", sums.len());
    }
}

#[test]
fn the_tuning_does_not_change_a_bit() {
    let gpu = gpu();
    for tier in TIERS {
        let (model, start) = (model(tier, ODD), landscape(ODD));
        let want = run(&gpu, tier, tuning(tier), &model, &start, STEPS);
        let tunings = match tier {
            Tier::Wet => [(uvec2(1, 1), 1), (uvec2(32, 1), 7), (uvec2(16, 4), 2), (uvec2(64, 2), 64)],
            Tier::Shallow => [(uvec2(3, 1), 1), (uvec2(4, 1), 2), (uvec2(32, 1), 61), (uvec2(7, 1), 14)],
        };
        for (group, rows) in tunings {
            assert_eq!(
                run(&gpu, tier, Tuning { group, rows }, &model, &start, STEPS),
                want,
                "{group} {rows}"
            );
        }
    }
}

#[test]
fn a_group_that_shallow_water_cannot_walk_is_refused() {
    let gpu = gpu();
    let refused = |group, rows| Shallow::new(&gpu, Tuning { group, rows }).err().unwrap().to_string();
    for (group, rows) in [(uvec2(32, 2), 8), (uvec2(2, 1), 8), (uvec2(32, 1), 0)] {
        let refused = refused(group, rows);
        assert!(refused.contains("allowed are 3 x 1 and up, and rows"), "{refused}");
    }
    let huge = refused(uvec2(4096, 1), 8);
    assert!(huge.starts_with("kernel `water.shallow`: 819200 bytes of shared memory, and "), "{huge}");
}

#[test]
fn the_comparison_can_fail() {
    let gpu = gpu();
    for tier in TIERS {
        let (model, start) = (model(tier, ODD), landscape(ODD));
        let got = run(&gpu, tier, tuning(tier), &model, &start, STEPS);
        for (what, other) in [
            ("gravity", DepthModel { gravity_mps2: 9.83, ..model }),
            ("damping", DepthModel { damping_per_s: 0.21, ..model }),
            ("step", DepthModel { dt_s: 1.001 * model.dt_s, ..model }),
        ] {
            let mut exact = Depths::<f64>::new(tier, &other, &start);
            (0..STEPS).for_each(|_| exact.step());
            let apart = got.rise_m.iter().zip(&exact.rise_m).filter(|(a, _)| **a != LAND_M);
            let worst = apart.map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
            assert!(worst > 2.0 * ROUNDING, "{tier:?}: {what} is not seen: {worst:e}");
        }
    }
}

#[test]
fn floods_conserve_volume_and_no_column_falls_below_dry() {
    let gpu = gpu();
    for tier in TIERS {
        let (model, start) = (model(tier, uvec2(96, 80)), landscape(uvec2(96, 80)));
        let end = run(&gpu, tier, tuning(tier), &model, &start, 5000);
        let volume = |columns: &Columns| columns.depths_m().iter().sum::<f64>();
        let drift = volume(&end) / volume(&start) - 1.0;
        println!("{tier:?}: volume drift after 5000 steps: {drift:e}");
        assert!(drift.abs() < 1e-7);
        assert!(end.depths_m().iter().all(|depth| *depth >= 0.0));
    }
}

/// Velocities that gravity alone changes, against their twin, and L1 of 0.53 to 0.57 of dam breaks on every grid (0.54 to
/// 0.56 elsewhere, by the same scheme in f64).
#[test]
fn without_advection_water_does_what_its_twin_does_and_no_dam_break_converges() {
    let gpu = gpu();
    let run = |model: &DepthModel, start: &Columns, count: u32| {
        let kernels = Shallow::without_advection(&gpu, tuning(Tier::Shallow)).unwrap();
        let mut state = kernels.state(model.cells).unwrap();
        state.upload(&gpu, start).unwrap();
        let params = model.params(state.pitch());
        steps(&gpu, &mut state, &params.first_from_rest(), 1);
        steps(&gpu, &mut state, &params, count - 1);
        state.columns(&gpu).unwrap()
    };
    let tier = Tier::Shallow;
    for cells in [ODD, uvec2(17, 33), uvec2(1, 40)] {
        let (model, start) = (model(tier, cells), landscape(cells));
        let got = run(&model, &start, STEPS);
        let mut exact = Depths::<f64>::new(tier, &model, &start).without_advection();
        let mut same = Depths::<f32>::new(tier, &model, &start).without_advection();
        let mut whole = Depths::<f64>::new(tier, &model, &start);
        exact.first_step_from_rest();
        same.first_step_from_rest();
        whole.first_step_from_rest();
        for _ in 1..STEPS {
            exact.step();
            same.step();
            whole.step();
        }
        assert_same(&gpu, &format!("no advection {cells}"), &got, &exact, &same, tier, cells.x as usize);
        let water = || got.rise_m.iter().zip(&whole.rise_m).filter(|(a, _)| **a != LAND_M);
        let highest = water().map(|(_, b)| b.abs()).fold(0.0, f64::max);
        let apart = water().map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
        assert!(apart > 10.0 * ROUNDING * highest, "{cells}: advection is not seen");
    }
    for low in [0.1, 0.0] {
        let dam = DamBreak::new(1.0, low);
        for cells in [100, 400] {
            let model = dam.model(tier, cells);
            let end = run(&model, &dam.columns(model.cells), steps_to(&model, DamBreak::TIME_S));
            let error = dam.distance(&end.depths_m());
            println!("no advection, {low} m before the dam, {cells} columns: {error:.4}");
            assert!((0.53..0.57).contains(&error), "{error}");
            assert!(end.depths_m().iter().all(|depth| *depth >= 0.0));
        }
    }
}

#[test]
fn shallow_water_swings_in_round_bowls() {
    let gpu = gpu();
    for (swing, limit) in [(Swing::Rising, 0.045), (Swing::Circling, 0.11)] {
        let bowl = Bowl::new(swing);
        let time_s = bowl.period_s();
        let error = |cells: u32| {
            let model = bowl.model(Tier::Shallow, cells, time_s);
            let start = bowl.columns(Tier::Shallow, &model);
            let end =
                run(&gpu, Tier::Shallow, tuning(Tier::Shallow), &model, &start, steps_to(&model, time_s));
            assert!(end.depths_m().iter().all(|depth| *depth >= 0.0));
            bowl.distance(&model, &end.depths_m(), time_s)
        };
        let (coarse, fine) = (error(64), error(128));
        println!("{swing:?}: {coarse:.4} at 64, {fine:.4} at 128 columns");
        assert!(fine < limit && fine < 0.7 * coarse);
    }
}

#[test]
fn the_dam_of_stoker_becomes_that_of_ritter() {
    let (wet, dry) = (DamBreak::new(1.0, 1e-12), DamBreak::new(1.0, 0.0));
    for x in [-3.0, -1.0, 0.0, 1.0, 2.0] {
        let (a, b) = (wet.at(x, 0.6), dry.at(x, 0.6));
        assert!((a.0 - b.0).abs() < 1e-4 && (a.1 - b.1).abs() < 1e-2, "{x}: {a:?} {b:?}");
    }
    // At the dam itself: 4/9 of the depth, 2/3 of the speed.
    assert!((dry.at(0.0, 0.6).0 - 4.0 / 9.0).abs() < 1e-12);
}

#[test]
fn rain_falls_whole_and_on_land_too() {
    let gpu = gpu();
    let mut rain = Rain::default();
    let fallen: f64 = (0..100_000).map(|_| f64::from(rain.fall(2.8e-6, 0.01))).sum();
    assert!((fallen + rain.owed_m() - 2.8e-3).abs() < 1e-12);
    for tier in TIERS {
        let (model, start) = (model(tier, ODD), landscape(ODD));
        let mut state = state(&gpu, tier, tuning(tier), &start, ODD);
        let params = model.params(state.pitch()).with_rain(Rain::DROP_M as f32);
        steps(&gpu, &mut state, &params, 10);
        let end = state.columns(&gpu).unwrap();
        let mut same = Depths::<f32>::new(tier, &model, &start);
        (0..10).for_each(|_| same.step_in_rain(Rain::DROP_M as f32));
        if gpu.is_exact() {
            assert_eq!(end.rise_m, same.rise_m);
        }
        let water = start.rise_m.iter().filter(|h| **h != LAND_M).count() as f64;
        let gained = end.depths_m().iter().sum::<f64>() - start.depths_m().iter().sum::<f64>();
        assert!((gained / (10.0 * Rain::DROP_M * water) - 1.0).abs() < 1e-4, "{tier:?}: {gained}");
    }
}

/// A drop, and a sink that wants more than there is: what it lacks is a debt, and what flows in pays it.
#[test]
fn a_sink_that_asks_too_much_leaves_a_debt_and_no_volume_is_lost() {
    let gpu = gpu();
    for tier in TIERS {
        let cells = uvec2(40, 30);
        let model = model(tier, cells);
        let start = Columns::at_rest(&vec![0.0; 1200], |_| 0.05);
        let mut state = state(&gpu, tier, tuning(tier), &start, cells);
        let list = Disturb::new(&gpu).unwrap().list(state.surfaces(), None, 4).unwrap();
        let at = |x, volume_m3, push_m3ps| Disturbance {
            at_m: vec2(x, 7.0),
            radius_m: 2.0,
            volume_m3,
            push_m3ps,
            ..Default::default()
        };
        let (staging, _) =
            list.staging(&[at(5.0, 2.0, 0.0), at(14.0, -1.0, 0.0), at(5.0, 0.0, 1.0)]).unwrap();
        let surface = state.surface();
        let params = DisturbParams {
            cells,
            pitch: surface.pitch,
            stride: surface.stride,
            cell_m: model.cell_m as f32,
            limit_m: 10.0,
            has_velocity: 0,
        };
        gpu.once(|rec| {
            rec.copy(&staging, list.list());
            rec.barrier(Access::CopyWrite, Disturb::ENTRY);
            list.record(rec, &surface, &params);
        })
        .unwrap();
        assert_eq!(list.counts().unwrap(), Counts { applied: 2, rejected: 1, missed: 0 });
        let volume = |columns: &Columns| columns.depths_m().iter().sum::<f64>() * model.cell_m.powi(2);
        let lowest = |columns: &Columns| columns.depths_m().into_iter().fold(f64::MAX, f64::min);
        let after = state.columns(&gpu).unwrap();
        assert!(lowest(&after) < -0.05);
        assert!((volume(&after) - volume(&start) - 1.0).abs() < 1e-5);
        let params = model.params(state.pitch());
        steps(&gpu, &mut state, &params, 2000);
        let end = state.columns(&gpu).unwrap();
        assert!((volume(&end) / volume(&after) - 1.0).abs() < 1e-6);
        assert!(lowest(&end) >= 0.0, "{tier:?}: {} still owed", lowest(&end));
    }
}

#[test]
fn what_is_not_finite_or_out_of_range_is_refused() {
    let gpu = gpu();
    let start = landscape(ODD);
    let state = state(&gpu, Tier::Wet, tuning(Tier::Wet), &start, ODD);
    for bad in [f32::NAN, f32::INFINITY, 1e30] {
        for field in 0..4 {
            let mut columns = start.clone();
            let all = [&mut columns.bed_m, &mut columns.rise_m, &mut columns.east, &mut columns.south];
            all.into_iter().nth(field).unwrap()[100] = bad;
            let error = state.upload(&gpu, &columns).unwrap_err();
            assert!(matches!(&error, Error::Invalid(it) if it.value.ends_with("in cell 100")), "{error}");
        }
    }
    let mut columns = start.clone();
    columns.rise_m[100] = -9.0;
    assert!(state.upload(&gpu, &columns).unwrap_err().to_string().starts_with("rise_m = -9 in cell 100"));
    let model = model(Tier::Shallow, ODD);
    assert_eq!(model.check(Tier::Shallow), Ok(()));
    let long = model.with_courant(Tier::Shallow, 0.46).check(Tier::Shallow).unwrap_err();
    assert_eq!(long.key, "dt_s");
    for (bad, key) in [
        (DepthModel { cells: uvec2(0, 4), ..model }, "cells"),
        (DepthModel { cell_m: 0.0, ..model }, "cell_m"),
        (DepthModel { gravity_mps2: f64::NAN, ..model }, "gravity_mps2"),
        (DepthModel { deepest_m: -1.0, ..model }, "deepest_m"),
        (DepthModel { fastest_mps: -1.0, ..model }, "fastest_mps"),
        (DepthModel { damping_per_s: -0.1, ..model }, "damping_per_s"),
        (DepthModel { thin_m: 2.0, ..model }, "thin_m"),
        (DepthModel { dt_s: 0.0, ..model }, "dt_s"),
    ] {
        assert_eq!(bad.check(Tier::Shallow).unwrap_err().key, key);
    }
}
