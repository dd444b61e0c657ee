// SPDX-License-Identifier: MIT OR Apache-2.0
//! What steps a water, and the numbers that it starts with.

use super::{Heightmap, Model, SceneError, Start, Variant, WaterScene};
use crate::water::{self, Columns, Tier, LAND_M};
use glam::{uvec2, UVec2, Vec2};
use std::f32::consts::PI;

/// A simulation, with its state at the start.
#[derive(Clone, Debug, PartialEq)]
pub enum Simulation {
    /// Of level water: `book`, `waves`, `pipes`.
    Level {
        /// Grid, speed and step.
        model: water::Model,
        /// Which kernel.
        variant: Variant,
        /// Several steps are one dispatch where nothing comes between them: to the bit what single ones give.
        is_fused: bool,
        /// Some columns are land.
        has_land: bool,
        /// The surface at the start (m above rest), [`LAND_M`] on land.
        height_m: Vec<f32>,
    },
    /// Of water over ground: `wet`, `shallow`.
    Depth {
        /// Grid, limits and step.
        model: water::DepthModel,
        /// Which kernels.
        tier: Tier,
        /// Ground and water at the start.
        columns: Columns,
        /// Falls on every column (m/s).
        rain_mps: f64,
    },
}

impl Simulation {
    /// Columns along x and z.
    pub fn cells(&self) -> UVec2 {
        match self {
            Self::Level { model, .. } => model.cells,
            Self::Depth { model, .. } => model.cells,
        }
    }

    /// Edge of a column (m).
    pub fn cell_m(&self) -> f64 {
        match self {
            Self::Level { model, .. } => model.cell_m,
            Self::Depth { model, .. } => model.cell_m,
        }
    }

    /// Step (s).
    pub fn dt_s(&self) -> f64 {
        match self {
            Self::Level { model, .. } => model.dt_s,
            Self::Depth { model, .. } => model.dt_s,
        }
    }

    /// Beyond it the scheme is not stable (s).
    pub fn longest_stable_s(&self) -> f64 {
        match self {
            Self::Level { model, variant, .. } if variant.order == 4 => {
                model.fourth_order_limit() * model.cell_m / model.speed_mps
            }
            Self::Level { model, .. } => model.longest_stable_s(),
            Self::Depth { model, tier, .. } => model.longest_stable_s(*tier),
        }
    }

    /// Speed of long waves where the water is deepest (m/s).
    pub fn speed_mps(&self) -> f64 {
        match self {
            Self::Level { model, .. } => model.speed_mps,
            Self::Depth { model, .. } => (model.gravity_mps2 * model.deepest_m).sqrt(),
        }
    }

    /// The kernels of a step, or of several.
    pub fn passes(&self) -> &'static [&'static str] {
        match self {
            Self::Level { variant, is_fused, .. } => match (variant.model, variant.order, is_fused) {
                (Model::Book, ..) => &["water.book"],
                (Model::Pipes, ..) => &["water.pipes_fused (several steps each where nothing comes between)"],
                (_, 4, _) => &["water.fourth"],
                (_, _, true) => &["water.fused (several steps each where nothing comes between)"],
                _ => &["water.waves"],
            },
            Self::Depth { tier: Tier::Wet, .. } => &["water.wet"],
            Self::Depth { tier: Tier::Shallow, .. } => &["water.shallow"],
        }
    }

    /// Whether some columns are land, or dry at the start.
    pub fn has_land(&self) -> bool {
        match self {
            Self::Level { has_land, .. } => *has_land,
            Self::Depth { columns, .. } => columns.depths_m().iter().any(|&depth| depth <= 0.0),
        }
    }

    /// Whether any column has water.
    pub fn has_water(&self) -> bool {
        match self {
            Self::Level { height_m, .. } => height_m.iter().any(|&h| h != LAND_M),
            Self::Depth { columns, .. } => columns.depths_m().iter().any(|&depth| depth > 0.0),
        }
    }
}

