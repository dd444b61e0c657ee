// SPDX-License-Identifier: MIT OR Apache-2.0
//! Named starts, shared by tests, hard cases, benches and studies, so that all speak of the same thing.

use super::{oracle, Model, Walls, LAND_M};
use glam::{dvec2, uvec2, UVec2, Vec2};

/// A model with a surface at rest.
#[derive(Clone, Debug)]
pub struct Start {
    /// How results name it.
    pub name: &'static str,
    /// Off every neutral value, so that no parameter can be forgotten.
    pub model: Model,
    /// One a column (m above rest).
    pub height_m: Vec<f32>,
}

/// A model for tests: half-metre columns, 0.9 of the longest stable step, damped.
pub fn model(cells: UVec2, diagonal: f64) -> Model {
    let model = Model {
        cells,
        cell_m: 0.5,
        speed_mps: 4.429,
        damping_per_s: 0.2,
        diagonal,
        walls: Walls::Folded,
        dt_s: 1.0,
    };
    model.with_courant(0.9 * model.courant_limit())
}

fn start(name: &'static str, model: Model, surface: impl Fn(Vec2) -> f32) -> Start {
    let cells = model.cells;
    let centre = |x, y| (uvec2(x, y).as_vec2() + 0.5) / cells.as_vec2();
    let rows = (0..cells.y).flat_map(|y| (0..cells.x).map(move |x| centre(x, y)));
    Start { name, model, height_m: rows.map(surface).collect() }
}

/// Level, above rest.
pub fn flat(model: Model, height_m: f32) -> Start {
    start("flat", model, |_| height_m)
}

/// A round hill off the middle: no symmetry hides a mistake.
pub fn hump(model: Model) -> Start {
    start("hump", model, |at| 0.3 * (-80.0 * at.distance_squared(Vec2::new(0.3, 0.6))).exp() + 0.02 * at.x)
}

/// A round hill in the middle, `sigma` of the width (m): the start of the linear study.
pub fn gauss(model: Model, sigma: f32) -> Start {
    start("gauss", model, |at| (-0.5 * (at - 0.5).length_squared() / (sigma * sigma)).exp())
}

/// One standing wave.
pub fn standing(model: Model, m: UVec2, height_m: f64) -> Start {
    let surface = oracle::mode(model.cells, m).into_iter().map(|h| (height_m * h) as f32).collect();
    Start { name: "standing", model, height_m: surface }
}

/// Every column at its own height within 1 mm: all waves at once.
pub fn noise(model: Model) -> Start {
    let count = model.cells.x * model.cells.y;
    let surface = (0..count).map(|i| 1e-3 * (2.0 * (hash(i) >> 8) as f32 / (1 << 24) as f32 - 1.0)).collect();
    Start { name: "noise", model, height_m: surface }
}

/// [`hump`] with islands: about a tenth of all columns is land, alone and in clumps.
pub fn islands(model: Model) -> Start {
    let mut start = hump(model);
    let width = model.cells.x;
    for (i, height) in start.height_m.iter_mut().enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        let clump = hash((x / 5) * 7919 + y / 5).is_multiple_of(16);
        let alone = hash(i as u32 ^ 0x9e37_79b9).is_multiple_of(24);
        if clump || alone {
            *height = LAND_M;
        }
    }
    start.name = "islands";
    start
}

/// [`noise`] round 4 x 4 islands, each a disc of a twentieth of the width: mostly open water, as maps are.
pub fn coast(model: Model) -> Start {
    let mut start = noise(model);
    let (width, apart) = (model.cells.x as usize, 0.25 * model.cells.as_dvec2());
    for (i, height) in start.height_m.iter_mut().enumerate() {
        let at = dvec2((i % width) as f64, (i / width) as f64) + 0.5;
        if (at % apart).distance(0.5 * apart) < 0.025 * width as f64 {
            *height = LAND_M;
        }
    }
    start.name = "coast";
    start
}

/// Integer hash (O'Neill, "PCG", 2014, in the form of Jarzynski and Olano, "Hash Functions for GPU Rendering", 2020).
fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}
