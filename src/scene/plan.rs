// SPDX-License-Identifier: MIT OR Apache-2.0
//! From a scene to what runs: models with their steps, starts, buffers and passes. No GPU is needed: `whitecap check`
//! prints a plan, a run builds it.

use super::{works, Heightmap, Model, Scene, SceneError, Start, View, Walls, WaterScene};
use crate::{draw::TerrainGrid, water};
use glam::{uvec2, vec2, UVec2, Vec2};
use serde::Serialize;

/// A buffer or an image, and who pays for it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedBuffer {
    /// As captures show it.
    pub name: String,
    /// On the device (bytes).
    pub bytes: u64,
    /// The key of the scene that it is for.
    pub because: String,
}

/// A water as it will run.
#[derive(Clone, Debug, PartialEq)]
pub struct WaterPlan {
    /// As in the scene.
    pub name: String,
    /// Grid, speed and step.
    pub model: water::Model,
    /// Which simulation.
    pub kind: Model,
    /// Why, and what error is to be expected.
    pub reason: String,
    /// Steps for each picture.
    pub steps_per_picture: f64,
    /// Most steps for one picture; time beyond it is lost and reported.
    pub most_steps: u32,
    /// Some columns are land.
    pub has_land: bool,
    /// The surface at the start (m above rest), [`water::LAND_M`] on land.
    pub height_m: Vec<f32>,
    /// Something falls into it.
    pub is_disturbed: bool,
    /// Borders that waves leave through, if there are any.
    pub absorbing: Option<water::Borders>,
    /// Bodies that move through it, in the world's coordinates.
    pub bodies: Vec<water::Body>,
}

/// A scene as it will run.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The waters.
    pub waters: Vec<WaterPlan>,
    /// The heightmap, or a flat bed under the water.
    pub terrain: TerrainGrid,
    /// Whether the scene has a heightmap.
    pub has_terrain: bool,
    /// Of the heightmap.
    pub warnings: Vec<String>,
    /// All buffers and images.
    pub buffers: Vec<PlannedBuffer>,
    /// Passes of a picture, in order, with how often each runs.
    pub passes: Vec<(String, f64)>,
}

/// Most disturbances of one pass; what is more goes into further passes of the same step.
pub const DISTURBANCES: u32 = 256;

impl WaterScene {
    /// The model with the step that `dt_s` gives, or the longest that divides a picture's time and is 5 % below the
    /// limit: fixed steps near the limit are the most accurate ones of a linear leapfrog, and the cheapest.
    pub fn simulation(&self, fps: f64) -> water::Model {
        let model = water::Model {
            cells: UVec2::from(self.cells),
            cell_m: f64::from(self.size_m[0]) / f64::from(self.cells[0]),
            speed_mps: (self.gravity_mps2 * self.depth_m).sqrt(),
            damping_per_s: self.damping_per_s,
            diagonal: self.diagonal,
            walls: match self.walls {
                Walls::Folded => water::Walls::Folded,
                Walls::Dropped => water::Walls::Dropped,
            },
            dt_s: 0.0,
        };
        let steps = (1.0 / (fps * 0.95 * model.longest_stable_s())).ceil().max(1.0);
        water::Model { dt_s: self.dt_s.unwrap_or(1.0 / (fps * steps)), ..model }
    }

    /// Relative error of the phase of waves eight columns long after they have run a hundred columns: `X k (k dx)^2
    /// (G - courant^2) / 24`, the leading term of the dispersion relation.
    fn predicted_phase_error(&self, model: &water::Model) -> f64 {
        let k = std::f64::consts::TAU / 8.0;
        // Mean over directions: 1 along the axis, (1 + 8 w) / (2 (1 + 2 w)) along the diagonal.
        let stencil = 0.5 * (1.0 + (1.0 + 8.0 * model.diagonal) / (2.0 * (1.0 + 2.0 * model.diagonal)));
        100.0 * k * k * k * (stencil - model.courant().powi(2)).abs() / 24.0
    }

