// SPDX-License-Identifier: MIT OR Apache-2.0
//! The keys of a scene file, their ranges and defaults: one function for each table.

use crate::clock::FixedStep;
use std::path::Path;

use super::{
    builtin,
    error::ProblemKind,
    heightmap::{self, Format},
    node::Sources,
    parse::{
        Reader, Rule,
        Rule::{AtLeastZero, Finite, Within},
        Table,
    },
    works, Camera, Drop, Model, Output, Override, Rain, Scene, SceneError, Start, Sun, TerrainSource, View,
    Walls, WaterScene,
};

/// Lengths and places (m): beyond them f32 has no columns left.
pub(super) const LENGTH: Rule = Within(1e-4, 1e7);
pub(super) const PLACE: Rule = Within(-1e7, 1e7);

/// Most steps that a picture may take: beyond it a run would seem to hang.
const MOST_STEPS: f64 = 10_000.0;

/// The name of a water that is not given one.
pub(super) const DEFAULT_NAME: &str = "water";

pub(super) fn scene(
    text: &str,
    file_name: &str,
    base_dir: Option<&Path>,
    overrides: &[Override],
) -> Result<Scene, SceneError> {
    let (sources, root) = Sources::read(text, file_name, overrides).map_err(SceneError::Invalid)?;
    let reader = Reader::new(sources);
    let mut table = reader.root(&root);

    let title = table.text("title", "a text", |_| true).unwrap_or_default().to_owned();
    let seed = table.maybe("seed", AtLeastZero).unwrap_or(1);
    let output = table.table("output").map_or_else(Output::default, output);
    let sun = table.table("sun").map_or_else(Sun::default, sun);
    let terrain = table.table("terrain").map(|table| terrain(table, base_dir));
    let mut water: Vec<WaterScene> = Vec::new();
    for table in table.tables("water") {
        let next = self::water(table, terrain.as_ref(), &water, output.fps);
        water.push(next);
    }
    // A water that could not be read has been reported already.
    if water.is_empty() && !table.has("terrain") && (!table.has("water") || reader.is_clean()) {
        table.conflict("", "nothing to see: a scene has [terrain] or [[water]] or both");
    }
    let camera_table = table.table("camera");
    let mut scene = Scene {
        title,
        seed,
        output,
        camera: None,
        sun,
        terrain,
        water,
        base_dir: base_dir.map(Path::to_owned),
    };
    scene.camera = camera_table.map(|table| camera(table, scene.camera()));
    table.finish();

    let problems = reader.finish();
    if problems.is_empty() {
        Ok(scene)
    } else {
        Err(SceneError::Invalid(problems))
    }
}

fn output(mut table: Table<'_>) -> Output {
    let default = Output::default();
    let output = Output {
        size: table.maybe("size", Within(16.0, 8192.0)).unwrap_or(default.size),
        fps: table.maybe("fps", Within(1.0, 1000.0)).unwrap_or(default.fps),
        frames: table.maybe("frames", Within(1.0, 1e6)).unwrap_or(default.frames),
        view: table
            .choice("view", &[("shaded", View::Shaded), ("wireframe", View::Wireframe)])
            .unwrap_or(default.view),
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
    };
    table.finish();
    sun
}

