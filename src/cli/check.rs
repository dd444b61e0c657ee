// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{hardcases::short, print, print_json, Failure};
use clap::Args;
use serde_json::json;
use std::path::PathBuf;
use whitecap::{
    scene::{
        builtin, measured::Refined, percent, percent_expected, EmitterPlan, Measured, MeshPlan, Override,
        Scene, SceneError, Verdict, WaterPlan, WaterScene,
    },
    study::shapes::table,
};

/// Which scene, and what is changed in it.
#[derive(Args)]
pub struct SceneArgs {
    /// A scene file, or the name of a built-in scene (see `whitecap scenes`); the first of them by default
    #[arg(value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Change a value, as `water.lake.depth_m=3`; may be given again and again
    #[arg(long = "set", value_name = "KEY.PATH=VALUE")]
    set: Vec<Override>,
    /// Number of pictures
    #[arg(long, value_name = "N")]
    frames: Option<u32>,
    /// Size of the pictures (pixels)
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<[u32; 2]>,
    /// Seed of everything random, or `random`; the one used is printed
    #[arg(long, value_name = "N|random", value_parser = seed)]
    seed: Option<u64>,
    /// Time step of every water (s)
    #[arg(long, value_name = "SECONDS")]
    dt: Option<f64>,
}

fn size(text: &str) -> Result<[u32; 2], String> {
    let parse = |n: &str| n.trim().parse::<u32>().ok();
    let pair = text.split_once(['x', 'X']).and_then(|(w, h)| Some([parse(w)?, parse(h)?]));
    pair.ok_or_else(|| "not WIDTHxHEIGHT, as in 960x540".into())
}

fn seed(text: &str) -> Result<u64, String> {
    if text != "random" {
        return text.parse().map_err(|_| "neither a whole number nor `random`".into());
    }
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    // TOML's integers are signed.
    Ok(now.map_or(1, |now| (now.as_nanos() as u64) >> 2))
}

impl SceneArgs {
    /// The scene with everything that the arguments change.
    pub fn load(&self) -> Result<Scene, Failure> {
        Ok(self.read(&self.changes()?)?)
    }

    /// Number of pictures, if it is given.
    #[cfg(feature = "viewer")]
    pub fn frames(&self) -> Option<u32> {
        self.frames
    }

    /// Text, name and file of the scene.
    #[cfg(feature = "viewer")]
    pub fn source(&self) -> Result<whitecap::view::Source, Failure> {
        let changes = self.changes()?;
        self.read(&changes)?; // what is wrong is said as every command says it
        let (name, file) = match self.place()? {
            Place::Builtin(name) => (name, None),
            Place::File(path) => (path.display().to_string(), Some(path)),
        };
        let text = match &file {
            None => builtin::toml(&name).unwrap_or_default().to_owned(),
            Some(path) => std::fs::read_to_string(path)
                .map_err(|source| SceneError::Read { path: path.display().to_string(), source })?,
        };
        Ok(whitecap::view::Source { text, name, file, changes })
    }

    fn changes(&self) -> Result<Vec<Override>, Failure> {
        let mut changes = self.set.clone();
        let mut add = |text: String| -> Result<(), SceneError> {
            changes.push(text.parse()?);
            Ok(())
        };
        if let Some(frames) = self.frames {
            add(format!("output.frames={frames}"))?;
        }
        if let Some([w, h]) = self.size {
            add(format!("output.size=[{w}, {h}]"))?;
        }
        if let Some(seed) = self.seed {
            add(format!("seed={seed}"))?;
        }
        if let Some(dt) = self.dt {
            let waters = self.read(&self.set)?.water.len();
            (0..waters).try_for_each(|i| add(format!("water.{i}.dt_s={dt:?}")))?;
        }
        Ok(changes)
    }

    fn read(&self, changes: &[Override]) -> Result<Scene, SceneError> {
        match self.place()? {
            Place::Builtin(name) => builtin::load(&name, changes),
            Place::File(path) => Scene::load(&path, changes),
        }
    }

