// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twin of `glsl/particles/{near.comp,cell_bits.glsl}`.

use crate::cells::{Grid, Plane};
use glam::{IVec3, UVec3, Vec3};

const ALIKE: f32 = 0.985;

/// Twin of `near.comp`.
pub fn near(grid: &Grid, occupied: &[u32], planes: &[Plane], reach: u32) -> Vec<u32> {
    let mut bits = vec![0u32; 2 * occupied.len()];
    let most = UVec3::from(grid.cells).as_ivec3() - 1;
    for i in 0..grid.count() {
        let cell = grid.cell(i);
        let (from, to) = ((cell - reach as i32).max(IVec3::ZERO), (cell + reach as i32).min(most));
        let is_near = (from.z..=to.z).any(|z| {
            (from.y..=to.y).any(|y| {
                let first = grid.index(IVec3::new(from.x, y, z)).expect("in the grid");
                (first..=first + (to.x - from.x) as usize).any(|j| bit(occupied, j))
            })
        });
        bits[i / 32] |= u32::from(is_near) << (i % 32);
        let is_crowded = || {
            let (one, two) = (planes[2 * i], planes[2 * i + 1]);
            let lacks = |face: usize| {
                let beside = grid.index(beside(cell, face)).filter(|j| bit(occupied, *j));
                beside.is_some_and(|j| {
                    let is = |lent: &Plane| is_missing(lent, &one, &two, face, grid.cell_m);
                    is(&planes[2 * j]) || (planes[2 * j + 1].triangle != 0 && is(&planes[2 * j + 1]))
                })
            };
            two.triangle != 0 && (0..6).any(lacks)
        };
        bits[occupied.len() + i / 32] |= u32::from(bit(occupied, i) && is_crowded()) << (i % 32);
    }
    bits
}

pub(super) fn beside(cell: IVec3, face: usize) -> IVec3 {
    let mut beside = cell;
    beside[face >> 1] += if face & 1 == 0 { -1 } else { 1 };
    beside
}

pub(super) fn is_missing(lent: &Plane, one: &Plane, two: &Plane, face: usize, cell_m: f32) -> bool {
    let [x, y, z] = lent.normal.map(f32::abs);
    let away = lent.distance_m + lent.normal[face >> 1] * if face & 1 == 0 { cell_m } else { -cell_m };
    !is_alike(lent, one) && !is_alike(lent, two) && away.abs() <= ((x + y) + z) * (0.501 * cell_m)
}

pub(super) fn bit(words: &[u32], i: usize) -> bool {
    words[i / 32] >> (i % 32) & 1 != 0
}

pub(super) fn dotted(a: Vec3, b: Vec3) -> f32 {
    (a.x * b.x + a.y * b.y) + a.z * b.z
}

fn is_alike(one: &Plane, other: &Plane) -> bool {
    dotted(one.normal.into(), other.normal.into()).abs() > ALIKE
}
