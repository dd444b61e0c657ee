// SPDX-License-Identifier: MIT OR Apache-2.0
//! Disks: every kernel against its f64 twin, the same bits on every run, and what holds of hard disks.
#![allow(missing_docs)]

mod borders;
#[path = "../common/mod.rs"]
mod common;
mod xpbd;

use common::{gpu, TestGpu};
use glam::{dvec3, DVec3};
use whitecap::disks::{
    cpu, edmd::Exact, oracle, starts, starts::Start, Borders, Disk, Grid, List, Model, Response, Sorted,
    SortedState, Space, Stir,
};

const MATCHING: Response = Response::Matching { rounds: 3, rewinds: true };
const RESPONSES: [Response; 6] = [
    Response::Seed,
    Response::GaussSeidel,
    MATCHING,
    Response::Matching { rounds: 2, rewinds: false },
    Response::Xpbd { bounces: true },
    Response::Xpbd { bounces: false },
];
const SPACES: [Space; 2] = [Space::Flat, Space::Solid];
const BORDERS: [Borders; 2] = [Borders::Walls, Borders::Periodic];

fn state(gpu: &TestGpu, start: &Start) -> SortedState {
    Sorted::new(gpu, &start.model, true, true).unwrap().state(&start.model, &start.disks).unwrap()
}

fn steps(gpu: &TestGpu, state: &mut SortedState, count: u32, stir: Option<&Stir>) {
    gpu.once(|rec| {
        for _ in 0..count {
            state.record_stirred(rec, stir);
            rec.barrier(Sorted::EXIT, Sorted::ENTRY);
        }
    })
    .unwrap();
}

fn run(gpu: &TestGpu, start: &Start, count: u32) -> Vec<Disk> {
    let mut state = state(gpu, start);
    steps(gpu, &mut state, count, None);
    state.disks(gpu).unwrap()
}

fn twin(start: &Start, count: u32) -> cpu::Disks {
    let mut twin = cpu::Disks::new(start.model, &start.disks);
    (0..count).for_each(|_| twin.step());
    twin
}

/// Difference of places (of the smallest radius) and of velocities (of the fastest), round a box that repeats, that 99 of
/// 100 disks stay below: whether two disks touch at all, or first, is now and then decided by the last bit.
#[must_use]
fn apart(model: &Model, got: &[Disk], want: &[Disk]) -> (f64, f64) {
    assert_eq!(got.len(), want.len());
    let radius = want.iter().map(|d| d.radius_m).fold(f64::MAX, f64::min);
    let speed = want.iter().map(|d| d.velocity_mps.length()).fold(0.0, f64::max);
    assert!(speed > 0.0, "nothing moves: nothing is compared");
    let (mut places, mut velocities) = (Vec::new(), Vec::new());
    for (a, b) in got.iter().zip(want) {
        assert!(a.at_m.is_finite() && a.velocity_mps.is_finite(), "{a:?}");
        assert!((a.radius_m - b.radius_m).abs() <= 1e-7 * b.radius_m, "{a:?} is not {b:?}");
        places.push(model.way(a.at_m, b.at_m).length() / radius);
        velocities.push((a.velocity_mps - b.velocity_mps).length() / speed);
    }
    let most = |mut all: Vec<f64>| {
        all.sort_by(f64::total_cmp);
        all[all.len() - 1 - all.len() / 100]
    };
    (most(places), most(velocities))
}

/// A random start of small and, if asked for, of a few large disks, with gravity and overlaps.
fn crowd(space: Space, borders: Borders, response: Response, count: u32, has_large: bool) -> Start {
    let mut start = starts::seed(space, count, borders, 5);
    start.model.response = response;
    start.model.dt_s = 0.03;
    start.model.size_m = dvec3(2.0, 1.7, 1.9);
    start.model.gravity_mps2 = dvec3(0.1, -0.3, if space == Space::Flat { 0.0 } else { 0.2 });
    for disk in &mut start.disks {
        disk.at_m = (disk.at_m * start.model.size_m / 2.0).clamp(DVec3::ZERO, start.model.size_m);
    }
    if has_large {
        for (i, radius_m) in [(7, 0.3), (20, 0.2), (3, 0.22)] {
            start.disks[i].radius_m = radius_m;
        }
    }
    start
}

