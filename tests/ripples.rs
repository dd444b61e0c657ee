// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rain that makes its own ripples, in scenes: what keys take, what a scene pays for, and runs from end to end.
#![allow(missing_docs)]

mod common;

use common::gpu;
use std::fs;
use tempfile::tempdir;
use whitecap::{
    gpu::{Gpu, Submitter},
    run::{self, stats::SplashStats, RunOptions, World, Written},
    scene::{Brings, Override, Plan, Scene},
};

/// A pond of 16 m, and drops from 5 m above it, over 70 m.
const POND: &str = "[output]
size = [32, 32]
fps = 12
frames = 25
[[water]]
name = \"pond\"
model = \"waves\"
cells = [64, 64]
size_m = [16, 16]
depth_m = 1
[[emitter]]
name = \"rain\"
effect = \"rain\"
at_m = [0, -15, 0]
rate_per_s = 200
life_s = 1.5
impacts = 512
[[water.splash]]
from = \"rain\"
drop_radius_m = 0.02
radius_m = 0.5
";

fn pond(changes: &[&str]) -> Result<Scene, String> {
    let changes: Vec<Override> = changes.iter().map(|it| it.parse().unwrap()).collect();
    Scene::parse(POND, "pond.toml", None, &changes).map_err(|error| error.to_string())
}

fn plan(text: &str) -> Plan {
    Scene::parse(text, "pond.toml", None, &[]).unwrap().plan().unwrap()
}

fn run_with(gpu: &Gpu, scene: &Scene, more: impl FnOnce(&mut RunOptions)) -> Written {
    let out = tempdir().unwrap();
    let mut options = RunOptions {
        out: out.path().to_owned(),
        has_frames: false,
        hash_every: 0,
        checkpoint: None,
        resume: None,
        profile: Default::default(),
    };
    more(&mut options);
    run::run(gpu, scene, &scene.plan().unwrap(), &options, |_| {}).unwrap()
}

fn splashes(written: &Written) -> &SplashStats {
    &written.stats.waters[0].splashes[0]
}

#[test]
fn a_mistake_is_named_with_its_line_and_what_is_allowed() {
    let says = |text: &str, says: &str| match Scene::parse(text, "pond.toml", None, &[]) {
        Err(error) => assert!(error.to_string().contains(says), "{error}"),
        Ok(_) => panic!("no error in {text}"),
    };
    let with = |from: &str, to: &str| {
        assert!(POND.contains(from));
        POND.replace(from, to)
    };
    says(
        &with("from = \"rain\"", "from = \"snow\""),
        "pond.toml:19:8: water.0.splash.0.from is \"snow\", which is no emitter; allowed: \"rain\"\n\
         19 | from = \"snow\"\n   |        ^^^^^^",
    );
    says(
        &with("impacts = 512\n", ""),
        "water.0.splash.0.from is \"rain\", which has no impacts; allowed: emitters that have `impacts`",
    );
    says(
        &with("effect = \"rain\"", "law = \"drag\"").replace("impacts = 512\n", ""),
        "water.0.splash.0.from is \"rain\", of the law \"drag\", whose particles do not land in water",
    );
    says(
        &with("effect = \"rain\"", "effect = \"fire\""),
        "emitter.0.impacts is given, and effect \"fire\" ends on no ground; allowed: rain, snow, or a file",
    );
    for bad in ["0", "16385", "1.5"] {
        says(&with("512", bad), &format!("emitter.0.impacts is {bad}; allowed: "));
    }
    says(&with("from = \"rain\"\n", ""), "water.0.splash.0.from is missing; allowed: the name of an emitter");
    says(
        &with("drop_radius_m = 0.02", "drop_radius_m = 0"),
        "water.0.splash.0.drop_radius_m is 0; allowed: ",
    );
    says(&with("radius_m = 0.5", "radius_m = 0.2"), "radius_m is 0.2; allowed: at least a column, 0.25 m");
    says(
        &(POND.to_owned() + "brings = 'push'"),
        "water.0.splash.0.brings is 'push'; allowed: \"both\" or \"volume\" or \"momentum\"",
    );
    let no_emitter = &POND[..POND.find("[[emitter]]").unwrap()];
    let splash = &POND[POND.find("[[water.splash]]").unwrap()..];
    says(
        &format!("{no_emitter}{splash}"),
        "is \"rain\", which is no emitter; allowed: none: the scene has no",
    );
}

