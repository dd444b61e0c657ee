// SPDX-License-Identifier: MIT OR Apache-2.0
//! From a scene to what runs: models with their steps, starts, buffers and passes. No GPU is needed: `whitecap check`
//! prints a plan, a run builds it.

use super::{
    choose::percent_expected, emit, kindled, particles::Draw, works, EmitterPlan, Heightmap, MeshPlan, Model,
    PaintPlan, PaintedBy, Scene, SceneError, Simulation, SplashPlan, View, VolumePlan, WaterScene,
};
use crate::{
    ballistic::GroundGrid,
    draw::{shadow::Shadow, TerrainGrid},
    water,
};
use glam::{uvec2, Vec2, Vec3};
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
    /// What steps it, from which start.
    pub simulation: Simulation,
    /// Which variant, why, and what error is to be expected.
    pub reason: String,
    /// Steps for each picture.
    pub steps_per_picture: f64,
    /// Most steps for one picture; time beyond it is lost and reported.
    pub most_steps: u32,
    /// Something falls into it.
    pub is_disturbed: bool,
    /// What ripples it without the host in between.
    pub splashes: Vec<SplashPlan>,
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
    /// What throws particles.
    pub emitters: Vec<EmitterPlan>,
    /// What particles collide with and paint.
    pub meshes: Vec<MeshPlan>,
    /// The cells that they meet it in.
    pub volume: Option<VolumePlan>,
    /// What they leave on it.
    pub paint: Option<PaintPlan>,
    /// The heightmap, or a flat bed under the water.
    pub terrain: TerrainGrid,
    /// It, and the highest water on it: what effects land on.
    pub grid: GroundGrid,
    /// Whether the scene has a heightmap.
    pub has_terrain: bool,
    /// Whether it has spheres, which stand on ground.
    pub has_spheres: bool,
    /// Of the heightmap.
    pub warnings: Vec<String>,
    /// All buffers and images.
    pub buffers: Vec<PlannedBuffer>,
    /// Passes of a picture, in order, with how often each runs.
    pub passes: Vec<(String, f64)>,
}

/// Texels along the map of shadows.
pub(crate) const SHADOW_SIDE: u32 = 2048;

/// Most disturbances of one pass; what is more goes into further passes of the same step.
pub const DISTURBANCES: u32 = 256;

impl WaterScene {
    fn plan(&self, fps: f64, ground: Option<&Heightmap>) -> Result<WaterPlan, SceneError> {
        let simulation = self.simulation(fps, ground)?;
        let steps_per_picture = 1.0 / (fps * simulation.dt_s());
        let taken = self.choice.taken();
        let reason = format!(
            "{}, {}: expected error {} % at the end of the scene, {} % of it the model's and {} % the grid's; step {:.6} s, \
             {:.0} % of the longest stable one",
            taken.name,
            self.choice.reason(self.tolerance),
            percent_expected(taken.error()),
            percent_expected(taken.model_error),
            percent_expected(taken.grid_error),
            simulation.dt_s(),
            100.0 * simulation.dt_s() / simulation.longest_stable_s(),
        );
        Ok(WaterPlan {
            name: self.name.clone(),
            reason,
            steps_per_picture,
            most_steps: self.max_catch_up_steps.unwrap_or(8.max((2.0 * steps_per_picture).ceil() as u32)),
            is_disturbed: self.is_disturbed(),
            splashes: Vec::new(), // of what the emitters land on: Scene::plan
            absorbing: self.absorbing(),
            bodies: self.fleet(),
            simulation,
        })
    }

    /// Whether drops fall or sources run, as opposed to even rain.
    fn is_disturbed(&self) -> bool {
        let drips = self.rain.as_ref().is_some_and(|rain| rain.drops_per_s > 0.0);
        drips || !self.drops.is_empty() || !self.sources.is_empty()
    }
}

