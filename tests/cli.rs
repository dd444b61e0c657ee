// SPDX-License-Identifier: MIT OR Apache-2.0
//! The command-line tool as a user meets it: what it prints, what it writes, how it ends.
#![allow(missing_docs)]

use serde_json::Value;
use std::{
    collections::BTreeSet,
    fs,
    path::Path,
    process::{Command, Output},
};

fn whitecap(args: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitecap"));
    // Help is wrapped to the terminal; caches belong to the user.
    command
        .args(args)
        .env("COLUMNS", "100")
        .env("XDG_CACHE_HOME", std::env::temp_dir().join("whitecap-tests"));
    command.env_remove("WHITECAP_DEVICE").output().expect("the tool starts")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[track_caller]
fn ok(args: &[&str]) -> String {
    let output = whitecap(args);
    assert!(output.status.success(), "{args:?}: {}", text(&output.stderr));
    text(&output.stdout)
}

/// Exit code and what standard error says.
#[track_caller]
fn fails(args: &[&str]) -> (i32, String) {
    let output = whitecap(args);
    let code = output.status.code().expect("an exit code");
    assert_ne!(code, 0, "{args:?} succeeds");
    (code, text(&output.stderr))
}

#[track_caller]
fn json(args: &[&str]) -> Value {
    serde_json::from_str(&ok(args)).expect("JSON")
}

fn keys(value: &Value) -> Vec<&str> {
    value.as_object().expect("an object").keys().map(String::as_str).collect()
}

#[test]
fn help_is_as_it_was() {
    for command in ["", "run", "view", "check", "scenes", "devices", "hardcases", "bench", "study"] {
        let args: Vec<_> = [command, "--help"].into_iter().filter(|arg| !arg.is_empty()).collect();
        let name = if command.is_empty() { "help".into() } else { format!("help-{command}") };
        insta::assert_snapshot!(name, ok(&args));
    }
}

#[test]
fn a_scene_is_explained_without_a_device() {
    insta::assert_snapshot!(ok(&["check", "fjord"]));
    insta::assert_snapshot!(ok(&["check", "sombrero", "--set", "water.0.dt_s=0.1"]));
    insta::assert_snapshot!(ok(&["check", "puddles"]));
    let checked = json(&["check", "fjord", "--json"]);
    assert_eq!(keys(&checked), ["buffers", "bytes", "emitters", "passes", "scene", "warnings", "waters"]);
    assert_eq!(checked["waters"][0]["has_land"], true);
}

#[test]
fn what_a_scene_does_not_name_costs_nothing() {
    let passes = |args: &[&str]| {
        let checked = json(args);
        checked["passes"].as_array().unwrap().iter().map(|p| p["name"].to_string()).collect::<String>()
    };
    let calm = ["check", "sombrero", "--json"];
    assert!(!passes(&calm).contains("disturb"));
    assert!(passes(&["check", "fjord", "--json"]).contains("water.disturb"));
    let buffers = json(&calm)["buffers"].to_string();
    assert!(!buffers.contains("disturbance"), "{buffers}");
}

#[test]
fn scenes_are_listed_and_printed_to_start_from() {
    insta::assert_snapshot!(ok(&["scenes"]));
    let dir = tempfile::tempdir().unwrap();
    for scene in json(&["scenes", "--json"]).as_array().unwrap() {
        let path = dir.path().join("copy.toml");
        fs::write(&path, ok(&["scenes", scene["name"].as_str().unwrap()])).unwrap();
        ok(&["check", path.to_str().unwrap()]);
    }
}

#[test]
fn mistakes_are_named_with_what_is_allowed() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("bad.toml");
    fs::write(
        &path,
        "[output]\nfps = 0\n[[water]]\nmodel = \"waves\"\ncells = [64, 0]\nsize_m = [8, 8]\ndepth_m = 2\ngravty = 1\n",
    )
    .unwrap();
    let (code, said) = fails(&["check", path.to_str().unwrap()]);
    assert_eq!(code, 2);
    insta::assert_snapshot!(said.replace(dir.path().to_str().unwrap(), "DIR"));

    let (code, said) = fails(&["run", "fjord", "--dt", "0.2"]);
    assert_eq!(code, 2);
    insta::assert_snapshot!(said);
    for (args, part) in [
        (&["run", "nosuch"] as &[&str], "no built-in scene is called \"nosuch\"; there are: fjord"),
        (&["run", "nosuch.toml"], "nosuch.toml"),
        (&["run", "--size", "12"], "not WIDTHxHEIGHT"),
        (&["run", "--seed", "x"], "neither a whole number nor `random`"),
        (&["run", "--set", "output.frames"], "--set"),
        (&["run", "--frames", "0"], "output.frames is 0; allowed: 1 to 1000000"),
        (&["hardcases", "Q9"], "no hard case `Q9`; there are W1,"),
        (&["bench", "nothing"], "no bench `nothing`; there are system/copy/kernel"),
        (&["run", "--device", "no such device"], "no device `no such device`"),
    ] {
        let (code, said) = fails(args);
        assert_eq!(code, 2, "{args:?}: {said}");
        assert!(said.contains(part), "{args:?}: {said}");
    }
}