#[test]
fn a_model_without_a_velocity_takes_the_water_and_refuses_the_momentum() {
    for model in ["waves", "book", "pipes", "wet", "shallow"] {
        let with = |brings: &str| {
            let text = POND.replace("\"waves\"", &format!("{model:?}")) + brings;
            Scene::parse(&text, "pond.toml", None, &[]).map_err(|error| error.to_string())
        };
        let brings = |scene: Scene| scene.water[0].splashes[0].brings;
        let is_waves = model == "waves";
        assert_eq!(brings(with("").unwrap()), if is_waves { Brings::Both } else { Brings::Volume });
        assert_eq!(brings(with("brings = 'volume'").unwrap()), Brings::Volume);
        for momentum in ["both", "momentum"] {
            match with(&format!("brings = {momentum:?}")) {
                Ok(scene) => assert!(is_waves && brings(scene).has_momentum()),
                Err(error) => {
                    let says =
                        format!("water.0.splash does not go with model {model:?}, which has no velocity");
                    assert!(!is_waves && error.contains(&says), "{error}");
                    assert!(error.contains("allowed: \"waves\""), "{error}");
                }
            }
        }
    }
    // Left to be chosen, momentum needs the model that has it.
    let auto = POND.replace("\"waves\"", "\"auto\"") + "brings = 'momentum'";
    let scene = Scene::parse(&auto, "pond.toml", None, &[]).unwrap();
    assert_eq!(scene.water[0].model, whitecap::scene::Model::Waves);
}

#[test]
fn a_scene_pays_for_it_where_it_names_it() {
    let has = |plan: &Plan, wanted: &str| {
        plan.buffers.iter().any(|it| it.name.contains(wanted))
            || plan.passes.iter().any(|it| it.0.contains(wanted))
    };
    let bare = plan(&POND.replace("impacts = 512\n", "")[..POND.find("[[water.splash]]").unwrap() - 14]);
    let full = plan(POND);
    for word in ["impact.", "water.disturbances", "splash", "ballistic.land"] {
        assert!(has(&full, word) && !has(&bare, word), "{word}");
    }
    let bytes = |wanted: &str| full.buffers.iter().find(|it| it.name == wanted).unwrap().bytes;
    assert_eq!((bytes("impact.impacts"), bytes("water.disturbances")), (512 * 64, 16 + 2 * 512 * 32));
    // Impacts that nobody reads are said, and not made.
    let unread = plan(&POND[..POND.find("[[water.splash]]").unwrap()]);
    assert!(!has(&unread, "impact.") && unread.warnings[0].contains("emitter `rain` has impacts"));
}

#[test]
fn as_many_drops_land_in_the_water_whatever_the_pictures() {
    let gpu = gpu();
    let mut all = Vec::new();
    for (fps, frames) in [
        ("output.fps=12", "output.frames=25"),
        ("output.fps=24", "output.frames=49"),
        ("output.fps=60", "output.frames=121"),
    ] {
        let written = run_with(&gpu, &pond(&[fps, frames]).unwrap(), |_| {});
        let stats = splashes(&written);
        assert_eq!((stats.dropped, stats.rejected), (0, 0), "{stats:?}");
        assert_eq!(stats.taken + stats.missed, stats.landed, "{stats:?}");
        // A second of drops, 1000 of them, of which the pond has (16 / 70)^2.
        assert!((940..1060).contains(&stats.landed) && (25..80).contains(&stats.taken), "{stats:?}");
        let water = &written.stats.waters[0];
        assert!((water.volume_gain_m3 / water.volume_given_m3 - 1.0).abs() < 1e-4, "{water:?}");
        all.push((stats.landed, stats.taken, stats.missed));
    }
    assert!(all.iter().all(|it| *it == all[0]), "{all:?}");
}

#[test]
fn two_runs_are_alike_and_one_that_is_resumed_too() {
    let gpu = gpu();
    let scene = pond(&[]).unwrap();
    let hash = |written: &Written| written.stats.waters[0].state_hash.clone();
    let dir = tempdir().unwrap();
    let file = dir.path().join("state");
    let half = pond(&["output.frames=18"]).unwrap();
    let first = run_with(&gpu, &half, |options| options.checkpoint = Some((file.clone(), 60)));
    let rest = run_with(&gpu, &scene, |options| options.resume = Some(file.clone()));
    let [one, other] = [(); 2].map(|()| run_with(&gpu, &scene, |_| {}));
    assert_eq!(hash(&one), hash(&other));
    assert_eq!(hash(&one), hash(&rest));
    assert_ne!(hash(&one), hash(&first));
    let [first, rest, all] = [&first, &rest, &one].map(splashes);
    assert!(first.taken > 0 && rest.taken > 0);
    assert_eq!(first.landed + rest.landed, all.landed, "the counts of a run are its own");
}