    fn place(&self) -> Result<Place, SceneError> {
        let default = builtin::list().next().map_or("", |(name, _)| name);
        let path = self.scene.clone().unwrap_or_else(|| default.into());
        let name = path.to_str().filter(|name| builtin::toml(name).is_some() && !path.exists());
        match name.map(str::to_owned) {
            Some(name) => Ok(Place::Builtin(name)),
            None if path.extension().is_none() && !path.exists() => {
                Err(SceneError::NoBuiltin { name: path.display().to_string() })
            }
            None => Ok(Place::File(path)),
        }
    }
}

/// Where a scene is.
enum Place {
    Builtin(String),
    File(PathBuf),
}

/// A row for each variant: what is expected of it, what it costs a column and simulated second on an H100, and why it is
/// taken or not.
fn verdicts(water: &WaterScene) -> Vec<Vec<String>> {
    let choice = &water.choice;
    let taken = choice.taken();
    let row = |(i, verdict): (usize, &Verdict)| {
        let cost = verdict.ns_per_column_second;
        let share = cost.zip(taken.ns_per_column_second).map_or(1.0, |(cost, least)| cost / least);
        let misses = water.tolerance.filter(|tolerance| verdict.error() > *tolerance);
        let word = match (&verdict.lacks, misses) {
            _ if i == choice.chosen => "taken".into(),
            (Some(lacks), _) => lacks.clone(),
            (None, Some(tolerance)) => format!("misses {} %", percent(tolerance)),
            (None, None) if cost.is_none() => "cost not measured, so not offered".into(),
            (None, None) if share > 1.0 => format!("{} times the cost", short(share)),
            (None, None) if choice.is_asked => "not asked for".into(),
            (None, None) if share < 1.0 => "a lower rung would do".into(),
            (None, None) => "no better".into(),
        };
        let error = [verdict.error(), verdict.model_error, verdict.grid_error].map(percent_expected);
        let [error, model, grid] = error;
        vec![verdict.name.clone(), error, model, grid, cost.map_or("not measured".into(), short), word]
    };
    choice.verdicts.iter().enumerate().map(row).collect()
}

#[derive(Args)]
pub struct CheckArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Choose again with what variants cost on a device: a study.json that `whitecap study` wrote there
    #[arg(long, value_name = "FILE")]
    study: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// A line for each water whose choice the costs of a device may change.
fn refined(measured: &Measured, scene: &Scene) -> Vec<String> {
    let line = |it: &Refined| {
        let verdict = if it.is_taken { "as taken" } else { "instead of what is taken" };
        let unmeasured = match it.unmeasured.is_empty() {
            true => String::new(),
            false => format!("; not in the study: {}", it.unmeasured.join(", ")),
        };
        format!(
            "water `{}` on {}: `{}`, {verdict}, {} ns a column and second, {} % expected{unmeasured}",
            it.water,
            measured.device,
            it.variant,
            short(it.ns_per_column_second),
            percent_expected(it.expected_error)
        )
    };
    let lines: Vec<_> = measured.refine(scene).iter().map(line).collect();
    if lines.is_empty() {
        return vec!["no water has a tolerance, so that there is nothing to choose by cost".into()];
    }
    lines
}

fn mesh_line(mesh: &MeshPlan) -> String {
    let painted = match mesh.map {
        0 => String::new(),
        side => format!(", painted on {side} x {side} texels"),
    };
    format!(
        "mesh `{}`: {} triangles, {}, {}{painted}",
        mesh.name,
        mesh.mesh.triangles.len(),
        if mesh.moves() { "moves" } else { "at rest" },
        if mesh.solid { "solid" } else { "only seen" },
    )
}

