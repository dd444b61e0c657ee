// SPDX-License-Identifier: MIT OR Apache-2.0
//! The models that variants step, and how long their steps are.

use super::{
    super::{Walls, WaterScene},
    Variant,
};
use crate::water::{self, Tier};

/// The step of a variant (s): that of the scene, or the longest that divides a picture's time and is 5 % below the limit.
pub(in crate::scene) fn step_s(water: &WaterScene, variant: &Variant, fps: f64) -> f64 {
    match variant.tier() {
        None => water.waves_model(variant, fps).dt_s,
        Some(tier) => water.depth_model(tier, fps).dt_s,
    }
}

impl WaterScene {
    /// What steps it.
    pub fn variant(&self) -> Variant {
        Variant { model: self.model, order: self.order, diagonal: self.diagonal }
    }

    /// Whether anything acts between every two steps, so that several cannot be one dispatch.
    pub(in crate::scene) fn acts_each_step(&self) -> bool {
        self.borders.any_absorbs() || !self.bodies.is_empty() || !self.sources.is_empty()
    }

    /// The model in the units of the kernels of flat water, with the step of `variant`.
    pub(in crate::scene) fn waves_model(&self, variant: &Variant, fps: f64) -> water::Model {
        let model = water::Model {
            cells: self.cells.into(),
            cell_m: self.column_m(),
            speed_mps: (self.gravity_mps2 * self.depth_m).sqrt(),
            damping_per_s: self.damping_per_s,
            diagonal: variant.diagonal,
            walls: match self.walls {
                Walls::Folded => water::Walls::Folded,
                Walls::Dropped => water::Walls::Dropped,
            },
            dt_s: 0.0,
        };
        let longest_s = match variant.order {
            4 => model.fourth_order_limit() * model.cell_m / model.speed_mps,
            _ => model.longest_stable_s(),
        };
        water::Model { dt_s: self.step_below(longest_s, fps), ..model }
    }

    /// The same for the kernels of water over ground.
    pub(in crate::scene) fn depth_model(&self, tier: Tier, fps: f64) -> water::DepthModel {
        let model = water::DepthModel {
            cells: self.cells.into(),
            cell_m: self.column_m(),
            gravity_mps2: self.gravity_mps2,
            deepest_m: self.deepest_m,
            fastest_mps: self.fastest_mps,
            damping_per_s: self.damping_per_s,
            thin_m: self.thin_m,
            dt_s: 0.0,
        };
        let longest_s = model.longest_stable_s(tier);
        water::DepthModel { dt_s: self.step_below(longest_s, fps), ..model }
    }

    /// The step that the scene gives, or the longest that divides a picture's time and is 5 % below the limit: fixed steps
    /// near the limit are the most accurate ones of a linear leapfrog, and the cheapest.
    fn step_below(&self, longest_s: f64, fps: f64) -> f64 {
        let steps = (1.0 / (fps * 0.95 * longest_s)).ceil().max(1.0);
        self.dt_s.unwrap_or(1.0 / (fps * steps))
    }
}
