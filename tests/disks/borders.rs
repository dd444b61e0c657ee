// SPDX-License-Identifier: MIT OR Apache-2.0
//! Boxes of few cells and of odd shapes, walls under gravity, stirring.

use crate::{
    apart, common::gpu, crowd, run, state, steps, twin, BORDERS, MATCHING, PLACES, RESPONSES, SPACES,
};
use glam::{dvec3, DVec3, Vec4};
use std::collections::BTreeSet;
use whitecap::disks::{oracle, starts::Start, Borders, Disk, Grid, Model, Response, Sorted, Space, Stir};

fn unit(i: u32, purpose: u32) -> [f64; 4] {
    whitecap::random::units(whitecap::random::bits(77, 0, i, purpose)).map(f64::from)
}

/// Disks of all sizes that the box takes, at random.
fn scattered(space: Space, borders: Borders, size_m: DVec3, count: u32) -> Start {
    let flat = if space == Space::Flat { dvec3(1.0, 1.0, 0.0) } else { DVec3::ONE };
    let narrowest = if space == Space::Flat { size_m.x.min(size_m.y) } else { size_m.min_element() };
    let widest = if borders == Borders::Walls { 0.3 } else { 0.25 } * narrowest;
    let disk = |i: u32| {
        let [x, y, z, r] = unit(i, 0);
        let [u, v, w, is_small] = unit(i, 1);
        let share = if is_small < 0.8 { 0.05 + 0.2 * r } else { 0.3 + 0.7 * r };
        Disk {
            at_m: dvec3(x, y, z) * size_m * flat,
            velocity_mps: (dvec3(u, v, w) - 0.5) * narrowest * flat,
            radius_m: share * widest,
        }
    };
    let model =
        Model { space, size_m, borders, gravity_mps2: DVec3::ZERO, response: Response::Seed, dt_s: 0.01 };
    Start { model, disks: (0..count).map(disk).collect() }
}

/// Against every pair, in boxes of one, two, three and more cells along an axis.
#[test]
fn every_contact_is_found_across_every_border_in_boxes_of_few_cells() {
    let gpu = gpu();
    let (mut along, mut hits) = (BTreeSet::new(), [0, 0]);
    for space in SPACES {
        for borders in BORDERS {
            let model = scattered(space, borders, DVec3::ONE, 1).model;
            let kernels = Sorted::new(&gpu, &model, true, true).unwrap();
            for size_m in [dvec3(1.0, 1.0, 1.0), dvec3(0.3, 2.5, 0.7), dvec3(2.5, 0.3, 1.1)] {
                for count in [1, 2, 3, 5, 9, 17, 40, 120] {
                    let start = scattered(space, borders, size_m, count);
                    let grid = Grid::of(&start.model, start.disks.iter().map(|disk| disk.radius_m));
                    along.extend(grid.cells.to_array());
                    let mut state = kernels.state(&start.model, &start.disks).unwrap();
                    steps(&gpu, &mut state, 1, None);
                    let disks = state.disks(&gpu).unwrap();
                    let hit: Vec<u32> = gpu.download(state.hits()).unwrap();
                    for (i, a) in disks.iter().enumerate() {
                        // How far it is inside the nearest of the others, of its radius.
                        let depth = |(k, b): (usize, &Disk)| {
                            let far = start.model.way(a.at_m, b.at_m).length();
                            if k == i {
                                -1.0
                            } else {
                                (a.radius_m + b.radius_m - far) / a.radius_m
                            }
                        };
                        let deepest = disks.iter().enumerate().map(depth).fold(-1.0, f64::max);
                        if deepest.abs() > 1e-4 {
                            let what = format!("{space:?} {borders:?} {size_m} {grid:?}: {i}, {deepest}");
                            assert_eq!(hit[i] == 1, deepest > 0.0, "{what}");
                            hits[usize::from(deepest > 0.0)] += 1;
                        }
                    }
                }
            }
        }
    }
    assert!((1..=4).all(|n| along.contains(&n)), "{along:?}");
    assert!(hits[0] > 100 && hits[1] > 100, "{hits:?} disks that touch nobody, somebody");
}

#[test]
fn every_response_does_what_the_twin_does_with_one_to_three_cells_along_an_axis() {
    let gpu = gpu();
    let mut along = BTreeSet::new();
    for response in RESPONSES {
        for borders in BORDERS {
            for space in SPACES {
                let model = crowd(space, borders, response, 1, false).model;
                let kernels = Sorted::new(&gpu, &model, true, true).unwrap();
                for count in [1, 2, 5, 12, 40] {
                    let mut start = crowd(space, borders, response, count, false);
                    let grid = Grid::of(&start.model, start.disks.iter().map(|disk| disk.radius_m));
                    along.extend(grid.cells.to_array());
                    start.disks[0].velocity_mps = dvec3(0.3, 0.2, 0.0); // so that one moves
                    let mut state = kernels.state(&start.model, &start.disks).unwrap();
                    steps(&gpu, &mut state, 5, None);
                    let (got, want) = (state.disks(&gpu).unwrap(), twin(&start, 5).disks());
                    let (places, _) = apart(&start.model, &got, &want);
                    assert!(places < PLACES, "{response:?} {borders:?} {space:?} {count}: {places:e}");
                }
            }
        }
    }
    assert!((1..=3).all(|n| along.contains(&n)), "{along:?}");
}

