// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scene files: what to simulate and how to look at it, read from TOML with every mistake found at once.
//!
//! The world is in metres: y is up, x and z are horizontal, terrain and water are centred on x = z = 0. Unknown
//! keys, values out of range, NaN and infinity are errors that name the line and what is allowed.
//!
//! ```
//! use whitecap::scene::{Override, Scene};
//!
//! let text = r#"
//!     title = "Bathtub"
//!     [[water]]
//!     model = "waves"
//!     cells = [160, 70]
//!     size_m = [1.6, 0.7]
//!     depth_m = 0.4
//! "#;
//! let smaller: Override = "water.0.cells=[80, 35]".parse()?;
//! let scene = Scene::parse(text, "bathtub.toml", None, &[smaller])?;
//! assert_eq!(scene.water[0].cells, [80, 35]);
//! # Ok::<(), whitecap::scene::SceneError>(())
//! ```

mod asc;
mod attractors;
pub mod builtin;
mod choose;
mod colliding;
mod disks;
mod emit;
mod error;
mod heightmap;
mod kindled;
pub mod measured;
mod meshes;
mod motion;
mod node;
mod paint;
mod parameter;
mod parse;
mod particles;
mod plan;
mod schema;
mod simulation;
mod splash;
mod volume;
mod water;
mod water_table;
mod works;

use std::path::{Path, PathBuf};

use serde::Serialize;

pub use attractors::Attractor;
pub(crate) use attractors::MOST_CENTRES;
pub use choose::{percent, percent_expected, Choice, Variant, Verdict};
pub use colliding::CollidingScene;
pub use disks::{DisksScene, Heavy};
pub use emit::{EmitterPlan, LawPlan, PlannedThrows, Spv};
pub use error::{Place, Problem, ProblemKind, SceneError};
pub use heightmap::{Heightmap, HeightmapError};
pub use kindled::{KindledPlan, KindledScene};
pub use measured::Measured;
pub use meshes::{MeshPlan, MeshScene, Shape, Source as MeshSource};
pub use motion::{Key, Motion};
pub use node::Override;
pub use paint::{PaintPlan, PaintScene, PaintedBy, Painter};
pub use parameter::{Given, Parameter, Takes};
pub use particles::{Draw, EffectScene, EmitterScene, LawScene, Throws};
pub(crate) use plan::SHADOW_SIDE;
pub use plan::{Plan, PlannedBuffer, WaterPlan, DISTURBANCES};
pub use simulation::Simulation;
pub use splash::{Brings, SplashPlan, SplashScene};
pub use volume::{VolumePlan, VolumeScene, Voxeliser};
pub use water::{Drop, Model, Rain, Source, Start, Walls, WaterScene};
pub use works::{Body, BodyPath, BodyShape, Border, Borders, Wall, WallLook};

/// A scene: everything that a run needs, with defaults filled in and every value within its range.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scene {
    /// A line for people; empty if not given.
    pub title: String,
    /// Seed of everything random in the scene, default 1.
    pub seed: u64,
    /// The pictures to make.
    pub output: Output,
    /// The camera, if the scene places one; [`Scene::camera`] fills in the default.
    pub camera: Option<Camera>,
    /// The sun.
    pub sun: Sun,
    /// Where the ground comes from, if there is any; [`Scene::terrain_heights`] loads it.
    pub terrain: Option<TerrainSource>,
    /// The bodies of water. A scene has terrain, water or something that throws particles.
    pub water: Vec<WaterScene>,
    /// What throws particles.
    #[serde(rename = "emitter")]
    pub emitters: Vec<EmitterScene>,
    /// What pulls them.
    #[serde(rename = "attractor")]
    pub attractors: Vec<Attractor>,
    /// Boxes of disks or spheres that collide.
    pub disks: Vec<DisksScene>,
    /// What particles collide with and paint.
    #[serde(rename = "mesh", skip_serializing_if = "Vec::is_empty")]
    pub meshes: Vec<MeshScene>,
    /// The cells that they meet it in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeScene>,
    /// What they leave on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paint: Option<PaintScene>,
    /// The folder that asset paths are relative to; `None` is the current one.
    #[serde(skip)]
    pub base_dir: Option<PathBuf>,
}