    fn plan(&self, fps: f64, ground: Option<&Heightmap>) -> WaterPlan {
        let model = self.simulation(fps);
        let steps_per_picture = 1.0 / (fps * model.dt_s);
        let mut height_m = self.start_heights(&model);
        let centre = |i: usize| {
            let c = uvec2(i as u32 % model.cells.x, i as u32 / model.cells.x).as_vec2();
            ((c + 0.5) / model.cells.as_vec2() - 0.5) * Vec2::from(self.size_m)
        };
        let ground = ground.filter(|_| self.model == Model::Waves);
        if let Some(ground) = ground {
            for (i, height) in height_m.iter_mut().enumerate() {
                let at = centre(i);
                if ground.height_at(at.x, at.y) > self.level_m {
                    *height = water::LAND_M;
                }
            }
        }
        self.build_walls(&mut height_m);
        let has_land = height_m.contains(&water::LAND_M);
        let limit = model.longest_stable_s();
        let reason = format!(
            "{} as the scene asks; step {:.6} s, {:.0} % of the longest stable one; waves 8 columns long are expected to be \
             {:.2} rad out of phase after 100 columns",
            match self.model {
                Model::Book => "the book's pipes, 40 bytes a column and step,",
                Model::Waves => "flat bottom, linear: two floats a column, 16 bytes a column and step,",
            },
            model.dt_s,
            100.0 * model.dt_s / limit,
            self.predicted_phase_error(&model),
        );
        WaterPlan {
            name: self.name.clone(),
            kind: self.model,
            reason,
            steps_per_picture,
            most_steps: self.max_catch_up_steps.unwrap_or(8.max((2.0 * steps_per_picture).ceil() as u32)),
            has_land,
            height_m,
            is_disturbed: !self.drops.is_empty() || self.rain.is_some(),
            absorbing: self.absorbing(),
            bodies: self.fleet(),
            model,
        }
    }

    fn start_heights(&self, model: &water::Model) -> Vec<f32> {
        let cells = model.cells;
        let place = |i: u32| {
            let c = uvec2(i % cells.x, i / cells.x).as_vec2();
            ((c + 0.5) / cells.as_vec2() - 0.5) * Vec2::from(self.size_m)
        };
        let round = |at_m: [f32; 2], shape: &dyn Fn(f32) -> f32| -> Vec<f32> {
            (0..cells.element_product()).map(|i| shape(place(i).distance(Vec2::from(at_m)))).collect()
        };
        match self.start {
            Start::Flat => vec![0.0; cells.as_usizevec2().element_product()],
            Start::Hump { height_m, at_m, radius_m } => {
                round(at_m, &|r| height_m * (-0.5 * (r / radius_m).powi(2)).exp())
            }
            Start::Sombrero { height_m, at_m, radius_m } => round(at_m, &|r| {
                let x = std::f32::consts::PI * r / radius_m;
                if x == 0.0 {
                    height_m
                } else {
                    height_m * x.sin() / x
                }
            }),
            Start::Mode { height_m, waves } => {
                let mode = water::oracle::mode(cells, UVec2::from(waves));
                mode.into_iter().map(|h| (f64::from(height_m) * h) as f32).collect()
            }
        }
    }
}

impl Scene {
    /// Loads what the scene refers to, and works out what will run.
    ///
    /// # Errors
    /// If the heightmap cannot be used.
    pub fn plan(&self) -> Result<Plan, SceneError> {
        let ground = self.terrain_heights()?;
        let waters: Vec<_> =
            self.water.iter().map(|water| water.plan(self.output.fps, ground.as_ref())).collect();
        let mut warnings = ground.as_ref().map_or(Vec::new(), |ground| ground.warnings.clone());
        for (water, scene) in waters.iter().zip(&self.water) {
            if water.height_m.iter().all(|&h| h == water::LAND_M) {
                warnings.push(format!(
                    "water `{}`: the ground is above level_m everywhere, there is no water",
                    water.name
                ));
            }
            if scene.model == Model::Book && ground.is_some() {
                warnings.push(format!(
                    "water `{}`: the book's model knows no shore, its basin is the whole grid",
                    water.name
                ));
            }
        }
        let has_terrain = ground.is_some();
        let mut terrain = match ground {
            Some(ground) => TerrainGrid {
                cells: uvec2(ground.columns, ground.rows),
                size_m: Vec2::from(ground.size_m),
                height_m: ground.height_m,
            },
            // A bed as deep as the deepest water, so that there is something to see through it.
            None => {
                let bed = self.water.iter().map(|w| w.level_m - w.depth_m as f32).fold(f32::MAX, f32::min);
                TerrainGrid::flat(vec2(self.extent_m(), self.extent_m()), bed)
            }
        };
        works::raise_walls(&self.water, &mut terrain);
        let mut plan =
            Plan { waters, terrain, has_terrain, warnings, buffers: Vec::new(), passes: Vec::new() };
        plan.list_buffers(self);
        plan.list_passes(self);
        Ok(plan)
    }
}

