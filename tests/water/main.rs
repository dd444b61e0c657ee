// SPDX-License-Identifier: MIT OR Apache-2.0
//! Water against its twins, exact solutions, and what must hold whatever the numbers: a module a kernel or two.
#![allow(missing_docs)]

mod absorb;
mod bodies;
#[path = "../common/mod.rs"]
mod common;
mod depth;
mod fourth;
mod fused;
mod halves;
mod pipes;
mod splash;
mod waves;

use common::TestGpu;
use glam::{uvec2, UVec2};
use whitecap::water::{starts, Tuning, LAND_M};

/// Grids that no workgroup and no vector divides, and the smallest there are.
const GRIDS: [UVec2; 14] = [
    uvec2(1, 1),
    uvec2(1, 2),
    uvec2(2, 1),
    uvec2(1, 40),
    uvec2(40, 1),
    uvec2(2, 2),
    uvec2(3, 5),
    uvec2(6, 4),
    uvec2(7, 3),
    uvec2(17, 33),
    uvec2(64, 16),
    uvec2(77, 45),
    uvec2(255, 257),
    uvec2(1000, 3),
];
const ODD: UVec2 = uvec2(77, 45);
const TUNING: Tuning = Tuning { group: uvec2(8, 8), rows: 4 };

/// Whether the driver rounds `fma` twice: GLSL leaves it to the driver, and one step shows.
fn rounds_twice(gpu: &TestGpu) -> bool {
    let probe = starts::noise(starts::model(uvec2(17, 33), 0.25));
    waves::run_waves(gpu, TUNING, &probe, 1).0 == waves::twin::<f32>(&probe, 1).height_m
}

/// Heights with those of land as 0: what is compared is water.
fn wet<T: Copy + Into<f64>>(heights: &[T]) -> Vec<f64> {
    heights.iter().map(|&h| h.into()).map(|h: f64| if h == f64::from(LAND_M) { 0.0 } else { h }).collect()
}

fn to_f32(numbers: &[f64]) -> Vec<f32> {
    numbers.iter().map(|&n| n as f32).collect()
}
