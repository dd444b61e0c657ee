// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes of particles: what their tables take, what a user's GLSL gets told, and runs from end to end.
#![allow(missing_docs)]

mod common;

use common::gpu;
use std::{fs, path::Path};
use tempfile::{tempdir, TempDir};
use whitecap::{
    gpu::Gpu,
    run::{self, RunOptions, Written},
    scene::{builtin, Override, PlannedThrows, Scene},
};

const HOLE: &str = "\n[[attractor]]\nat_m = [50, 0, 0]\nmu_m3ps2 = 10000\nhorizon_m = 5\n";
const EMITTER: &str =
    "[[emitter]]\nlaw = 'black_hole'\nat_m = [-50, 10, 0]\nspeed_mps = 5\nrate_per_s = 200\nlife_s = 30\n";

fn error(text: &str) -> String {
    match Scene::parse(text, "storm.toml", None, &[]) {
        Err(error) => error.to_string(),
        Ok(_) => panic!("no error in {text}"),
    }
}

#[test]
fn a_wrong_key_is_named_with_its_value_and_what_is_allowed() {
    let one = |lines: &str, says: &str| {
        let said = error(&format!("[[emitter]]\n{lines}\n"));
        assert!(said.contains(says), "{lines}: {said}");
    };
    one(
        "effect = 'fog'",
        "emitter.0.effect is 'fog'; allowed: fire, rain, smoke, sparks, snow, fireworks, dust, or a .glsl file",
    );
    one(
        "law = 'gravity'",
        "emitter.0.law is 'gravity'; allowed: black_hole, drag, colliding, or a .glsl file",
    );
    one("name = 'x'", "emitter.0.effect is missing; allowed: fire, rain");
    one("effect = 'fire'\nlaw = 'drag'", "is given beside effect");
    one("effect = 'fire'\nlife_s = 0", "emitter.0.life_s is 0; allowed: 0.001 to 86400");
    one("effect = 'fire'\nspeed_mps = 1", "emitter.0.speed_mps is not a key; allowed here: ");
    one(
        "effect = 'fire'\ndraw = 'points'",
        "emitter.0.draw is 'points'; allowed: \"quads\" or \"geometry\" or \"splat\"",
    );
    one("effect = 'fire'\ndraw = 'splat'\nsoft = 'yes'", "emitter.0.soft is for draw \"quads\"");
    one("effect = 'rain'", "ends on the ground: it needs [terrain] or [[water]]");
    one("law = 'drag'\nlife_s = 2", "emitter.0.rate_per_s is missing");
    one("law = 'black_hole'\nrate_per_s = 1\nlife_s = 1", "the scene has no [[attractor]]");
    one(
        "law = 'drag'\nrate_per_s = 1e8\nlife_s = 100",
        "particles at once; allowed: 268435456, or a capacity",
    );
    one(
        "effect = 'fire'\n[[emitter]]\neffect = 'fire'",
        "emitter.1.name is \"fire\", as emitter.0 is called already",
    );
    let said = error(&format!("{EMITTER}tolerance = 0.1\nintegrator = 'rk4'\n{HOLE}"));
    assert!(said.contains("tolerance is given beside integrator"), "{said}");
    let said = error(&format!("{EMITTER}\n[[attractor]]\nat_m = [0, 0]\nmu_m3ps2 = -1\norbit_m = 3\n"));
    for says in [
        "attractor.0.at_m is [0, 0]; allowed: three numbers",
        "attractor.0.mu_m3ps2 is -1",
        "period_s go together",
    ] {
        assert!(said.contains(says), "{said}");
    }
}

fn reason(text: &str) -> String {
    let scene = Scene::parse(text, "storm.toml", None, &[]).unwrap();
    scene.plan().unwrap().emitters[0].reason.clone()
}