/// The pictures that a run makes.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Output {
    /// Width and height (pixels), each 16..=8192, default 960 × 540.
    pub size: [u32; 2],
    /// Pictures per simulated second (1/s), 1..=1000, default 30.
    pub fps: f64,
    /// Number of pictures, 1..=1 000 000, default 120.
    pub frames: u32,
    /// How surfaces are drawn, default [`View::Shaded`].
    pub view: View,
}

/// How surfaces are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum View {
    /// Lit water and ground.
    #[default]
    Shaded,
    /// The book's debug view: lines, with the tiles of the workgroups in alternating colours.
    Wireframe,
    /// The cells that meshes are in, as boxes, coloured by the normal of their first plane.
    Voxels,
    /// The planes that cells hold.
    Planes,
    /// Where in the world each texel of the paint maps is, as colours, one map beside the other.
    PositionMap,
    /// The paint maps themselves.
    PaintMap,
}

impl View {
    /// With their names.
    pub const ALL: [(&str, Self); 6] = [
        ("shaded", Self::Shaded),
        ("wireframe", Self::Wireframe),
        ("voxels", Self::Voxels),
        ("planes", Self::Planes),
        ("position_map", Self::PositionMap),
        ("paint_map", Self::PaintMap),
    ];
}

/// A camera that may circle its target.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Camera {
    /// Position at time 0 (m); differs from the target.
    pub eye_m: [f32; 3],
    /// The point looked at (m), default the origin.
    pub target_m: [f32; 3],
    /// Vertical angle of view (degrees), 5..=120, default 40.
    pub fov_deg: f32,
    /// How fast the eye circles the target, from +z towards +x (degrees/s), -360..=360, default 0.
    pub orbit_deg_per_s: f32,
}

/// The direction of the sunlight.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sun {
    /// Direction towards the sun, from +z towards +x (degrees), -360..=360, default 135.
    pub azimuth_deg: f32,
    /// Height above the horizon (degrees), 1..=90, default 32.
    pub elevation_deg: f32,
    /// Of sun and sky, 0..=1, default 1; below a tenth it is night.
    pub brightness: f32,
}

/// Where the ground comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TerrainSource {
    /// As written in the scene: a `.png` (8 or 16 bits of grey) or `.asc` (ESRI ASCII grid) file relative to
    /// [`Scene::base_dir`], or `builtin/NAME`.
    pub heightmap: String,
    /// Extent along x and z (m), more than 0; for `.asc` by default the size in its header.
    pub size_m: [f32; 2],
    /// Heights of black and white (m), finite; always present for `.png`, never for `.asc`.
    pub height_m: Option<[f32; 2]>,
}