impl Plan {
    /// Sum of all buffers and images (bytes).
    pub fn bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.bytes).sum()
    }

    fn list_buffers(&mut self, scene: &Scene) {
        let mut list = Vec::new();
        let mut add = |name: &str, bytes: u64, because: String| {
            list.push(PlannedBuffer { name: name.into(), bytes, because });
        };
        for water in &self.waters {
            let because = format!("water.{}", water.name);
            let cells = water.model.cells.as_u64vec2();
            match water.kind {
                Model::Book => {
                    for i in 0..2 {
                        add(&format!("water.columns.{i}"), 20 * cells.element_product(), because.clone());
                    }
                }
                Model::Waves => {
                    let bytes = 4 * cells.x.next_multiple_of(4) * cells.y;
                    for name in ["water.height_m.0", "water.height_m.1", "water.velocity_mps"] {
                        add(name, bytes, because.clone());
                    }
                }
            }
            if water.is_disturbed {
                let why = format!("{because}.drop or .rain");
                add("water.disturbances", 16 + 32 * u64::from(DISTURBANCES), why.clone());
                add("water.disturbance_counts", 12, why);
            }
            if let Some(borders) = &water.absorbing {
                add("water.absorb_keep", 4 * u64::from(borders.strip), format!("{because}.borders"));
            }
            if !water.bodies.is_empty() {
                let poses = water.bodies.len() as u64 * (u64::from(water.most_steps) + 1);
                let bytes = poses * size_of::<water::bodies::Pose>() as u64;
                add("water.bodies", bytes, format!("{because}.body"));
            }
        }
        if scene.output.view == View::Shaded {
            let samples = self.terrain.height_m.len() as u64;
            let ground = if self.has_terrain { "terrain" } else { "water without terrain: a flat bed" };
            add("draw.terrain_m", 4 * samples, ground.into());
            add("draw.light", 8 * samples, ground.into());
        }
        let pixels = u64::from(scene.output.size[0]) * u64::from(scene.output.size[1]);
        let size = "output.size";
        add("draw.samples (4 a pixel, where the device has them)", 4 * 8 * pixels, size.into());
        add("draw.color", 8 * pixels, size.into());
        add("draw.depth", 4 * 4 * pixels, size.into());
        add("draw.pixels", 4 * pixels, size.into());
        add("draw.pixels.readback (of the host)", 4 * pixels, size.into());
        add("draw.views (of the host)", size_of::<crate::draw::View>() as u64, size.into());
        add("draw.grid", crate::draw::Grid::BYTES, size.into());
        self.buffers = list;
    }

    fn list_passes(&mut self, scene: &Scene) {
        for water in &self.waters {
            if !water.bodies.is_empty() {
                self.passes.push(("water.draught".into(), 1.0));
                self.passes.push(("water.body".into(), water.steps_per_picture));
            }
            let step = if water.kind == Model::Book { "water.book" } else { "water.waves" };
            self.passes.push((step.into(), water.steps_per_picture));
            if water.absorbing.is_some() {
                self.passes.push(("water.absorb".into(), water.steps_per_picture));
            }
            if water.is_disturbed {
                self.passes.push((
                    "water.weigh, water.disturb (when something falls)".into(),
                    water.steps_per_picture,
                ));
            }
        }
        let surface =
            if scene.output.view == View::Wireframe { "water.wire" } else { "sky, terrain, water.surface" };
        if scene.output.view == View::Shaded {
            self.passes.push(("draw.light (with the first picture)".into(), 0.0));
        }
        self.passes.push((format!("draw.scene ({surface})"), 1.0));
        self.passes.push(("draw.tonemap".into(), 1.0));
    }
}