#[test]
fn the_integrator_is_the_cheapest_within_the_tolerance() {
    assert!(reason(&format!("{EMITTER}{HOLE}")).contains("by kepler: one hole"));
    let two = format!("{HOLE}{}", HOLE.replace("50", "-20"));
    let coarse = reason(&format!("{EMITTER}tolerance = 0.1\n{two}"));
    let fine = reason(&format!("{EMITTER}tolerance = 0.0001\n{two}"));
    assert!(coarse.contains("by leapfrog, 1 substeps"), "{coarse}");
    assert!(fine.contains("by rk4"), "{fine}");
    let asked = reason(&format!("{EMITTER}integrator = 'euler'\nsubsteps = 3\n{two}"));
    assert!(asked.contains("by euler, 3 substeps, as the scene asks"), "{asked}");
}

#[test]
fn a_scene_pays_for_what_it_names() {
    let plan = |text: &str| Scene::parse(text, "a.toml", None, &[]).unwrap().plan().unwrap();
    let has = |text: &str, wanted: &str| {
        let plan = plan(text);
        plan.buffers.iter().any(|it| it.name.contains(wanted))
            || plan.passes.iter().any(|it| it.0.contains(wanted))
    };
    let water = "[[water]]\nmodel = 'waves'\ncells = [8, 8]\nsize_m = [8, 8]\ndepth_m = 1\n";
    for word in ["particles", "sprites", "scene_depth", "draw.splat", "texture"] {
        assert!(!has(water, word), "{word}");
    }
    let fire = "[[emitter]]\neffect = 'fire'\n";
    assert!(
        has(fire, "sprites")
            && !has(fire, "particles.")
            && !has(fire, "scene_depth")
            && !has(fire, "terrain")
    );
    let soft = format!("{fire}soft = 'yes'\n");
    assert!(has(&soft, "scene_depth") && !has(&soft, "draw.splats"));
    assert!(has(&format!("{fire}draw = 'splat'\n"), "draw.splats"));
    assert!(has(&format!("{EMITTER}{HOLE}"), "particles.pool"));
}

/// A folder with a scene and a file of GLSL.
fn folder(scene: &str, file: &str, glsl: &str) -> (TempDir, Scene) {
    let dir = tempdir().unwrap();
    fs::write(dir.path().join("scene.toml"), scene).unwrap();
    fs::write(dir.path().join(file), glsl).unwrap();
    let scene = Scene::load(&dir.path().join("scene.toml"), &[]).unwrap();
    (dir, scene)
}

const SPRING: &str =
    "layout(set = 0, binding = LAW_BINDING, std430) readonly buffer Law { float stiff_per_s2; };
bool advance(inout Particle it, float dt_s) {
    it.velocity_mps -= dt_s * stiff_per_s2 * it.at_m;
    it.at_m += dt_s * it.velocity_mps;
    return true;
}
";
const SPRUNG: &str = "[output]\nsize = [64, 48]\nframes = 4\n[[emitter]]\nlaw = 'spring.glsl'\nnumbers = [4]\nspeed_mps = 2\nrate_per_s = 400\nlife_s = 3\n";
const GLOW: &str = "/* effect
rate_per_s = 50
life_s = 2
*/
Birth birth(Who who, vec3 emitter_m) { return Birth(emitter_m, vec3(0.0, 1.0, 0.0), 0.0); }
Look look(Who who, inout Flight f) { return Look(vec2(0.1), 0.0, vec4(0.2, 0.1, 0.0, 0.0), false); }
";
const GLOWING: &str =
    "[output]\nsize = [64, 48]\nframes = 4\n[[emitter]]\neffect = 'glow.glsl'\nat_m = [0, 0, 0]\n";

