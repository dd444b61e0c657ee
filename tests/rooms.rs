// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scenes of meshes: what `[[mesh]]`, `[volume]`, `[paint]` and emitters that collide take, and runs from end to end.
#![allow(missing_docs)]

mod common;

use common::gpu;
use std::{
    fs,
    mem::{offset_of, size_of},
};
use tempfile::{tempdir, TempDir};
use whitecap::{
    cells::Cells,
    draw::{map_view::MapViewParams, mesh::MeshParams, shadow::ShadowView, voxels::VoxelParams},
    gpu::{reflect::reflect, Gpu},
    particles::{balls::BallParams, Slabs, Surroundings},
    run::{self, picture::Picture, stats::VolumeStats, RunOptions, Written},
    scene::{builtin, Override, Scene},
    shaders,
};

const BLOCK: &str = "[[mesh]]\nname = 'block'\nshape = 'box'\nhalf_m = [0.4, 0.1, 0.4]\n";
const VOLUME: &str = "[volume]\nlow_m = [-1, -1, -1]\nsize_m = [2, 2, 2]\n";
const RAIN: &str =
    "[[emitter]]\nname = 'rain'\nlaw = 'colliding'\nradius_m = 0.02\npopulation = 100\nat_m = [0, 0.5, 0]\n\
                    spread_m = 0.3\nrespawn_below_m = -1\n";

fn parse(text: &str) -> Result<Scene, String> {
    Scene::parse(text, "room.toml", None, &[]).map_err(|error| error.to_string())
}

fn error(text: &str) -> String {
    parse(text).err().unwrap_or_else(|| panic!("no error in {text}"))
}

#[test]
fn a_wrong_key_is_named_with_its_value_and_what_is_allowed() {
    let one = |text: &str, says: &str| {
        let said = error(text);
        assert!(said.contains(says), "{text}: {said}");
    };
    one(
        "[[mesh]]\nshape = 'cube'",
        "mesh.0.shape is 'cube'; allowed: box, sphere, torus, capsule, lizard, room, stencil, lathe",
    );
    one("[[mesh]]\nname = 'x'", "mesh.0.shape is missing; allowed: box, sphere");
    one("[[mesh]]\nfile = 'a.stl'", "mesh.0.file is 'a.stl'; allowed: a .glb, .gltf or .obj file");
    one("[[mesh]]\nfile = 'a.obj'\nshape = 'box'", "shape is given beside file");
    one("[[mesh]]\nshape = 'box'\nhalf_m = [1, 0, 1]", "mesh.0.half_m.1 is 0; allowed: 0.0001 to 10000000");
    one("[[mesh]]\nshape = 'torus'\nring_m = 1\nradius_m = 2", "the tube is thinner than ring_m, 1");
    one(
        "[[mesh]]\nshape = 'room'\nhalf_m = [1, 1, 1]\nopen = ['lid']",
        "mesh.0.open.0 is 'lid'; allowed: left, right, floor",
    );
    one(
        "[[mesh]]\nshape = 'stencil'\nsize_m = [1, 1, 1]\npattern = ['##', '#']",
        "rows that differ in length",
    );
    one("[[mesh]]\nshape = 'stencil'\nsize_m = [1, 1, 1]\npattern = ['..']", "leaves nothing of the plate");
    one("[[mesh]]\nshape = 'lathe'\nprofile_m = [[0, 1], [0, 2]]", "a part without a surface");
    one(
        &format!("{BLOCK}keys = [{{ t_s = 1 }}, {{ t_s = 0.5 }}]"),
        "is 0.5, and that of the key before 1; times rise",
    );
    one(&format!("{BLOCK}loop = true"), "loop needs keys, two or more");
    one(&format!("{BLOCK}map = 64"), "map is for a mesh with paints = true");
    one(&format!("{BLOCK}{BLOCK}"), "is \"block\", as mesh.0 is called already");
    one(&format!("{VOLUME}{RAIN}"), "volume has nothing to hold");
    one(&format!("{BLOCK}{RAIN}"), "the scene has no [volume] to collide in");
    one(
        &format!("{BLOCK}{VOLUME}cell_m = 0.001\n"),
        "volume.cell_m makes 2000 cells along the longest side; allowed: 1 to 1024",
    );
    one(
        &format!("{BLOCK}{VOLUME}cells = 1024\n"),
        "volume.cells makes 1073741824 cells of 64 bytes; allowed: 67108863",
    );
    one(&format!("{BLOCK}{VOLUME}cells = 8\ncell_m = 0.1\n"), "is given beside cells");
    one(
        &format!("{BLOCK}[volume]\nlow_m = [0, 0, 0]\nhigh_m = [1, 0, 1]"),
        "each is more than that of low_m",
    );
    one(
        &format!("{BLOCK}[volume]\nlow_m = [1e6, 0, 0]\nsize_m = [1, 1, 1]"),
        "an f32 cannot tell a thousandth",
    );
    one(
        &format!("{BLOCK}{VOLUME}variant = 'slices'\n"),
        "allowed: \"conservative\" or \"layered\" or \"one-pass\"",
    );
    one(&format!("{BLOCK}{VOLUME}{RAIN}dt_s = 0.1\n"), "dt_s is that of [volume]");
    one(&format!("{BLOCK}{VOLUME}{RAIN}rate_per_s = 3\n"), "is given beside population");
    one(&format!("{BLOCK}{VOLUME}{RAIN}restitution = 2\n"), "restitution is 2; allowed: 0 to 1");
    one(
        &format!("{BLOCK}paints = true\n{VOLUME}{RAIN}"),
        "takes paint (paints = true), and the scene has no [paint]",
    );
    one(&format!("{BLOCK}{VOLUME}{RAIN}[paint]\nradius_m = 0.1"), "paint has nothing to paint");
    one(&format!("{BLOCK}paints = true\n[paint]\nradius_m = 0.1"), "paint has no one who paints");
    one(
        &format!("{BLOCK}paints = true\n{VOLUME}{RAIN}[paint]\nradius_m = 0.1\nshare = 4"),
        "share is for paint from particles; every impact paints",
    );
    one(
        &format!("{BLOCK}paints = true\n{VOLUME}{RAIN}[paint]\nradius_m = 0.1\nfrom = 'balls'"),
        "paint.from is 'balls'; allowed: \"impacts\" or \"particles\"",
    );
    one(&format!("[output]\nview = 'voxels'\n{BLOCK}"), "has a view of [volume], and the scene has none");
}