/// What f32 does to a step: positions up to 2 m round by 2^-24 of themselves, 1e-7 m, of which there are some ten an
/// operation, in radii of 0.01 m; an impulse divides by a distance and passes the error on to velocities and to the next
/// contact. Measured 2e-5 to 4e-4 after four steps of a crowd.
const PLACES: f64 = 2e-3;
const VELOCITIES: f64 = 2e-3;

#[test]
fn every_response_does_what_the_twin_does_flat_and_solid_between_walls_and_round() {
    let gpu = gpu();
    for space in SPACES {
        for borders in BORDERS {
            for response in RESPONSES {
                for has_large in [false, true] {
                    let start = crowd(space, borders, response, 600, has_large);
                    let grid = Grid::of(&start.model, start.disks.iter().map(|d| d.radius_m));
                    assert_eq!(grid.large > 0, has_large, "{grid:?}");
                    // A large disk has a hundred contacts, whose pushes add up or follow each other: errors grow faster.
                    let count = if has_large { 2 } else { 4 };
                    let (got, twin) = (run(&gpu, &start, count), twin(&start, count));
                    let (places, velocities) = apart(&start.model, &got, &twin.disks());
                    println!("{space:?} {borders:?} {response:?} {has_large}: {places:.1e} {velocities:.1e}");
                    assert!(places < PLACES && velocities < VELOCITIES, "{places:e} {velocities:e}");
                }
            }
        }
    }
}

#[test]
fn the_comparison_can_fail() {
    for response in RESPONSES {
        let start = crowd(Space::Flat, Borders::Walls, response, 600, false);
        let want = twin(&start, 4).disks();
        let mut wrong = start.clone();
        wrong.model.dt_s *= 1.003;
        let (places, _) = apart(&start.model, &twin(&wrong, 4).disks(), &want);
        assert!(places > 2.0 * PLACES, "a step longer by 0.3 % is not seen: {places:e}");
        let mut wrong = start.clone();
        wrong.disks.iter_mut().step_by(20).for_each(|disk| disk.velocity_mps *= 1.1);
        let (_, velocities) = apart(&start.model, &twin(&wrong, 4).disks(), &want);
        assert!(velocities > 2.0 * VELOCITIES, "disks faster by 10 % are not seen: {velocities:e}");
    }
}

#[test]
fn the_lists_of_the_tutorial_do_what_its_response_does_sorted() {
    let gpu = gpu();
    for count in [1, 2, 600, 5000] {
        let mut start = starts::seed(Space::Flat, count, Borders::Walls, 9);
        start.model.response = Response::Seed;
        let mut state = List::new(&gpu).unwrap().state(&start.model, &start.disks).unwrap();
        gpu.once(|rec| {
            for _ in 0..4 {
                state.record(rec);
                rec.barrier(List::EXIT, List::ENTRY);
            }
        })
        .unwrap();
        let got = state.disks(&gpu).unwrap();
        let twin = twin(&start, 4);
        let (places, velocities) = apart(&start.model, &got, &twin.disks());
        assert!(places < PLACES && velocities < VELOCITIES, "{count}: {places:e} {velocities:e}");
        let records: Vec<whitecap::disks::ListDisk> = gpu.download(state.records()).unwrap();
        for (record, &hit) in records.iter().zip(&twin.hit) {
            let cool = if hit == 0 { 0.0 } else { (-2.0 * f64::from(4 - hit) / 60.0).exp() };
            assert!((f64::from(record.temperature) - cool).abs() < 1e-5, "{record:?} was hit at {hit}");
        }
    }
}

#[test]
fn any_number_of_disks_is_sorted_and_nobody_is_lost() {
    let gpu = gpu();
    for space in SPACES {
        for count in [1, 2, 3, 63, 257, 4095, 9001] {
            let mut start = crowd(space, Borders::Walls, Response::Seed, count, false);
            start.model.response = MATCHING;
            let (got, want) = (run(&gpu, &start, 2), twin(&start, 2).disks());
            let (places, _) = apart(&start.model, &got, &want);
            assert!(places < PLACES, "{space:?} {count}: {places:e}");
        }
    }
}

