// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twin of `glsl/particles/{near.comp,met.comp,cell_bits.glsl}`.

use crate::cells::{Grid, Plane};
use glam::{IVec3, UVec3, Vec3};

const ALIKE: f32 = 0.985;

/// Twin of `near.comp`, cube by cube, and behind its bits of `met.comp`.
pub fn near(grid: &Grid, occupied: &[u32], planes: &[Plane], reach: u32) -> Vec<u32> {
    let mut bits = vec![0u32; 17 * occupied.len()];
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
        if bit(occupied, i) {
            bits[occupied.len() + i / 2] |= met_in(grid, occupied, planes, cell) << (16 * (i % 2));
        }
    }
    bits
}

fn met_in(grid: &Grid, occupied: &[u32], planes: &[Plane], cell: IVec3) -> u32 {
    let plane = |k: usize| {
        let stored = grid.index(cell_of_met(cell, k)).filter(|j| bit(occupied, *j))?;
        Some(planes[2 * stored + (k & 1)]).filter(|it| it.triangle != 0)
    };
    let (Some(one), Some(two)) = (plane(0), plane(1)) else { return 1 };
    let mut met = 3;
    for k in 2..14 {
        let Some(lent) = plane(k).filter(|it| is_missing(it, &one, &two, (k >> 1) - 1, grid.cell_m)) else {
            continue;
        };
        let is_like =
            |other: usize| met >> other & 1 != 0 && plane(other).is_some_and(|it| is_alike(&lent, &it));
        if !(2..k).any(is_like) {
            met |= 1 << k;
        }
    }
    met
}

pub(super) fn cell_of_met(cell: IVec3, k: usize) -> IVec3 {
    let mut stored = cell;
    if k >= 2 {
        let face = (k >> 1) - 1;
        stored[face >> 1] += if face & 1 == 0 { -1 } else { 1 };
    }
    stored
}

fn is_missing(lent: &Plane, one: &Plane, two: &Plane, face: usize, cell_m: f32) -> bool {
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