impl Scene {
    /// Loads what the scene refers to, and works out what will run.
    ///
    /// # Errors
    /// If the heightmap cannot be used.
    pub fn plan(&self) -> Result<Plan, SceneError> {
        let ground = self.terrain_heights()?;
        let mut waters: Vec<_> = self
            .water
            .iter()
            .map(|water| water.plan(self.output.fps, ground.as_ref()))
            .collect::<Result<_, _>>()?;
        let mut warnings = ground.as_ref().map_or(Vec::new(), |ground| ground.warnings.clone());
        for (water, scene) in waters.iter().zip(&self.water) {
            let comes = !scene.sources.is_empty() || scene.rain.is_some() && scene.model.has_ground();
            if !water.simulation.has_water() && !comes {
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
                built: Vec::new(),
            },
            // A bed as deep as the deepest water, so that there is something to see through it.
            None => {
                let beds = self.water.iter().map(|w| w.level_m - w.depth_m as f32);
                let bed = beds.reduce(f32::min).unwrap_or(0.0);
                let water = self.water.iter().map(|water| Vec2::from(water.size_m)).reduce(Vec2::max);
                TerrainGrid::flat(water.unwrap_or(Vec2::splat(self.extent_m())), bed)
            }
        };
        works::raise_walls(&self.water, &mut terrain);
        let meshes = self.plan_meshes()?;
        let volume = self.plan_volume(&meshes);
        let mut emitters = self.plan_emitters(volume.as_ref())?;
        self.plan_kindled(&solid_first(&meshes), &mut emitters)?;
        let water_m = self.water.iter().map(|it| it.level_m).fold(f32::NEG_INFINITY, f32::max);
        let grid = GroundGrid { size_m: terrain.size_m, cells: terrain.cells, water_m };
        for (water, scene) in waters.iter_mut().zip(&self.water) {
            water.splashes = self.plan_splashes(scene, &emitters, grid)?;
        }
        self.warn_of_impacts(&mut warnings);
        let paint = self.plan_paint(&solid_first(&meshes), &emitters, &mut warnings)?;
        let mut plan = Plan {
            waters,
            emitters,
            meshes,
            volume,
            paint,
            terrain,
            grid,
            has_terrain,
            has_spheres: self.disks.iter().any(|it| it.space == crate::disks::Space::Solid),
            warnings,
            buffers: Vec::new(),
            passes: Vec::new(),
        };
        plan.list_buffers(self);
        plan.list_passes(self);
        Ok(plan)
    }
}

fn solid_first(meshes: &[MeshPlan]) -> Vec<&MeshPlan> {
    let of = |painted: bool| meshes.iter().filter(move |it| it.solid && (it.map > 0) == painted);
    of(true).chain(of(false)).collect()
}

impl Plan {
    /// Sum of all buffers and images (bytes).
    pub fn bytes(&self) -> u64 {
        self.buffers.iter().map(|buffer| buffer.bytes).sum()
    }

    /// Whether there is ground to be seen; particles alone have none, and no sky either.
    pub fn has_ground(&self) -> bool {
        self.has_terrain || !self.waters.is_empty() || self.has_spheres
    }

