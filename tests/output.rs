// SPDX-License-Identifier: MIT OR Apache-2.0
//! Everything that is written for people and programs to read: files, pictures, clips, JSON, CSV, plots,
//! pages.
#![cfg(feature = "tools")]

use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::Path;

use serde::{de::DeserializeOwned, Serialize};
use tempfile::{tempdir, TempDir};
use whitecap::run::atomic::write_atomic;
use whitecap::run::clip::{Clip, ClipOptions};
use whitecap::run::picture::{contact_sheet, Picture};
use whitecap::scene::{Measured, Scene};
use whitecap::study::linear::cost_of;
use whitecap::study::page::{page, panels};
use whitecap::study::plot::{self, log_log, Curve, Mark};
use whitecap::study::shapes::*;

fn names(dir: &TempDir) -> Vec<String> {
    let entries = fs::read_dir(dir.path()).expect("the directory is there");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("it can be listed").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Pins the exact JSON of a value, and that reading it gives the value back.
fn pin<T: Serialize + DeserializeOwned + PartialEq + std::fmt::Debug>(value: &T, json: &str) {
    assert_eq!(serde_json::to_string(value).expect("it serialises"), json);
    assert_eq!(&serde_json::from_str::<T>(json).expect("it reads back"), value);
}

fn point(variant: &str, error: Option<f64>, ms: f64) -> Point {
    let (variant, metric) = (variant.to_owned(), "relative L2".to_owned());
    Point {
        variant,
        step: 0.5,
        size: 64,
        error,
        metric,
        ms_per_sim_second: ms,
        ns_per_item: 0.25,
        pareto: false,
    }
}

fn result(points: Vec<Point>) -> StudyResult {
    StudyResult {
        sim: "water".into(),
        study: "time step".into(),
        reference: "f64 twin".into(),
        points,
        cheapest: Vec::new(),
    }
}

fn study(studies: Vec<StudyResult>) -> Study {
    let (headlines, parts) = (Vec::new(), Vec::new());
    Study {
        device: "D".into(),
        driver: "1".into(),
        clock: "free".into(),
        edited: Vec::new(),
        studies,
        headlines,
        parts,
    }
}

fn headline() -> Headline {
    Headline {
        sim: "water".into(),
        study: "linear".into(),
        what: "Time to 1 %".into(),
        value: Some(100.0),
        unit: "times".into(),
        note: "from a & b".into(),
    }
}

fn parts() -> Parts {
    Parts {
        sim: "water".into(),
        study: "linear".into(),
        variant: "a".into(),
        step: 0.5,
        size: 64,
        truncation: Some(0.25),
        model: None,
        rounding: Some(1e-6),
    }
}

#[test]
fn hard_cases_have_this_json() {
    let mut case = HardCase {
        id: "still".into(),
        title: "Still water stays still".into(),
        variant: "a".into(),
        measured: Some(1e-7),
        limit: 1e-6,
        unit: "m".into(),
        pass: true,
        seed_measured: None,
        note: None,
    };
    let cases = |case: &HardCase| HardCases {
        device: "D".into(),
        driver: "1".into(),
        clock: "free".into(),
        edited: Vec::new(),
        cases: vec![case.clone()],
    };
    let json = r#"{"device":"D","driver":"1","clock":"free","cases":[{"id":"still","title":"Still water stays still","variant":"a","measured":1e-7,"limit":1e-6,"unit":"m","pass":true}]}"#;
    pin(&cases(&case), json);
    case.seed_measured = Some(0.5);
    case.note = Some("n".into());
    pin(&cases(&case), &json.replace("true}", r#"true,"seed_measured":0.5,"note":"n"}"#));
    case.measured = finite(f64::NAN);
    case.pass = false;
    let json = serde_json::to_string(&case).expect("it serialises");
    assert!(json.contains(r#""measured":null,"#), "{json}");
}

#[test]
fn a_bench_has_this_json() {
    let result = BenchResult {
        sim: "water".into(),
        variant: "a".into(),
        size: "4096x4096".into(),
        items_per_s: 2e10,
        unit: "cell".into(),
        bytes_per_item: 32.0,
        fraction_of_copy: 0.5,
        median_ms: 0.75,
        ms_per_sim_second: None,
        runs: 21,
        min_ms: None,
        p95_ms: None,
    };
    let skipped = Skipped { variant: "b".into(), size: "8x8".into(), reason: "too small".into() };
    let bench = Bench {
        device: "D".into(),
        driver: "1".into(),
        clock: "free".into(),
        edited: Vec::new(),
        copy_bytes_per_s: 1.5e12,
        results: vec![result],
        skipped: vec![skipped],
    };
    pin(
        &bench,
        r#"{"device":"D","driver":"1","clock":"free","copy_bytes_per_s":1500000000000.0,"results":[{"sim":"water","variant":"a","size":"4096x4096","items_per_s":20000000000.0,"unit":"cell","bytes_per_item":32.0,"fraction_of_copy":0.5,"median_ms":0.75,"runs":21}],"skipped":[{"variant":"b","size":"8x8","reason":"too small"}]}"#,
    );
}

#[test]
fn a_study_has_this_json() {
    let mut result = result(vec![point("a", Some(0.125), 2.0), point("b", None, 4.0)]);
    result.mark_pareto();
    result.cheapest = result.cheapest_for(&[0.5, 0.001], "a");
    pin(
        &study(vec![result]),
        r#"{"device":"D","driver":"1","clock":"free","studies":[{"sim":"water","study":"time step","reference":"f64 twin","points":[{"variant":"a","step":0.5,"size":64,"error":0.125,"metric":"relative L2","ms_per_sim_second":2.0,"ns_per_item":0.25,"pareto":true},{"variant":"b","step":0.5,"size":64,"error":null,"metric":"relative L2","ms_per_sim_second":4.0,"ns_per_item":0.25,"pareto":false}],"cheapest":[{"tolerance":0.5,"variant":"a","ms_per_sim_second":2.0,"speedup_over_seed":1.0},{"tolerance":0.001,"variant":null,"ms_per_sim_second":null,"speedup_over_seed":null}]}]}"#,
    );
}

#[test]
fn findings_and_parts_of_errors_have_this_json() {
    let found = Study { headlines: vec![headline()], parts: vec![parts()], ..study(Vec::new()) };
    pin(
        &found,
        r#"{"device":"D","driver":"1","clock":"free","studies":[],"headlines":[{"sim":"water","study":"linear","what":"Time to 1 %","value":100.0,"unit":"times","note":"from a & b"}],"parts":[{"sim":"water","study":"linear","variant":"a","step":0.5,"size":64,"truncation":0.25,"model":null,"rounding":1e-6}]}"#,
    );
}

#[test]
fn what_an_error_costs_is_read_between_two_sizes_and_never_beyond_them_in_silence() {
    // Order 1 in the error, order 3 in the cost.
    let points = [(100.0, 0.04, 1.0), (200.0, 0.02, 8.0), (400.0, 0.01, 64.0)];
    let close = |(ms, how): (f64, String), want: f64, words: &str| {
        assert!((ms / want - 1.0).abs() < 1e-9 && how.contains(words), "{ms}: {how}");
    };
    close(cost_of(0.03, &points).unwrap(), (400.0f64 / 300.0).powi(3), "between 100 and 200");
    close(cost_of(0.01, &points).unwrap(), 64.0, "between 200 and 400");
    close(cost_of(0.005, &points).unwrap(), 512.0, "EXTRAPOLATED: 1.00 % is the best");
    // Where all are within it, it costs no more than the first.
    close(cost_of(0.05, &points).unwrap(), 1.0, "at most: 100 columns");
    assert_eq!(cost_of(0.01, &points[..1]), None);
    // An error that no grid brings down has no cost.
    assert_eq!(cost_of(0.01, &[(100.0, 0.6, 1.0), (200.0, 0.6, 8.0)]), None);
}

#[test]
fn many_variants_are_drawn_in_panels_of_those_that_begin_alike() {
    let names = ["seed", "a/x", "a/y", "a/z", "b/x", "b/y", "b/z", "a/b/x", "a/b/y"];
    let result = result(names.map(|name| point(name, Some(0.1), 2.0)).into());
    let found: Vec<(String, Vec<String>)> = panels(&result)
        .into_iter()
        .map(|panel| (panel.title, panel.curves.into_iter().map(|curve| curve.name).collect()))
        .collect();
    let want =
        |title: &str, curves: &[&str]| (title.to_owned(), curves.iter().map(|c| (*c).into()).collect());
    assert_eq!(
        found,
        [
            want("a", &["seed", "x", "y", "z"]),
            want("b", &["seed", "x", "y", "z"]),
            want("a/b", &["seed", "x", "y"])
        ]
    );
}

#[test]
fn a_line_goes_through_what_no_other_point_of_its_variant_beats() {
    let points = [(0.5, 1.0), (0.6, 2.0), (0.1, 3.0), (0.1, 4.0)].map(|(e, ms)| point("a", Some(e), ms));
    let joined: Vec<bool> =
        panels(&result(points.into()))[0].curves[0].marks.iter().map(|m| m.is_joined).collect();
    assert_eq!(joined, [true, false, true, false]);
}

#[test]
fn a_number_that_must_be_finite_is_refused_when_it_is_not() {
    let error = serde_json::to_string(&point("a", Some(0.1), f64::NAN)).expect_err("NaN has no JSON");
    assert_eq!(error.to_string(), "NaN is not a finite number");
}

#[test]
fn the_pareto_front_has_the_points_that_no_other_beats() {
    let mut result = result(vec![
        point("cheap", Some(1.0), 1.0),
        point("middle", Some(0.1), 2.0),
        point("beaten", Some(0.5), 3.0),
        point("as accurate but dearer", Some(0.1), 2.5),
        point("twin of middle", Some(0.1), 2.0),
        point("blown up", None, 0.1),
        point("exact", Some(0.0), 9.0),
    ]);
    result.mark_pareto();
    let front: Vec<&str> = result.points.iter().filter(|p| p.pareto).map(|p| p.variant.as_str()).collect();
    assert_eq!(front, ["cheap", "middle", "twin of middle", "exact"]);
}

#[test]
fn the_cheapest_point_is_compared_with_the_cheapest_seed_that_meets_the_tolerance() {
    let points = [("seed-a", 0.5, 4.0), ("seed-b", 0.05, 10.0), ("fast", 0.05, 2.0), ("fine", 0.001, 6.0)];
    let result = result(points.map(|(v, e, ms)| point(v, Some(e), ms)).into());
    let cheapest = result.cheapest_for(&[0.5, 0.1, 0.01, 0.0001], "seed");
    let found: Vec<_> = cheapest.iter().map(|c| (c.variant.as_deref(), c.speedup_over_seed)).collect();
    assert_eq!(
        found,
        [(Some("fast"), Some(2.0)), (Some("fast"), Some(5.0)), (Some("fine"), None), (None, None)]
    );
}

#[test]
fn csv_quotes_commas_quotes_and_line_breaks() {
    let mut result = result(vec![point("a, \"b\"", Some(1e-9), 2.0), point("c\nd", None, 4.0)]);
    result.sim = "water".into();
    assert_eq!(
        study(vec![result]).to_csv(),
        "sim,study,reference,variant,step,size,error,metric,ms_per_sim_second,ns_per_item,pareto\n\
         water,time step,f64 twin,\"a, \"\"b\"\"\",0.5,64,1e-9,relative L2,2.0,0.25,false\n\
         water,time step,f64 twin,\"c\nd\",0.5,64,,relative L2,4.0,0.25,false\n"
    );
}

#[test]
fn a_table_aligns_numbers_to_the_right_and_words_to_the_left() {
    let row = |cells: [&str; 3]| cells.map(str::to_owned).to_vec();
    let rows = [row(["water", "1.5", "4.0×"]), row(["particles", "120", "-"]), row(["−", "1e-3", ""])];
    assert_eq!(
        table(&["sim", "ms", "speedup"], &rows),
        "sim          ms  speedup\n\
         ---------  ----  -------\n\
         water       1.5     4.0×\n\
         particles   120        -\n\
         −          1e-3\n"
    );
}

#[test]
fn a_png_reads_back_as_it_was_written() {
    let dir = tempdir().expect("a temporary directory");
    let rgba = (0..7 * 5).flat_map(|i| [i as u8 * 7, 255 - i as u8, i as u8, 255]).collect();
    let picture = Picture { width: 7, height: 5, rgba };
    let path = dir.path().join("a.png");
    picture.write_png(&path).expect("it is written");
    assert_eq!(Picture::read_png(&path).expect("it is read"), picture);
    assert_eq!(names(&dir), ["a.png"]);
}

#[test]
fn a_picture_whose_bytes_do_not_fit_its_size_is_an_error_that_names_the_file() {
    let dir = tempdir().expect("a temporary directory");
    let picture = Picture { width: 2, height: 2, rgba: vec![0; 4] };
    let error =
        picture.write_png(&dir.path().join("a.png")).expect_err("the buffer is too short").to_string();
    assert!(error.contains("a.png: cannot write it: "), "{error}");
    assert!(names(&dir).is_empty());
}

#[test]
fn a_checkerboard_averages_in_linear_light() {
    let colour = |i: u32| if (i % 8 + i / 8).is_multiple_of(2) { 0 } else { 255 };
    let rgba = (0..64).flat_map(|i| [colour(i), colour(i), colour(i), 255]).collect();
    let small = Picture { width: 8, height: 8, rgba }.downscale(4);
    assert_eq!(small, Picture::filled(4, 4, [188; 3]));
}

#[test]
fn a_plain_picture_keeps_its_colour_at_every_size() {
    let picture = Picture::filled(97, 53, [3, 128, 250]);
    for width in [1, 2, 10, 60, 96, 97, 500] {
        let small = picture.downscale(width);
        let height = (53.0 * f64::from(width.min(97)) / 97.0).round().max(1.0) as u32;
        assert_eq!(small, Picture::filled(width.min(97), height, [3, 128, 250]), "width {width}");
    }
}

#[test]
fn a_contact_sheet_has_thin_margins_and_keeps_the_aspect() {
    let tiles = [
        Picture::filled(64, 32, [255, 0, 0]),
        Picture::filled(64, 32, [0, 255, 0]),
        Picture::filled(32, 32, [0, 0, 255]),
    ];
    let sheet = contact_sheet(&tiles, 2, 32);
    // Two columns of 32 and two rows of 32, the height of the square tile, with 4 between and around them.
    assert_eq!((sheet.width, sheet.height), (3 * 4 + 2 * 32, 3 * 4 + 2 * 32));
    let at = |x: u32, y: u32| &sheet.rgba[4 * (y * sheet.width + x) as usize..][..3];
    assert_eq!(at(4, 4 + 8), [255, 0, 0]);
    assert_eq!(at(4 + 31, 4 + 8 + 15), [255, 0, 0]);
    assert_eq!(at(40, 4 + 8), [0, 255, 0]);
    assert_eq!(at(4, 40), [0, 0, 255]);
    for margin in [(0, 0), (3, 20), (36, 20), (4, 4 + 7), (40, 60), (75, 75)] {
        assert!(at(margin.0, margin.1).iter().all(|&v| v < 40), "{margin:?}");
    }
    assert!(!contact_sheet(&[], 3, 32).rgba.is_empty());
}

/// Frame count, plays, delay, size and the number of frames that can be decoded.
fn animation(path: &Path) -> (u32, u32, (u16, u16), (u32, u32), usize) {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).expect("it is there")))
        .read_info()
        .expect("it is a PNG");
    let control = *reader.info().animation_control().expect("it is animated");
    let mut bytes = vec![0; reader.output_buffer_size().expect("it fits")];
    let mut delay = (0, 0);
    let mut decoded = 0;
    while decoded < control.num_frames as usize {
        reader.next_frame(&mut bytes).expect("the frame decodes");
        let frame = reader.info().frame_control.expect("it is a frame");
        delay = (frame.delay_num, frame.delay_den);
        decoded += 1;
    }
    (control.num_frames, control.num_plays, delay, reader.info().size(), decoded)
}

fn clip(dir: &TempDir, fps: f64, frames: u8) -> Clip {
    let options = ClipOptions { fps, apng_max_width: 32, ffmpeg: None };
    let mut clip = Clip::new(&dir.path().join("clip.v1"), 64, 36, options).expect("it begins");
    for i in 0..frames {
        clip.push(&Picture::filled(64, 36, [i * 20, 100, 255 - i * 20])).expect("it takes a frame");
    }
    clip
}

#[test]
fn a_clip_is_an_animated_png_that_loops_at_the_exact_rate() {
    for (fps, delay) in
        [(60.0, (1, 60)), (30000.0 / 1001.0, (1001, 30000)), (29.97, (100, 2997)), (0.5, (2, 1))]
    {
        let dir = tempdir().expect("a temporary directory");
        let written = clip(&dir, fps, 7).finish().expect("it is written");
        assert_eq!(animation(&written.apng), (7, 0, delay, (32, 18), 7));
        assert_eq!((written.mp4, written.warnings.len()), (None, 0));
        assert_eq!(names(&dir), ["clip.v1.png"]);
        assert_eq!(
            Picture::read_png(&written.apng).expect("it reads"),
            Picture::filled(32, 18, [0, 100, 255])
        );
    }
}

#[test]
fn a_clip_of_one_frame_is_valid_and_one_of_none_is_an_error() {
    let dir = tempdir().expect("a temporary directory");
    let error = clip(&dir, 60.0, 0).finish().expect_err("there is nothing to show").to_string();
    assert!(error.ends_with("clip.v1.png: cannot write it: no frame was drawn"), "{error}");
    assert!(names(&dir).is_empty());
    assert_eq!(animation(&clip(&dir, 60.0, 1).finish().expect("it is written").apng).4, 1);
}

#[test]
fn a_clip_that_is_dropped_leaves_nothing_behind() {
    let dir = tempdir().expect("a temporary directory");
    let unfinished = clip(&dir, 60.0, 3);
    assert_eq!(names(&dir).len(), 1);
    drop(unfinished);
    assert!(names(&dir).is_empty());
}

#[test]
fn a_clip_takes_no_frame_of_another_size_and_no_rate_that_is_none() {
    let dir = tempdir().expect("a temporary directory");
    let error =
        clip(&dir, 60.0, 1).push(&Picture::filled(8, 8, [0; 3])).expect_err("the size differs").to_string();
    assert!(error.ends_with("cannot take a frame of another size: 8x8 into 64x36"), "{error}");
    for fps in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e6] {
        let options = ClipOptions { fps, ffmpeg: None, ..ClipOptions::default() };
        assert!(Clip::new(&dir.path().join("clip"), 8, 8, options).is_err(), "{fps}");
    }
    assert!(names(&dir).is_empty());
}

#[test]
fn a_missing_ffmpeg_is_silent() {
    let dir = tempdir().expect("a temporary directory");
    let options = ClipOptions { ffmpeg: Some(dir.path().join("no-such-program")), ..ClipOptions::default() };
    let mut clip = Clip::new(&dir.path().join("clip"), 8, 8, options).expect("it begins");
    clip.push(&Picture::filled(8, 8, [9; 3])).expect("it takes a frame");
    let written = clip.finish().expect("it is written");
    assert_eq!((written.mp4, written.warnings.len()), (None, 0));
}

#[cfg(unix)]
#[test]
fn an_ffmpeg_that_fails_is_a_warning_with_its_message() {
    let dir = tempdir().expect("a temporary directory");
    // It knows none of ffmpeg's options, says so and fails.
    let options = ClipOptions { ffmpeg: Some("cat".into()), ..ClipOptions::default() };
    let mut clip = Clip::new(&dir.path().join("clip"), 640, 360, options).expect("it begins");
    for _ in 0..8 {
        clip.push(&Picture::filled(640, 360, [9; 3])).expect("it takes a frame");
    }
    let written = clip.finish().expect("the animated PNG is written all the same");
    assert_eq!(written.mp4, None);
    let [warning] = &written.warnings[..] else { panic!("{:?}", written.warnings) };
    assert!(warning.contains("clip.mp4: not written: ffmpeg failed (exit status: 1): "), "{warning}");
    assert!(warning.contains("option"), "{warning}");
    assert_eq!(names(&dir), ["clip.png"]);
}

#[test]
fn where_there_is_an_ffmpeg_an_mp4_of_odd_size_is_written() {
    let runs = std::process::Command::new("ffmpeg").args(["-hide_banner", "-encoders"]).output();
    if !runs.is_ok_and(|o| String::from_utf8_lossy(&o.stdout).contains("libx264")) {
        return eprintln!("not run: there is no ffmpeg with libx264");
    }
    let dir = tempdir().expect("a temporary directory");
    let mut clip = Clip::new(&dir.path().join("clip"), 65, 37, ClipOptions::default()).expect("it begins");
    for i in 0..10 {
        clip.push(&Picture::filled(65, 37, [i * 20, 50, 90])).expect("it takes a frame");
    }
    let written = clip.finish().expect("it is written");
    assert!(written.warnings.is_empty(), "{:?}", written.warnings);
    let mp4 = fs::read(written.mp4.expect("there is an mp4")).expect("it can be read");
    assert_eq!(&mp4[4..8], b"ftyp");
    assert_eq!(names(&dir), ["clip.mp4", "clip.png"]);
}

#[test]
fn a_failed_write_keeps_the_old_file_and_leaves_nothing_behind() {
    let dir = tempdir().expect("a temporary directory");
    let path = dir.path().join("state");
    write_atomic(&path, |file| file.write_all(b"old")).expect("it is written");
    let full = write_atomic(&path, |file| {
        file.write_all(&[0; 100_000])?;
        Err(io::ErrorKind::StorageFull.into())
    });
    let error = full.expect_err("the closure failed").to_string();
    assert_eq!(error, format!("{}: cannot write it: no storage space", path.display()));
    assert_eq!(fs::read(&path).expect("it is still there"), b"old");
    assert_eq!(names(&dir), ["state"]);
    write_atomic(&path, |file| file.write_all(b"new")).expect("it is replaced");
    assert_eq!(fs::read(&path).expect("it is there"), b"new");
    let panicked = std::panic::catch_unwind(|| write_atomic(&path, |_| panic!("on purpose")));
    assert!(panicked.is_err());
    assert_eq!(names(&dir), ["state"]);
}

#[test]
fn a_directory_that_cannot_be_written_is_named_in_the_error() {
    let dir = tempdir().expect("a temporary directory");
    fs::write(dir.path().join("file"), "").expect("it is written");
    // A path through a plain file fails for root as well.
    let path = dir.path().join("file").join("a.png");
    let start = format!("{}: cannot create a file in its directory: ", path.display());
    let error = Picture::filled(1, 1, [0; 3]).write_png(&path).expect_err("it is no directory").to_string();
    assert!(error.starts_with(&start), "{error}");
    let stem = dir.path().join("file").join("a");
    let Err(error) = Clip::new(&stem, 8, 8, ClipOptions::default()) else { panic!("it is no directory") };
    assert!(error.to_string().starts_with(&start), "{error}");
    let error = Picture::read_png(&path).expect_err("it is no directory").to_string();
    assert!(error.contains("a.png: cannot open it: "), "{error}");
}

#[test]
fn a_plot_drops_what_logarithms_cannot_show_and_says_so() {
    let points =
        vec![(1e-3, 2.0), (f64::NAN, 3.0), (1e-2, f64::INFINITY), (0.0, 1.0), (1e-1, -4.0), (1e-1, 8.0)];
    let mark = |at| Mark { at, detail: String::new(), is_joined: true, is_pareto: at == (1e-3, 2.0) };
    let curve = Curve { name: "<a & b>".into(), marks: points.into_iter().map(mark).collect() };
    let svg = log_log("Error & cost", "error", "ms", &[curve]);
    assert!(svg.contains("4 points are not shown: not finite or not positive."));
    assert!(svg.contains("10⁻³") && svg.contains("10⁻¹"));
    assert!(svg.contains("Error &amp; cost") && svg.contains("&lt;a &amp; b&gt;"));
    assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    // Two points and the legend's.
    assert_eq!(svg.matches(r#"class="marker""#).count(), 3);
    assert!(!log_log("t", "x", "y", &[]).contains("NaN"));
}

#[test]
fn a_page_is_complete_in_itself() {
    let mut result =
        result(vec![point("seed<1>", Some(0.1), 2.0), point("b", None, 4.0), point("b", Some(0.01), 1.0)]);
    result.mark_pareto();
    result.cheapest = result.cheapest_for(&[0.5, 1e-6], "seed");
    let panels = panels(&result);
    let curves = panels[0].curves.iter().map(|c| (&*c.name, c.marks.len())).collect::<Vec<_>>();
    assert_eq!((panels.len(), curves), (1, vec![("seed<1>", 1), ("b", 2)]));
    let svg = plot::panels("t", "x", "y", &panels);
    let mut study = study(vec![result]);
    study.headlines = vec![headline()];
    study.parts = vec![parts()];
    let html = page(&study, "Work and precision", "2026-01-31", std::slice::from_ref(&svg));
    assert!(html.contains("100 times") && html.contains("from a &amp; b") && html.contains("Truncation"));
    assert!(html.contains(&svg) && html.contains("2026-01-31") && html.contains("not finite"));
    assert!(html.contains("seed&lt;1&gt;") && !html.contains("seed<1>"));
    assert!(html.contains("2.00×") && html.contains("none is this accurate"));
    let elsewhere = html.replace("http://www.w3.org/2000/svg", "");
    assert!(!elsewhere.contains("http") && !elsewhere.contains("<script") && !elsewhere.contains("src="));
}

/// Draws the committed studies again with today's plots: `UPDATE_RESULTS=1 cargo test --test output results`.
#[test]
fn committed_results_have_todays_shapes() {
    for dir in std::fs::read_dir("docs/results").unwrap().flatten().map(|entry| entry.path()) {
        let read = |name: &str| std::fs::read_to_string(dir.join(name)).unwrap_or_default();
        let study: Study = match read("study.json") {
            text if text.is_empty() => continue,
            text => serde_json::from_str(&text).unwrap(),
        };
        assert!(study.studies.iter().all(|study| study.points.len() >= 10), "{}", dir.display());
        let bench: Bench = serde_json::from_str(&read("bench.json")).unwrap();
        assert!(bench.copy_bytes_per_s > 0.0 && bench.results.len() > 10);
        let cases: HardCases = serde_json::from_str(&read("hardcases.json")).unwrap();
        assert!(cases.cases.iter().all(|case| case.pass), "{}", dir.display());
        if std::env::var_os("UPDATE_RESULTS").is_some() {
            whitecap::study::write_report(&study, &dir, "2026-11-24").unwrap();
        }
    }
}

/// A study as it is written, and a scene whose rules think otherwise than the device that the study is of.
#[test]
fn a_measured_table_chooses_again_by_its_own_costs() {
    let with = |tolerance: f64, walls: &str| {
        let text = format!(
            "output = {{ size = [16, 16], fps = 1, frames = 20 }}\n[[water]]\nname = 'hill'\ncells = [128, 128]\n\
             size_m = [10, 10]\ndepth_m = 1\ngravity_mps2 = 1\ndamping_per_s = 0\ntolerance = {tolerance}\n\
             start = {{ shape = 'hump', height_m = 1e-6, radius_m = 0.5 }}\n{walls}"
        );
        Scene::parse(&text, "hill", None, &[]).unwrap()
    };
    let scene = |tolerance: f64| with(tolerance, "");
    let row = |variant: &str, size: u32, error: f64, ns: f64| Point {
        size,
        ns_per_item: ns,
        ms_per_sim_second: ns,
        ..point(variant, Some(error), 1.0)
    };
    let mut linear = result(vec![
        row("waves/w0", 64, 0.1, 90.0),
        row("waves/w0", 128, 0.03, 40.0),
        row("waves/fused/w0", 128, 0.03, 30.0),
        row("waves/w0.25", 128, 0.02, 50.0),
        row("waves/fourth", 128, 0.0003, 20.0),
    ]);
    linear.study = "linear".into();
    let dir = tempdir().expect("a temporary directory");
    let path = dir.path().join("study.json");
    fs::write(&path, serde_json::to_string(&study(vec![linear])).unwrap()).unwrap();
    let measured = Measured::read(&path).unwrap();
    assert_eq!(measured.device, "D");
    let cheapest = |tolerance| measured.cheapest("water", "linear", tolerance).map(|p| p.variant.as_str());
    assert_eq!([0.05, 0.0001].map(cheapest), [Some("waves/fourth"), None]);
    assert_eq!(measured.cheapest("particles", "linear", 1.0), None);
    assert_eq!(measured.ns_per_column("waves/w0", 60 * 60), Some(90.0));
    assert_eq!(measured.ns_per_column("waves/w0", 4096 * 4096), Some(40.0));

    // The rules take fused waves of second order, at the costs of an H100; here the fourth order costs less.
    let wide = scene(0.1);
    assert!(wide.water[0].choice.taken().name.starts_with("waves/w"));
    let refined = measured.refine(&wide);
    assert_eq!((refined.len(), refined[0].variant.as_str(), refined[0].is_taken), (1, "waves/fourth", false));
    assert!(refined[0].unmeasured.iter().any(|name| name == "waves/w1"), "{refined:?}");
    // Where only the fourth order is accurate enough both take it.
    let narrow = measured.refine(&scene(0.001));
    assert_eq!((narrow[0].variant.as_str(), narrow[0].is_taken), ("waves/fourth", true));
    // Studies are of open water: among walls the same kernel takes several times as long.
    let walled = measured.refine(&with(0.1, "[[water.wall]]\nfrom_m = [0, 1]\nto_m = [3, 2]\n"));
    assert!(walled[0].ns_per_column_second > 2.0 * refined[0].ns_per_column_second, "{walled:?}");
    // A scene without a tolerance has nothing to choose by cost.
    assert_eq!(measured.refine(&whitecap::scene::builtin::load("fjord", &[]).unwrap()), []);

    fs::write(&path, "{}").unwrap();
    let error = Measured::read(&path).unwrap_err().to_string();
    assert!(error.contains("study.json: not a study.json: missing field `device`"), "{error}");
}