#[test]
fn an_error_in_a_users_glsl_shows_file_line_and_excerpt() {
    let (_dir, scene) = folder(SPRUNG, "spring.glsl", &SPRING.replace("stiff_per_s2 *", "stif *"));
    let said = scene.plan().unwrap_err().to_string();
    for says in [
        "spring.glsl: does not compile",
        "spring.glsl:3: error: 'stif' : undeclared identifier",
        "    3 |     it.velocity_mps -= dt_s * stif * it.at_m;",
    ] {
        assert!(said.contains(says), "{said}");
    }
    let (_dir, scene) = folder(GLOWING, "glow.glsl", &GLOW.replace("vec2(0.1), 0.0", "vec2(0.1)"));
    let said = scene.plan().unwrap_err().to_string();
    assert!(
        said.contains("glow.glsl:6: error: 'constructor'") && said.contains("    6 | Look look("),
        "{said}"
    );
    let (_dir, scene) = folder(GLOWING, "glow.glsl", &GLOW.replace("life_s = 2", "life_s = long"));
    let said = scene.plan().unwrap_err().to_string();
    assert!(
        said.contains("glow.glsl: 3: `life_s` = long") && said.contains("    3 | life_s = long"),
        "{said}"
    );
    let said =
        Scene::parse(SPRUNG, "scene.toml", Some(Path::new("nowhere")), &[]).unwrap().plan().unwrap_err();
    assert!(said.to_string().contains("spring.glsl"), "{said}");
}

fn run_into(gpu: &Gpu, scene: &Scene, change: impl FnOnce(&mut RunOptions)) -> (TempDir, Written) {
    let dir = tempdir().unwrap();
    let mut options = RunOptions {
        out: dir.path().to_owned(),
        has_frames: true,
        hash_every: 0,
        checkpoint: None,
        resume: None,
        profile: Default::default(),
    };
    change(&mut options);
    let plan = scene.plan().unwrap();
    let written = run::run(gpu, scene, &plan, &options, |_| {}).unwrap();
    (dir, written)
}

fn last_picture(dir: &TempDir, frames: u32) -> Vec<u8> {
    fs::read(dir.path().join(format!("frames/frame_{:05}.png", frames - 1))).unwrap()
}

#[test]
fn a_users_law_and_effect_run() {
    let gpu = gpu();
    let (_dir, scene) = folder(SPRUNG, "spring.glsl", SPRING);
    let (_out, written) = run_into(&gpu, &scene, |_| {});
    let stats = &written.stats.emitters[0];
    // 400 a second for a tenth of a second: of three pictures after the first.
    assert!((38..=41).contains(&stats.born) && stats.alive == stats.born, "{stats:?}");
    let (_dir, scene) = folder(GLOWING, "glow.glsl", GLOW);
    let (_out, written) = run_into(&gpu, &scene, |_| {});
    let stats = &written.stats.emitters[0];
    assert_eq!((stats.born, stats.alive, stats.dropped), (6, 6, 0), "{stats:?}");
}

fn tiny(name: &str, more: &[&str]) -> Scene {
    let changes = ["output.size=[64, 36]", "output.frames=3", "output.fps=2"];
    let changes: Vec<Override> = changes.iter().chain(more).map(|it| it.parse().unwrap()).collect();
    builtin::load(name, &changes).unwrap()
}

fn scenes() -> Vec<Scene> {
    vec![
        tiny("black_hole", &["emitter.0.rate_per_s=100"]),
        tiny("binary_hole", &["emitter.0.rate_per_s=100", "emitter.1.rate_per_s=100"]),
        tiny("campfire", &[]),
        tiny(
            "rain",
            &[
                "emitter.0.rate_per_s=100",
                "emitter.1.rate_per_s=100",
                "water.0.cells=[64, 64]",
                "water.0.splash.0.radius_m=3",
            ],
        ),
        tiny(
            "fireworks",
            &["water.0.cells=[64, 64]", "emitter.0.burst=100", "output.fps=1", "output.frames=4"],
        ),
    ]
}