/// How many drops have landed after pictures of these times, of which the last come after an edit.
fn landed(gpu: &Gpu, frames_s: [&[f64]; 2], edit: &str) -> u64 {
    let scenes = [pond(&[]).unwrap(), pond(&[edit]).unwrap()];
    let plans = scenes.each_ref().map(|scene| scene.plan().unwrap());
    let mut submitter = Submitter::new(gpu, 64).unwrap();
    let mut world = World::new(gpu, &scenes[0], &plans[0]).unwrap();
    let count = |world: &World| {
        let counts = world.counters().unwrap().swap_remove(0).counts;
        let of_drops = ["rings", "drops missed", "drops dropped"];
        counts.iter().filter(|(name, _)| of_drops.contains(name)).map(|(_, n)| n).sum::<u64>()
    };
    for frame_s in frames_s[0] {
        world.frame(&mut submitter, *frame_s).unwrap();
    }
    let before = count(&world);
    let left = world.follow(gpu, (&scenes[1], &plans[1]), &plans[0], false).unwrap();
    drop(left);
    for frame_s in frames_s[1] {
        world.frame(&mut submitter, *frame_s).unwrap();
    }
    before + count(&world)
}

/// Drops fall by the time of the scene, and a water that is made anew, or has lost time, is not behind it.
#[test]
fn an_edited_water_takes_the_drops_of_the_time_that_it_is() {
    let gpu = gpu();
    const PICTURES: &[f64] = &[1.0 / 12.0; 19];
    let whole = landed(&gpu, [PICTURES, &[0.125; 4]], "water.0.damping_per_s=0.1");
    assert!(whole > 900, "{whole}");
    // All goes on; in steps of another length; and from the start, at the time that it is.
    for edit in ["water.0.dt_s=0.011", "water.0.depth_m=1.5"] {
        let edited = landed(&gpu, [PICTURES, &[0.125; 4]], edit);
        assert!(edited.abs_diff(whole) <= 15, "{edit}: {edited} of {whole}");
    }
    // Of ten seconds all but a few pictures are lost. Then half a second of rain lands.
    let steady = landed(&gpu, [&[10.0], &[0.125; 4]], "water.0.damping_per_s=0.1");
    for edit in ["water.0.dt_s=0.011", "water.0.depth_m=1.5"] {
        let edited = landed(&gpu, [&[10.0], &[0.125; 4]], edit);
        assert!(steady > 400 && edited.abs_diff(steady) <= 15, "{edit}: {edited} of {steady}");
    }
}

#[test]
fn what_finds_no_room_is_reported() {
    let gpu = gpu();
    let written = run_with(&gpu, &pond(&["emitter.rain.impacts=16"]).unwrap(), |_| {});
    let stats = splashes(&written);
    assert!(stats.dropped > 0 && stats.taken > 0, "{stats:?}");
    assert_eq!(stats.taken + stats.missed + stats.dropped, stats.landed, "{stats:?}");
}

#[test]
fn the_water_of_drops_goes_into_every_model() {
    let gpu = gpu();
    for model in ["book", "pipes", "wet", "shallow"] {
        let model = format!("water.0.model={model:?}");
        let written = run_with(&gpu, &pond(&[&model, "output.frames=19"]).unwrap(), |_| {});
        let water = &written.stats.waters[0];
        assert!(splashes(&written).taken > 0);
        assert!((water.volume_gain_m3 / water.volume_given_m3 - 1.0).abs() < 1e-3, "{model}: {water:?}");
    }
}

/// An effect from a file lands as the built-in ones do; one without a ground is refused.
#[test]
fn an_effect_of_the_users_own_lands() {
    const HAIL: &str = "/* effect
rate_per_s = 300
life_s = 2
acceleration_mps2 = 0 -9.8 0
drag_per_s = 0.1
ground = 1
*/
Birth birth(Who who, vec3 emitter_m) {
    vec4 u = chance(who, 0u);
    return Birth(emitter_m + vec3(10.0 * u.x - 5.0, 0.0, 10.0 * u.y - 5.0), vec3(0.0, -3.0, 0.0), 0.0);
}
Look look(Who who, inout Flight f) { return Look(vec2(0.05), 0.0, vec4(1.0), false); }
";
    let gpu = gpu();
    let dir = tempdir().unwrap();
    let text = POND
        .replace(
            "effect = \"rain\"\nat_m = [0, -15, 0]\nrate_per_s = 200",
            "effect = \"hail.glsl\"\nat_m = [0, 4, 0]",
        )
        .replace("frames = 25", "frames = 13");
    let scene = || Scene::parse(&text, "pond.toml", Some(dir.path()), &[]).unwrap();
    fs::write(dir.path().join("hail.glsl"), HAIL).unwrap();
    let written = run_with(&gpu, &scene(), |_| {});
    let stats = splashes(&written);
    assert!((90..310).contains(&stats.taken) && stats.missed == 0, "{stats:?}");
    fs::write(dir.path().join("hail.glsl"), HAIL.replace("ground = 1", "ground = 0")).unwrap();
    let error = scene().plan().unwrap_err().to_string();
    assert!(error.contains("hail.glsl: has impacts, and ends on no ground"), "{error}");
}
