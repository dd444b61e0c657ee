// SPDX-License-Identifier: MIT OR Apache-2.0
//! The keys of a water: one function for each table.

use super::{
    choose::{choose, Wishes},
    error::ProblemKind,
    parse::{
        Rule::{AtLeastZero, Finite, Within},
        Table,
    },
    schema::{LENGTH, PLACE},
    splash, works, Choice, Drop, Model, Output, Rain, Source, Start, TerrainSource, Walls, WaterScene,
};
use crate::clock::FixedStep;

/// Most steps that a picture may take: beyond it a run would seem to hang.
const MOST_STEPS: f64 = 10_000.0;

/// The name of a water that is not given one.
pub(super) const DEFAULT_NAME: &str = "water";

pub(super) fn water(
    mut table: Table<'_>,
    terrain: Option<&TerrainSource>,
    others: &[WaterScene],
    output: &Output,
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

    let models = [Model::Book, Model::Waves, Model::Pipes, Model::Wet, Model::Shallow];
    let models = models.map(|model| (model.name(), Some(model)));
    let [book, waves, pipes, wet, shallow] = models;
    let asked = table.choice("model", &[book, waves, pipes, wet, shallow, ("auto", None)]).flatten();
    let walls: &[_] = match asked {
        Some(Model::Book) => &[("dropped", Walls::Dropped)],
        _ => &[("folded", Walls::Folded), ("dropped", Walls::Dropped)],
    };
    let order = table.choice_of("order", &[2, 4]);
    let wishes = Wishes {
        model: asked,
        order,
        diagonal: table.maybe("diagonal", Within(0.0, 1.0)),
        walls: table.choice("walls", walls),
        foam: table.flag("foam"),
        has_terrain: terrain.is_some(),
    };
    let cells: [u32; 2] = table.number("cells", Within(1.0, 16384.0));
    let size_m: [f32; 2] = match table.maybe("size_m", LENGTH).or(terrain.map(|terrain| terrain.size_m)) {
        Some(size_m) => size_m,
        None => table.number("size_m", LENGTH),
    };
    let column_m = f64::from(size_m[0]) / f64::from(cells[0].max(1));
    let level_m = table.maybe("level_m", PLACE).unwrap_or(0.0);
    let depth_m = table.number("depth_m", LENGTH);
    let start = table.table("start").map_or(Start::Flat, |table| start(table, cells));
    let gravity_mps2 = table.maybe("gravity_mps2", Within(1e-6, 1e6)).unwrap_or(9.81);
    let splashes: Vec<_> =
        table.tables("splash").into_iter().map(|table| splash::splash(table, column_m)).collect();
    let is_asked: Vec<bool> = splashes.iter().map(|(_, brings)| *brings).collect();
    let limits = ["deepest_m", "fastest_mps", "thin_m"].map(|key| table.has(key));
    let deepest_m = table.maybe("deepest_m", LENGTH).unwrap_or(depth_m + f64::from(start.highest_m()));
    let mut water = WaterScene {
        name,
        model: asked.unwrap_or(Model::Waves),
        order: 2,
        tolerance: table.maybe("tolerance", Within(1e-6, 1.0)),
        foam: false,
        cells,
        size_m,
        level_m,
        depth_m,
        deepest_m,
        fastest_mps: table
            .maybe("fastest_mps", Within(0.0, 1e6))
            .unwrap_or((gravity_mps2 * deepest_m).max(0.0).sqrt()),
        thin_m: table.maybe("thin_m", Within(0.0, 1.0)).unwrap_or(1e-4),
        gravity_mps2,
        damping_per_s: table.maybe("damping_per_s", Within(0.0, 100.0)).unwrap_or(0.03),
        diagonal: 0.0,
        walls: wishes.walls.unwrap_or(Walls::Folded),
        dt_s: table.maybe("dt_s", Within(FixedStep::SHORTEST_S, FixedStep::LONGEST_S)),
        max_catch_up_steps: table.maybe("max_catch_up_steps", Within(1.0, 10_000.0)),
        start,
        drops: table.tables("drop").into_iter().map(drop).collect(),
        rain: table.table("rain").map(rain),
        splashes: splashes.into_iter().map(|(splash, _)| splash).collect(),
        sources: table.tables("source").into_iter().map(source).collect(),
        borders: works::borders(&mut table),
        absorb_width_m: table.maybe("absorb_width_m", LENGTH),
        barriers: table.tables("wall").into_iter().map(|table| works::wall(table, depth_m)).collect(),
        bodies: table.tables("body").into_iter().map(|table| works::body(table, column_m)).collect(),
        choice: Choice::default(),
    };
    // Only numbers that are right each by itself can be wrong together.
    if table.is_clean() && has_square_columns(&table, &water) {
        let span_s = f64::from(output.frames - 1) / output.fps;
        match choose(&mut water, &wishes, span_s, output.fps) {
            Ok(()) => {
                splash::settle(&mut water, &is_asked);
                check_step(&table, &water, output.fps);
                works::check(&table, &water);
                check_limits(&table, &water, limits);
            }
            Err(refusals) => refusals.into_iter().for_each(|(key, why)| table.conflict(key, why)),
        }
    }
    table.finish();
    water
}