#[test]
fn neither_the_run_nor_the_workgroup_changes_a_bit() {
    let gpu = gpu();
    for response in RESPONSES {
        let start = crowd(Space::Flat, Borders::Walls, response, 3000, true);
        let words = |group| {
            let kernels = Sorted::tuned(&gpu, &start.model, true, false, group).unwrap();
            let mut state = kernels.state(&start.model, &start.disks).unwrap();
            steps(&gpu, &mut state, 20, None);
            state.words(&gpu).unwrap()
        };
        let want = words(64);
        for group in [64, 32, 128, 256] {
            assert!(words(group) == want, "{response:?}, workgroups of {group}");
        }
    }
}

#[test]
fn a_saved_state_goes_on_to_the_same_bits() {
    let gpu = gpu();
    for response in RESPONSES {
        let start = crowd(Space::Solid, Borders::Periodic, response, 700, true);
        let mut whole = state(&gpu, &start);
        steps(&gpu, &mut whole, 6, None);
        let saved = whole.save(&gpu).unwrap();
        let mut second = state(&gpu, &start);
        assert!(second.restore(&gpu, &saved).unwrap());
        assert!(!second.restore(&gpu, &saved[1..]).unwrap(), "of another box");
        steps(&gpu, &mut whole, 6, None);
        steps(&gpu, &mut second, 6, None);
        assert!(whole.words(&gpu).unwrap() == second.words(&gpu).unwrap(), "{response:?}");
    }
}

#[test]
fn energy_and_momentum_hold_and_the_tutorial_loses_momentum() {
    let gpu = gpu();
    let drift = |response| {
        let mut start = starts::fluid(Space::Flat, 1000, 0.45, 2);
        start.model.response = response;
        let got = run(&gpu, &start, 400);
        let energy = oracle::energy(&start.model, &got) / oracle::energy(&start.model, &start.disks) - 1.0;
        let (momentum, lengths) = oracle::momentum(&start.model, &got);
        (energy.abs(), momentum.length() / lengths)
    };
    for response in [MATCHING, Response::GaussSeidel] {
        let (energy, momentum) = drift(response);
        assert!(energy < 1e-5 && momentum < 1e-6, "{response:?}: {energy:e} {momentum:e}");
    }
    let (energy, momentum) = drift(Response::Seed);
    assert!(energy < 1e-5 && momentum > 1e-3, "the tutorial's response: {energy:e} {momentum:e}");
}

#[test]
fn a_lone_disk_flies_as_the_mirrored_billiard() {
    let gpu = gpu();
    let start = Start {
        model: Model {
            space: Space::Flat,
            size_m: dvec3(1.3, 0.9, 1.0),
            borders: Borders::Walls,
            gravity_mps2: DVec3::ZERO,
            response: MATCHING,
            dt_s: 0.01,
        },
        disks: vec![Disk {
            at_m: dvec3(0.31, 0.52, 0.0),
            velocity_mps: dvec3(1.7, -0.9, 0.0),
            radius_m: 0.1,
        }],
    };
    let got = run(&gpu, &start, 1000)[0];
    for axis in 0..2 {
        let room = start.model.size_m[axis] - 0.2;
        let way = (start.disks[0].at_m[axis] - 0.1 + 10.0 * start.disks[0].velocity_mps[axis])
            .rem_euclid(2.0 * room);
        let want = 0.1 + if way > room { 2.0 * room - way } else { way };
        // A thousand roundings of 6e-8 m, and some twenty mirrorings.
        assert!((got.at_m[axis] - want).abs() < 3e-5, "{} is not {want}", got.at_m[axis]);
    }
}

#[test]
fn a_stirred_box_is_what_the_twin_stirs() {
    let gpu = gpu();
    let start = crowd(Space::Flat, Borders::Periodic, MATCHING, 600, false);
    let stir = Stir { at_m: dvec3(0.1, 0.8, 0.0), radius_m: 0.5, push_mps2: 3.0 };
    let mut state = state(&gpu, &start);
    steps(&gpu, &mut state, 3, Some(&stir));
    let mut twin = cpu::Disks::new(start.model, &start.disks);
    let still = {
        let mut still = twin.clone();
        (0..3).for_each(|_| still.step());
        still.disks()
    };
    (0..3).for_each(|_| twin.step_stirred(Some(&stir)));
    let (places, velocities) = apart(&start.model, &state.disks(&gpu).unwrap(), &twin.disks());
    assert!(places < PLACES && velocities < VELOCITIES, "{places:e} {velocities:e}");
    assert!(apart(&start.model, &still, &twin.disks()).0 > 2.0 * PLACES, "nothing is stirred");
}