#[test]
fn a_machine_without_vulkan_is_exit_code_3() {
    let output = Command::new(env!("CARGO_BIN_EXE_whitecap"))
        .args(["run", "--frames", "1"])
        .env("VK_DRIVER_FILES", "/nowhere.json")
        .env("VK_ICD_FILENAMES", "/nowhere.json")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", text(&output.stderr));
}

fn small_run(dir: &Path, more: &[&str]) -> Value {
    let out = dir.to_str().unwrap();
    let mut args = vec![
        "run",
        "fjord",
        "--set",
        "output.frames=4",
        "--size",
        "64x48",
        "--out",
        out,
        "--json",
        "--hash-every",
        "2",
    ];
    args.extend(more);
    if std::env::var("WHITECAP_TEST_PASS").as_deref() != Ok("swiftshader") {
        args.push("--validate");
    }
    json(&args)
}

#[test]
fn a_run_writes_pictures_a_sheet_a_clip_and_statistics() {
    let dir = tempfile::tempdir().unwrap();
    let stats = small_run(dir.path(), &[]);
    for file in ["contact.png", "clip.png", "stats.json", "frames/frame_00000.png", "frames/frame_00003.png"]
    {
        assert!(dir.path().join(file).is_file(), "{file}");
    }
    let written: Value = serde_json::from_slice(&fs::read(dir.path().join("stats.json")).unwrap()).unwrap();
    assert_eq!(written, stats);
    assert_eq!(
        keys(&stats),
        [
            "clock",
            "device",
            "driver",
            "frames",
            "hashes",
            "passes",
            "scene",
            "seed",
            "simulated_s",
            "version",
            "wall_s",
            "warnings",
            "waters"
        ]
    );
    let passes: BTreeSet<_> =
        stats["passes"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert!(passes.contains("water.fused") && passes.contains("draw.scene"), "{passes:?}");
    let lake = &stats["waters"][0];
    assert_eq!(lake["steps"], 3);
    assert!(lake["disturbances_rejected"] == 0 && lake["disturbances_dropped"] == 0);
    // The picture is of water under a sky: not one colour.
    let picture =
        whitecap::run::picture::Picture::read_png(&dir.path().join("frames/frame_00003.png")).unwrap();
    let colors: BTreeSet<_> = picture.rgba.chunks_exact(4).map(<[u8]>::to_vec).collect();
    assert!(colors.len() > 500, "{} colours", colors.len());
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_seed_others() {
    let dir = tempfile::tempdir().unwrap();
    let hash = |more: &[&str]| {
        let stats = small_run(dir.path(), more);
        (stats["hashes"].clone(), stats["waters"][0]["state_hash"].clone())
    };
    let first = hash(&["--no-frames"]);
    assert_eq!(first, hash(&["--no-frames"]));
    assert_ne!(first.1, hash(&["--no-frames", "--seed", "2"]).1);
    // A value that is set to what it is changes nothing.
    assert_eq!(first.1, hash(&["--no-frames", "--set", "output.fps=30"]).1);
}

#[test]
fn a_run_that_is_resumed_is_the_run_that_never_stopped() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("state.bin");
    let state = file.to_str().unwrap();
    let end = |stats: Value| stats["waters"][0]["state_hash"].clone();
    let whole = end(small_run(dir.path(), &["--set", "output.frames=9"]));
    small_run(dir.path(), &["--checkpoint", state]); // pictures 0 to 3
    assert_eq!(end(small_run(dir.path(), &["--set", "output.frames=9", "--resume", state])), whole);

    let out = dir.path().to_str().unwrap();
    let resume = |more: &[&str]| {
        let args = ["run", "fjord", "--size", "64x48", "--out", out, "--resume", state];
        fails(&args.iter().chain(more).copied().collect::<Vec<_>>())
    };
    let (code, said) = resume(&["--seed", "7"]);
    assert!(code == 2 && said.contains("of another scene"), "{said}");
    assert!(resume(&["--frames", "4"]).1.contains("its 4 pictures are all that the scene asks for"));
    let mut bytes = fs::read(&file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&file, &bytes).unwrap();
    assert!(resume(&[]).1.contains("its checksum does not fit"));
    fs::write(&file, &bytes[..7]).unwrap();
    assert!(resume(&[]).1.contains("it is too short"));
    fs::write(&file, b"some other file of some length").unwrap();
    assert!(resume(&[]).1.contains("it begins with something else"));
}

#[test]
fn a_folder_that_cannot_be_written_ends_the_run() {
    let dir = tempfile::tempdir().unwrap();
    let blocked = dir.path().join("file");
    fs::write(&blocked, "in the way").unwrap();
    let (code, said) =
        fails(&["run", "pond", "--frames", "1", "--size", "32x32", "--out", blocked.to_str().unwrap()]);
    assert_eq!(code, 2);
    assert!(said.contains("file") && said.contains("make the folder"), "{said}");
}

#[test]
fn devices_are_listed_with_what_they_lack() {
    let devices = json(&["devices", "--json"]);
    let device = &devices[0];
    for key in ["index", "name", "uuid", "driver", "api", "kind", "missing", "optional", "paths"] {
        assert!(device.get(key).is_some(), "{key}");
    }
    assert!(ok(&["devices"]).contains(device["uuid"].as_str().unwrap()));
}

#[test]
fn measurements_have_their_stable_shapes() {
    let cases = json(&["hardcases", "W5", "--json"]);
    assert_eq!(keys(&cases), ["cases", "clock", "device", "driver"]);
    assert_eq!(
        keys(&cases["cases"][0]),
        ["id", "limit", "measured", "note", "pass", "seed_measured", "title", "unit", "variant"]
    );
    let bench = json(&["bench", "waves/w1", "--sizes", "64", "--budget", "0.02", "--json"]);
    assert_eq!(keys(&bench), ["clock", "copy_bytes_per_s", "device", "driver", "results", "skipped"]);
    let row = &bench["results"][0];
    assert_eq!(
        (&row["sim"], &row["variant"], &row["size"]),
        (&"water".into(), &"waves/w1".into(), &"64x64".into())
    );
    for key in [
        "items_per_s",
        "unit",
        "bytes_per_item",
        "fraction_of_copy",
        "median_ms",
        "ms_per_sim_second",
        "runs",
    ] {
        assert!(row.get(key).is_some(), "{key}");
    }
}

#[test]
fn edited_shaders_are_what_is_measured() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path().join("glsl");
    let row = ["bench", "particles/ring", "--sizes", "4096", "--budget", "0.01", "--glsl"];
    let with = |folder: &Path| [&row[..], &[folder.to_str().unwrap()]].concat().join("\n");
    let run = |folder: &Path| fails(&with(folder).split('\n').collect::<Vec<_>>());
    let (code, said) = run(&folder);
    assert!(code == 2 && said.contains("no folder of GLSL"), "{said}");
    fs::create_dir_all(folder.join("particles")).unwrap();
    let (code, said) = run(&folder);
    assert!(code == 2 && said.contains("none of this crate's shaders is below it"), "{said}");
    for module in ["common", "particles", "prims"] {
        fs::create_dir_all(folder.join(module)).unwrap();
        for file in fs::read_dir(Path::new("glsl").join(module)).unwrap() {
            let file = file.unwrap().path();
            fs::copy(&file, folder.join(module).join(file.file_name().unwrap())).unwrap();
        }
    }
    // Another law than the twin's is found out; one that does not compile is named with its line.
    let drag = folder.join("particles/drag.glsl");
    let whole = fs::read_to_string(&drag).unwrap();
    fs::write(&drag, whole.replace("it.at_m = at;", "it.at_m = at + dt_s;")).unwrap();
    let (code, said) = run(&folder);
    assert!(code == 1 && said.contains("particles.drag.comp") && said.contains("from its twin"), "{said}");
    fs::write(&drag, whole.replace("it.at_m = at;", "it.at_m = nowhere;")).unwrap();
    let (code, said) = run(&folder);
    assert!(code == 2 && said.contains("drag.glsl:37") && said.contains("nowhere"), "{said}");
    let (code, said) = fails(&["devices", "--glsl", "glsl"]);
    assert!(code == 2 && said.contains("--pipelines"), "{said}");
}