pub fn run(args: &CheckArgs) -> Result<(), Failure> {
    let scene = args.scene.load()?;
    let measured = args.study.as_deref().map(Measured::read).transpose()?;
    let plan = scene.plan()?;
    if args.json {
        let water = |(water, of): (&WaterPlan, &WaterScene)| {
            let simulation = &water.simulation;
            json!({
                "name": water.name, "model": of.model, "variant": of.variant().name(), "reason": water.reason,
                "expected_error": of.choice.taken().error(), "tolerance": of.tolerance, "variants": of.choice.verdicts,
                "dt_s": simulation.dt_s(), "longest_stable_s": simulation.longest_stable_s(),
                "steps_per_picture": water.steps_per_picture, "has_land": simulation.has_land(),
            })
        };
        let waters: Vec<_> = plan.waters.iter().zip(&scene.water).map(water).collect();
        let emitter = |it: &EmitterPlan| json!({"name": it.name, "reason": it.reason, "capacity": it.capacity, "draw": it.draw});
        let emitters: Vec<_> = plan.emitters.iter().map(emitter).collect();
        let mesh = |it: &MeshPlan| json!({"name": it.name, "triangles": it.mesh.triangles.len(), "moves": it.moves(), "solid": it.solid, "map": it.map});
        let meshes: Vec<_> = plan.meshes.iter().map(mesh).collect();
        let passes: Vec<_> =
            plan.passes.iter().map(|(name, runs)| json!({"name": name, "runs": runs})).collect();
        let mut all = json!({
            "scene": scene, "waters": waters, "emitters": emitters, "passes": passes, "buffers": plan.buffers, "bytes": plan.bytes(),
            "warnings": plan.warnings,
        });
        if !meshes.is_empty() {
            all["meshes"] = json!(meshes);
        }
        if let Some(volume) = &plan.volume {
            all["volume"] =
                json!({"reason": volume.reason, "dt_s": volume.dt_s, "cells_a_step": volume.cells_a_step});
        }
        if let Some(measured) = measured {
            all["refined"] = json!({"device": measured.device, "waters": measured.refine(&scene)});
        }
        return print_json(&all);
    }
    let title = if scene.title.is_empty() { "untitled" } else { &scene.title };
    print(&format!("{title}: {} pictures of {:?}\n", scene.output.frames, scene.output.size));
    for (water, of) in plan.waters.iter().zip(&scene.water) {
        let (simulation, cells) = (&water.simulation, water.simulation.cells());
        print(&format!(
            "water `{}`: {} x {} columns of {:.4} m{}, waves of {:.3} m/s, {} steps a picture\n  {}\n",
            water.name,
            cells.x,
            cells.y,
            simulation.cell_m(),
            if simulation.has_land() { ", with land" } else { "" },
            simulation.speed_mps(),
            short(water.steps_per_picture),
            water.reason
        ));
        print(&table(&["variant", "error, %", "model", "grid", "ns", "verdict"], &verdicts(of)));
    }
    if let Some(measured) = &measured {
        refined(measured, &scene).iter().for_each(|line| print(line));
        print("");
    }
    for mesh in &plan.meshes {
        print(&mesh_line(mesh));
    }
    if let Some(volume) = &plan.volume {
        print(&format!("volume: {}\n", volume.reason));
    }
    for emitter in &plan.emitters {
        print(&format!(
            "emitter `{}`: up to {} particles, drawn as {:?}{}\n  {}\n",
            emitter.name,
            emitter.capacity,
            emitter.draw,
            if emitter.soft { ", soft" } else { "" },
            emitter.reason
        ));
    }
    let rows: Vec<_> = plan
        .passes
        .iter()
        .map(|(name, runs)| vec![name.clone(), if *runs == 0.0 { "once".into() } else { short(*runs) }])
        .collect();
    print(&format!("{}\n", table(&["pass", "runs a picture"], &rows)));
    let mut rows: Vec<_> = plan
        .buffers
        .iter()
        .map(|buffer| vec![buffer.name.clone(), buffer.bytes.to_string(), buffer.because.clone()])
        .collect();
    rows.push(vec!["all".into(), plan.bytes().to_string(), String::new()]);
    print(&table(&["buffer", "bytes", "because of"], &rows));
    for warning in &plan.warnings {
        print(&format!("warning: {warning}"));
    }
    Ok(())
}
