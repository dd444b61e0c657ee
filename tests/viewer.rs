// SPDX-License-Identifier: MIT OR Apache-2.0
//! The window as a script drives it, in an X server without a screen. Everything runs under validation, which must say
//! nothing. Without Xvfb or a display the tests are skipped, and say so.
#![allow(missing_docs)]

use std::{
    env, fs,
    path::{Path, PathBuf},
    process::{Command, Output, Stdio},
    sync::{Mutex, OnceLock},
    thread,
    time::{Duration, Instant},
};
use whitecap::{run::picture::Picture, scene::builtin};

const TOOL: &str = env!("CARGO_BIN_EXE_whitecap");

/// Windows one after the other: they share the CPU, which is the GPU here.
static ALONE: Mutex<()> = Mutex::new(());

fn has(program: &str) -> bool {
    let paths = env::var_os("PATH").unwrap_or_default();
    env::split_paths(&paths).any(|dir| dir.join(program).exists())
}

/// The tool in a window, or why there is none.
fn in_a_window() -> Option<Command> {
    static SAID: OnceLock<()> = OnceLock::new();
    if has("xvfb-run") && has("Xvfb") && has("xauth") {
        let mut command = Command::new("xvfb-run");
        command.args(["-a", "-s", "-screen 0 1280x1024x24", TOOL]).env_remove("WAYLAND_DISPLAY");
        return Some(command);
    }
    if env::var_os("DISPLAY").is_some() {
        return Some(Command::new(TOOL));
    }
    SAID.get_or_init(|| println!("SKIP: no xvfb-run and no DISPLAY: no window is opened"));
    None
}

fn prepared(mut command: Command, args: &[&str]) -> Command {
    command.args(args).env("XDG_CACHE_HOME", env::temp_dir().join("whitecap-tests"));
    command.env_remove("WHITECAP_DEVICE").stdin(Stdio::null());
    command
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// What the window said; `None` if there is none to say anything.
fn view(args: &[&str]) -> Option<String> {
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let output = prepared(in_a_window()?, &[&["view", "--validate"], args].concat()).output().unwrap();
    assert!(output.status.success(), "{args:?}: {:?}\n{}", output.status.code(), text(&output));
    Some(text(&output))
}

/// The last picture of a run without a window, and what it says of itself.
fn run(dir: &Path, args: &[&str]) -> (Picture, serde_json::Value) {
    let out = dir.join("run");
    let all = [&["run", "--json", "--out", out.to_str().unwrap()], args].concat();
    let output = prepared(Command::new(TOOL), &all).output().unwrap();
    assert!(output.status.success(), "{all:?}: {}", text(&output));
    let mut pictures: Vec<PathBuf> =
        fs::read_dir(out.join("frames")).unwrap().map(|entry| entry.unwrap().path()).collect();
    pictures.sort();
    let stats = serde_json::from_slice(&output.stdout).unwrap();
    (Picture::read_png(pictures.last().unwrap()).unwrap(), stats)
}

#[track_caller]
fn assert_same(got: &Path, want: &Picture) {
    let got = Picture::read_png(got).unwrap();
    assert_eq!((got.width, got.height), (want.width, want.height));
    let differ = got.rgb().iter().zip(want.rgb()).filter(|(a, b)| **a != *b).count();
    assert_eq!(differ, 0, "of {} bytes", 3 * got.width * got.height);
}

/// A fresh folder; `$` in a script stands for it.
fn scripted(script: &str) -> (tempfile::TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    let script = script.replace('$', dir.path().to_str().unwrap());
    (dir, script)
}

fn after<'a>(text: &'a str, word: &str) -> &'a str {
    let at = text.rfind(word).unwrap_or_else(|| panic!("no {word} in {text}"));
    text[at + word.len()..].lines().next().unwrap().trim()
}

