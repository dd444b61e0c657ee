// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every rung of water as a scene runs it: fused steps, checkpoints, volumes, dry land, and errors within the tolerance.
#![cfg(feature = "tools")]
#![allow(missing_docs)]

mod common;

use whitecap::{
    gpu::{Access, Gpu, Submitter},
    run::{checkpoint::Checkpoint, Falls, World},
    scene::{Scene, Simulation},
    water::{oracle, Disturb, DisturbParams, Surface, Tuning, Waves},
};

const OUTPUT: &str = "output = { size = [16, 16], fps = 25, frames = 26 }\n";

/// A lake of odd size with a hump, and what is added to it.
fn lake(model: &str, more: &str) -> Scene {
    let text = format!(
        "{OUTPUT}[[water]]\nname = 'lake'\nmodel = '{model}'\ncells = [65, 33]\nsize_m = [16.25, 8.25]\ndepth_m = 2\n\
         start = {{ shape = 'hump', height_m = 0.2, at_m = [-2, 1], radius_m = 1.2 }}\n{more}"
    );
    Scene::parse(&text, "lake.toml", None, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// The world after so many pictures.
fn after(gpu: &Gpu, scene: &Scene, pictures: u32) -> World {
    let mut world = World::new(gpu, scene, &scene.plan().unwrap()).unwrap();
    go_on(gpu, scene, &mut world, 0..pictures);
    world
}

fn go_on(gpu: &Gpu, scene: &Scene, world: &mut World, pictures: std::ops::Range<u32>) {
    let mut submitter = Submitter::new(gpu, 64).unwrap();
    for picture in pictures {
        world.frame(&mut submitter, if picture == 0 { 0.0 } else { 1.0 / scene.output.fps }).unwrap();
    }
}

fn state(gpu: &Gpu, world: &World) -> Vec<f32> {
    world.checkpoint(gpu, 0).unwrap().states.remove(0)
}

const DROP: &str = "[[water.drop]]\nat_m = [3, 1]\nradius_m = 1\nvolume_m3 = 0.1\nevery_s = 0.13\n";
const SOURCE: &str = "[[water.source]]\nat_m = [3, 1]\nradius_m = 1\nrate_m3ps = 0.5\nend_s = 0.5\n";
const WALL: &str = "[[water.wall]]\nfrom_m = [0, -9]\nto_m = [1, 1]\n";
const BODY: &str =
    "[[water.body]]\nshape = 'sphere'\nradius_m = 1\npath = [[0, -3, 0.5, 0], [1, 3, 0.5, 0]]\n";
const RAIN: &str = "[water.rain]\nmm_per_h = 90000\n";

/// Model and what goes with it, one of each.
fn rungs() -> Vec<(&'static str, String)> {
    vec![
        ("book", format!("{DROP}{BODY}")),
        ("waves", format!("{DROP}{WALL}")),
        ("waves", format!("borders = 'absorb'\nabsorb_width_m = 2\n{BODY}{SOURCE}")),
        ("waves", format!("order = 4\n{DROP}{WALL}")),
        ("pipes", format!("diagonal = 0\n{DROP}{WALL}")),
        ("pipes", format!("foam = true\n{SOURCE}{BODY}")),
        ("wet", format!("{DROP}{WALL}{RAIN}")),
        ("shallow", format!("{DROP}{SOURCE}{WALL}{RAIN}")),
    ]
}

#[test]
fn every_rung_goes_on_from_a_checkpoint_to_the_bit() {
    let gpu = common::gpu();
    for (model, more) in rungs() {
        let scene = lake(model, &more);
        let whole = after(&gpu, &scene, 12);
        let half = after(&gpu, &scene, 5).checkpoint(&gpu, 4).unwrap();
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("state");
        half.write(&path).unwrap();
        let mut world = World::new(&gpu, &scene, &scene.plan().unwrap()).unwrap();
        assert!(world.restore(&gpu, &Checkpoint::read(&path, &scene).unwrap()).unwrap());
        go_on(&gpu, &scene, &mut world, 5..12);
        let (got, want) = (state(&gpu, &world), state(&gpu, &whole));
        assert!(got.iter().zip(&want).all(|(a, b)| a.to_bits() == b.to_bits()), "{model} with {more}");
        assert!(want.iter().any(|&h| h != want[0]), "{model}: nothing moves");
        // That of another grid is refused.
        let mut other = half.clone();
        other.states[0].pop();
        assert!(!world.restore(&gpu, &other).unwrap());
    }
}

#[test]
fn what_is_given_is_what_is_gained() {
    let gpu = common::gpu();
    for (model, more) in rungs() {
        let scene = lake(model, &more);
        let plan = scene.plan().unwrap();
        let out = tempfile::tempdir().unwrap();
        let options = whitecap::run::RunOptions {
            out: out.path().to_owned(),
            has_frames: false,
            hash_every: 0,
            checkpoint: None,
            resume: None,
            profile: Default::default(),
        };
        let stats = whitecap::run::run(&gpu, &scene, &plan, &options, |_| ()).unwrap().stats;
        let water = &stats.waters[0];
        assert_eq!(water.variant, scene.water[0].variant().name());
        assert_eq!(
            (water.disturbances_rejected, water.disturbances_missed, water.disturbances_dropped),
            (0, 0, 0)
        );
        if more.contains("absorb") {
            continue; // waves carry volume out
        }
        let given = water.volume_given_m3;
        assert!(given > 0.2, "{model}: {given}");
        // Rounding of f32 heights: 1e-7 of 2 m in each of 2145 columns, random over some hundred steps, and twice as much
        // for two floats a column, whose sum is not kept by pairs.
        let error = (water.volume_gain_m3 - given).abs();
        assert!(error < 2e-4, "{model} with {more}: {} of {given}", water.volume_gain_m3);
        if let Some(depths) = &water.depths {
            assert!((1.9..2.6).contains(&depths.deepest_m) && depths.least_m > 1.5, "{depths:?}");
            assert_eq!((depths.in_debt, depths.cut_off, depths.wet), (0, 0, depths.open));
        }
    }
}

/// Steps are fused from one drop to the next; here is the same run with one step a dispatch.
#[test]
fn fused_steps_between_drops_are_single_steps_to_the_bit() {
    let gpu = common::gpu();
    // 1 / 25 s is 4 steps of this one; the drops fall before steps 0, 13, 26, ...
    let scene = lake("waves", &format!("dt_s = 0.01\n{DROP}"));
    let plan = scene.plan().unwrap();
    let Simulation::Level { model, is_fused: true, height_m, .. } = &plan.waters[0].simulation else {
        panic!("{:?}", plan.waters[0].simulation)
    };
    let got = state(&gpu, &after(&gpu, &scene, 26));

    let mut waves =
        Waves::new(&gpu, Tuning::for_grid(&gpu, model.cells), false).unwrap().state(model.cells).unwrap();
    waves.upload(&gpu, height_m, &vec![0.0; height_m.len()]).unwrap();
    let velocity = waves.velocity().clone();
    let list = Disturb::new(&gpu).unwrap().list(waves.surfaces(), Some(&velocity), 8).unwrap();
    let (params, falls) =
        (model.params(waves.pitch()), Falls::new(&scene.water[0], scene.seed, 0, model.dt_s));
    let disturb = DisturbParams {
        cells: model.cells,
        pitch: waves.pitch(),
        stride: 1,
        cell_m: model.cell_m as f32,
        limit_m: 10.0,
        has_velocity: 1,
    };
    let mut fallen = 0;
    for step in 0..100 {
        let falling = falls.at_step(step);
        fallen += falling.len();
        let (staging, _) = list.staging(&falling).unwrap();
        gpu.once(|rec| {
            rec.copy(&staging, list.list());
            rec.barrier(Access::CopyWrite, Disturb::ENTRY);
            let surface: Surface<'_> = waves.surface();
            list.record(rec, &surface, &disturb);
            rec.barrier(Disturb::EXIT, Waves::ENTRY);
            waves.record(rec, &if step == 0 { params.first_from_rest() } else { params });
        })
        .unwrap();
    }
    assert_eq!(fallen, 8);
    let want: Vec<f32> =
        [waves.height(), waves.velocity()].map(|buffer| gpu.download(buffer).unwrap()).concat();
    let pitch = waves.pitch() as usize;
    let of_columns = |all: &[f32]| -> Vec<u32> {
        all.chunks_exact(pitch).flat_map(|row| &row[..65]).map(|x| x.to_bits()).collect()
    };
    assert!(of_columns(&got) == of_columns(&want));
}

/// A tolerance chooses a variant; what it then gets wrong is measured against the exact solution, and so is every variant
/// that would have been cheaper.
#[test]
fn the_choice_keeps_its_tolerance_and_no_cheaper_one_would() {
    let gpu = common::gpu();
    let scene = |keys: &str| {
        let text = format!(
            "output = {{ size = [16, 16], fps = 5, frames = 52 }}\n[[water]]\n{keys}\ncells = [96, 96]\n\
             size_m = [16, 16]\ndepth_m = 1\ndamping_per_s = 0\n\
             start = {{ shape = 'hump', height_m = 1e-5, at_m = [2, -1], radius_m = 0.9 }}\n"
        );
        Scene::parse(&text, "tank.toml", None, &[]).unwrap_or_else(|error| panic!("{error}"))
    };
    let measured = |scene: &Scene| -> f64 {
        let plan = scene.plan().unwrap();
        let Simulation::Level { model, height_m, .. } = &plan.waters[0].simulation else {
            panic!("level water")
        };
        let got = state(&gpu, &after(&gpu, scene, scene.output.frames));
        let time_s = f64::from(scene.output.frames - 1) / scene.output.fps;
        let want = oracle::Exact::new(model.cells, height_m).after(model.speed_mps * time_s / model.cell_m);
        oracle::relative_l2(&got[..96 * 96], &want)
    };
    let mut variants = Vec::new();
    for tolerance in [0.06, 0.03, 0.002] {
        let scene_of = scene(&format!("tolerance = {tolerance}"));
        let choice = &scene_of.water[0].choice;
        let (taken, error) = (choice.taken(), measured(&scene_of));
        assert!(error <= tolerance, "{tolerance}: {} has {error}", taken.name);
        // The prediction is a good one, too: within a quarter, or of the rule for the model's error, which the exact
        // solution does not have.
        let expected = taken.grid_error;
        assert!(
            (error / expected - 1.0).abs() < 0.25 || (error - expected).abs() < taken.model_error,
            "{} has {error}, not {expected}",
            taken.name
        );
        for cheaper in choice.verdicts.iter().filter(|v| v.ns_per_column_second < taken.ns_per_column_second)
        {
            let variant = cheaper.variant;
            let order = if variant.order == 4 {
                "order = 4".into()
            } else {
                format!("diagonal = {}", variant.diagonal)
            };
            let other = scene(&format!("model = '{}'\n{order}", variant.model.name()));
            assert_eq!(other.water[0].variant(), variant);
            let error = measured(&other);
            assert!(error > tolerance, "{tolerance}: {} costs less and has {error}", cheaper.name);
        }
        variants.push(taken.name.clone());
    }
    variants.dedup();
    assert!(variants.len() > 1 && variants.contains(&"waves/fourth".to_string()), "{variants:?}");
}

#[test]
fn a_dam_break_floods_dry_land_and_only_that() {
    let gpu = common::gpu();
    for model in ["wet", "shallow"] {
        let text = format!(
            "{OUTPUT}terrain = {{ heightmap = 'builtin/pond.asc' }}\n[[water]]\nmodel = '{model}'\ncells = [64, 64]\n\
             depth_m = 1.2\nlevel_m = -3\n\
             start = {{ shape = 'block', height_m = 3.6, from_m = [-20, -20], to_m = [-3, 20] }}\n"
        );
        let scene = Scene::parse(&text, "dam.toml", None, &[]).unwrap();
        let plan = scene.plan().unwrap();
        let Simulation::Depth { columns, .. } = &plan.waters[0].simulation else { panic!("over ground") };
        let wet = |depths: &[f64]| depths.iter().filter(|&&depth| depth > 1e-3).count();
        let dry_at_start = columns.depths_m().iter().filter(|&&depth| depth == 0.0).count();
        assert!(dry_at_start > 1500 && wet(&columns.depths_m()) > 300, "{dry_at_start}");
        let out = tempfile::tempdir().unwrap();
        let options = whitecap::run::RunOptions {
            out: out.path().to_owned(),
            has_frames: false,
            hash_every: 0,
            checkpoint: None,
            resume: None,
            profile: Default::default(),
        };
        let stats = whitecap::run::run(&gpu, &scene, &plan, &options, |_| ()).unwrap().stats;
        let water = &stats.waters[0];
        let depths = water.depths.as_ref().unwrap();
        // 4096 columns of up to 1.2 m, each right to 1e-7 of it.
        assert!(water.volume_gain_m3.abs() < 1e-4, "{}", water.volume_gain_m3);
        assert!(depths.least_m >= 0.0 && depths.in_debt == 0, "{depths:?}");
        assert!(depths.wet > wet(&columns.depths_m()) + 100, "{depths:?}");
        assert!(depths.fastest_mps > 1.0, "{water:?}");
        let is_lossy = water.energy_relative.map(|energy| (0.5..1.0).contains(&energy));
        assert_eq!(is_lossy, (model == "shallow").then_some(true), "{water:?}");
    }
}
