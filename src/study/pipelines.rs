// SPDX-License-Identifier: MIT OR Apache-2.0
//! Every kernel and graphics pipeline of the crate, built once and without a state, for what the driver makes of them
//! ([`PipelineReport`]): with the tunings of this device for large grids, and as the built-in scenes draw.

use super::{bench, black_hole, hard, OnProgress, Progress, Result};
use crate::{
    ballistic::{
        draw::Drawing, Builtin, GroundGrid, Kindling, KindlingInfo, Land, Landing, StoredEffect,
        StreamedEffect,
    },
    disks::{self, draw::DisksDraw, starts, Borders, List, Model, Response, Space},
    draw::{Stage, TerrainGrid},
    gpu::{Gpu, PipelineReport},
    impact::Stream,
    mesh::Pose,
    particles::{
        black_hole::BlackHole, black_hole_fate::Fates, drag::Drag, kepler_stateless, Compaction, Options,
        Particles,
    },
    prims::{Bins, Compact, Scan, Sums},
    run::{RunError, World},
    scene::{builtin, Override},
    shaders,
    water::{
        draw::{Drawn, Look, SurfaceDraw},
        Absorb, Bodies, Book, Disturb, Fourth, Fused, FusedTuning, Halves, Pipes, PipesTuning, Shallow,
        Splash, Tier, Tuning, Walls, Waves, Wet,
    },
};
use glam::{uvec2, vec2, UVec2, Vec3};

/// One group of pipelines.
type Build = fn(&Gpu) -> Result<()>;

const GROUPS: [(&str, Build); 10] = [
    ("system", system),
    ("prims", prims),
    ("water", water),
    ("water, drawn", surfaces),
    ("particles", particles),
    ("ballistic", ballistic),
    ("disks", collisions),
    ("sprites", bench::draw::build),
    ("volume", bench::volume::build),
    ("scenes", scenes),
];

/// Grids that tunings are for: large where the device is.
const LARGE: UVec2 = uvec2(4096, 4096);

