// SPDX-License-Identifier: MIT OR Apache-2.0
//! The keys of a scene file, their ranges and defaults: one function for each table.

use std::path::Path;

use super::{
    attractors, builtin, disks,
    error::ProblemKind,
    heightmap::{self, Format},
    meshes,
    node::Sources,
    paint,
    parameter::Parameter,
    parse::{
        Reader, Rule,
        Rule::{AtLeastZero, Within},
        Table,
    },
    particles, splash, volume, water_table, Camera, Output, Override, Scene, SceneError, Sun, TerrainSource,
    View, WaterScene,
};

/// Lengths and places (m): beyond them f32 has no columns left.
pub(super) const LENGTH: Rule = Within(1e-4, 1e7);
pub(super) const PLACE: Rule = Within(-1e7, 1e7);

pub(super) fn scene(
    text: &str,
    file_name: &str,
    base_dir: Option<&Path>,
    overrides: &[Override],
) -> (Result<Scene, SceneError>, Vec<Parameter>) {
    let (sources, root) = match Sources::read(text, file_name, overrides) {
        Ok(read) => read,
        Err(problems) => return (Err(SceneError::Invalid(problems)), Vec::new()),
    };
    let reader = Reader::new(sources);
    let mut table = reader.root(&root);

    let title = table.text("title", "a text", |_| true).unwrap_or_default().to_owned();
    let seed = table.maybe("seed", AtLeastZero).unwrap_or(1);
    let output = output(table.table_or_empty("output"));
    let sun = sun(table.table_or_empty("sun"));
    let terrain = table.table("terrain").map(|table| terrain(table, base_dir));
    let mut water: Vec<WaterScene> = Vec::new();
    for table in table.tables("water") {
        let next = water_table::water(table, terrain.as_ref(), &water, &output);
        water.push(next);
    }
    let attractors = attractors::attractors(&mut table);
    let emitters = particles::emitters(&mut table, &attractors, terrain.is_some() || !water.is_empty());
    let disks = disks::disks(&mut table);
    let meshes = meshes::meshes(&mut table);
    let volume = table.table("volume").map(volume::volume);
    let paint = table.table("paint").map(paint::paint);
    splash::check_together(&mut table, &emitters);
    volume::check_together(&mut table, (volume.as_ref(), paint.as_ref()), &meshes, &emitters, output.view);
    // A water that could not be read has been reported already.
    let is_empty = water.is_empty() && emitters.is_empty() && disks.is_empty() && meshes.is_empty();
    let tables = ["terrain", "water", "emitter", "disks", "mesh"];
    let is_blank = !tables.into_iter().any(|key| table.has(key));
    if is_empty && (is_blank || !table.has("terrain") && reader.is_clean()) {
        table.conflict(
            "",
            "nothing to see: a scene has [terrain], [[water]], [[emitter]], [[disks]] or [[mesh]]",
        );
    }
    let (has_camera, camera_table) = (table.is_table("camera"), table.table_or_empty("camera"));
    let mut scene = Scene {
        title,
        seed,
        output,
        camera: None,
        sun,
        terrain,
        water,
        emitters,
        attractors,
        disks,
        meshes,
        volume,
        paint,
        base_dir: base_dir.map(Path::to_owned),
    };
    scene.camera = Some(camera(camera_table, scene.camera())).filter(|_| has_camera);
    table.finish();

    let (problems, parameters) = reader.finish();
    let read = if problems.is_empty() { Ok(scene) } else { Err(SceneError::Invalid(problems)) };
    (read, parameters)
}

fn output(mut table: Table<'_>) -> Output {
    let default = Output::default();
    let output = Output {
        size: table.maybe("size", Within(16.0, 8192.0)).unwrap_or(default.size),
        fps: table.maybe("fps", Within(1.0, 1000.0)).unwrap_or(default.fps),
        frames: table.maybe("frames", Within(1.0, 1e6)).unwrap_or(default.frames),
        view: table.choice("view", &View::ALL).unwrap_or(default.view),
    };
    table.finish();
    output
}

fn camera(mut table: Table<'_>, default: Camera) -> Camera {
    let camera = Camera {
        eye_m: table.maybe("eye_m", PLACE).unwrap_or(default.eye_m),
        target_m: table.maybe("target_m", PLACE).unwrap_or(default.target_m),
        fov_deg: table.maybe("fov_deg", Within(5.0, 120.0)).unwrap_or(default.fov_deg),
        orbit_deg_per_s: table
            .maybe("orbit_deg_per_s", Within(-360.0, 360.0))
            .unwrap_or(default.orbit_deg_per_s),
    };
    if camera.eye_m == camera.target_m {
        table.conflict("eye_m", "is the same as target_m; the camera would look nowhere");
    }
    table.finish();
    camera
}

fn sun(mut table: Table<'_>) -> Sun {
    let default = Sun::default();
    let sun = Sun {
        azimuth_deg: table.maybe("azimuth_deg", Within(-360.0, 360.0)).unwrap_or(default.azimuth_deg),
        elevation_deg: table.maybe("elevation_deg", Within(1.0, 90.0)).unwrap_or(default.elevation_deg),
        brightness: table.maybe("brightness", Within(0.0, 1.0)).unwrap_or(default.brightness),
    };
    table.finish();
    sun
}

fn terrain(mut table: Table<'_>, base_dir: Option<&Path>) -> TerrainSource {
    let allowed = "a .png or .asc file, or a built-in asset such as \"builtin/fjord.png\"";
    let is_known = |name: &str| {
        Format::of(name).is_some() && (!name.starts_with("builtin/") || builtin::asset(name).is_some())
    };
    let heightmap = table.file("heightmap", allowed, is_known);
    if !table.has("heightmap") {
        table.missing("heightmap", format_args!("{allowed}"));
    }
    let mut size_m = table.maybe("size_m", LENGTH);
    let height_m: Option<[f32; 2]> = table.maybe("height_m", PLACE);
    let heightmap = heightmap.unwrap_or_default();
    match Format::of(heightmap) {
        Some(Format::Png) => {
            if size_m.is_none() {
                table.missing("size_m", format_args!("for a .png, two numbers, each {LENGTH}"));
            }
            if height_m.is_none() {
                table.missing("height_m", format_args!("the heights of black and white, each {PLACE}"));
            }
        }
        Some(Format::Asc) => {
            if height_m.is_some() {
                table.conflict("height_m", "is not for an .asc file, which has its own heights");
            }
            if size_m.is_none() {
                match heightmap::asc_size_m(heightmap, base_dir) {
                    Ok(size) => size_m = Some(size),
                    Err(error) => {
                        table.blame("heightmap", ProblemKind::Asset, format!("cannot be used: {error}"))
                    }
                }
            }
        }
        None => {}
    }
    table.finish();
    TerrainSource { heightmap: heightmap.to_owned(), size_m: size_m.unwrap_or([1.0; 2]), height_m }
}