#[test]
fn the_window_shows_what_a_run_writes() {
    let scenes: [(&str, &[&str]); 4] =
        [("pond", &[]), ("campfire", &[]), ("black_hole", &["--set", "emitter.0.draw=splat"]), ("gas", &[])];
    for (scene, more) in scenes {
        let (dir, script) = scripted("frames 4; screenshot $/picture.png; window $/window.png; exit");
        let same = [&[scene, "--size", "320x200"], more].concat();
        if view(&[&same[..], &["--no-panel", "--script", &script]].concat()).is_none() {
            return;
        }
        let (want, _) = run(dir.path(), &[&same[..], &["--frames", "4"]].concat());
        assert_same(&dir.path().join("picture.png"), &want);
        // On its way through canvas, blit and swapchain not a bit is lost.
        assert_same(&dir.path().join("window.png"), &want);
    }
}

#[test]
fn another_size_is_as_if_it_had_always_been() {
    for scene in ["pond", "campfire"] {
        let (dir, script) = scripted(
            "frames 2; resize 410x250; frames 1; minimise; frames 3; restore; frames 1; screenshot $/a.png; exit",
        );
        if view(&[scene, "--size", "320x200", "--no-panel", "--script", &script]).is_none() {
            return;
        }
        // While it is minimised no time passes.
        let (want, _) = run(dir.path(), &[scene, "--size", "410x250", "--frames", "4"]);
        assert_same(&dir.path().join("a.png"), &want);
    }
}

#[test]
fn the_panel_is_over_the_picture_and_not_in_it() {
    let (dir, script) =
        scripted("frames 2; screenshot $/a.png; window $/b.png; key F1; window $/c.png; exit");
    if view(&["pond", "--size", "480x300", "--timings", "--script", &script]).is_none() {
        return;
    }
    let read = |name: &str| Picture::read_png(&dir.path().join(name)).unwrap();
    let (picture, panel) = (read("a.png"), read("b.png"));
    let differ = picture.rgb().iter().zip(panel.rgb()).filter(|(a, b)| **a != *b).count();
    assert!(differ > 100_000, "{differ} bytes are of the panel");
    assert_same(&dir.path().join("c.png"), &picture); // F1 has hidden it
}

#[test]
fn what_does_not_change_goes_on_and_what_does_keeps_its_state() {
    // Each edit makes something anew, and none touches what the simulation does.
    let edits = [
        ("pond", "set sun.elevation_deg=20; set water.pond.max_catch_up_steps=50", "waters"),
        ("black_hole", "set emitter.0.half_m=0.3; set emitter.0.far_m=50", "emitters"),
        ("gas", "set disks.0.name=others; set output.view=wireframe", "disks"),
    ];
    for (scene, edit, kind) in edits {
        let (dir, script) = scripted(&format!("frames 3; {edit}; frames 3; say; exit"));
        let Some(said) = view(&[scene, "--size", "160x100", "--script", &script]) else { return };
        let (_, stats) = run(dir.path(), &[scene, "--size", "160x100", "--frames", "6"]);
        assert_eq!(
            after(&said, "hashes "),
            stats[kind][0]["state_hash"].as_str().unwrap(),
            "{scene}: {said}"
        );
    }
}

#[test]
fn a_number_that_is_refused_leaves_all_as_it_is() {
    let (dir, script) = scripted("frames 2; set water.0.cells=[0, 7]; frames 2; say; exit");
    let Some(said) = view(&["pond", "--size", "160x100", "--script", &script]) else { return };
    assert!(said.contains("water.0.cells") && said.contains("allowed"), "{said}");
    let (_, stats) = run(dir.path(), &["pond", "--size", "160x100", "--frames", "4"]);
    assert_eq!(after(&said, "hashes "), stats["waters"][0]["state_hash"].as_str().unwrap());
}

#[test]
fn an_edit_and_a_start_again_are_the_edited_scene() {
    let (dir, script) = scripted(
        "frames 3; set water.pond.damping_per_s=2; set camera.fov_deg=30; key R; frames 4; screenshot $/a.png; \
         save $/b.toml; exit",
    );
    if view(&["pond", "--size", "240x150", "--no-panel", "--script", &script]).is_none() {
        return;
    }
    let edits = ["--set", "water.pond.damping_per_s=2", "--set", "camera.fov_deg=30"];
    let (want, _) = run(dir.path(), &[&["pond", "--size", "240x150", "--frames", "4"], &edits[..]].concat());
    assert_same(&dir.path().join("a.png"), &want);
    // What was saved is the same scene, with its comments.
    let saved = dir.path().join("b.toml");
    assert!(fs::read_to_string(&saved).unwrap().contains("# A stone every 1.7 s"));
    let (again, _) = run(dir.path(), &[saved.to_str().unwrap(), "--frames", "4"]);
    assert_same(&dir.path().join("a.png"), &again);
}