#[test]
fn a_thin_box_has_about_a_cell_a_disk_and_never_more_than_memory_takes() {
    let thin = [
        (Space::Flat, dvec3(1e6, 1e-6, 1.0)),
        (Space::Flat, dvec3(3.0, 0.001, 1.0)),
        (Space::Solid, dvec3(1e6, 1e-6, 1e6)),
        (Space::Solid, dvec3(100.0, 0.01, 100.0)),
        (Space::Solid, dvec3(1e-6, 1e-6, 1e6)),
        (Space::Solid, dvec3(2.0, 3.0, 5.0)),
    ];
    for (space, size_m) in thin {
        for count in [1, 100, 100_000] {
            let model = Model { space, size_m, ..scattered(space, Borders::Walls, size_m, 1).model };
            let grid = Grid::of(&model, (0..count).map(|_| 1e-9));
            let cells = grid.count();
            let room = count.max(8);
            assert!(cells <= room && 3 * cells >= count.min(1 << 20), "{size_m}, {count}: {grid:?}");
        }
    }
}

#[test]
fn wide_disks_that_are_no_wider_than_the_rest_have_cells() {
    let model = scattered(Space::Flat, Borders::Walls, dvec3(1.0, 1.0, 1.0), 1).model;
    let large = |wide: usize| {
        let grid = Grid::of(&model, (0..10_000).map(|i| if i % 100 < wide / 100 { 0.02 } else { 0.001 }));
        (grid.large, grid.small_m)
    };
    assert_eq!(Grid::of(&model, (0..10_000).map(|i| if i < 3 { 0.02 } else { 0.001 })).large, 3);
    // More than the list takes: all of them are in cells.
    assert_eq!(large(200), (0, 0.02));
}

/// A ball above a floor, of which the exact height is known. A mirror would lift it by some 0.1 % a bounce.
#[test]
fn a_ball_bounces_under_gravity_for_minutes_and_comes_as_high_as_ever() {
    let gpu = gpu();
    for (space, down, minutes) in [(Space::Flat, 1, 2), (Space::Solid, 2, 1)] {
        for towards in [-1.0, 1.0] {
            let mut gravity_mps2 = DVec3::ZERO;
            gravity_mps2[down] = 9.81 * towards;
            let flat = if space == Space::Flat { 0.0 } else { 1.0 };
            let model = Model {
                space,
                size_m: dvec3(2.0, 2.0, 2.0),
                borders: Borders::Walls,
                gravity_mps2,
                response: MATCHING,
                dt_s: 1.0 / 60.0,
            };
            let ball = Disk { at_m: dvec3(1.0, 1.0, flat), velocity_mps: DVec3::ZERO, radius_m: 0.1 };
            let start = Start { model, disks: vec![ball] };
            let mut state = state(&gpu, &start);
            let twin_drift = {
                let far = twin(&start, 36_000).disks(); // ten minutes
                oracle::total_energy(&model, &far) / oracle::total_energy(&model, &start.disks) - 1.0
            };
            assert!(twin_drift.abs() < 1e-9, "{twin_drift:e}");
            // 0.9 m down takes this long, and up again.
            let half_s = (2.0 * 0.9 / 9.81_f64).sqrt();
            for round in 1..=minutes {
                steps(&gpu, &mut state, 3600, None);
                let got = state.disks(&gpu).unwrap();
                let drift =
                    oracle::total_energy(&model, &got) / oracle::total_energy(&model, &start.disks) - 1.0;
                assert!(drift.abs() < 1e-4, "{space:?} {gravity_mps2}: {drift:e} after {round} min");
                if round == 1 {
                    let since_s = (60.0_f64 + half_s).rem_euclid(2.0 * half_s) - half_s;
                    let fallen = 0.5 * 9.81 * since_s * since_s;
                    let height = 0.5 * 2.0 - towards * (got[0].at_m[down] - 1.0) - 0.1;
                    assert!((height - (0.9 - fallen)).abs() < 1e-3, "{height} is not {}", 0.9 - fallen);
                }
            }
            let sum: f64 = state.impulses(&gpu).unwrap().iter().map(|it| f64::from(it[1])).sum();
            // What a floor gives in the mean is the weight, to half a bounce.
            let weight = space.mass(0.1) * 9.81 * 60.0 * f64::from(minutes);
            assert!((sum / weight - 1.0).abs() < 1e-2, "{} of its weight", sum / weight);
        }
    }
}

