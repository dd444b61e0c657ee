// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a step of a variant costs, as it was measured.

use super::{
    super::{Model, WaterScene},
    Variant,
};
use glam::UVec2;
use std::collections::BTreeSet;

/// A step of a column (ns): what an H100 80GB HBM3 with driver 580.159.04 measured (docs/results), at 4096 x 4096 but for
/// waves with land a step a dispatch, at 8192 x 8192. `None`: not measured. Fused kernels cost as their steps do, but a
/// dispatch no less than one of a step. `shores`: share of the tiles with land, if there is any.
fn step_ns(water: &WaterScene, variant: &Variant, shores: Option<f64>, fps: f64, step_s: f64) -> Option<f64> {
    // Between the rates of `coast`, of whose tiles a tenth are shores, and of `islands`, of whose tiles all are.
    let with_land = |coast: f64, islands: f64| {
        let share = ((shores.unwrap_or(0.0) - COAST) / (1.0 - COAST)).max(0.0);
        1.0 / ((1.0 - share) / coast + share / islands)
    };
    let steps = (1.0 / (fps * step_s)).max(1.0);
    // Rates in columns a ns: many steps a dispatch, and one.
    let fused = |many: f64, one: f64| {
        if water.acts_each_step() {
            1.0 / one
        } else {
            (1.0 / many).max(1.0 / (one * steps))
        }
    };
    Some(match (variant.model, variant.order, shores.is_some()) {
        (Model::Book, ..) => 1.0 / 50.4,
        (Model::Waves, 4, false) => 1.0 / 170.0,
        (Model::Waves, 4, true) => 1.0 / 58.8,
        (Model::Waves, _, false) => fused(877.0, 174.0),
        (Model::Waves, _, true) => fused(with_land(647.0, 163.0), 167.0),
        (Model::Pipes, _, true) if water.acts_each_step() => return None,
        (Model::Pipes, _, true) => 1.0 / with_land(188.0, 89.4),
        (Model::Pipes, ..) if variant.diagonal == 0.0 => fused(510.0, 118.0),
        (Model::Pipes, ..) => fused(308.0, 69.5),
        (Model::Wet, ..) => 1.0 / 86.3,
        (Model::Shallow, ..) => 1.0 / 52.9,
    })
}

/// Share of the tiles with land, if there is any.
fn shores(water: &WaterScene, has_terrain: bool) -> Option<f64> {
    match (has_terrain, water.barriers.is_empty()) {
        (true, _) => Some(1.0),
        (false, true) => None,
        (false, false) => Some(shore_share(water)),
    }
}

/// A step of a column (ns), if it was measured.
pub(super) fn cost_ns(
    water: &WaterScene,
    variant: &Variant,
    has_terrain: bool,
    fps: f64,
    step_s: f64,
) -> Option<f64> {
    step_ns(water, variant, shores(water, has_terrain), fps, step_s)
}

/// How many times what it takes in open water a step takes among the land of the scene, if it was measured.
pub(in crate::scene) fn land_factor(
    water: &WaterScene,
    variant: &Variant,
    has_terrain: bool,
    fps: f64,
    step_s: f64,
) -> Option<f64> {
    let open = step_ns(water, variant, None, fps, step_s)?;
    Some(cost_ns(water, variant, has_terrain, fps, step_s)? / open)
}

/// Columns along a side of what a fused tile writes, and those beside it that it reads.
const TILE: u32 = 48;
const HALO: u32 = 8;
/// Share of the tiles of the bench's `coast` that are shores, as [`shore_share`] counts them.
const COAST: f64 = 0.1;

/// Share of tiles that have land or the border of the grid in reach: those cost several times what open water does.
fn shore_share(water: &WaterScene) -> f64 {
    let cells = UVec2::from(water.cells);
    let tiles = cells.map(|n| n.div_ceil(TILE));
    let reach = |from: UVec2, to: UVec2| {
        let from = from.saturating_sub(UVec2::splat(HALO)) / TILE;
        let to = ((to + HALO) / TILE).min(tiles - 1);
        (from.y..=to.y).flat_map(move |y| (from.x..=to.x).map(move |x| (x, y)))
    };
    let border = |(x, y): &(u32, u32)| *x == 0 || *y == 0 || *x + 1 == tiles.x || *y + 1 == tiles.y;
    let all = (0..tiles.y).flat_map(|y| (0..tiles.x).map(move |x| (x, y)));
    let mut shores: BTreeSet<_> = all.filter(border).collect();
    for [from, to] in water.walled_columns() {
        shores.extend(reach(from, to));
    }
    shores.len() as f64 / f64::from(tiles.element_product())
}