#[test]
fn a_hand_ripples_water_stirs_disks_and_drags_emitters() {
    // In the middle of each picture there is water, or the box.
    for (scene, kind) in
        [("pond", "waters"), ("harbour", "waters"), ("dam_break", "waters"), ("gas", "disks")]
    {
        let (dir, script) = scripted("frames 2; touch 80,60 2; frames 1; say; exit");
        let Some(said) = view(&[scene, "--size", "160x100", "--script", &script]) else { return };
        let (_, stats) = run(dir.path(), &[scene, "--size", "160x100", "--frames", "5"]);
        let untouched = stats[kind][0]["state_hash"].as_str().unwrap();
        assert_ne!(after(&said, "hashes "), untouched, "{scene}: {said}");
        assert!(!said.contains("rejected 1"), "{scene}: {said}");
    }
    let (dir, script) = scripted("frames 2; drag 80,52 120,60; frames 2; save $/a.toml; exit");
    let scene = dir.path().join("drag.toml");
    let text =
        "[camera]\neye_m = [0, 6, 10]\ntarget_m = [0, 0, 0]\nfov_deg = 40\n\n[[emitter]]\nlaw = \"drag\"\n\
                at_m = [0, 0, 0]  # here\nspeed_mps = 2\nrate_per_s = 200\nlife_s = 2\n";
    fs::write(&scene, text).unwrap();
    view(&[scene.to_str().unwrap(), "--size", "160x100", "--script", &script]).unwrap();
    let saved = fs::read_to_string(dir.path().join("a.toml")).unwrap();
    let line = saved.lines().find(|line| line.starts_with("at_m")).unwrap();
    assert!(!line.contains("[0, 0, 0]") && line.ends_with("# here"), "{saved}");
    let x: f64 = line.split(['[', ',']).nth(1).unwrap().trim().parse().unwrap();
    assert!(x > 0.5, "dragged to the right: {line}");
}

#[test]
fn shaders_are_read_again_and_broken_ones_change_nothing() {
    let (dir, script) = scripted(
        "frames 3; screenshot $/a.png; wait $/edited; key F5; screenshot $/b.png; wait $/broken; key F5; \
         screenshot $/c.png; wait $/mended; key F5; screenshot $/d.png; say; exit",
    );
    let glsl = dir.path().join("glsl");
    copy("glsl".as_ref(), &glsl);
    let Some(command) = in_a_window() else { return };
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let folder = glsl.to_str().unwrap();
    let args = ["view", "pond", "--size", "160x100", "--validate", "--glsl", folder, "--script", &script];
    let mut command = prepared(command, &args);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let at = |name: &str| dir.path().join(name);
    let file = glsl.join("draw/tonemap.comp");
    let first = fs::read_to_string(&file).unwrap();
    let change = |after: &str, from: &str, to: &str, then: &str| {
        let start = Instant::now();
        while !at(after).exists() && start.elapsed() < Duration::from_secs(60) {
            thread::sleep(Duration::from_millis(20));
        }
        assert!(first.contains(from), "{from} is gone from the shader");
        fs::write(&file, first.replace(from, to)).unwrap();
        fs::write(at(then), "").unwrap();
    };
    change("a.png", "vec4(x, linear.a)", "vec4(x.bgr, linear.a)", "edited");
    change("b.png", "vec4(x, linear.a)", "vec4(nothing, linear.a)", "broken");
    change("c.png", "vec4(x, linear.a)", "vec4(x, linear.a)", "mended");
    let output = child.wait_with_output().unwrap();
    let said = text(&output);
    assert!(output.status.success(), "{said}");
    let read = |name: &str| Picture::read_png(&at(name)).unwrap();
    let (a, b) = (read("a.png").rgb(), read("b.png").rgb());
    assert!(
        a.chunks_exact(3).zip(b.chunks_exact(3)).all(|(a, b)| a == [b[2], b[1], b[0]]),
        "not turned about"
    );
    assert!(said.contains("1 shader differs"), "{said}");
    // What the compiler says has file, line and the line itself, and the old pipeline goes on.
    assert!(said.contains("draw/tonemap.comp:") && said.contains("nothing"), "{said}");
    assert_same(&at("c.png"), &read("b.png"));
    assert_same(&at("d.png"), &read("a.png"));
    assert!(said.contains("0 shaders differ"), "{said}");
    // All that was made anew went on where it was.
    let (_, stats) = run(dir.path(), &["pond", "--size", "160x100", "--frames", "3"]);
    assert_eq!(after(&said, "hashes "), stats["waters"][0]["state_hash"].as_str().unwrap());
}

