// SPDX-License-Identifier: MIT OR Apache-2.0
//! `whitecap run --trace`: what is written is the Trace Event Format, and says what `stats.json` says.
#![cfg(feature = "tools")]
#![allow(missing_docs)]

use serde_json::{json, Value};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
    process::{Command, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

fn whitecap(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitecap"));
    command.args(args).env("XDG_CACHE_HOME", std::env::temp_dir().join("whitecap-tests"));
    command
}

/// Runs a scene in small; events of the trace, and `stats.json`.
fn run(scene: &str, more: &[&str]) -> (Vec<Value>, Value) {
    let dir = tempfile::tempdir().unwrap();
    let (out, trace) = (dir.path().join("out"), dir.path().join("trace.json"));
    let [out, file] = [&out, &trace].map(|path| path.to_str().unwrap());
    let mut args =
        vec!["run", scene, "--frames", "4", "--size", "64x48", "--out", out, "--no-frames", "--json"];
    args.extend(["--trace", file]);
    args.extend(more);
    let output = whitecap(&args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    let events = serde_json::from_slice(&fs::read(&trace).unwrap()).expect("a whole array");
    (events, serde_json::from_slice(&output.stdout).expect("stats.json"))
}

/// Microseconds in the file as nanoseconds: the format's unit, and the grain of this writer.
fn ns(value: &Value) -> Result<i64, String> {
    let us = value.as_f64().filter(|us| us.is_finite() && *us >= 0.0).ok_or(format!("{value} is no time"))?;
    let ns = us * 1e3;
    if (ns - ns.round()).abs() > 1e-3 {
        return Err(format!("{us} us has more than three decimals"));
    }
    Ok(ns.round() as i64)
}

/// Begin and end of every complete event, by track.
type Tracks = BTreeMap<(u64, u64), Vec<(i64, i64, String)>>;

/// The Trace Event Format, as far as this writer uses it.
fn check(events: &[Value]) -> Result<Tracks, String> {
    let mut tracks = Tracks::new();
    let (mut processes, mut threads) = (BTreeSet::new(), BTreeSet::new());
    for event in events {
        let wrong = |what: &str| format!("{what}: {event}");
        let number = |key: &str| event[key].as_u64().ok_or_else(|| wrong(key));
        let name = event["name"].as_str().filter(|name| !name.is_empty()).ok_or_else(|| wrong("name"))?;
        let args = event["args"].as_object().ok_or_else(|| wrong("args"))?;
        let pid = number("pid")?;
        match event["ph"].as_str() {
            Some("X") => {
                let (begin, length) = (ns(&event["ts"])?, ns(&event["dur"])?);
                event["cat"].as_str().ok_or_else(|| wrong("cat"))?;
                let track = tracks.entry((pid, number("tid")?)).or_default();
                track.push((begin, begin + length, name.to_string()));
            }
            Some("C") => {
                ns(&event["ts"])?;
                if args.is_empty() || !args.values().all(Value::is_number) {
                    return Err(wrong("a counter of no numbers"));
                }
            }
            Some("i") => {
                ns(&event["ts"])?;
                event["s"].as_str().filter(|s| ["g", "p", "t"].contains(s)).ok_or_else(|| wrong("scope"))?;
            }
            Some("M") => {
                args["name"].as_str().ok_or_else(|| wrong("a name"))?;
                match name {
                    "process_name" => processes.insert(pid),
                    "thread_name" => threads.insert((pid, number("tid")?)),
                    _ => return Err(wrong("metadata")),
                };
            }
            _ => return Err(wrong("phase")),
        }
    }
    for (track, spans) in &mut tracks {
        if !processes.contains(&track.0) || !threads.contains(track) {
            return Err(format!("track {track:?} has no name"));
        }
        nest(spans)?;
    }
    Ok(tracks)
}

/// Of two spans of a track, one holds the other, or they are apart.
fn nest(spans: &mut [(i64, i64, String)]) -> Result<(), String> {
    // What begins first comes first, and of those the longest.
    spans.sort_by_key(|(begin, end, _)| (*begin, -*end));
    let mut open: Vec<&(i64, i64, String)> = Vec::new();
    for span in spans.iter() {
        open.retain(|outer| outer.1 > span.0);
        if let Some(outer) = open.last().filter(|outer| outer.1 < span.1) {
            return Err(format!("{span:?} begins within {outer:?} and ends after it"));
        }
        open.push(span);
    }
    Ok(())
}

fn of_queue(tracks: &Tracks) -> &[(i64, i64, String)] {
    &tracks[&(2, 1)]
}

fn whole<'a>(events: &'a [Value], prefix: &'a str) -> impl Iterator<Item = &'a Value> {
    events.iter().filter(move |it| it["ph"] == "X" && it["name"].as_str().unwrap().starts_with(prefix))
}

/// The last value that a counter has.
fn last(events: &[Value], name: &str, key: &str) -> f64 {
    let values = events.iter().filter(|it| it["ph"] == "C" && it["name"] == name).map(|it| &it["args"][key]);
    values.filter_map(Value::as_f64).next_back().unwrap_or_else(|| panic!("no counter {name}.{key}"))
}

/// The trace and `stats.json` have the same passes, as often, and in all as long.
fn compare(tracks: &Tracks, stats: &Value) {
    let mut totals: BTreeMap<&str, (u64, i64)> = BTreeMap::new();
    for (begin, end, name) in of_queue(tracks) {
        let total = totals.entry(name).or_default();
        *total = (total.0 + 1, total.1 + end - begin);
    }
    let passes = stats["passes"].as_array().unwrap();
    assert_eq!(passes.len(), totals.len(), "{totals:?}");
    for pass in passes {
        let (runs, total_ns) = totals[pass["name"].as_str().unwrap()];
        assert_eq!(pass["runs"], runs, "{pass}");
        let missed_ns = (pass["total_ms"].as_f64().unwrap() * 1e6 - total_ns as f64).abs();
        assert!(missed_ns <= runs as f64 + 1.0, "{pass}: {missed_ns} ns apart");
        // a nanosecond is cut off each
    }
    assert!(stats.get("untimed").is_none(), "a traced run times all passes");
}

#[test]
fn a_trace_has_every_pass_of_the_statistics() {
    let (events, stats) = run("fjord", &["--pass-statistics"]);
    let tracks = check(&events).unwrap();
    compare(&tracks, &stats);

    let host: BTreeSet<_> = tracks[&(1, 1)].iter().map(|(_, _, name)| name.as_str()).collect();
    for name in
        ["parse", "plan", "open the device", "build", "picture 0", "picture 3", "record", "submit", "wait"]
    {
        assert!(host.contains(name), "{name}: {host:?}");
    }
    assert!(host.contains("read back") && host.contains("count"), "{host:?}");
    assert_eq!(tracks[&(1, 2)].len(), 4, "one `encode` a picture");

    let about = events.iter().find(|it| it["name"] == "about").unwrap();
    for key in ["device", "driver", "clock", "version"] {
        assert_eq!(about["args"][key], stats[key], "{key}");
    }
    // The last picture's counters are the end's.
    let water = &stats["waters"][0];
    let name = format!("water {}", water["name"].as_str().unwrap());
    assert_eq!(last(&events, &name, "volume_gain_m3"), water["volume_gain_m3"].as_f64().unwrap());
    assert_eq!(last(&events, &name, "lost_s"), water["lost_s"].as_f64().unwrap());

    let counted = stats["passes"].as_array().unwrap().iter().any(|it| it.get("statistics").is_some());
    if !counted {
        println!("SKIP: no pipeline statistics: {}", stats["warnings"]);
        return;
    }
    for pass in stats["passes"].as_array().unwrap() {
        for (counter, total) in pass["statistics"].as_object().unwrap() {
            let of_pass = whole(&events, pass["name"].as_str().unwrap());
            let sum: u64 = of_pass.filter_map(|it| it["args"][counter].as_u64()).sum();
            assert_eq!(*total, sum, "{pass}, {counter}");
        }
    }
    let tonemap = stats["passes"].as_array().unwrap().iter().find(|it| it["name"] == "draw.tonemap").unwrap();
    assert_eq!(
        tonemap["statistics"]["compute_invocations"],
        4 * 64 * 48,
        "one a pixel and picture: {tonemap}"
    );
}

#[test]
fn particles_are_counted_picture_by_picture() {
    let (events, stats) = run("campfire", &["--validate"]);
    compare(&check(&events).unwrap(), &stats);
    let emitters = stats["emitters"].as_array().unwrap();
    assert!(!emitters.is_empty());
    for it in emitters {
        let name = format!("particles {}", it["name"].as_str().unwrap());
        for key in ["alive", "born", "dropped"] {
            assert_eq!(last(&events, &name, key), it[key].as_f64().unwrap(), "{name}.{key}");
        }
    }
}

#[test]
fn passes_by_the_clock_of_the_device_lie_within_their_picture() {
    let (events, stats) = run("sombrero", &["--clock", "gpu"]);
    assert_eq!(stats["clock"], "gpu");
    let tracks = check(&events).unwrap();
    compare(&tracks, &stats);
    let device = whitecap_devices();
    let is_calibrated = device["optional"]["calibrated timestamps"] == true;
    for picture in whole(&events, "picture ") {
        let placed = picture["args"]["placed"].as_str().unwrap();
        assert_eq!(placed, if is_calibrated { "calibrated" } else { "end of submission" }, "{picture}");
        let off = picture["args"]["within_ns"].as_i64().unwrap_or(0);
        let begin = ns(&picture["ts"]).unwrap() - off;
        let end = begin + ns(&picture["dur"]).unwrap() + 2 * off;
        let number: u64 = picture["name"].as_str().unwrap()["picture ".len()..].parse().unwrap();
        let passes = events.iter().filter(|it| it["cat"] == "gpu" && it["args"]["picture"] == number);
        let mut count = 0;
        for pass in passes {
            let at = ns(&pass["ts"]).unwrap();
            assert!(begin <= at && at + ns(&pass["dur"]).unwrap() <= end, "{pass} outside {picture}");
            count += 1;
        }
        assert!(count > 0, "{picture}");
    }
    let mut named = events.iter().filter(|it| it["ph"] == "M" && it["pid"] == 2 && it["tid"] == 1);
    assert!(named.next_back().unwrap()["args"]["name"].as_str().unwrap().contains("placed by"));
}

fn whitecap_devices() -> Value {
    let output = whitecap(&["devices", "--json"]).output().unwrap();
    let devices: Value = serde_json::from_slice(&output.stdout).unwrap();
    devices[0].clone()
}

#[test]
fn a_run_that_is_killed_leaves_a_trace_that_opens() {
    let dir = tempfile::tempdir().unwrap();
    let trace = dir.path().join("trace.json");
    let [out, file] = [dir.path(), &trace].map(|path| path.to_str().unwrap());
    let args = ["run", "sombrero", "--frames", "100000", "--size", "64x48", "--no-frames", "--out", out];
    let mut child =
        whitecap(&args).args(["--trace", file]).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let start = Instant::now();
    while fs::read_to_string(&trace).map_or(0, |text| text.matches("\"picture ").count()) < 3 {
        assert!(start.elapsed() < Duration::from_secs(120), "no picture in two minutes");
        sleep(Duration::from_millis(20));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let text = fs::read_to_string(&trace).unwrap();
    assert!(serde_json::from_str::<Value>(&text).is_err(), "it was killed too late");
    // Readers of the format supply the bracket.
    let events: Vec<Value> = serde_json::from_str(&format!("{text}]")).expect("whole lines");
    assert!(of_queue(&check(&events).unwrap()).len() >= 3);
}

#[test]
fn a_trace_that_cannot_be_written_ends_the_run() {
    let output = whitecap(&["run", "sombrero", "--trace", "/nowhere/trace.json"]).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("/nowhere/trace.json") && said.contains("make the trace"), "{said}");
    assert!(!Path::new("/nowhere").exists());
}

#[test]
fn the_check_sees_what_is_wrong() {
    let named =
        |tid: u64| json!({"ph": "M", "pid": 1, "tid": tid, "name": "thread_name", "args": {"name": "t"}});
    let process = json!({"ph": "M", "pid": 1, "tid": 0, "name": "process_name", "args": {"name": "p"}});
    let span = |ts: f64, dur: f64| json!({"ph": "X", "cat": "c", "pid": 1, "tid": 1, "ts": ts, "dur": dur, "name": "s", "args": {}});
    let of = |events: &[Value]| {
        let all = [&[process.clone(), named(1)], events].concat();
        check(&all)
    };
    of(&[span(0.0, 10.0), span(2.0, 3.0), span(5.0, 5.0), span(10.0, 1.0)]).unwrap();
    let crossing = of(&[span(0.0, 10.0), span(5.0, 6.0)]).unwrap_err();
    assert!(crossing.contains("ends after it"), "{crossing}");
    assert!(of(&[span(0.0, -1.0)]).is_err());
    assert!(of(&[span(0.0, 0.0001)]).is_err());
    assert!(check(&[span(0.0, 1.0)]).unwrap_err().contains("has no name"));
    let mut no_length = span(0.0, 1.0);
    no_length.as_object_mut().unwrap().remove("dur");
    assert!(of(&[no_length]).is_err());
    let counter = |args: Value| json!({"ph": "C", "pid": 1, "ts": 0.0, "name": "n", "args": args});
    of(&[counter(json!({"a": 1}))]).unwrap();
    assert!(of(&[counter(json!({"a": "1"}))]).is_err());
    assert!(of(&[counter(json!({}))]).is_err());
    assert!(of(&[json!({"ph": "B", "pid": 1, "name": "n", "args": {}})]).is_err());
}