fn terrain(mut table: Table<'_>, base_dir: Option<&Path>) -> TerrainSource {
    let allowed = "a .png or .asc file, or a built-in asset such as \"builtin/fjord.png\"";
    let is_known = |name: &str| {
        Format::of(name).is_some() && (!name.starts_with("builtin/") || builtin::asset(name).is_some())
    };
    let heightmap = table.text("heightmap", allowed, is_known);
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

fn water(
    mut table: Table<'_>,
    terrain: Option<&TerrainSource>,
    others: &[WaterScene],
    fps: f64,
) -> WaterScene {
    let is_name = |name: &str| {
        (1..=64).contains(&name.len())
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-')
            && !name.chars().all(|c| c.is_ascii_digit())
    };
    let name = table.text("name", "1 to 64 of A-Z a-z 0-9 _ -, not digits only", is_name);
    let name = name.unwrap_or(DEFAULT_NAME).to_owned();
    if let Some(i) = others.iter().position(|other| other.name == name) {
        table.conflict("name", format!("is {name:?}, as water.{i} is called already; names are unique"));
    }

    let model = table.choice("model", &[("book", Model::Book), ("waves", Model::Waves)]);
    if !table.has("model") {
        table.missing("model", format_args!("\"book\" or \"waves\""));
    }
    let model = model.unwrap_or(Model::Waves);
    let (diagonal, walls): (_, &[_]) = match model {
        Model::Book => (1.0, &[("dropped", Walls::Dropped)]),
        Model::Waves => (0.25, &[("folded", Walls::Folded), ("dropped", Walls::Dropped)]),
    };
    let cells: [u32; 2] = table.number("cells", Within(1.0, 16384.0));
    let size_m: [f32; 2] = match table.maybe("size_m", LENGTH).or(terrain.map(|terrain| terrain.size_m)) {
        Some(size_m) => size_m,
        None => table.number("size_m", LENGTH),
    };
    let column_m = f64::from(size_m[0]) / f64::from(cells[0].max(1));
    let level_m = table.maybe("level_m", PLACE).unwrap_or(0.0);
    let depth_m = table.number("depth_m", LENGTH);
    let water = WaterScene {
        name,
        model,
        cells,
        size_m,
        level_m,
        depth_m,
        gravity_mps2: table.maybe("gravity_mps2", Within(1e-6, 1e6)).unwrap_or(9.81),
        damping_per_s: table.maybe("damping_per_s", Within(0.0, 100.0)).unwrap_or(0.03),
        diagonal: table.maybe("diagonal", Within(0.0, 1.0)).unwrap_or(diagonal),
        walls: table.choice("walls", walls).unwrap_or(walls[0].1),
        dt_s: table.maybe("dt_s", Within(FixedStep::SHORTEST_S, FixedStep::LONGEST_S)),
        max_catch_up_steps: table.maybe("max_catch_up_steps", Within(1.0, 10_000.0)),
        start: table.table("start").map_or(Start::Flat, |table| start(table, cells)),
        drops: table.tables("drop").into_iter().map(|table| drop(table, model)).collect(),
        rain: table.table("rain").map(|table| rain(table, model)),
        borders: works::borders(&mut table),
        absorb_width_m: table.maybe("absorb_width_m", LENGTH),
        barriers: table.tables("wall").into_iter().map(|table| works::wall(table, depth_m)).collect(),
        bodies: table.tables("body").into_iter().map(|table| works::body(table, column_m)).collect(),
    };
    // Only numbers that are right each by itself can be wrong together.
    if table.is_clean() {
        check_together(&table, &water, fps);
        works::check(&table, &water);
    }
    table.finish();
    water
}

/// Square columns, a stable step, and a clock that can keep up.
fn check_together(table: &Table<'_>, water: &WaterScene, fps: f64) {
    let [x, z] = [0, 1].map(|axis| f64::from(water.size_m[axis]) / f64::from(water.cells[axis]));
    if (x / z - 1.0).abs() > 1e-3 {
        let cells = water.cells;
        let other = (f64::from(water.size_m[1]) / x).round().max(1.0) as u32;
        let message = format!(
            "is {cells:?}, columns of {x:.4} x {z:.4} m; they are square, as with {:?}",
            [cells[0], other]
        );
        return table.blame("cells", ProblemKind::Conflict, message);
    }
    let simulation = water.simulation(fps);
    if let Err(invalid) = simulation.check() {
        let key = if invalid.key == "speed_mps" { "depth_m" } else { invalid.key };
        let message = format!("is {}; allowed: {}", invalid.value, invalid.allowed);
        return table.blame(key, ProblemKind::OutOfRange, message);
    }
    let steps = (1.0 / (fps * simulation.dt_s)).ceil();
    if steps > MOST_STEPS || simulation.dt_s < FixedStep::SHORTEST_S {
        let dt_s = simulation.dt_s;
        let message = format!(
            "is {dt_s:e}, {steps} steps a picture; allowed: at most {MOST_STEPS} steps a picture, each of {:e} s at least",
            FixedStep::SHORTEST_S
        );
        return table.blame("dt_s", ProblemKind::OutOfRange, message);
    }
    if let Some(most) = water.max_catch_up_steps.filter(|&most| f64::from(most) < steps) {
        let message = format!("is {most}; a picture takes {steps} steps, so time would be lost at each");
        table.blame("max_catch_up_steps", ProblemKind::Conflict, message);
    }
}

fn start(mut table: Table<'_>, cells: [u32; 2]) -> Start {
    let shapes = ["flat", "hump", "sombrero", "mode"].map(|name| (name, name));
    let shape = table.choice("shape", &shapes);
    if !table.has("shape") {
        table.missing("shape", format_args!("\"flat\" or \"hump\" or \"sombrero\" or \"mode\""));
    }
    // Which keys belong here depends on the shape.
    let Some(shape) = shape else { return Start::Flat };
    let start = match shape {
        "flat" => Start::Flat,
        "mode" => {
            let height_m = table.number("height_m", Within(-1e5, 1e5));
            let waves: [u32; 2] = table.number("waves", AtLeastZero);
            if cells != [0, 0] && (waves[0] > cells[0] || waves[1] > cells[1]) {
                let allowed = format!("is {waves:?}; allowed: at most one half wave per cell, {cells:?}");
                table.blame("waves", ProblemKind::OutOfRange, allowed);
            }
            Start::Mode { height_m, waves }
        }
        round => {
            let height_m = table.number("height_m", Within(-1e5, 1e5));
            let at_m = table.maybe("at_m", PLACE).unwrap_or([0.0; 2]);
            let radius_m = table.number("radius_m", LENGTH);
            match round {
                "hump" => Start::Hump { height_m, at_m, radius_m },
                _ => Start::Sombrero { height_m, at_m, radius_m },
            }
        }
    };
    table.finish();
    start
}

fn drop(mut table: Table<'_>, model: Model) -> Drop {
    let (volume_m3, push_m3ps) = amount(&mut table, model);
    let drop = Drop {
        at_m: table.number("at_m", PLACE),
        radius_m: table.number("radius_m", LENGTH),
        volume_m3,
        push_m3ps,
        start_s: table.maybe("start_s", AtLeastZero).unwrap_or(0.0),
        every_s: table.maybe("every_s", Within(1e-4, 1e9)),
        count: table.maybe("count", Within(1.0, f64::from(u32::MAX))),
    };
    if drop.count.is_some() && drop.every_s.is_none() {
        table.conflict("count", "needs every_s, the time between falls");
    }
    table.finish();
    drop
}

fn rain(mut table: Table<'_>, model: Model) -> Rain {
    let (volume_m3, push_m3ps) = amount(&mut table, model);
    let rain = Rain {
        drops_per_s: table.number("drops_per_s", Within(0.0, 1e6)),
        radius_m: table.number("radius_m", LENGTH),
        volume_m3,
        push_m3ps,
    };
    table.finish();
    rain
}

/// What a drop adds: volume and push.
fn amount(table: &mut Table<'_>, model: Model) -> (f32, f32) {
    let volume_m3 = table.maybe("volume_m3", Finite).unwrap_or(0.0);
    let push_m3ps = table.maybe("push_m3ps", Finite).unwrap_or(0.0);
    if volume_m3 == 0.0 && push_m3ps == 0.0 {
        table.conflict("volume_m3", "is 0 and push_m3ps too; a drop without both does nothing");
    }
    if model == Model::Book && push_m3ps != 0.0 {
        table
            .conflict("push_m3ps", "is for model \"waves\"; the book has no velocity of the surface to push");
    }
    (volume_m3, push_m3ps)
}
