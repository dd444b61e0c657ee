// SPDX-License-Identifier: MIT OR Apache-2.0
//! `whitecap run --renderdoc-frame`: a capture of RenderDoc's, replayed, has every pass under its label. It takes Debian's
//! `renderdoccmd` and `python3-renderdoc`, or the like.
#![cfg(feature = "tools")]
#![allow(missing_docs)]

use serde_json::Value;
use std::{
    fs,
    path::Path,
    process::{Command, Output},
};

fn run(args: &[&str], watched: bool) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_whitecap"));
    command.args(args).env("XDG_CACHE_HOME", std::env::temp_dir().join("whitecap-tests"));
    command.env_remove("ENABLE_VULKAN_RENDERDOC_CAPTURE");
    if watched {
        command.env("ENABLE_VULKAN_RENDERDOC_CAPTURE", "1");
    }
    command.output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Whether there is a RenderDoc here that has to see the run: its program, or its layer where loaders look for it.
fn is_installed() -> bool {
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let has_program = std::env::split_paths(&paths).any(|dir| dir.join("renderdoccmd").exists());
    has_program
        || ["/usr/share", "/usr/local/share", "/etc"]
            .iter()
            .any(|root| Path::new(root).join("vulkan/implicit_layer.d/renderdoc_capture.json").exists())
}

/// What a capture has in it, or why it cannot be replayed here.
fn replay(file: &str) -> Result<Value, String> {
    let mut said = String::new();
    for python in ["/usr/bin/python3", "python3"] {
        let once = || Command::new(python).args(["tests/renderdoc/replay.py", file]).output();
        // RenderDoc 1.24 now and then ends without a word, of captures that it replays the next time.
        let mut tries = (0..3).map_while(|_| once().ok());
        let Some(mut output) = tries.next() else { continue };
        while !output.status.success() && output.stderr.is_empty() {
            println!("the replay died: {}", output.status);
            output = tries.next().expect("a replay that says something");
        }
        if output.status.success() {
            return Ok(serde_json::from_slice(&output.stdout).expect("JSON of the replay"));
        }
        said = text(&output.stderr);
        assert!(said.contains("No module named 'renderdoc'"), "the replay failed, {}: {said}", output.status);
    }
    Err(said)
}

#[test]
fn a_capture_has_every_pass_under_its_label() {
    let dir = tempfile::tempdir().unwrap();
    let (out, trace) = (dir.path().join("out"), dir.path().join("trace.json"));
    let [folder, file] = [&out, &trace].map(|path| path.to_str().unwrap());
    let mut args = vec!["run", "fjord", "--frames", "3", "--size", "64x48", "--no-frames", "--json"];
    args.extend(["--out", folder, "--trace", file, "--renderdoc-frame", "1"]);
    let output = run(&args, true);
    if output.status.code() == Some(3) && !is_installed() {
        return println!("SKIP: RenderDoc is not installed: {}", text(&output.stderr));
    }
    assert!(output.status.success(), "{}", text(&output.stderr));
    let stats: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(stats["warnings"].as_array().unwrap().len(), 0, "{stats}");
    let names = fs::read_dir(&out).unwrap().flatten().map(|entry| entry.path());
    let capture = names.filter(|path| path.extension().is_some_and(|it| it == "rdc")).collect::<Vec<_>>();
    assert_eq!(capture.len(), 1, "{capture:?}");
    let capture = match replay(capture[0].to_str().unwrap()) {
        Ok(capture) => capture,
        Err(why) => return println!("SKIP: the capture cannot be replayed: {why}"),
    };

    // The trace of the same run says which passes picture 1 has, in order.
    let events: Vec<Value> = serde_json::from_slice(&fs::read(&trace).unwrap()).unwrap();
    let of_picture = events.iter().filter(|it| it["cat"] == "gpu" && it["args"]["picture"] == 1);
    let wanted: Vec<_> = of_picture.map(|it| it["name"].clone()).collect();
    let passes = capture["passes"].as_array().unwrap();
    let found: Vec<_> = passes.iter().map(|it| it["name"].clone()).collect();
    assert!(wanted.len() >= 5, "{wanted:?}");
    assert_eq!(found, wanted);
    assert!(passes.iter().all(|it| it["inside"] == serde_json::json!(["picture 1"])), "{capture}");
    assert_eq!(capture["outside"], serde_json::json!([]), "nothing runs outside a label");

    // What each is known to record: `water.fused` has one dispatch for open tiles and one for those with a shore, and the
    // scene is sky, terrain and water.
    let counts = |name: &str| {
        let pass = passes.iter().find(|it| it["name"] == name).unwrap_or_else(|| panic!("no {name}"));
        (pass["dispatches"].as_u64().unwrap(), pass["draws"].as_u64().unwrap())
    };
    for (name, dispatches, draws) in [
        ("water.weigh", 1, 0),
        ("water.disturb", 1, 0),
        ("water.fused", 2, 0),
        ("draw.scene", 0, 3),
        ("draw.tonemap", 1, 0),
    ] {
        assert_eq!(counts(name), (dispatches, draws), "{name}");
    }
    assert_eq!(
        capture["unnamed"],
        serde_json::json!([]),
        "every buffer, image, pipeline and shader has a name"
    );
    let named = capture["named"].as_array().unwrap();
    assert!(named.contains(&"water.height_m.0".into()) && named.contains(&"draw.color".into()), "{named:?}");
}

#[test]
fn without_renderdoc_a_capture_is_refused_before_anything_runs() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let args = ["run", "sombrero", "--frames", "1", "--out", out.to_str().unwrap(), "--renderdoc-frame", "0"];
    let output = run(&args, false);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(
        said.contains("RenderDoc does not watch") && said.contains("ENABLE_VULKAN_RENDERDOC_CAPTURE=1"),
        "{said}"
    );
    assert!(!out.join("stats.json").exists());
}