#[test]
fn what_cannot_be_written_is_said_and_the_window_goes_on() {
    let (dir, script) = scripted(
        "frames 2; key F2; key F9; set sun.elevation_deg=20; frames 1; key R; frames 4; screenshot $/a.png; exit",
    );
    fs::write(dir.path().join("file"), "").unwrap();
    let out = dir.path().join("file/out");
    let args =
        ["pond", "--size", "160x100", "--no-panel", "--out", out.to_str().unwrap(), "--script", &script];
    let Some(said) = view(&args) else { return };
    assert_eq!(said.matches("cannot make the folder").count(), 2, "{said}");
    let sun = ["--set", "sun.elevation_deg=20"];
    let (want, _) = run(dir.path(), &[&["pond", "--size", "160x100", "--frames", "4"], &sun[..]].concat());
    assert_same(&dir.path().join("a.png"), &want);
}

#[test]
fn edits_outlive_a_window_that_fails() {
    let (dir, script) =
        scripted("frames 1; set sun.elevation_deg=21; frames 1; screenshot $/file/a.png; exit");
    fs::write(dir.path().join("file"), "").unwrap();
    let out = dir.path().join("out");
    let args = ["view", "pond", "--size", "160x100", "--out", out.to_str().unwrap(), "--script", &script];
    let Some(command) = in_a_window() else { return };
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let output = prepared(command, &args).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{}", text(&output));
    assert!(text(&output).contains("cannot make the folder"), "{}", text(&output));
    let saved = fs::read_to_string(out.join("scene_001.toml")).unwrap();
    assert!(saved.contains("elevation_deg = 21"), "{saved}");
}