#[test]
fn a_scene_pays_for_what_it_names() {
    let has = |text: &str, wanted: &str| {
        let plan = parse(text).unwrap().plan().unwrap();
        plan.buffers.iter().any(|it| it.name.contains(wanted))
            || plan.passes.iter().any(|it| it.0.contains(wanted))
    };
    let fire = "[[emitter]]\neffect = 'fire'\n";
    for word in ["mesh", "cells", "impact", "paint", "shadow", "volume"] {
        assert!(!has(fire, word), "{word}");
    }
    assert!(has(BLOCK, "mesh.places") && has(BLOCK, "draw.shadow"));
    for word in ["mesh.pose", "cells", "impact", "paint", "volume"] {
        assert!(!has(BLOCK, word), "{word}");
    }
    let collides = format!("{BLOCK}{VOLUME}{RAIN}");
    assert!(has(&collides, "cells.planes") && has(&collides, "impact") && !has(&collides, "paint"));
    assert!(has(&format!("{BLOCK}paints = true\n{VOLUME}{RAIN}[paint]\nradius_m = 0.1"), "paint"));
}

#[test]
fn the_plan_lists_what_is_near_and_a_shadow_of_depth_alone() {
    let plan = parse(&format!("{BLOCK}{VOLUME}cells = 24\n{RAIN}")).unwrap().plan().unwrap();
    let bytes = |name: &str| plan.buffers.iter().find(|it| it.name.contains(name)).map(|it| it.bytes);
    let gpu = gpu();
    let grid = plan.volume.as_ref().unwrap().scene.grid();
    let near =
        Surroundings::new(&gpu, &Cells::new(&gpu, grid).unwrap(), 3, Slabs::OfAll).unwrap().near().bytes();
    // Four bits and five words a cell, and four bits that are there on the way, with a word behind them.
    let (cells, words) = (24u64.pow(3), 24u64.pow(3).div_ceil(8));
    let (found, between) = (4 * (words + 5 * cells), 4 * (words + 1));
    assert_eq!((near, bytes("particles.near")), (found, Some(found + between)));
    assert_eq!(bytes("draw.shadow"), Some(8 * 2048 * 2048));
    // Particles are listed while they wait, 10 words each.
    let particles = bytes("particles.particles.0").unwrap();
    assert_eq!(bytes("particles.deferred"), Some(16 + particles / 7 * 10));
}