/// What [`pipelines`] found.
pub struct Found {
    /// Sorted by name.
    pub pipelines: Vec<PipelineReport>,
    /// Groups that were not built to their end, and why.
    pub left_out: Vec<(&'static str, String)>,
}

/// Builds all, and says what became of those whose name, or a shader's, contains one of `names`; of all if there are none.
/// The device has been opened by [`Gpu::capturing`].
pub fn pipelines(gpu: &Gpu, names: &[String], progress: OnProgress<'_>) -> Found {
    let mut left_out = Vec::new();
    for (done, (now, build)) in GROUPS.into_iter().enumerate() {
        progress(Progress { done, of: GROUPS.len(), now });
        if let Err(error) = build(gpu) {
            left_out.push((now, error.to_string()));
        }
    }
    let mut all = gpu.pipelines();
    let is_wanted = |it: &PipelineReport| {
        let called =
            |name: &String| it.name.contains(name) || it.shaders.iter().any(|file| file.contains(name));
        names.is_empty() || names.iter().any(called)
    };
    all.retain(is_wanted);
    all.sort_by(|a, b| (&a.name, &a.shaders, &a.constants).cmp(&(&b.name, &b.shaders, &b.constants)));
    // A pipeline that two of them build is one.
    all.dedup_by(|a, b| (&a.name, &a.shaders, &a.constants) == (&b.name, &b.shaders, &b.constants));
    Found { pipelines: all, left_out }
}

fn system(gpu: &Gpu) -> Result<()> {
    bench::copy_kernel(gpu)?;
    gpu.clock()?; // its check has a kernel of its own
    Ok(())
}

fn prims(gpu: &Gpu) -> Result<()> {
    let mut ways = vec![Sums::Shared, Sums::for_device(gpu)];
    ways.dedup();
    for sums in ways {
        Scan::new(gpu, sums)?;
        Compact::new(gpu, sums)?;
        Bins::new(gpu, sums)?;
    }
    Pose::new(gpu)?;
    Ok(())
}

fn water(gpu: &Gpu) -> Result<()> {
    Book::new(gpu)?;
    let (one, fused) = (Tuning::for_grid(gpu, LARGE), FusedTuning::for_grid(gpu, LARGE));
    for has_land in [false, true] {
        Waves::new(gpu, one, has_land)?;
        Fourth::new(gpu, one, has_land)?;
        Fused::new(gpu, fused, Walls::Folded, has_land)?;
        for tuning in [PipesTuning::OneStep(one), PipesTuning::for_grid(gpu, LARGE)] {
            Pipes::new(gpu, tuning, true, has_land)?;
        }
    }
    for tuning in [PipesTuning::OneStep(one), PipesTuning::Fused(fused)] {
        Halves::new(gpu, tuning, Walls::Folded)?;
    }
    Wet::new(gpu, Tier::Wet.tuning(gpu, LARGE))?;
    Shallow::new(gpu, Tier::Shallow.tuning(gpu, LARGE))?;
    Disturb::new(gpu)?;
    Splash::new(gpu)?;
    Bodies::new(gpu)?;
    Absorb::new(gpu)?;
    Ok(())
}

/// How each kind of water is drawn, of a few columns.
fn surfaces(gpu: &Gpu) -> Result<()> {
    if !gpu.has_graphics() {
        return Ok(());
    }
    let cells = uvec2(16, 16);
    let stage = Stage::new(gpu, uvec2(64, 64), Some(TerrainGrid::flat(vec2(10.0, 10.0), -1.0)))?;
    let waves = Waves::new(gpu, Tuning::for_grid(gpu, cells), false)?.state(cells)?;
    let pipes = Pipes::new(gpu, PipesTuning::for_grid(gpu, cells), true, false)?.state(cells)?;
    let wet = Wet::new(gpu, Tier::Wet.tuning(gpu, cells))?.state(cells)?;
    for look in [Look::Shaded, Look::Wireframe] {
        for drawn in [Drawn::Level(waves.surfaces()), Drawn::Pipes(&pipes), Drawn::Depth(&wet)] {
            SurfaceDraw::new(gpu, &stage, &drawn, look)?;
        }
    }
    Ok(())
}

fn particles(gpu: &Gpu) -> Result<()> {
    let usual = Options::for_device(gpu);
    for compaction in [
        Compaction::Stable,
        Compaction::Group,
        Compaction::Subgroup,
        Compaction::Atomic,
        Compaction::InPlace,
        Compaction::Ring,
    ] {
        if compaction != Compaction::Subgroup || gpu.adapter().has("subgroup ballot") {
            Particles::new(gpu, &Drag::LAW, Options { compaction, ..usual })?;
        }
    }
    let (fountain, orbits) =
        (kepler_stateless::Fountain::book(100.0), black_hole::ellipses(1, 20.0, 60.0, true));
    for variant in ["euler", "leapfrog", "forest-ruth", "rk4", "logh", "kepler"] {
        let law = black_hole::law(variant, black_hole::hole());
        let options = Options { compaction: Compaction::InPlace, ..usual };
        Particles::new(gpu, &BlackHole::law(&law.constants()), options)?;
        Fates::new(gpu, &law, &orbits)?;
    }
    for writes in [false, true] {
        kepler_stateless::Stateless::new(gpu, &fountain, 1, writes)?;
    }
    Ok(())
}

fn ballistic(gpu: &Gpu) -> Result<()> {
    let ground = gpu.upload("ballistic.ground_m", &[0f32; 4])?;
    let stream = Stream::new(gpu, 64)?;
    let stage = if gpu.has_graphics() { Some(Stage::new(gpu, uvec2(64, 64), None)?) } else { None };
    for builtin in Builtin::ALL {
        builtin.materialise(gpu)?;
        if let Some(spv) = builtin.landing() {
            let landing = Landing { effect: builtin.effect(), source: 0 };
            let of = (c"ballistic.land", spv);
            Land::new(gpu, of, landing, (0, 0), (&ground, &GroundGrid::FLAT), &stream)?;
        }
        if let Some(stage) = &stage {
            Drawing::new(gpu, stage, builtin, Some(&ground))?;
        }
    }
    let stream = Stream::new(gpu, 64)?;
    let info = KindlingInfo {
        most: 64,
        burst: 1,
        life_s: 1.0,
        least_impulse_mps: 0.0,
        sources: vec![64],
        meshes: Vec::new(),
    };
    let kindling = Kindling::new(gpu, &stream, &info)?;
    for (name, spv) in [
        (c"ballistic.sparks_kindled", shaders::BALLISTIC_SPARKS_KINDLED_COMP),
        (c"ballistic.dust_kindled", shaders::BALLISTIC_DUST_KINDLED_COMP),
    ] {
        kindling.vertices(name, spv, None)?;
    }
    let fire = Builtin::Fire.effect();
    StoredEffect::new(gpu, c"ballistic.fire_emit", shaders::BALLISTIC_FIRE_EMIT_COMP, &fire, 64)?;
    if gpu.has_transform_feedback() {
        StreamedEffect::new(gpu, c"ballistic.stream", shaders::BALLISTIC_FIRE_STREAM_VERT, &fire, 64)?;
    }
    super::ballistic::integrate_kernel(gpu)?;
    hard::ballistic::fall_kernel(gpu)?;
    Ok(())
}

fn collisions(gpu: &Gpu) -> Result<()> {
    List::new(gpu)?;
    for space in [Space::Flat, Space::Solid] {
        let start = starts::seed(space, 100, Borders::Walls, 1);
        let matching = Response::Matching { rounds: 3, rewinds: true };
        let xpbd = Response::Xpbd { bounces: true };
        for response in [Response::Seed, Response::GaussSeidel, matching, xpbd] {
            let model = Model { response, ..start.model };
            let state = disks::Sorted::new(gpu, &model, false, false)?.state(&model, &start.disks)?;
            if gpu.has_graphics() {
                let stage = Stage::new(gpu, uvec2(64, 64), None)?;
                DisksDraw::new(gpu, &stage, &state, Vec3::ZERO)?;
            }
        }
    }
    Ok(())
}

/// What the built-in scenes are stepped and drawn with, in small pictures.
fn scenes(gpu: &Gpu) -> Result<()> {
    if !gpu.has_graphics() {
        return Ok(());
    }
    let mut all: Vec<(&str, Option<&str>)> = builtin::list().map(|(name, _)| (name, None)).collect();
    all.push(("black_hole", Some("emitter.0.draw=\"splat\"")));
    all.extend(gpu.has_geometry_shader().then_some(("black_hole", Some("emitter.0.draw=\"geometry\""))));
    for view in ["voxels", "planes", "position_map", "paint_map"] {
        all.push(("paint_shower", Some(view)));
    }
    for (name, drawn) in all {
        // A change, or a view.
        let drawn =
            drawn.map(|it| if it.contains('=') { it.into() } else { format!("output.view=\"{it}\"") });
        let changes = [Some("output.size=[64, 64]".into()), drawn];
        let changes = changes.iter().flatten().map(|change: &String| change.parse());
        let changes: Vec<Override> = changes.collect::<Result<_, _>>().map_err(RunError::from)?;
        let scene = builtin::load(name, &changes).map_err(RunError::from)?;
        World::new(gpu, &scene, &scene.plan().map_err(RunError::from)?)?;
    }
    Ok(())
}
