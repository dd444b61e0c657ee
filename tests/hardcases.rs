// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every hard case holds on this device; the simple method, measured the same way, holds none of them; and the reports
//! that are made of such numbers are whole.
#![cfg(feature = "tools")]
#![allow(missing_docs)]

mod common;

use common::gpu;
use glam::{uvec2, UVec2};
use whitecap::{
    study::{
        bench::{bench, rows, Options},
        hard::{self, Case},
        runs::{apart, book_constants, farther, larger, rms, twin, Basin, Effort, Scheme},
        shapes::HardCase,
        write_report, Error, Progress,
    },
    water::{
        oracle,
        starts::{self, Start},
        Model,
    },
};

fn case_of(row: &HardCase) -> &'static Case {
    hard::cases().find(|case| case.id == row.id && case.title == row.title).expect("a row of the table")
}

fn seed(row: &HardCase) -> f64 {
    row.seed_measured.unwrap_or_else(|| panic!("{} has no seed", row.id))
}

/// Runs the cases that `wanted` takes: they hold, and the simple method, where it was measured too, does not.
fn hold(wanted: impl Fn(&str) -> bool) -> Vec<HardCase> {
    let gpu = gpu();
    let mut seen = Vec::new();
    let mut ids: Vec<String> =
        hard::cases().map(|case| case.id.into()).filter(|id: &String| wanted(id)).collect();
    ids.dedup();
    let rows = hard::run(&gpu, &ids, &mut |Progress { done, of, now }| seen.push((done, of, now.to_owned())))
        .unwrap();
    assert_eq!(seen.len(), rows.cases.len());
    assert_eq!(seen.last().map(|(done, of, _)| (*done + 1, *of)), Some((seen.len(), seen.len())));
    serde_json::to_string(&rows).expect("every number is one");
    for row in &rows.cases {
        println!("{} {}: {:?} of {:e} {}", row.id, row.variant, row.measured, row.limit, row.unit);
        assert!(row.pass, "{row:?}");
        let fails = row.seed_measured.map(|seed| !case_of(row).allows(seed));
        assert_ne!(fails, Some(false), "the case is none: {row:?}");
    }
    rows.cases
}

/// What is known of the simple method, to the digits that are known.
fn known(rows: &[HardCase], id: &str, range: std::ops::Range<f64>) {
    let its = |row: &&HardCase| row.id == id && row.limit != 1e-12 && row.seed_measured.is_some();
    assert!(rows.iter().any(|row| its(&row)), "{id} has no seed");
    for row in rows.iter().filter(its) {
        assert!(range.contains(&seed(row)), "{id} {}: {}", row.variant, seed(row));
    }
}

// Several tests for all cases, so that they run side by side: small grids keep no processor busy.
#[test]
fn a_lake_stays_flat_and_the_listings_lose_a_quarter_of_it() {
    known(&hold(|id| id == "W1"), "W1", -0.25..-0.235);
}

#[test]
fn every_other_hard_case_of_water_holds_and_the_simple_method_holds_none() {
    let rows = hold(|id| id.starts_with('W') && id != "W1");
    let known = |id: &str, range: std::ops::Range<f64>| known(&rows, id, range);
    known("W2", 1.60..1.64);
    known("W3", 2.33..2.37);
    known("W4", 1.30..1.34);
    known("W5", 1e6..1e8);
    known("W6", 0.1..1.0);
    known("W7", 2.5e-2..3.5e-2);
    known("W11", -0.014..-0.012);
    known("W17", 441.0..441.5);
    known("W14", 0.59..0.63);
    known("W15", 0.83..0.85);
    known("W10", 1.0..10.0);
    let notes: Vec<&str> = rows.iter().filter_map(|row| row.note.as_deref()).collect();
    for words in
        ["52.3693, 30.2922, 19.6263, 7.7446 s", "92.4402, 19.2560, 2.7722 s", "0.3667 s lost and reported"]
    {
        assert!(notes.iter().any(|note| note.contains(words)), "{words}");
    }
}

#[test]
fn every_hard_case_of_disks_holds() {
    assert!(hold(|id| id.starts_with('D')).len() > 30);
}