#[test]
fn what_is_saved_is_what_f5_reads_and_it_finds_its_files() {
    let (dir, script) = scripted(
        "frames 2; set water.0.depth_m=0.7; save $/out/today/a.toml; set water.0.depth_m=0.9; wait $/edited; key F5; \
         save $/b.toml; screenshot $/b.png; exit",
    );
    let at = |name: &str| dir.path().join(name);
    fs::create_dir(at("scenes")).unwrap();
    fs::copy("scenes/pond.asc", at("scenes/rock.asc")).unwrap();
    let pond = builtin::toml("pond").unwrap().replace("builtin/pond.asc", "rock.asc");
    fs::write(at("scenes/pond.toml"), pond).unwrap();
    let scene = at("scenes/pond.toml");
    let Some(command) = in_a_window() else { return };
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    // What the command line changes is in the file that is saved, and does not come again with F5.
    let set = "water.0.damping_per_s=0.5";
    let args = [
        "view",
        scene.to_str().unwrap(),
        "--size",
        "160x100",
        "--set",
        set,
        "--validate",
        "--script",
        &script,
    ];
    let child = prepared(command, &args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let saved = at("out/today/a.toml");
    let start = Instant::now();
    while !saved.exists() && start.elapsed() < Duration::from_secs(60) {
        thread::sleep(Duration::from_millis(20));
    }
    let text_a = fs::read_to_string(&saved).unwrap();
    assert!(
        text_a.contains("heightmap = \"../../scenes/rock.asc\"") && text_a.contains("depth_m = 0.7"),
        "{text_a}"
    );
    fs::write(&saved, text_a.replace("damping_per_s = 0.5", "damping_per_s = 0.25")).unwrap();
    fs::write(at("edited"), "").unwrap();
    let output = child.wait_with_output().unwrap();
    let said = text(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("Edits that were not saved are gone."), "{said}");
    let text_b = fs::read_to_string(at("b.toml")).unwrap();
    assert!(text_b.contains("heightmap = \"scenes/rock.asc\""), "{text_b}");
    assert!(text_b.contains("depth_m = 0.7") && text_b.contains("damping_per_s = 0.25"), "{text_b}");
    for file in [saved, at("b.toml")] {
        run(dir.path(), &[file.to_str().unwrap(), "--frames", "1"]);
    }
}

#[test]
fn a_built_in_scene_that_was_saved_is_read_again_and_without_shaders_that_is_said() {
    let none = ["--glsl", "no/such/folder"];
    let (_dir, script) = scripted("frames 1; key F5; save $/a.toml; key F5; exit");
    let Some(said) = view(&[&["pond", "--size", "160x100", "--script", &script], &none[..]].concat()) else {
        return;
    };
    assert!(said.contains("Nothing to read again") && said.contains("no folder no/such/folder"), "{said}");
    assert!(said.contains("Read again: no shaders, as there is no folder no/such/folder"), "{said}");
}

#[test]
fn a_lost_surface_is_made_anew() {
    let (dir, script) =
        scripted("frames 2; renew; frames 1; renew; resize 200x120; renew; frames 1; window $/a.png; exit");
    if view(&["pond", "--size", "160x100", "--no-panel", "--script", &script]).is_none() {
        return;
    }
    let (want, _) = run(dir.path(), &["pond", "--size", "200x120", "--frames", "4"]);
    assert_same(&dir.path().join("a.png"), &want);
}

#[test]
fn a_scene_of_meshes_keeps_its_state() {
    let (dir, script) = scripted("frames 8; key F5; set output.view=voxels; frames 2; say; exit");
    let args = ["sandblast", "--size", "64x48"];
    let Some(said) = view(&[&args[..], &["--script", &script]].concat()) else { return };
    let (_, stats) = run(dir.path(), &[&args[..], &["--frames", "10"]].concat());
    let volume = &stats["volume"];
    assert!(volume["impacts"].as_u64().unwrap() > 0, "nothing is painted: {volume}");
    let emitters = stats["emitters"].as_array().unwrap().iter().map(|it| &it["state_hash"]);
    let hashes: Vec<_> = emitters.chain([&volume["paint_hash"]]).map(|it| it.as_str().unwrap()).collect();
    assert_eq!(after(&said, "hashes "), hashes.join(" "), "{said}");
}

/// Processor time of a process so far (s).
#[cfg(target_os = "linux")]
fn busy_s(pid: u32) -> f64 {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).unwrap();
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
    let ticks = |i: usize| fields[i].parse::<f64>().unwrap(); // utime and stime, counted from the state
    (ticks(11) + ticks(12)) / 100.0
}

/// One window over another, in an X server of their own.
#[cfg(target_os = "linux")]
#[test]
fn a_covered_window_rests_and_its_picture_is_written_all_the_same() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let under = "frames 3; screenshot $/ready.png; wait $/rested; screenshot $/a.png; window $/b.png; exit";
    let over = "frames 2; screenshot $/covered.png; wait $/end; exit";
    let [under, over] = [under, over].map(|it| it.replace('$', dir.path().to_str().unwrap()));
    if !has("xvfb-run") || !has("Xvfb") || !has("xauth") {
        return println!("SKIP: no xvfb-run: which window covers which cannot be said");
    }
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let mut command = Command::new("xvfb-run");
    command.args(["-a", "-s", "-screen 0 640x480x24", "sh", "-c"]).env_remove("WAYLAND_DISPLAY");
    let both = r#"
        "$0" view pond --size 160x100 --no-panel --script "$1" & under=$!; echo $under > "$3/pid.new"; mv "$3/pid.new" "$3/pid"
        while [ ! -e "$3/ready.png" ]; do sleep 0.1; done
        "$0" view pond --size 320x240 --no-panel --script "$2" & over=$!
        wait $under; echo "code $?"; : > "$3/end"; wait $over"#;
    let args = [both, TOOL, &under, &over, dir.path().to_str().unwrap()];
    let child = prepared(command, &args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let start = Instant::now();
    while !at("covered.png").exists() && start.elapsed() < Duration::from_secs(60) {
        thread::sleep(Duration::from_millis(20));
    }
    let pid = fs::read_to_string(at("pid")).unwrap().trim().parse().unwrap();
    thread::sleep(Duration::from_millis(500));
    let before_s = busy_s(pid);
    thread::sleep(Duration::from_secs(2));
    let busy_s = busy_s(pid) - before_s;
    fs::write(at("rested"), "").unwrap();
    let output = child.wait_with_output().unwrap();
    let said = text(&output);
    assert!(busy_s < 0.4, "busy for {busy_s} s of 2 s while nothing of it is seen: {said}");
    // Nothing of the window can be written, and that is an error; the picture can.
    assert!(said.contains("code 3") && said.contains("the window shows nothing: it is covered"), "{said}");
    let (want, _) = run(dir.path(), &["pond", "--size", "160x100", "--frames", "3"]);
    assert_same(&at("a.png"), &want);
}