/// Waves run alike along x and z.
fn has_square_columns(table: &Table<'_>, water: &WaterScene) -> bool {
    let [x, z] = [0, 1].map(|axis| f64::from(water.size_m[axis]) / f64::from(water.cells[axis]));
    let is_square = (x / z - 1.0).abs() <= 1e-3;
    if !is_square {
        let cells = water.cells;
        let other = (f64::from(water.size_m[1]) / x).round().max(1.0) as u32;
        let message = format!(
            "is {cells:?}, columns of {x:.4} x {z:.4} m; they are square, as with {:?}",
            [cells[0], other]
        );
        table.blame("cells", ProblemKind::Conflict, message);
    }
    is_square
}

/// A stable step, and a clock that can keep up.
fn check_step(table: &Table<'_>, water: &WaterScene, fps: f64) {
    let variant = water.variant();
    let (dt_s, valid) = match variant.tier() {
        Some(tier) => {
            let model = water.depth_model(tier, fps);
            (model.dt_s, model.check(tier))
        }
        None => {
            let model = water.waves_model(&variant, fps);
            (model.dt_s, if variant.order == 4 { model.check_fourth_order() } else { model.check() })
        }
    };
    if let Err(invalid) = valid {
        let key = if invalid.key == "speed_mps" { "depth_m" } else { invalid.key };
        let message = format!("is {}; allowed: {}", invalid.value, invalid.allowed);
        return table.blame(key, ProblemKind::OutOfRange, message);
    }
    let steps = (1.0 / (fps * dt_s)).ceil();
    if steps > MOST_STEPS || dt_s < FixedStep::SHORTEST_S {
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

/// The limits of water over ground are for the models that have it.
fn check_limits(table: &Table<'_>, water: &WaterScene, [deepest, fastest, thin]: [bool; 3]) {
    let name = water.model.name();
    for (key, is_there) in [("deepest_m", deepest), ("thin_m", thin)] {
        if is_there && !water.model.has_ground() {
            table.conflict(key, format!("does not go with model {name:?}; allowed: \"wet\", \"shallow\""));
        }
    }
    if fastest && water.model != Model::Shallow {
        let why = "whose flow is not advected; allowed: \"shallow\"";
        table.conflict("fastest_mps", format!("does not go with model {name:?}, {why}"));
    }
}

fn start(mut table: Table<'_>, cells: [u32; 2]) -> Start {
    let shapes = ["flat", "hump", "sombrero", "mode", "block"].map(|name| (name, name));
    let shape = table.choice("shape", &shapes);
    if !table.has("shape") {
        table.missing("shape", format_args!("\"flat\" or \"hump\" or \"sombrero\" or \"mode\" or \"block\""));
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
        "block" => {
            let height_m = table.number("height_m", Within(-1e5, 1e5));
            let from_m: [f32; 2] = table.number("from_m", PLACE);
            let to_m: [f32; 2] = table.number("to_m", PLACE);
            if (0..2).any(|axis| from_m[axis] == to_m[axis]) {
                table.conflict("to_m", "is in line with from_m; a block has two corners across");
            }
            Start::Block { height_m, from_m, to_m }
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

fn drop(mut table: Table<'_>) -> Drop {
    let (volume_m3, push_m3ps) = amount(&mut table);
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

fn rain(mut table: Table<'_>) -> Rain {
    let rate = Within(0.0, 1e6);
    let mm_per_h = table.maybe("mm_per_h", rate);
    let is_even = mm_per_h.is_some()
        && !["drops_per_s", "radius_m", "volume_m3", "push_m3ps"].map(|key| table.has(key)).contains(&true);
    let mm_per_h = mm_per_h.unwrap_or(0.0);
    let rain = if is_even {
        Rain { mm_per_h, drops_per_s: 0.0, radius_m: 0.0, volume_m3: 0.0, push_m3ps: 0.0 }
    } else {
        let (volume_m3, push_m3ps) = amount(&mut table);
        let drops_per_s = table.number("drops_per_s", rate);
        Rain { mm_per_h, drops_per_s, radius_m: table.number("radius_m", LENGTH), volume_m3, push_m3ps }
    };
    table.finish();
    rain
}

fn source(mut table: Table<'_>) -> Source {
    let source = Source {
        at_m: table.number("at_m", PLACE),
        radius_m: table.number("radius_m", LENGTH),
        rate_m3ps: table.number("rate_m3ps", Within(-1e6, 1e6)),
        start_s: table.maybe("start_s", AtLeastZero).unwrap_or(0.0),
        end_s: table.maybe("end_s", AtLeastZero),
    };
    if source.rate_m3ps == 0.0 && table.is_clean() {
        table.conflict("rate_m3ps", "is 0; a source without water does nothing");
    }
    if source.end_s.is_some_and(|end_s| end_s <= source.start_s) {
        table.conflict("end_s", "is not after start_s");
    }
    table.finish();
    source
}

/// What a drop adds: volume and push.
fn amount(table: &mut Table<'_>) -> (f32, f32) {
    let volume_m3 = table.maybe("volume_m3", Finite).unwrap_or(0.0);
    let push_m3ps = table.maybe("push_m3ps", Finite).unwrap_or(0.0);
    if volume_m3 == 0.0 && push_m3ps == 0.0 {
        table.conflict("volume_m3", "is 0 and push_m3ps too; a drop without both does nothing");
    }
    (volume_m3, push_m3ps)
}