#[test]
fn every_hard_case_of_particles_in_a_volume_holds() {
    assert!(hold(|id| id.starts_with('V')).len() > 15);
}

#[test]
fn every_hard_case_of_anything_else_holds() {
    assert!(hold(|id| !id.starts_with(['W', 'D', 'V'])).len() > 60);
}

#[test]
fn filters_take_the_exact_identifier_first() {
    let ids = |filter: &str| -> Vec<&str> {
        let mut ids: Vec<_> =
            hard::select(&[filter.to_owned()]).unwrap().iter().map(|case| case.id).collect();
        ids.dedup();
        ids
    };
    assert_eq!(ids("W1"), ["W1"]);
    assert_eq!(ids("w12"), ["W12"]);
    assert_eq!(ids("W").len(), 19);
    assert!(ids("W").iter().all(|id| id.starts_with('W')));
    assert!(ids("s").iter().all(|id| id.starts_with('S')) && ids("s").contains(&"S4"));
    assert_eq!(ids("hitch"), ["W6"]);
    assert_eq!(ids("land"), ["W16"]);
    assert_eq!(hard::select(&[]).unwrap().len(), hard::cases().count());
    let Err(Error::NoSuch { wanted, have, .. }) = hard::select(&["W99".into()]) else { panic!("W99 found") };
    assert_eq!((wanted.as_str(), have[0].as_str()), ("W99", "W1"));
    assert!(hard::cases().all(|case| have.iter().any(|id| id == case.id)));
}

#[test]
fn a_case_without_a_seed_can_fail_too() {
    let gpu = gpu();
    let limit = |id: &str| hard::cases().find(|case| case.id == id).expect("in the table");
    let scheme = Scheme::named("waves/w0.25");

    // W13: above the longest step the checkerboard grows.
    let cells = UVec2::splat(64);
    let model = scheme.model(Model { damping_per_s: 0.0, ..book_constants(cells) });
    let model = model.with_courant(1.01 * model.courant_limit());
    let board: Vec<f64> = (0..64 * 64).map(|i| if (i + i / 64) % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let height_m = board.iter().map(|&sign| 0.1 * sign as f32).collect();
    let mut basin = Basin::new(&gpu, scheme, &Start { name: "checkerboard", model, height_m }).unwrap();
    basin.steps(50).unwrap();
    assert!(!limit("W13").allows(oracle::amplitude(&basin.heights().unwrap(), &board) / 0.1));

    // W16: a diagonal weight that is off by 1e-3, and a surface with one column wrong.
    let start = starts::hump(starts::model(uvec2(17, 33), 0.25));
    let mut basin = Basin::new(&gpu, scheme, &start).unwrap();
    basin.steps(16).unwrap();
    let mut height = basin.heights().unwrap();
    assert!(limit("W16").allows(apart(&height, &twin(scheme, &start, 16))));
    let other = Start { model: Model { diagonal: 0.251, ..start.model }, ..start.clone() };
    assert!(!limit("W16").allows(apart(&height, &twin(scheme, &other, 16))));
    for wrong in [height[40] + 1e-4, f32::NAN, f32::INFINITY] {
        height[40] = wrong;
        assert!(!limit("W16").allows(apart(&height, &twin(scheme, &start, 16))));
    }
}

#[test]
fn a_measurement_that_is_no_number_does_not_pass() {
    for case in hard::cases() {
        for measured in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!case.allows(measured), "{}", case.id);
        }
    }
    assert!(rms(&[f32::NAN]).is_nan());
    for (a, b) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::NAN, f64::NAN)] {
        assert!(larger(a, b).is_nan() && farther(a, b).is_nan(), "{a} {b}");
    }
    assert_eq!((larger(1.0, -2.0), farther(1.0, -2.0)), (1.0, -2.0));
    // Nor does a comparison with a twin that blew up, with too few columns, or of nothing at all.
    assert_eq!(apart(&[1.0, 0.5], &[1.0, 0.75]), 0.25);
    for (got, want) in [(&[1.0, 0.5][..], &[1.0, f64::NAN][..]), (&[1.0], &[1.0, 0.5]), (&[0.0], &[0.0])] {
        assert!(!apart(got, want).is_finite(), "{got:?} {want:?}");
    }
}