#[test]
fn every_scene_of_particles_runs_twice_alike() {
    let gpu = gpu();
    for scene in scenes() {
        let frames = scene.output.frames;
        let (one, first) = run_into(&gpu, &scene, |_| {});
        let (other, second) = run_into(&gpu, &scene, |_| {});
        assert_eq!(first.stats.emitters, second.stats.emitters, "{}", scene.title);
        let hashes = |written: &Written| -> Vec<String> {
            written.stats.waters.iter().map(|it| it.state_hash.clone()).collect()
        };
        assert_eq!(hashes(&first), hashes(&second), "{}", scene.title);
        assert!(
            last_picture(&one, frames) == last_picture(&other, frames),
            "{}: pictures differ",
            scene.title
        );
        for (stats, plan) in first.stats.emitters.iter().zip(scene.plan().unwrap().emitters) {
            assert!(stats.born > 0 && stats.alive > 0, "{}: {stats:?}", scene.title);
            assert_eq!(stats.born, stats.alive + stats.aged + stats.ended + stats.spoiled, "{stats:?}");
            assert_eq!(stats.dropped + stats.spoiled, 0, "{stats:?}");
            assert_eq!(stats.state_hash.is_some(), matches!(plan.throws, PlannedThrows::Law(_)));
        }
    }
}

#[test]
fn a_pool_goes_on_from_a_checkpoint_to_the_bit() {
    let gpu = gpu();
    let more = ["emitter.0.rate_per_s=100", "emitter.1.rate_per_s=100", "output.frames=6"];
    let scene = tiny("binary_hole", &more);
    let (whole, all) = run_into(&gpu, &scene, |_| {});
    let dir = tempdir().unwrap();
    let file = dir.path().join("state");
    let half = tiny("binary_hole", &[more[0], more[1], "output.frames=3"]);
    run_into(&gpu, &half, |options| options.checkpoint = Some((file.clone(), 60)));
    let (rest, resumed) = run_into(&gpu, &scene, |options| options.resume = Some(file.clone()));
    assert_eq!(all.stats.emitters, resumed.stats.emitters);
    assert!(last_picture(&whole, 6) == last_picture(&rest, 6), "pictures differ");
    // Another rate is another scene.
    let other = tiny("binary_hole", &["emitter.0.rate_per_s=101", more[1], more[2]]);
    let options = RunOptions {
        out: dir.path().to_owned(),
        has_frames: false,
        hash_every: 0,
        checkpoint: None,
        resume: Some(file),
        profile: Default::default(),
    };
    let error = run::run(&gpu, &other, &other.plan().unwrap(), &options, |_| {}).unwrap_err();
    assert!(error.to_string().contains("of another scene"), "{error}");
}

#[test]
fn three_ways_to_draw_a_scene_show_the_same() {
    let gpu = gpu();
    let mut ways = vec!["quads", "splat"];
    if gpu.has_geometry_shader() {
        ways.push("geometry");
    }
    for (name, rate) in [("black_hole", "emitter.0.rate_per_s=200"), ("fireworks", "emitter.0.burst=100")] {
        let pictures: Vec<_> = ways
            .iter()
            .map(|way| {
                let scene =
                    tiny(name, &[rate, &format!("emitter.0.draw={way}"), "output.frames=4", "output.fps=1"]);
                let (dir, _) = run_into(&gpu, &scene, |_| {});
                let path = dir.path().join("frames/frame_00003.png");
                run::picture::Picture::read_png(&path).unwrap().rgba
            })
            .collect();
        let sum = |rgba: &[u8]| rgba.iter().map(|&byte| f64::from(byte)).sum::<f64>();
        let black = 255.0 * 64.0 * 36.0; // alpha
        assert!(sum(&pictures[0]) > 1.001 * black, "{name}: nothing to compare");
        let mean = |other: &[u8]| {
            let apart = pictures[0].iter().zip(other).map(|(a, b)| f64::from(a.abs_diff(*b)));
            apart.sum::<f64>() / pictures[0].len() as f64
        };
        eprintln!("{name}: splat {:.3}", mean(&pictures[1]));
        assert!(mean(&pictures[1]) < 2.0, "{name}: {}", mean(&pictures[1]));
        assert!(pictures.get(2).is_none_or(|it| it == &pictures[0]), "{name}");
    }
}