#[test]
fn f12_has_renderdoc_capture_once() {
    let layer = ["/usr/share", "/usr/local/share", "/etc"]
        .map(|root| Path::new(root).join("vulkan/implicit_layer.d/renderdoc_capture.json"));
    if !layer.iter().any(|it| it.exists()) {
        return println!("SKIP: RenderDoc is not installed");
    }
    let (dir, script) = scripted("frames 2; key F12; frames 2; minimise; key F12; exit");
    let Some(command) = in_a_window() else { return };
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let args =
        ["view", "pond", "--size", "160x100", "--out", dir.path().to_str().unwrap(), "--script", &script];
    let mut command = prepared(command, &args);
    let output = command.env("ENABLE_VULKAN_RENDERDOC_CAPTURE", "1").output().unwrap();
    let said = text(&output);
    assert!(output.status.success(), "{said}");
    let files = fs::read_dir(dir.path()).unwrap().flatten().map(|entry| entry.path());
    let captures = files.filter(|path| path.extension().is_some_and(|it| it == "rdc")).count();
    assert_eq!((captures, said.matches("is captured.").count()), (1, 1), "{said}");
    assert!(said.contains("Nothing is captured: the window shows nothing."), "{said}");
}

#[test]
fn f9_traces_the_passes_of_frames() {
    let (dir, script) = scripted("frames 2; key F9; frames 5; exit");
    let out = dir.path().to_str().unwrap();
    let args = ["pond", "--size", "160x100", "--no-panel", "--out", out, "--script", &script];
    let Some(said) = view(&args) else { return };
    assert!(said.contains("trace_001.json is written"), "{said}");
    let text = fs::read_to_string(dir.path().join("trace_001.json")).unwrap();
    let events: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
    let of = |name: &str| events.iter().filter(|event| event["name"] == name).count();
    // The last frames are on their way when the window closes.
    assert!((3..=5).contains(&of("draw.scene")), "{} frames of 5", of("draw.scene"));
    assert!(of("water.fused") >= of("draw.tonemap"), "a step a picture at the least");
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(|entry| entry.unwrap()) {
        let to = to.join(entry.file_name());
        match entry.file_type().unwrap().is_dir() {
            true => copy(&entry.path(), &to),
            false => drop(fs::copy(entry.path(), to).unwrap()),
        }
    }
}

#[test]
fn every_built_in_scene_opens() {
    for (scene, _) in builtin::list() {
        let few: &[&str] = match scene {
            "avalanche" | "brownian" => &["--set", "disks.0.count=300"],
            _ => &[],
        };
        let (_dir, script) = scripted("frames 2; resize 200x120; touch 90,70 1; key V; frames 1; exit");
        let args = [&[scene, "--size", "160x100", "--script", &script], few].concat();
        if view(&args).is_none() {
            return;
        }
    }
}

#[test]
fn no_display_and_no_script_have_exit_codes_of_their_own() {
    let mut command = prepared(Command::new(TOOL), &["view", "pond"]);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(3), "{}", text(&output));
    assert!(text(&output).starts_with("error: no display: "), "{}", text(&output));
    assert!(!text(&output).contains(".rs:"), "{}", text(&output));
    for args in [["view", "pond", "--script", "jump 3"], ["view", "pond", "--set", "water.0.cells=[0, 0]"]] {
        let output = prepared(Command::new(TOOL), &args).output().unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", text(&output));
        assert!(text(&output).contains("allowed"), "{}", text(&output));
    }
}