#[test]
fn what_blows_up_while_it_is_timed_is_not_believed() {
    let gpu = gpu();
    let scheme = Scheme::named("waves/w0.25");
    let model = scheme.model(book_constants(UVec2::splat(16)));
    let start = |courant| starts::noise(model.with_courant(courant * model.courant_limit()));
    let effort = Effort { run_ms: 5.0, fewest_runs: 3, budget_s: 0.1 };
    let time = |courant| Basin::new(&gpu, scheme, &start(courant)).unwrap().time(effort);
    assert!(time(0.95).unwrap().median_ms > 0.0);
    let error = time(3.0).unwrap_err();
    assert!(matches!(error, Error::BlownUp { spoiled: 256, of: 256, .. }), "{error}");
}

#[test]
fn a_bench_of_small_grids_is_whole() {
    let gpu = gpu();
    let options = Options { sizes: Some(vec![64, 100]), budget_s: Some(0.05) };
    let result = bench(&gpu, &["water".into()], &options, &mut |_| ()).unwrap();
    assert_eq!(result.results.len(), 2 * rows().filter(|(sim, _)| *sim == "water").count(), "{result:?}");
    assert_eq!(result.skipped, []);
    for row in &result.results {
        let Some((min, p95)) = row.min_ms.zip(row.p95_ms) else { panic!("{row:?}") };
        assert!(row.runs >= 3 && 0.0 < min && min <= row.median_ms && row.median_ms <= p95, "{row:?}");
        let traffic = row.items_per_s * row.bytes_per_item / result.copy_bytes_per_s;
        assert!((row.fraction_of_copy / traffic - 1.0).abs() < 1e-12);
    }
    serde_json::to_string(&result).expect("every number is one");
    let error = bench(&gpu, &["watre".into()], &options, &mut |_| ()).unwrap_err();
    assert!(error.to_string().starts_with("no bench `watre`; there are system/copy/kernel, "), "{error}");
}

#[test]
fn a_size_that_does_not_fit_is_skipped_with_the_reason() {
    let gpu = gpu();
    if gpu.limits().max_storage_buffer_range as u64 >= 20 * 16384 * 16384 {
        return; // it fits
    }
    let options = Options { sizes: Some(vec![16384]), budget_s: Some(0.05) };
    let result = bench(&gpu, &["book".into()], &options, &mut |_| ()).unwrap();
    assert_eq!(result.results, []);
    assert!(result.skipped[0].reason.contains("maxStorageBufferRange"), "{:?}", result.skipped);
}

/// The errors that are known for a hill of 1/20 of a basin of 128 columns (relative L2, measured elsewhere).
#[test]
fn the_linear_study_finds_the_known_errors_and_its_report_is_whole() {
    let gpu = gpu();
    let study = whitecap::study::study(&gpu, &["water linear".into()], true, &mut |_| ()).unwrap();
    let error = |variant: &str, courant: f64| {
        let close = |step: f64| (step * 12.8 - courant).abs() < 0.01;
        let found =
            study.studies[0].points.iter().find(|p| p.variant == variant && p.size == 128 && close(p.step));
        found.and_then(|p| p.error).unwrap_or_else(|| panic!("{variant} at {courant}"))
    };
    for (variant, courant, known) in
        [("waves/w1", 0.99, 2.9e-2), ("waves/w0.25", 0.86, 2.3e-2), ("waves/w0", 0.7, 2.5e-2)]
    {
        let error = error(variant, courant);
        assert!((error / known - 1.0).abs() < 0.06, "{variant} at {courant}: {error}");
    }
    assert!(error("book", 0.0707) > 0.1);
    let dir = tempfile::tempdir().unwrap();
    write_report(&study, dir.path(), "2026-01-01").unwrap();
    let mut names: Vec<_> = std::fs::read_dir(dir.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["index.html", "study.csv", "study.json", "water-linear.svg"]);
    let error = whitecap::study::study(&gpu, &["wine".into()], true, &mut |_| ()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "no study `wine`; there are water linear, water non-linear, black hole, ballistic, disks, volume"
    );
}