impl Scene {
    /// Reads a scene file; `overrides` replace or add keys, in order.
    pub fn load(path: &Path, overrides: &[Override]) -> Result<Self, SceneError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| SceneError::Read { path: path.display().to_string(), source })?;
        Self::parse(&text, &path.display().to_string(), path.parent(), overrides)
    }

    /// Reads a scene from `text`. `file_name` stands in errors, `base_dir` is what asset paths are relative to.
    ///
    /// Touches no file, except that the header of an `.asc` heightmap without `size_m` is read for its size.
    pub fn parse(
        text: &str,
        file_name: &str,
        base_dir: Option<&Path>,
        overrides: &[Override],
    ) -> Result<Self, SceneError> {
        schema::scene(text, file_name, base_dir, overrides).0
    }

    /// [`Scene::parse`], with a list of every key that the scene has or could have, in the order of the schema: what it
    /// takes, and what it is given. Where the scene is wrong the list is of what could be read.
    pub fn parse_listing(
        text: &str,
        file_name: &str,
        base_dir: Option<&Path>,
    ) -> (Result<Self, SceneError>, Vec<Parameter>) {
        schema::scene(text, file_name, base_dir, &[])
    }

    /// Loads the heightmap of the terrain, if the scene has one.
    pub fn terrain_heights(&self) -> Result<Option<Heightmap>, SceneError> {
        self.terrain.as_ref().map(|terrain| heightmap::load(terrain, self.base_dir.as_deref())).transpose()
    }

    /// Emitters that have a state: a pool, or a ring of impacts.
    pub(crate) fn pools(&self) -> usize {
        let has_state = |it: &&EmitterScene| matches!(it.throws, Throws::Law(_)) || it.kindled().is_some();
        self.emitters.iter().filter(has_state).count()
    }

    /// The scene's camera, or else one that sees the whole scene.
    pub fn camera(&self) -> Camera {
        let level = self.water.first().map_or(0.0, |water| water.level_m);
        self.camera.clone().unwrap_or_else(|| Camera::overview(self.extent_m(), level))
    }

    /// The largest horizontal extent of the terrain and the waters (m).
    pub fn extent_m(&self) -> f32 {
        let sizes = self.terrain.iter().map(|t| t.size_m).chain(self.water.iter().map(|w| w.size_m));
        let extent = sizes.flatten().fold(0.0, f32::max);
        let boxes = self.disks.iter().flat_map(|it| it.size_m).fold(0.0, f64::max) as f32;
        if extent.max(boxes) > 0.0 {
            return extent.max(6.0 * boxes);
        }
        if let Some(volume) = &self.volume {
            return volume.cell_m * volume.cells.into_iter().max().unwrap_or(1) as f32;
        }
        // Particles alone: what throws them and what pulls them.
        let places =
            self.emitters.iter().filter_map(|it| it.at_m).chain(self.attractors.iter().map(|it| it.at_m));
        2.0 * places.flatten().fold(5.0, |far: f32, x| far.max(x.abs()))
    }
}

impl Default for Output {
    fn default() -> Self {
        Self { size: [960, 540], fps: 30.0, frames: 120, view: View::default() }
    }
}

impl Camera {
    /// A camera that sees a square of `extent_m` (m) around the y axis at height `level_m` (m).
    pub fn overview(extent_m: f32, level_m: f32) -> Self {
        let [x, y, z] = [0.45, 0.65, 0.95].map(|share: f32| share * extent_m);
        let target_m = [0.0, level_m, 0.0];
        Self { eye_m: [x, level_m + y, z], target_m, fov_deg: 40.0, orbit_deg_per_s: 0.0 }
    }

    /// Where the eye is at `time_s` (s), on its way round the target (m).
    pub fn eye_at(&self, time_s: f64) -> [f32; 3] {
        // Whole turns are dropped in f64, so that the eye does not jitter late in a long run.
        let angle = (f64::from(self.orbit_deg_per_s) * time_s).rem_euclid(360.0).to_radians();
        let (sin, cos) = angle.sin_cos();
        let (sin, cos) = (sin as f32, cos as f32);
        let [x, z] = [self.eye_m[0] - self.target_m[0], self.eye_m[2] - self.target_m[2]];
        [self.target_m[0] + cos * x + sin * z, self.eye_m[1], self.target_m[2] + cos * z - sin * x]
    }
}

impl Default for Sun {
    fn default() -> Self {
        Self { azimuth_deg: 135.0, elevation_deg: 32.0, brightness: 1.0 }
    }
}

impl Sun {
    /// The unit vector towards the sun.
    pub fn direction(&self) -> [f32; 3] {
        let (azimuth_sin, azimuth_cos) = self.azimuth_deg.to_radians().sin_cos();
        let (elevation_sin, elevation_cos) = self.elevation_deg.to_radians().sin_cos();
        [azimuth_sin * elevation_cos, elevation_sin, azimuth_cos * elevation_cos]
    }
}