#[test]
fn cells_are_cubes_that_reach_the_last_corner() {
    let volume =
        |text: &str| parse(&format!("{BLOCK}[volume]\nlow_m = [-1, 0, -1]\n{text}")).unwrap().volume.unwrap();
    assert_eq!(volume("size_m = [2, 2, 2]").cells, [32, 32, 32]);
    let long = volume("high_m = [3, 0.99, 0]\ncells = 40");
    assert_eq!((long.cells, long.cell_m), ([40, 10, 10], 0.1));
}

#[test]
fn a_mesh_file_is_looked_for_beside_the_scene() {
    let dir = tempdir().unwrap();
    let path = dir.path().join("scene.toml");
    fs::write(&path, "[[mesh]]\nfile = 'part.obj'\n").unwrap();
    let said = Scene::load(&path, &[]).unwrap().plan().unwrap_err().to_string();
    assert!(said.starts_with("part.obj: "), "{said}");
    fs::write(dir.path().join("part.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n").unwrap();
    let said = Scene::load(&path, &[]).unwrap().plan().unwrap_err().to_string();
    assert_eq!(said, "part.obj: line 4: index 4; allowed: 1 to 3, or -1 to -3");
    fs::write(dir.path().join("part.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let plan = Scene::load(&path, &[]).unwrap().plan().unwrap();
    assert_eq!((plan.meshes[0].mesh.triangles.len(), plan.meshes[0].moves()), (1, false));
    fs::write(
        &path,
        format!("[[mesh]]\nfile = 'part.obj'\npaints = true\n{VOLUME}{RAIN}[paint]\nradius_m = 0.1\n"),
    )
    .unwrap();
    let said = Scene::load(&path, &[]).unwrap().plan().unwrap_err().to_string();
    assert_eq!(said, "mesh.mesh: has no texture coordinates, so it cannot be painted");
}

#[test]
fn the_plan_says_how_many_cells_a_step_takes() {
    let scene = parse(&format!("{BLOCK}{VOLUME}{RAIN}velocity_mps = [0, -30, 0]\n")).unwrap();
    let plan = scene.plan().unwrap();
    let volume = plan.volume.unwrap();
    // 30 m/s and a fall of two metres, in a sixtieth of a second, over cells of a sixteenth of a metre.
    let expected = (30.0f64.powi(2) + 2.0 * 9.81 * 2.0).sqrt() / 60.0 * 16.0;
    assert!((volume.cells_a_step - expected).abs() < 1e-3, "{} {expected}", volume.cells_a_step);
    assert!(
        plan.emitters[0].reason.contains("cells a step at the most, more than one: the rule takes `dda2`"),
        "{}",
        plan.emitters[0].reason
    );
}

fn run_into(gpu: &Gpu, scene: &Scene, change: impl FnOnce(&mut RunOptions)) -> (TempDir, Written) {
    let dir = tempdir().unwrap();
    let mut options = RunOptions {
        out: dir.path().to_owned(),
        has_frames: true,
        hash_every: 1,
        checkpoint: None,
        resume: None,
        profile: Default::default(),
    };
    change(&mut options);
    let plan = scene.plan().unwrap();
    let written = run::run(gpu, scene, &plan, &options, |_| {}).unwrap();
    (dir, written)
}

fn picture(dir: &TempDir, frame: u32) -> Vec<u8> {
    Picture::read_png(&dir.path().join(format!("frames/frame_{frame:05}.png"))).unwrap().rgba
}

fn tiny(name: &str, more: &[&str]) -> Scene {
    let changes = ["output.size=[96, 54]", "output.frames=4", "output.fps=20"];
    let changes: Vec<Override> = changes.iter().chain(more).map(|it| it.parse().unwrap()).collect();
    builtin::load(name, &changes).unwrap()
}

const FEW: [&str; 3] = ["emitter.0.population=150", "emitter.1.population=150", "emitter.2.population=150"];

#[test]
fn every_scene_of_meshes_runs_twice_alike() {
    let gpu = gpu();
    let sand = ["emitter.0.rate_per_s=900", "emitter.1.rate_per_s=900", "emitter.2.rate_per_s=900"];
    for scene in [tiny("paint_shower", &FEW), tiny("marbles", &[]), tiny("sandblast", &sand)] {
        let (one, first) = run_into(&gpu, &scene, |_| {});
        let (other, second) = run_into(&gpu, &scene, |_| {});
        assert_eq!(first.stats.emitters, second.stats.emitters, "{}", scene.title);
        assert_eq!(first.stats.hashes, second.stats.hashes, "{}", scene.title);
        assert!(picture(&one, 3) == picture(&other, 3), "{}: pictures differ", scene.title);
        assert!(picture(&one, 0) != picture(&one, 3), "{}: nothing moves", scene.title);
        for stats in &first.stats.emitters {
            assert!(
                stats.alive > 0 && stats.spoiled == 0 && stats.dropped == 0,
                "{}: {stats:?}",
                scene.title
            );
        }
    }
}

#[test]
fn a_room_goes_on_from_a_checkpoint_to_the_bit() {
    let gpu = gpu();
    let more = [FEW[0], FEW[1], FEW[2], "output.frames=6"];
    let scene = tiny("paint_shower", &more);
    let (whole, all) = run_into(&gpu, &scene, |_| {});
    let dir = tempdir().unwrap();
    let file = dir.path().join("state");
    run_into(&gpu, &tiny("paint_shower", &FEW), |options| options.checkpoint = Some((file.clone(), 60)));
    let (rest, resumed) = run_into(&gpu, &scene, |options| options.resume = Some(file.clone()));
    assert_eq!(all.stats.emitters, resumed.stats.emitters);
    assert_eq!(all.stats.hashes.last(), resumed.stats.hashes.last());
    assert!(picture(&whole, 5) == picture(&rest, 5), "pictures differ");
}

macro_rules! assert_layout {
    ($spv:expr, $glsl:literal == $rust:ident { $($field:ident),* $(,)? }) => {{
        let interface = reflect($spv, &[8; 8]).unwrap();
        let glsl = interface.structs.get($glsl).unwrap_or_else(|| panic!("no struct `{}`", $glsl));
        let fields: Vec<_> = glsl.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
        assert_eq!(fields, [$((stringify!($field), offset_of!($rust, $field))),*], "fields of `{}`", $glsl);
        assert_eq!(glsl.bytes, size_of::<$rust>(), "size of `{}`", $glsl);
    }};
}

#[test]
fn what_crosses_to_the_gpu_is_laid_out_alike() {
    for spv in [shaders::DRAW_MESH_FRAG, shaders::DRAW_MESH_SHADOW_VERT] {
        assert_layout!(
            spv,
            "MeshParams" == MeshParams { color, first_triangle, first_joint, tile_m, reserved, map }
        );
        assert_layout!(spv, "Shadow" == ShadowView { right, up, to_sun, centre_m });
    }
    for spv in [shaders::PARTICLES_BALLS_VERT, shaders::PARTICLES_BALLS_SHADOW_VERT] {
        assert_layout!(spv, "BallParams" == BallParams { color, far_color });
    }
    assert_layout!(shaders::DRAW_VOXELS_VERT, "VoxelParams" == VoxelParams { grid, slot });
    assert_layout!(
        shaders::DRAW_MAP_PAINT_FRAG,
        "MapViewParams" == MapViewParams { low_m, high_m, corner, map }
    );
}

#[test]
fn every_way_to_fill_cells_and_to_paint_runs_and_every_view_shows_something() {
    let gpu = gpu();
    let heavy = [0, 1, 2].map(|i| format!("emitter.{i}.gravity_mps2=[0, -9, 0]"));
    let heavy: Vec<&str> = heavy.iter().map(String::as_str).collect();
    let paint = |more: &str| {
        // Half of the scene's along each side: texels enough, and `brute` asks each for every impact.
        let sizes = ["output.frames=14", "mesh.0.map=128", "mesh.1.map=256", more];
        let scene = tiny("paint_shower", &[&FEW[..], &heavy, &sizes].concat());
        let (_dir, written) = run_into(&gpu, &scene, |options| options.hash_every = 0);
        written.stats.volume.unwrap()
    };
    let default = paint("paint.variant=sifted");
    assert!(default.impacts > 100 && default.paint.iter().all(|it| it.painted > 0), "{default:?}");
    assert_eq!(
        (default.impacts_dropped, default.impacts_without_paint, default.not_finite),
        (0, 0, 0),
        "{default:?}"
    );
    assert_eq!(paint("paint.variant=brute"), default);
    for variant in ["layered", "one-pass"] {
        let drawn = paint(&format!("volume.variant={variant}"));
        // They lose what is steep to the way that they look, and find nothing that is not there.
        assert!(
            drawn.occupied > default.occupied / 4 && drawn.occupied < default.occupied,
            "{variant}: {drawn:?}"
        );
        assert!(drawn.impacts > 0, "{variant}: {drawn:?}");
    }
    let looks: Vec<Vec<u8>> = ["shaded", "voxels", "planes", "position_map", "paint_map"]
        .iter()
        .map(|view| {
            let scene = tiny(
                "paint_shower",
                &[&FEW[..], &["output.frames=1", &format!("output.view={view}")]].concat(),
            );
            picture(&run_into(&gpu, &scene, |_| {}).0, 0)
        })
        .collect();
    for (i, look) in looks.iter().enumerate() {
        let bright = look.chunks_exact(4).filter(|rgba| rgba[..3].iter().any(|byte| *byte > 60)).count();
        assert!(bright > 200, "view {i}: {bright} of 5184 pixels");
        assert!(looks[..i].iter().all(|other| other != look), "view {i} is another");
    }
}

#[test]
fn particles_that_are_near_paint_as_the_original_has_it() {
    let gpu = gpu();
    let paint = |more: &[&str]| {
        let from = [
            "output.frames=14",
            "paint.from=particles",
            "paint.radius_m=0.05",
            "mesh.0.map=64",
            "mesh.1.map=64",
        ];
        let heavy = [0, 1, 2].map(|i| format!("emitter.{i}.gravity_mps2=[0, -9, 0]"));
        let heavy: Vec<&str> = heavy.iter().map(String::as_str).collect();
        let scene = tiny("paint_shower", &[&FEW[..], &heavy, &from, more].concat());
        let plan = scene.plan().unwrap();
        let buffer = |name: &str| plan.buffers.iter().find(|it| it.name.contains(name)).unwrap().bytes;
        let most = if more.contains(&"paint.from=impacts") { 1 << 16 } else { 450 };
        assert_eq!(buffer("paint.drops"), 20 * most);
        let (_dir, written) = run_into(&gpu, &scene, |options| options.hash_every = 0);
        written.stats.volume.unwrap()
    };
    let all = paint(&[]);
    assert!(all.paint.iter().all(|it| it.painted > 0 && it.nowhere == 0), "{all:?}");
    assert_eq!(paint(&["paint.variant=brute"]), all);
    assert_eq!(paint(&["paint.variant=tiles"]), all);
    let impacts = paint(&["paint.from=impacts"]);
    assert!(impacts.impacts == all.impacts && impacts.paint_hash != all.paint_hash, "{impacts:?}");
    let third = paint(&["paint.share=3"]);
    let sum = |stats: &VolumeStats| stats.paint.iter().map(|it| it.painted).sum::<u64>();
    assert!(sum(&third) > 0 && sum(&third) < sum(&all), "{} of {}", sum(&third), sum(&all));
}

#[test]
fn an_impact_stream_that_is_too_small_says_so() {
    let gpu = gpu();
    let scene = tiny("paint_shower", &[&FEW[..], &["output.frames=24", "volume.impacts=2"]].concat());
    let (_dir, written) = run_into(&gpu, &scene, |options| options.hash_every = 0);
    let volume = written.stats.volume.unwrap();
    assert!(volume.impacts_dropped > 0 && volume.impacts > 0, "{volume:?}");
}

/// Balls fall on a block and knock something off it; the rest of the emitter's table is `more`.
fn knocked(effect: &str, more: &str) -> String {
    format!(
        "[output]\nsize = [96, 54]\nframes = 30\nfps = 60\n[camera]\neye_m = [0, 1, 2]\n{BLOCK}{VOLUME}{RAIN}\
         [[emitter]]\nname = 'chips'\neffect = '{effect}'\nfrom = 'impacts'\nsize = 3\n{more}\n"
    )
}

#[test]
fn what_does_not_go_with_births_from_impacts_is_named() {
    let one = |text: &str, says: &str| {
        let said = error(text);
        assert!(said.contains(says), "{text}: {said}");
    };
    let room = format!("{BLOCK}{VOLUME}{RAIN}");
    let chips = "[[emitter]]\neffect = 'dust'\nfrom = 'impacts'\n";
    one(chips, "emitter.0.from is \"impacts\", and the scene has no [volume] for anything to hit");
    one(
        &format!("{BLOCK}{VOLUME}{chips}"),
        "emitter.0.from is \"impacts\", and no [[emitter]] with law = \"colliding\" makes any",
    );
    for line in ["rate_per_s = 3", "at_m = [0, 0, 0]", "velocity_mps = [0, 0, 0]", "light = [1, 1, 1]"] {
        let key = line.split(' ').next().unwrap();
        one(
            &format!("{room}{chips}{line}\n"),
            &format!("emitter.1.{key} is given beside from = \"impacts\"; impacts say when and where"),
        );
    }
    one(
        &format!("{room}{chips}impacts = 8\n"),
        "emitter.1.impacts is given beside from = \"impacts\"; where what they throw lands",
    );
    one("[[emitter]]\neffect = 'dust'\nmost = 3\n", "emitter.0.most needs from = \"impacts\"");
    one("[[emitter]]\neffect = 'dust'\non = ['block']\n", "emitter.0.on needs from = \"impacts\"");
    one("[[emitter]]\neffect = 'dust'\nfrom = 'rain'\n", "emitter.0.from is 'rain'; allowed: \"impacts\"");
    one(&format!("{RAIN}from = 'impacts'\n"), "emitter.0.from is not a key");
    one(
        &format!("{room}{chips}by = ['sand']\n"),
        "emitter.1.by has \"sand\", which is no emitter that collides; there are: rain",
    );
    one(
        &format!("{room}{chips}on = ['block', 'wall']\n"),
        "emitter.1.on has \"wall\", which is no mesh that is solid; there are: block",
    );
    one(&format!("{room}{chips}by = [3]\n"), "emitter.1.by.0 is 3; allowed: names of emitters");
    one(&format!("{room}{chips}most = 0\n"), "emitter.1.most is 0; allowed: 1 to 67108864");
    one(
        &format!("{room}{chips}least_impulse_mps = -1\n"),
        "emitter.1.least_impulse_mps is -1; allowed: 0 or more",
    );
    let many = parse(&format!("{room}{chips}most = 60000\nburst = 60000\n")).unwrap().plan().unwrap_err();
    assert_eq!(
        many.to_string(),
        "emitter.dust: most x burst = 60000 x 60000: 1 to 268435456 particles are allowed"
    );
    // The rate of the file is of no matter.
    let ground = "[terrain]\nheightmap = 'builtin/fjord.png'\nsize_m = [9, 9]\nheight_m = [0, 1]\n";
    let splash = "[[emitter]]\nname = 'splash'\neffect = 'rain'\nfrom = 'impacts'\n";
    let plan = parse(&format!("{room}{splash}{ground}")).unwrap().plan().unwrap();
    assert_eq!(plan.emitters[1].capacity, 5 << 14);
}

#[test]
fn the_plan_of_births_from_impacts_is_what_is_paid_for() {
    let plan = parse(&knocked("dust", "most = 1000\nburst = 3")).unwrap().plan().unwrap();
    let bytes = |name: &str| plan.buffers.iter().find(|it| it.name.contains(name)).map(|it| it.bytes);
    // 100 balls, 16 orders each, three bits of 32 for each.
    assert_eq!(
        (bytes("ballistic.strikes"), bytes("ballistic.marks")),
        (Some(48_000), Some(12 * (16 * u64::from(plan.emitters[0].capacity)).div_ceil(32)))
    );
    let runs = |name: &str| plan.passes.iter().find(|it| it.0.contains(name)).map(|it| it.1);
    assert_eq!((runs("ballistic.mark"), runs("ballistic.living")), (Some(1.0), Some(1.0)));
    assert_eq!((plan.emitters[1].capacity, plan.emitters[1].has_place()), (3000, false));
    let without = parse(&format!("{BLOCK}{VOLUME}{RAIN}")).unwrap().plan().unwrap();
    assert!(without.passes.iter().all(|it| !it.0.contains("ballistic")));
    assert!(without.buffers.iter().all(|it| !it.name.contains("ballistic")));
}

#[test]
fn what_impacts_throw_is_the_same_again_and_at_any_rate_of_pictures() {
    let gpu = gpu();
    let of = |more: &str| {
        let text = knocked("dust", &format!("burst = 4\nlife_s = 0.333\n{more}"));
        parse(&text.replace("[volume]", "[volume]\ndt_s = 0.004166666666666667")).unwrap()
    };
    let (mut all, mut pictures) = (Vec::new(), Vec::new());
    // Half a second each.
    for (fps, frames) in [(24, 13), (60, 31), (240, 121), (240, 121)] {
        let mut scene = of("");
        (scene.output.fps, scene.output.frames) = (f64::from(fps), frames);
        let (dir, written) = run_into(&gpu, &scene, |options| options.hash_every = 0);
        all.push(written.stats.emitters.clone());
        pictures.push(picture(&dir, frames - 1));
    }
    let chips = all[0][1].clone();
    let kindled = chips.kindled.unwrap();
    assert!(chips.alive > 0 && kindled.impacts > 100, "{chips:?}");
    assert_eq!((kindled.overwritten, kindled.lost), (0, 0));
    assert_eq!((chips.born, chips.born), (4 * kindled.impacts, chips.alive + chips.aged));
    assert!(all[1..].iter().all(|it| it[1] == chips), "{all:?}");
    assert!(pictures[1..].iter().all(|it| *it == pictures[0]), "pictures differ");
    // A ring that is too small, a threshold, and somebody else's mesh.
    let stats = |more: &str| {
        let mut scene = of(more);
        scene.output.frames = 31;
        run_into(&gpu, &scene, |options| options.hash_every = 0).1.stats.emitters[1].clone()
    };
    let small = stats("most = 16");
    let lost = small.kindled.unwrap();
    assert!(lost.impacts == kindled.impacts && lost.overwritten > 0 && small.alive <= 64, "{small:?}");
    assert_eq!(small.born, small.alive + small.aged + lost.overwritten);
    let hard = stats("least_impulse_mps = 2").kindled.unwrap();
    assert!(hard.impacts > 0 && hard.impacts < kindled.impacts, "{hard:?} of {kindled:?}");
    assert_eq!(stats("on = ['block']\nby = ['rain']").kindled.unwrap(), kindled);
}

#[test]
fn births_from_impacts_go_on_from_a_checkpoint_to_the_bit() {
    let gpu = gpu();
    let scene = parse(&knocked("sparks", "")).unwrap();
    let (whole, all) = run_into(&gpu, &scene, |_| {});
    let dir = tempdir().unwrap();
    let file = dir.path().join("state");
    let mut half = scene.clone();
    half.output.frames = 24;
    run_into(&gpu, &half, |options| options.checkpoint = Some((file.clone(), 60)));
    let (rest, resumed) = run_into(&gpu, &scene, |options| options.resume = Some(file.clone()));
    assert!(all.stats.emitters[1].kindled.unwrap().impacts > 0);
    assert_eq!(all.stats.emitters, resumed.stats.emitters);
    assert_eq!(all.stats.hashes.last(), resumed.stats.hashes.last());
    assert!(picture(&whole, 29) == picture(&rest, 29), "pictures differ");
    // A threshold more is another scene.
    let other = parse(&knocked("sparks", "least_impulse_mps = 1")).unwrap();
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
fn every_way_to_draw_shows_what_impacts_throw_and_nothing_before_the_first() {
    let gpu = gpu();
    let mut ways = vec!["quads", "splat"];
    ways.extend(gpu.has_geometry_shader().then_some("geometry"));
    let shot = |text: &str| {
        let (dir, written) = run_into(&gpu, &parse(text).unwrap(), |options| options.hash_every = 0);
        (picture(&dir, 29), picture(&dir, 3), written.stats)
    };
    let whole = knocked("sparks", "");
    let (bare, early_bare, _) = shot(whole.split("[[emitter]]\nname = 'chips'").next().unwrap());
    let mut shots = Vec::new();
    for way in ways {
        let (late, early, stats) = shot(&knocked("sparks", &format!("draw = '{way}'")));
        assert!(stats.emitters[1].alive > 100, "{way}: {:?}", stats.emitters[1]);
        // Nothing has fallen as far as the block yet.
        assert!(early == early_bare, "{way}: something is seen before the first impact");
        let changed = late.chunks(4).zip(bare.chunks(4)).filter(|(a, b)| a != b).count();
        assert!((100..4000).contains(&changed), "{way} changes {changed} pixels");
        shots.push(late);
    }
    let apart = |a: &[u8], b: &[u8]| {
        a.iter().zip(b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64
    };
    eprintln!("splat {:.3}", apart(&shots[0], &shots[1]));
    assert!(apart(&shots[0], &shots[1]) < 2.0, "{}", apart(&shots[0], &shots[1]));
    assert!(shots.get(2).is_none_or(|it| *it == shots[0]), "geometry");
}

const GRIT: &str = "/* effect
rate_per_s = 50
life_s = 60
*/
Birth birth(Who who, vec3 emitter_m) {
    return Birth(emitter_m, struck.impulse_mps * struck.normal - 0.1 * struck.velocity_mps, 0.0);
}
Look look(Who who, inout Flight f) { return Look(vec2(0.02), 0.0, vec4(0.2, 0.1, 0.0, 0.0), false); }
";

#[test]
fn a_users_effect_is_told_of_its_impact_and_its_mistakes_have_a_line() {
    let gpu = gpu();
    let dir = tempdir().unwrap();
    let load = |glsl: &str, text: &str| {
        fs::write(dir.path().join("grit.glsl"), glsl).unwrap();
        fs::write(dir.path().join("scene.toml"), text).unwrap();
        Scene::load(&dir.path().join("scene.toml"), &[]).unwrap()
    };
    let text = knocked("grit.glsl", "burst = 2");
    let (_out, written) = run_into(&gpu, &load(GRIT, &text), |options| options.hash_every = 0);
    let stats = &written.stats.emitters[1];
    assert!(stats.alive > 100 && stats.alive == stats.born, "{stats:?}");
    let said = load(&GRIT.replace("struck.normal", "struck.normale"), &text).plan().unwrap_err().to_string();
    for says in ["grit.glsl: does not compile", "grit.glsl:6: error: 'normale'", "    6 |     return Birth("]
    {
        assert!(said.contains(says), "{said}");
    }
    // The same file by the clock: what it would be told of is at rest.
    let clock = "[output]\nsize = [64, 48]\nframes = 2\n[[emitter]]\neffect = 'grit.glsl'\nrate_per_s = 20\n";
    load(GRIT, clock).plan().unwrap();
}
