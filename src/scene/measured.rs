// SPDX-License-Identifier: MIT OR Apache-2.0
//! What variants cost on a device, read from the `study.json` that `whitecap study` wrote there: the costs in the rules
//! are those of one GPU and of large grids.

use super::{choose, Scene, SceneError, Verdict, WaterScene};
use serde::{Deserialize, Serialize};
use std::{fs, path::Path};

/// The points of a `study.json`.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct Measured {
    /// Name of the device.
    pub device: String,
    /// Its driver.
    pub driver: String,
    studies: Vec<Study>,
}

#[derive(Clone, Debug, Deserialize, PartialEq)]
struct Study {
    sim: String,
    study: String,
    points: Vec<MeasuredPoint>,
}

/// One variant at one step and size.
#[derive(Clone, Debug, Deserialize, PartialEq)]
pub struct MeasuredPoint {
    /// The variant.
    pub variant: String,
    /// Time step (s).
    pub step: f64,
    /// Columns along one side, or the number of particles.
    pub size: u32,
    /// Distance from the reference, `None` if the run blew up.
    pub error: Option<f64>,
    /// Device time for one simulated second (ms).
    pub ms_per_sim_second: f64,
    /// Device time for one column, or particle, of one step (ns).
    pub ns_per_item: f64,
}

/// The choice for one water, with the costs of a device.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refined {
    /// Name of the water.
    pub water: String,
    /// The cheapest variant that the rules expect to keep within the tolerance.
    pub variant: String,
    /// What is expected of it.
    pub expected_error: f64,
    /// A column and simulated second of it (ns).
    pub ns_per_column_second: f64,
    /// The scene takes the same.
    pub is_taken: bool,
    /// Variants within the tolerance that the table does not have: they were not compared.
    pub unmeasured: Vec<String>,
}

impl Measured {
    /// Reads a `study.json`.
    ///
    /// # Errors
    /// If it cannot be read, or is something else.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let failed = |source| SceneError::Read { path: path.display().to_string(), source };
        let text = fs::read_to_string(path).map_err(failed)?;
        serde_json::from_str(&text).map_err(|error| {
            failed(std::io::Error::new(std::io::ErrorKind::InvalidData, format!("not a study.json: {error}")))
        })
    }

    /// The cheapest point of a study, as `water`, `linear`, whose error is within `tolerance`.
    pub fn cheapest(&self, sim: &str, study: &str, tolerance: f64) -> Option<&MeasuredPoint> {
        let its = self.studies.iter().filter(|it| it.sim == sim && it.study == study);
        its.flat_map(|it| &it.points)
            .filter(|point| point.error.is_some_and(|error| error <= tolerance))
            .min_by(|a, b| a.ms_per_sim_second.total_cmp(&b.ms_per_sim_second))
    }

    /// A column and step of a variant of water (ns), on the square grid nearest in columns to `columns`.
    pub fn ns_per_column(&self, variant: &str, columns: u64) -> Option<f64> {
        let apart = |point: &&MeasuredPoint| (2.0 * f64::from(point.size).ln() - (columns as f64).ln()).abs();
        let its = self.studies.iter().filter(|it| it.sim == "water").flat_map(|it| &it.points);
        let its = its.filter(|point| point.variant == variant);
        its.min_by(|a, b| apart(a).total_cmp(&apart(b))).map(|point| point.ns_per_item)
    }

    /// The choice again for every water of `scene` that has a tolerance: the same expected errors, the costs measured, and for
    /// land the ratio of the rules.
    pub fn refine(&self, scene: &Scene) -> Vec<Refined> {
        let refined = |water| self.refine_water(water, scene.terrain.is_some(), scene.output.fps);
        scene.water.iter().filter_map(refined).collect()
    }

    fn refine_water(&self, water: &WaterScene, has_terrain: bool, fps: f64) -> Option<Refined> {
        let (tolerance, choice) = (water.tolerance?, &water.choice);
        let taken = choice.taken();
        let able = |v: &&Verdict| {
            let is_asked = !choice.is_asked || v.variant.model == taken.variant.model;
            *v == taken
                || (is_asked && v.lacks.is_none() && v.variant.model != super::Model::Book)
                    && v.error() <= tolerance
        };
        let columns = water.cells.map(u64::from).iter().product();
        let mut unmeasured = Vec::new();
        let mut best: Option<(f64, &Verdict)> = None;
        for verdict in choice.verdicts.iter().filter(able) {
            let step_s = choose::step_s(water, &verdict.variant, fps);
            // A picture of several steps is fused where nothing acts between them.
            let fused = verdict.name.split_once('/').map(|(kernel, rest)| format!("{kernel}/fused/{rest}"));
            let fused = fused.filter(|_| !water.acts_each_step() && 1.0 / fps >= 2.0 * step_s);
            let names = fused.iter().map(String::as_str).chain([verdict.name.as_str()]);
            // Studies are of open water: what land costs is known from the rules alone.
            let land = choose::land_factor(water, &verdict.variant, has_terrain, fps, step_s);
            let ns = names.filter_map(|name| self.ns_per_column(name, columns)).reduce(f64::min);
            let Some((ns, land)) = ns.zip(land) else {
                unmeasured.push(verdict.name.clone());
                continue;
            };
            let cost = ns * land / step_s;
            if best.is_none_or(|(least, _)| cost < least) {
                best = Some((cost, verdict));
            }
        }
        let (ns_per_column_second, verdict) = best?;
        Some(Refined {
            water: water.name.clone(),
            variant: verdict.name.clone(),
            expected_error: verdict.error(),
            ns_per_column_second,
            is_taken: verdict == taken,
            unmeasured,
        })
    }
}
