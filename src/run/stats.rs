// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a run reports: `stats.json`.

use crate::gpu::SpanTime;
use serde::Serialize;
use std::collections::BTreeMap;

pub use super::basin::Depths;

/// The whole of `stats.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stats {
    /// Version of this crate.
    pub version: String,
    /// Title of the scene.
    pub scene: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Name of the device.
    pub device: String,
    /// Its driver.
    pub driver: String,
    /// Clock of the pass times: `gpu` or `fence`.
    pub clock: String,
    /// Pictures made.
    pub frames: u32,
    /// Simulated (s).
    pub simulated_s: f64,
    /// Taken, pictures and files included (s).
    pub wall_s: f64,
    /// By pass, in the order that they first ran.
    pub passes: Vec<PassStats>,
    /// Passes that ran and were not timed: a picture has room for so many.
    #[serde(skip_serializing_if = "is_zero")]
    pub untimed: u64,
    /// By water, as in the scene.
    pub waters: Vec<WaterStats>,
    /// By emitter, as in the scene.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub emitters: Vec<EmitterStats>,
    /// By box of disks, as in the scene.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub disks: Vec<DisksStats>,
    /// Of meshes, cells, impacts and paint, if particles meet meshes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeStats>,
    /// Every so many frames, if asked for: frame and one hash a water, then one a pool of particles or a ring of impacts, one a box of disks, and
    /// one of the paint.
    pub hashes: Vec<(u32, Vec<String>)>,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Times of one pass.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PassStats {
    /// Name of the pass.
    pub name: String,
    /// How often it was timed.
    pub runs: u64,
    /// In all (ms).
    pub total_ms: f64,
    /// The shortest (ms).
    pub min_ms: f64,
    /// Mean (ms).
    pub mean_ms: f64,
    /// The longest (ms).
    pub max_ms: f64,
    /// What all runs together made the device do, if that was asked for; counters that are zero are left out.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub statistics: BTreeMap<&'static str, u64>,
}

fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// What became of one water.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WaterStats {
    /// As in the scene.
    pub name: String,
    /// What stepped it, as results name it.
    pub variant: String,
    /// Steps taken.
    pub steps: u64,
    /// Of a step (s).
    pub dt_s: f64,
    /// Not simulated, because frames asked for more steps than allowed (s).
    pub lost_s: f64,
    /// At rest (m^3).
    pub volume_at_rest_m3: f64,
    /// Gained since the start, drops included (m^3).
    pub volume_gain_m3: f64,
    /// Asked for by drops, sources and rain; what missed the water is in it, and of what landed (`splashes`) what did since the
    /// run began, was resumed or was built anew (m^3).
    pub volume_given_m3: f64,
    /// Energy at the end, of that at the start; absent for a start at rest, and where a scheme has none.
    pub energy_relative: Option<f64>,
    /// Lowest point (m above rest); `null` if no column is wet, as is the highest.
    pub lowest_m: Option<f32>,
    /// Highest point (m above rest).
    pub highest_m: Option<f32>,
    /// Of water over ground at the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub depths: Option<Depths>,
    /// Drops and sources' steps that fell in.
    pub disturbances_applied: u64,
    /// Not finite or absurd.
    pub disturbances_rejected: u64,
    /// Fell on land or outside.
    pub disturbances_missed: u64,
    /// Did not fit in the list.
    pub disturbances_dropped: u64,
    /// What rippled it, since the start (of this run, where it went on from another).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub splashes: Vec<SplashStats>,
    /// Of the state at the end.
    pub state_hash: String,
}

/// What became of the drops of an emitter that ripples a water.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SplashStats {
    /// The emitter.
    pub from: String,
    /// Drops that have landed, in the water or not.
    pub landed: u64,
    /// Of them, in the water: each is a ring.
    pub taken: u64,
    /// On land, or outside.
    pub missed: u64,
    /// For which there was no room in their step: they ripple nothing.
    pub dropped: u64,
    /// Disturbances, one or two a drop, that were not finite or absurd.
    pub rejected: u64,
    /// Water that they brought (m^3).
    pub volume_m3: f64,
}