#[test]
fn exact_motion_has_the_pressure_of_henderson_and_collides_as_often_as_enskog_says() {
    for packing in [0.2245, 0.4] {
        let start = starts::fluid(Space::Flat, 200, packing, 4);
        let mut exact = Exact::new(start.model, &start.disks);
        exact.run(60.0);
        exact.reset();
        exact.run(250.0);
        let z = oracle::pressure_of_virial(oracle::energy(&start.model, &exact.disks), exact.virial, 250.0);
        let want = oracle::pressure(Space::Flat, packing);
        // 13 000 and 36 000 collisions, whose impulses scatter by two thirds of themselves; 200 disks are few.
        assert!((z / want - 1.0).abs() < 0.015, "{packing}: {z} is not {want}");
        let often = 2.0 * exact.collisions as f64 / 200.0 / 250.0;
        let model = Model { dt_s: 1.0, ..start.model };
        let enskog = model.collisions_a_step(&start.disks);
        assert!((often / enskog - 1.0).abs() < 0.03, "{packing}: {often} is not {enskog} a second");
        assert!(oracle::overlap(&start.model, &exact.disks) < 1e-9);
    }
}

#[test]
fn matching_follows_exact_motion_as_long_as_chaos_lets_it() {
    // With few collisions a step, and none that is jumped over, a step is exact but for f64, which grows threefold a
    // collision: measured 5e-12 radii.
    let start = starts::fluid(Space::Flat, 64, 0.2, 8);
    let mut exact = Exact::new(start.model, &start.disks);
    exact.run(6.0);
    let mut fine = start.clone();
    fine.model.dt_s = 0.03;
    fine.model.response = Response::Matching { rounds: 6, rewinds: true };
    let got = twin(&fine, 200).disks();
    let (places, velocities) = apart(&start.model, &got, &exact.disks);
    println!("{places:e} {velocities:e} after {} collisions", exact.collisions);
    assert!(exact.collisions > 60 && places < 1e-9, "{places:e} after {} collisions", exact.collisions);
}

#[test]
fn a_cradle_passes_the_blow_on() {
    let gpu = gpu();
    let row = |i: u32| Disk {
        at_m: dvec3(0.2 + 0.2 * f64::from(i) + if i == 0 { 0.0 } else { 0.1 }, 0.5, 0.0),
        velocity_mps: dvec3(if i == 0 { 1.0 } else { 0.0 }, 0.0, 0.0),
        radius_m: 0.099,
    };
    for response in [MATCHING, Response::GaussSeidel] {
        let start = Start {
            model: Model {
                space: Space::Flat,
                size_m: dvec3(2.0, 1.0, 1.0),
                borders: Borders::Walls,
                gravity_mps2: DVec3::ZERO,
                response,
                dt_s: 1.0 / 240.0,
            },
            disks: (0..6).map(row).collect(),
        };
        let got = run(&gpu, &start, 60);
        for (i, disk) in got.iter().enumerate() {
            let want = if i == 5 { 1.0 } else { 0.0 };
            assert!(
                (disk.velocity_mps - dvec3(want, 0.0, 0.0)).length() < 1e-5,
                "{response:?} {i}: {disk:?}"
            );
        }
    }
}

#[test]
fn steps_are_cut_as_fast_disks_and_crowds_need() {
    let mut start = starts::fluid(Space::Flat, 400, 0.5, 1);
    start.model.dt_s = 0.01;
    assert_eq!(start.model.substeps(&start.disks), 1);
    start.model.dt_s = 0.5; // 1.25 collisions a disk, of which 0.3 are allowed
    assert_eq!(start.model.substeps(&start.disks), 5);
    start.disks[3].velocity_mps = dvec3(100.0, 0.0, 0.0); // 50 m a step, of which 2 are allowed
    assert_eq!(start.model.substeps(&start.disks), 25);
    let cut = start.model.cut(25);
    assert!((cut.dt_s - 0.02).abs() < 1e-15);
}