    fn list_buffers(&mut self, scene: &Scene) {
        let mut list = Vec::new();
        let mut add = |name: &str, bytes: u64, because: String| {
            list.push(PlannedBuffer { name: name.into(), bytes, because });
        };
        for water in &self.waters {
            let because = format!("water.{}", water.name);
            let cells = water.simulation.cells().as_u64vec2();
            let plane = 4 * cells.x.next_multiple_of(4) * cells.y;
            let mut pair = |name: &str, bytes: u64| {
                for i in 0..2 {
                    add(&format!("water.{name}.{i}"), bytes, because.clone());
                }
            };
            match &water.simulation {
                Simulation::Level { variant, is_fused, .. } => match variant.model {
                    Model::Book => pair("columns", 20 * cells.element_product()),
                    Model::Pipes => {
                        pair("height_m", plane);
                        pair("flow_mps", if variant.diagonal == 0.0 { 2 } else { 4 } * plane);
                    }
                    _ => {
                        pair("height_m", plane);
                        match is_fused {
                            true => pair("velocity_mps", plane),
                            false => add("water.velocity_mps", plane, because.clone()),
                        }
                    }
                },
                Simulation::Depth { tier, .. } => {
                    pair("rise_m", plane);
                    if *tier == water::Tier::Shallow {
                        pair("before_m", plane);
                    }
                    pair("flow", 2 * plane);
                    add("water.bed_m", plane, because.clone());
                }
            }
            if water.is_disturbed {
                let why = format!("{because}.drop, .rain or .source");
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
        if scene.output.view != View::Wireframe && self.has_ground() {
            let samples = self.terrain.height_m.len() as u64;
            let ground = if self.has_terrain { "terrain" } else { "water without terrain: a flat bed" };
            add("draw.terrain_m", 4 * samples, ground.into());
            add("draw.light", 4 * samples, ground.into());
        }
        for disks in &scene.disks {
            disks.list_buffers(scene.seed, &mut list);
        }
        for emitter in &self.emitters {
            emitter.list_buffers(scene.output.size.map(u64::from).iter().product(), &mut list);
        }
        for water in &self.waters {
            water.splashes.iter().for_each(|it| it.list_buffers(&water.name, &mut list));
        }
        self.meshes.iter().for_each(|mesh| mesh.list_buffers(&mut list));
        if let Some(volume) = &self.volume {
            volume.list_buffers(self.paint.as_ref(), &mut list);
        }
        let mut add = |name: &str, bytes: u64, because: String| {
            list.push(PlannedBuffer { name: name.into(), bytes, because });
        };
        if self.has_shadow() {
            let side = u64::from(SHADOW_SIDE);
            add("draw.shadow (depth, its copy)", Shadow::BYTES_A_TEXEL * side * side, "mesh".into());
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

    /// Meshes that particles meet, those that are painted first: triangles are counted in this order.
    pub fn solid(&self) -> Vec<&MeshPlan> {
        solid_first(&self.meshes)
    }

    /// Whether what is solid casts shadows: meshes and balls.
    pub fn has_shadow(&self) -> bool {
        !self.meshes.is_empty() || self.emitters.iter().any(|it| it.draw == Draw::Balls)
    }

    /// Least and greatest corner of where things happen (m): the volume, or else all meshes.
    pub fn lit_m(&self) -> (Vec3, Vec3) {
        if let Some(volume) = &self.volume {
            return (volume.scene.low_m.into(), volume.scene.high_m());
        }
        let boxes = self.meshes.iter().map(|mesh| mesh.bounds_m(0.0));
        boxes.reduce(|(a, b), (c, d)| (a.min(c), b.max(d))).unwrap_or((-Vec3::ONE, Vec3::ONE))
    }

    /// Of meshes, cells, impacts and paint, and of the shadow.
    fn list_room_passes(&mut self, scene: &Scene) {
        let often = self.volume.as_ref().map_or(1.0, |volume| 1.0 / (scene.output.fps * volume.dt_s));
        if self.meshes.iter().any(MeshPlan::moves) {
            self.passes.push(("mesh.pose (of what moves)".into(), often));
        }
        if let Some(volume) = &self.volume {
            self.passes.push((format!("volume.{} (of what moves)", volume.scene.variant.name()), often));
        }
        if self.volume.is_some() {
            self.passes.push(("particles.near (of what moves)".into(), often));
            self.passes.push(("impact.close, .locate".into(), often));
        }
        if let Some(paint) = &scene.paint {
            self.passes.push(("paint.place, .blocks (of what moves)".into(), often));
            let method = paint.variant.name();
            let before = match paint.from {
                PaintedBy::Impacts => "paint.mark, .bits, .drops",
                PaintedBy::Particles => "paint.take",
            };
            self.passes.push((format!("{before}, .{method}"), often));
        }
        if self.has_shadow() {
            self.passes.push(("draw.shadow".into(), 1.0));
        }
    }

    fn list_passes(&mut self, scene: &Scene) {
        for water in &self.waters {
            if !water.bodies.is_empty() {
                self.passes.push(("water.draught".into(), 1.0));
                self.passes.push(("water.body".into(), water.steps_per_picture));
            }
            for pass in water.simulation.passes() {
                self.passes.push(((*pass).into(), water.steps_per_picture));
            }
            if water.absorbing.is_some() {
                self.passes.push(("water.absorb".into(), water.steps_per_picture));
            }
            if !water.splashes.is_empty() {
                let list = "ballistic.land, impact.close, water.splash, .weigh, .disturb (what lands)";
                self.passes.push((list.into(), water.steps_per_picture * water.splashes.len() as f64));
            }
            if water.is_disturbed {
                self.passes.push((
                    "water.weigh, water.disturb (when something falls)".into(),
                    water.steps_per_picture,
                ));
            }
        }
        for disks in &scene.disks {
            disks.list_passes(scene, &mut self.passes);
        }
        self.list_room_passes(scene);
        for emitter in &self.emitters {
            let often = kindled::often(self.volume.as_ref(), scene.output.fps);
            emitter.list_steps((scene.output.fps, often), &mut self.passes);
        }
        let surface = match (self.has_ground(), scene.output.view) {
            (false, _) if !self.meshes.is_empty() => "meshes",
            (false, _) => "nothing but particles",
            (_, View::Wireframe) => "water.wire",
            _ => "sky, terrain, water.surface",
        };
        if scene.output.view != View::Wireframe && self.has_ground() {
            self.passes.push(("draw.light (with the first picture)".into(), 0.0));
        }
        self.passes.push((format!("draw.scene ({surface})"), 1.0));
        emit::list_draws(&self.emitters, &mut self.passes);
        self.passes.push(("draw.tonemap".into(), 1.0));
    }
}