/// What became of the particles of one emitter.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EmitterStats {
    /// As in the scene.
    pub name: String,
    /// Born since the start.
    pub born: u64,
    /// Alive at the end.
    pub alive: u64,
    /// Born without room, and not drawn.
    pub dropped: u64,
    /// Ended by age.
    pub aged: u64,
    /// Ended by the law.
    pub ended: u64,
    /// Ended because a number was none.
    pub spoiled: u64,
    /// Steps taken; absent where nothing is stepped.
    pub steps: Option<u64>,
    /// Of a step (s).
    pub dt_s: Option<f64>,
    /// Of all that lives at the end, or of the ring.
    pub state_hash: Option<String>,
    /// If impacts throw them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kindled: Option<KindledStats>,
}

/// What became of the impacts that throw an emitter's particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct KindledStats {
    /// That threw, since the start.
    pub impacts: u64,
    /// Particles that lived when others took their places: born, and neither alive nor aged.
    pub overwritten: u64,
    /// Impacts that threw nothing, as they had no place in the order of their step.
    pub lost: u64,
}

/// What became of one box of disks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DisksStats {
    /// As in the scene.
    pub name: String,
    /// How many.
    pub count: u64,
    /// Share of the box that is disk.
    pub packing: f64,
    /// Steps taken, substeps included.
    pub steps: u64,
    /// Of each (s).
    pub dt_s: f64,
    /// Energy at the end, of motion and of height in the box, of the start's, less 1. A box that repeats has no height:
    /// gravity adds to it.
    pub energy_drift: f64,
    /// Of all that the next step depends on.
    pub state_hash: String,
}

/// What became of meshes, cells, impacts and paint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VolumeStats {
    /// Of all meshes that particles meet.
    pub triangles: u32,
    /// Of the grid.
    pub cells: u64,
    /// Cells that a triangle passes through, at the end.
    pub occupied: u64,
    /// Triangles without an area, which are in no cell.
    pub without_area: u32,
    /// Triangles with a corner that is no number.
    pub not_finite: u32,
    /// Steps taken.
    pub steps: u64,
    /// Of each (s).
    pub dt_s: f64,
    /// Impacts, since the start (of this run, where it went on from another).
    pub impacts: u64,
    /// For which there was no room in their step: they moved the particle, and left no paint.
    pub impacts_dropped: u64,
    /// On a mesh that is painted, of nobody who paints.
    pub impacts_without_paint: u64,
    /// By mesh that is painted.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub paint: Vec<PaintStats>,
    /// Of all paint maps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paint_hash: Option<String>,
}

/// What became of the paint on one mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PaintStats {
    /// As in the scene.
    pub name: String,
    /// Of its map, in a triangle.
    pub texels: u64,
    /// Of them, in more than one.
    pub overlapping: u64,
    /// Of them, with paint on them.
    pub painted: u64,
    /// In a triangle or beside one, and at no finite place: they take no paint.
    pub nowhere: u64,
}

impl Stats {
    /// Adds one time of a pass.
    pub(super) fn add(&mut self, span: &SpanTime) {
        let (name, ms) = (span.name.to_string_lossy(), span.ms);
        let pass = match self.passes.iter_mut().position(|pass| pass.name == name) {
            Some(i) => &mut self.passes[i],
            None => {
                let new = PassStats {
                    name: name.into(),
                    runs: 0,
                    total_ms: 0.0,
                    min_ms: ms,
                    mean_ms: 0.0,
                    max_ms: ms,
                    statistics: BTreeMap::new(),
                };
                self.passes.push(new);
                self.passes.last_mut().expect("just pushed")
            }
        };
        pass.runs += 1;
        pass.total_ms += ms;
        pass.min_ms = pass.min_ms.min(ms);
        pass.max_ms = pass.max_ms.max(ms);
        pass.mean_ms = pass.total_ms / pass.runs as f64;
        for (counter, count) in &span.statistics {
            *pass.statistics.entry(counter).or_default() += count;
        }
    }
}