#[test]
fn what_has_no_meaning_is_refused_with_what_is_allowed() {
    let start = starts::fluid(Space::Flat, 16, 0.3, 1);
    let refused = |change: &dyn Fn(&mut Start)| {
        let mut start = start.clone();
        change(&mut start);
        start.model.check(&start.disks).unwrap_err().to_string()
    };
    assert!(start.model.check(&start.disks).is_ok());
    for (text, part) in [
        (refused(&|s| s.disks[2].radius_m = 0.0), "radius_m = 0 of disk 2"),
        (refused(&|s| s.disks[2].radius_m = f64::NAN), "radius_m = NaN of disk 2"),
        (refused(&|s| s.disks[2].radius_m = 100.0), "radius_m = 100 of disk 2"),
        (refused(&|s| s.disks[1].at_m.x = -1.0), "at_m"),
        (refused(&|s| s.disks[1].velocity_mps.y = f64::INFINITY), "velocity_mps"),
        (refused(&|s| s.disks.clear()), "disks = 0: allowed is 1 to"),
        (refused(&|s| s.model.dt_s = 0.0), "dt_s = 0"),
        (refused(&|s| s.model.size_m.y = 0.0), "size_m"),
        (refused(&|s| s.model.gravity_mps2.y = f64::NAN), "gravity_mps2"),
        (refused(&|s| s.model.gravity_mps2.y = 1e300), "below 1e9"),
        (refused(&|s| s.model.gravity_mps2.z = 1.0), "0 along z of a flat box"),
        (
            refused(&|s| s.disks[1].velocity_mps.z = 1.0),
            "z = 0 m, 1 m/s of disk 1: allowed is 0 in a flat box",
        ),
        (refused(&|s| s.disks[1].at_m.z = 0.5), "0 in a flat box"),
        (refused(&|s| s.model.size_m.x = 1e6 * 9.0), "size_m"),
        (
            refused(&|s| (s.model.size_m.x, s.disks[2].radius_m) = (1e6, 0.05)),
            "radius_m = 0.05 of disk 2: allowed is 1e-1 to",
        ),
        (refused(&|s| s.model.response = Response::Matching { rounds: 0, rewinds: true }), "rounds = 0"),
    ] {
        assert!(text.contains(part), "{text:?} does not say {part:?}");
    }
}

#[test]
fn two_steps_without_a_barrier_between_them_are_reported() {
    let gpu = gpu();
    let start = crowd(Space::Flat, Borders::Walls, MATCHING, 300, false);
    let mut one = state(&gpu, &start);
    gpu.once(|rec| {
        one.record(rec);
        one.record(rec); // no barrier from EXIT to ENTRY
    })
    .unwrap();
    if common::validates() {
        gpu.expect_message("SYNC-HAZARD");
    }
}

#[test]
fn push_constants_are_what_the_shaders_say() {
    use std::mem::offset_of;
    use whitecap::{disks::Params, gpu::reflect::reflect, shaders};
    let want = [
        ("size_m", offset_of!(Params, size_m)),
        ("cells", offset_of!(Params, cells)),
        ("cells_per_m", offset_of!(Params, cells_per_m)),
        ("gravity_mps2", offset_of!(Params, gravity_mps2)),
        ("stir_at_m", offset_of!(Params, stir_at_m)),
        ("stir_mps2", offset_of!(Params, stir_mps2)),
        ("dt_s", offset_of!(Params, dt_s)),
        ("disks", offset_of!(Params, disks)),
        ("large", offset_of!(Params, large)),
        ("small_m", offset_of!(Params, small_m)),
        ("step", offset_of!(Params, step)),
        ("color", offset_of!(Params, color)),
        ("is_first", offset_of!(Params, is_first)),
    ];
    let mut seen = 0;
    for (name, spv) in shaders::ALL.iter().filter(|(name, _)| name.starts_with("disks.")) {
        let interface = reflect(spv, &[8; 8]).unwrap();
        if name.contains("sums") || name.contains("starts") || name.contains("draw") {
            continue; // none, or of its own
        }
        assert_eq!(interface.push_bytes, size_of::<Params>(), "{name}");
        let members: Vec<(&str, usize)> = interface.structs["DisksParams"]
            .members
            .iter()
            .map(|member| (member.name.as_str(), member.offset))
            .collect();
        assert_eq!(members, want, "{name}");
        seen += 1;
    }
    assert!(seen >= 24, "{seen} kernels");
}