impl WaterScene {
    /// Works out what runs.
    ///
    /// # Errors
    /// If the start is deeper than the scene says that the water will be.
    pub(super) fn simulation(&self, fps: f64, ground: Option<&Heightmap>) -> Result<Simulation, SceneError> {
        let variant = self.variant();
        let Some(tier) = variant.tier() else { return Ok(self.level_water(&variant, fps, ground)) };
        let model = self.depth_model(tier, fps);
        let start_m = self.start_heights();
        let bed_m = |i: u32| match ground {
            Some(ground) => {
                let at = self.column_centre(i);
                f64::from(ground.height_at(at.x, at.y)) - f64::from(self.level_m)
            }
            None => -self.depth_m,
        };
        let bed_m: Vec<f64> = (0..model.cells.element_product()).map(bed_m).collect();
        let mut columns = Columns::at_rest(&bed_m, |i| start_m[i].into());
        self.build_walls(&mut columns.rise_m);
        let deepest = columns.depths_m().into_iter().fold(0.0, f64::max);
        if deepest > self.deepest_m * (1.0 + 1e-6) {
            let message = format!(
                "deepest_m is {}, and the water is {deepest:.4} m deep at the start; allowed: at least that, or a \
                 depth_m from which it follows",
                self.deepest_m
            );
            return Err(SceneError::Water { name: self.name.clone(), message });
        }
        let rain_mps = self.rain.as_ref().map_or(0.0, |rain| rain.mm_per_h / 3.6e6);
        Ok(Simulation::Depth { model, tier, columns, rain_mps })
    }

    fn level_water(&self, variant: &Variant, fps: f64, ground: Option<&Heightmap>) -> Simulation {
        let mut height_m = self.start_heights();
        if let Some(ground) = ground.filter(|_| self.model != Model::Book) {
            for (i, height) in (0..).zip(&mut height_m) {
                let at = self.column_centre(i);
                if ground.height_at(at.x, at.y) > self.level_m {
                    *height = LAND_M;
                }
            }
        }
        self.build_walls(&mut height_m);
        Simulation::Level {
            model: self.waves_model(variant, fps),
            variant: *variant,
            is_fused: match self.model {
                Model::Waves => variant.order == 2 && !self.acts_each_step(),
                Model::Pipes => true,
                _ => false,
            },
            has_land: height_m.contains(&LAND_M),
            height_m,
        }
    }

    /// Centre of a column, x and z (m).
    fn column_centre(&self, i: u32) -> Vec2 {
        let cells = UVec2::from(self.cells);
        let c = uvec2(i % cells.x, i / cells.x).as_vec2();
        ((c + 0.5) / cells.as_vec2() - 0.5) * Vec2::from(self.size_m)
    }

    /// The surface at the start (m above rest).
    fn start_heights(&self) -> Vec<f32> {
        let cells = UVec2::from(self.cells);
        let each = |shape: &dyn Fn(Vec2) -> f32| -> Vec<f32> {
            (0..cells.element_product()).map(|i| shape(self.column_centre(i))).collect()
        };
        match self.start {
            Start::Flat => each(&|_| 0.0),
            Start::Hump { height_m, at_m, radius_m } => {
                each(&|at| height_m * (-0.5 * (at.distance(at_m.into()) / radius_m).powi(2)).exp())
            }
            Start::Sombrero { height_m, at_m, radius_m } => each(&|at| {
                let x = PI * at.distance(at_m.into()) / radius_m;
                if x == 0.0 {
                    height_m
                } else {
                    height_m * x.sin() / x
                }
            }),
            Start::Mode { height_m, waves } => {
                let mode = water::oracle::mode(cells, waves.into());
                mode.into_iter().map(|h| (f64::from(height_m) * h) as f32).collect()
            }
            Start::Block { height_m, from_m, to_m } => {
                let (a, b) = (Vec2::from(from_m), Vec2::from(to_m));
                let (lo, hi) = (a.min(b), a.max(b));
                each(&|at| if at.cmpge(lo).all() && at.cmplt(hi).all() { height_m } else { 0.0 })
            }
        }
    }
}

impl Start {
    /// Height of its highest point above the level at rest (m), 0 if there is none.
    pub fn highest_m(&self) -> f32 {
        match *self {
            Self::Flat => 0.0,
            Self::Hump { height_m, .. } | Self::Block { height_m, .. } => height_m.max(0.0),
            // The first trough of sin(x) / x is 0.2172 deep; of an upside-down one it is a crest.
            Self::Sombrero { height_m, .. } => height_m.max(-0.2173 * height_m),
            Self::Mode { height_m, .. } => height_m.abs(),
        }
    }
}