#[test]
fn a_ball_that_bounces_several_times_in_a_step_neither_climbs_nor_sinks() {
    let gpu = gpu();
    let model = Model {
        space: Space::Flat,
        size_m: DVec3::ONE,
        borders: Borders::Walls,
        gravity_mps2: dvec3(0.0, -9.81, 0.0),
        response: MATCHING,
        dt_s: 0.05,
    };
    // 1e-4 m: eleven times in a step; and one at rest.
    let ball = |x: f64, above: f64| Disk {
        at_m: dvec3(x, 0.1 + above, 0.0),
        velocity_mps: DVec3::ZERO,
        radius_m: 0.1,
    };
    let start = Start { model, disks: vec![ball(0.3, 1e-4), ball(0.7, 0.0)] };
    let mut state = state(&gpu, &start);
    let mut highest = [0.0_f64; 2];
    for _ in 0..40 {
        steps(&gpu, &mut state, 10, None);
        for (highest, disk) in highest.iter_mut().zip(state.disks(&gpu).unwrap()) {
            let energy = 0.5 * disk.velocity_mps.y.powi(2) / 9.81 + disk.at_m.y - 0.1;
            assert!(disk.at_m.y > 0.0999999, "{disk:?}");
            *highest = highest.max(energy);
        }
    }
    // A place is rounded to 1e-8 m, and energy with it, at each of 8000 bounces in either direction.
    assert!((0.9e-4..1.1e-4).contains(&highest[0]) && highest[1] < 1e-7, "{highest:?} m");
}

#[test]
fn a_heap_of_spheres_keeps_its_energy_of_motion_and_height() {
    let gpu = gpu();
    let mut start = crowd(Space::Solid, Borders::Walls, MATCHING, 2000, false);
    start.model.gravity_mps2 = dvec3(0.0, -9.81, 0.0);
    start.model.dt_s = 1.0 / 60.0;
    start.model = start.model.cut(start.model.substeps(&start.disks));
    {
        let mut state = state(&gpu, &start);
        steps(&gpu, &mut state, 60, None); // the start is at random, and overlaps
        start.disks = state.disks(&gpu).unwrap();
    }
    for disk in &mut start.disks {
        let low = DVec3::splat(disk.radius_m);
        disk.at_m = disk.at_m.clamp(low, start.model.size_m - low); // some are on their way back from a wall
    }
    let before = oracle::total_energy(&start.model, &start.disks);
    let got = run(&gpu, &start, 600);
    let drift = oracle::total_energy(&start.model, &got) / before - 1.0;
    println!("{drift:e} in {} s", 600.0 * start.model.dt_s);
    // What pushes disks apart by mass moves no weight, but for one that the floor stops: measured 4.5e-4. A mirror for a
    // floor lifts one that comes down at 2 m/s by 8 % of its energy, each time.
    assert!(drift.abs() < 1e-3, "{drift:e}");
}

#[test]
fn stirring_makes_nobody_faster_than_steps_are_cut_for() {
    let gpu = gpu();
    for space in SPACES {
        let start = crowd(space, Borders::Walls, MATCHING, 400, false);
        let most = start.model.stirred_mps(&start.disks);
        let middle =
            start.model.size_m * if space == Space::Flat { dvec3(0.5, 0.5, 0.0) } else { DVec3::splat(0.5) };
        let stir = Stir { at_m: middle, radius_m: 3.0, push_mps2: 1e4 };
        let mut state = state(&gpu, &start);
        steps(&gpu, &mut state, 1, Some(&stir));
        let fastest =
            |disks: &[Disk]| disks.iter().map(|disk| disk.velocity_mps.length()).fold(0.0, f64::max);
        let fast = fastest(&state.disks(&gpu).unwrap());
        // Gravity, and collisions with lighter ones, come after.
        assert!(fast > 0.9 * most && fast < 2.0 * most, "{space:?}: {fast} m/s, most is {most}");
    }
}

#[test]
#[should_panic(expected = "finite numbers")]
fn a_hand_that_is_nowhere_is_refused() {
    let gpu = gpu();
    let start = crowd(Space::Flat, Borders::Walls, MATCHING, 10, false);
    let mut state = state(&gpu, &start);
    let stir = Stir { at_m: DVec3::NAN, radius_m: 0.5, push_mps2: 3.0 };
    steps(&gpu, &mut state, 1, Some(&stir));
}

#[test]
fn a_cell_of_thousands_is_sorted_the_same_on_every_run() {
    let gpu = gpu();
    let mut start = crowd(Space::Flat, Borders::Walls, MATCHING, 5000, false);
    for (i, disk) in (0..).zip(&mut start.disks) {
        let [x, y, ..] = unit(i, 2);
        disk.at_m = dvec3(0.5 + 0.02 * x, 0.5 + 0.02 * y, 0.0);
    }
    let words = |group| {
        let kernels = Sorted::tuned(&gpu, &start.model, false, false, group).unwrap();
        let mut state = kernels.state(&start.model, &start.disks).unwrap();
        steps(&gpu, &mut state, 2, None);
        let words = state.words(&gpu).unwrap();
        // Ids are no denormal numbers, which a device may flush.
        let place: Vec<Vec4> = gpu.download(state.place()).unwrap();
        assert!(place.iter().all(|it| it.w.is_normal()));
        words
    };
    assert!(words(64) == words(256));
}
