// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twin of `glsl/particles/{near.comp,cell_bits.glsl}`.

use super::colliding::Slabs;
use crate::cells::{Extent, Grid, Plane, Read};
use glam::{vec3, IVec3, Vec3};

const ALIKE: f32 = 0.985;
const STANDS_FOR: f32 = 0.15;
const FELT_HALF: f32 = 0.627;
const RIM: f32 = 1e-3;

/// Twin of `near.comp`: from every occupied cell outwards, a ring of cells at a time.
pub fn near(grid: &Grid, cells: &Read, reach: u32, slabs: Slabs) -> Vec<u32> {
    let count = grid.count();
    let words = count.div_ceil(8);
    let mut near = vec![0u32; words + 5 * count];
    let mut gaps = vec![reach + 1; count];
    let mut ring: Vec<usize> = (0..count).filter(|i| cells.is_occupied(*i)).collect();
    for &i in &ring {
        gaps[i] = 0;
        let [own, other, neither] = cells.extents[i].map(|extent| extent.0);
        let met = Around { grid, cells, cell: grid.cell(i) }.met_bits();
        near[words + 4 * i..][..4].copy_from_slice(&[own, other, neither, met]);
    }
    for gap in 1..=reach {
        let around = |i: usize| {
            let cell = grid.cell(i);
            (0..27).filter_map(move |k| grid.index(cell + IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1)))
        };
        let mut next: Vec<usize> = ring.iter().flat_map(|&i| around(i)).collect();
        next.retain(|&i| {
            let is_new = gaps[i] > gap;
            gaps[i] = gaps[i].min(gap);
            is_new
        });
        ring = next;
    }
    // Of a corner: the least of the cells that touch it.
    for i in 0..count {
        let touching = |k: i32| grid.index(grid.cell(i) - IVec3::new(k & 1, k >> 1 & 1, k >> 2));
        let gap = (0..8).filter_map(touching).map(|cell| gaps[cell]).min().expect("the cell itself");
        near[i / 8] |= gap << (4 * (i % 8));
        let round = Around { grid, cells, cell: grid.cell(i) };
        let is_of_all = slabs == Slabs::OfAll;
        let slab = if gap < 1 + u32::from(is_of_all) { round.slab(&near, slabs) } else { NO_SLAB };
        near[words + 4 * count + i] = slab | if gap > 1 { gap } else { u32::from(is_of_all) };
    }
    near
}

/// Twin of `normal_of_slab` and `bounds_of_slab`: the normal, scaled so that |x| + |y| + z = 1, and between what all lies along it
/// that is felt within a cell of a corner, in cells from there.
pub fn slab(near: &[u32], count: usize, corner: usize) -> (Vec3, [f32; 2]) {
    let word = near[count.div_ceil(8) + 4 * count + corner];
    let [a, b, low, high] = [4, 11, 18, 25].map(|from| ((word << (25 - from)) as i32 >> 25) as f32);
    (normal_of_slab([a, b]), [low, high].map(|bound| bound / SLAB_STEPS))
}

/// Planes that are met in an occupied cell: the cell that each is stored in, and the slot there.
pub fn met_in(grid: &Grid, near: &[u32], cell: IVec3) -> Vec<(IVec3, usize)> {
    let bits = grid.index(cell).map_or(0, |i| met_at(near, grid.count(), i));
    (0..14).filter(|k| bits >> k & 1 != 0).map(|k| (cell_of_met(cell, k), k & 1)).collect()
}

/// Bits 0 to 3 of the word of a corner: `flies_freely` in `glsl/particles/collide_look.glsl`.
pub(super) fn gap_of_slab(near: &[u32], count: usize, corner: usize) -> u32 {
    near[count.div_ceil(8) + 4 * count + corner] & 15
}

fn normal_of_slab(sides: [f32; 2]) -> Vec3 {
    let [a, b] = sides.map(|side| side / SLAB_SIDES);
    let (x, y) = (0.5 * (a + b), 0.5 * (a - b));
    vec3(x, y, (1.0 - x.abs()) - y.abs())
}

/// Twin of `gap_at`.
pub(super) fn gap(near: &[u32], corner: usize) -> i32 {
    (near[corner / 8] >> (4 * (corner % 8)) & 15) as i32
}

/// Twin of `met_at`: numbers of planes, as bits.
pub(super) fn met_at(near: &[u32], count: usize, cell: usize) -> u32 {
    near[count.div_ceil(8) + 4 * cell + 3]
}

/// Where plane `k` is felt in a cell.
pub(super) fn extent_of(near: &[u32], count: usize, cell: usize, k: usize) -> Extent {
    Extent(near[count.div_ceil(8) + 4 * cell + k.min(2)])
}

const SLAB_SIDES: f32 = 63.0;
const SLAB_STEPS: f32 = 62.0;
const NO_SLAB: u32 = 0x80fc_0000;

/// Twin of `Felt`.
struct Felt {
    normal: Vec3,
    distance: f32,
    middle: Vec3,
    half_size: Vec3,
}

struct Around<'a> {
    grid: &'a Grid,
    cells: &'a Read,
    cell: IVec3,
}

impl Around<'_> {
    fn plane(&self, cell: IVec3, slot: usize) -> Option<Plane> {
        self.cells.planes_of(self.grid.index(cell)?).get(slot).copied()
    }

    /// Number k of the planes that may be met in a cell, seen from there: twin of `plane_met`.
    fn met(&self, cell: IVec3, k: usize) -> Option<Plane> {
        let stored = cell_of_met(cell, k);
        let mut plane = self.plane(stored, k & 1)?;
        plane.distance_m += dotted(plane.normal.into(), (cell - stored).as_vec3() * self.grid.cell_m);
        Some(plane)
    }

    /// Twin of `met_round`: the extent of a plane that is met in a cell, if any of it is felt within a cell of the cell's least corner.
    fn reach(&self, near: &[u32], cell: IVec3, k: usize) -> Option<u32> {
        let (i, count) = (self.grid.index(cell).expect("in the grid"), self.grid.count());
        let of = |k| extent_of(near, count, i, k).0;
        let extent = if k == 0 { of(0) | of(1) | of(2) } else { of(k) };
        // Of cells that the corner is none of, only what reaches beyond them.
        let reaches = |axis: usize| match (cell - self.cell)[axis] {
            -2 => 1 << 9,
            1 => 1,
            _ => 0x3ff,
        };
        (0..3).all(|axis| extent >> (10 * axis) & reaches(axis) != 0).then_some(extent)
    }

    /// Twin of `is_felt_round`, of the cell's least corner.
    fn felt(&self, near: &[u32], cell: IVec3, k: usize) -> Option<Felt> {
        let extent = self.reach(near, cell, k)?;
        let [low, high] = Extent(extent).bounds()?;
        let centre = (cell - self.cell).as_vec3() + 0.5;
        let low = (low - 2.0 * RIM).max(-1.0 - centre);
        let high = (high + 2.0 * RIM).min(1.0 - centre);
        if low.cmpgt(high).any() {
            return None;
        }
        let plane = self.met(cell, k).expect("it is met");
        let normal = Vec3::from(plane.normal);
        let (middle, half_size) = (0.5 * (low + high), 0.5 * (high - low));
        let distance = dotted(normal, middle) + plane.distance_m / self.grid.cell_m;
        (distance.abs() <= dotted(normal.abs(), half_size) + RIM).then_some(Felt {
            normal,
            distance,
            middle: centre + middle,
            half_size,
        })
    }

    /// Twin of `slab_round`, of the cell's least corner.
    fn slab(&self, near: &[u32], slabs: Slabs) -> u32 {
        let (grid, count) = (self.grid, self.grid.count());
        let around = (0..64).map(|k| self.cell + IVec3::new(k & 3, k >> 2 & 3, k >> 4) - 2);
        let occupied = around.filter(|cell| grid.index(*cell).is_some_and(|i| self.cells.is_occupied(i)));
        let met = occupied.flat_map(|cell| {
            let bits = met_at(near, count, grid.index(cell).expect("in the grid"));
            (0..14).filter(move |k| bits >> k & 1 != 0).map(move |k| (cell, k))
        });
        let mut met: Vec<(IVec3, usize)> = met.collect();
        let is_own = |cell: IVec3| {
            (self.cell - cell).cmpge(IVec3::ZERO).all() && (self.cell - cell).cmple(IVec3::ONE).all()
        };
        let has_own = met.iter().any(|(cell, _)| is_own(*cell));
        if slabs == Slabs::OfEight {
            met.retain(|(cell, _)| is_own(*cell));
        }
        let counts = met.iter().filter(|(cell, _)| is_own(*cell) == has_own);
        let sum = counts.filter(|(cell, k)| self.reach(near, *cell, *k).is_some()).fold(
            Vec3::ZERO,
            |sum, (cell, k)| {
                let normal = Vec3::from(self.met(*cell, *k).expect("it is met").normal);
                sum + if dotted(sum, normal) < 0.0 { -normal } else { normal }
            },
        );
        let felt: Vec<Felt> = met.iter().filter_map(|(cell, k)| self.felt(near, *cell, *k)).collect();
        let up = if sum.z < 0.0 { -sum } else { sum };
        let length = (up.x.abs() + up.y.abs()) + up.z;
        let sides = if length > 0.0 { [(up.x + up.y) / length, (up.x - up.y) / length] } else { [0.0; 2] };
        let sides = sides.map(|side| (SLAB_SIDES * side.clamp(-1.0, 1.0)).round_ties_even());
        let n = normal_of_slab(sides);
        let (mut least, mut most) = (2.0f32, -2.0f32);
        for it in &felt {
            let along = dotted(n, it.normal);
            let spread = dotted((n - it.normal * along).abs(), it.half_size);
            let middle = dotted(n, it.middle) - along * it.distance;
            (least, most) = (least.min(middle - spread), most.max(middle + spread));
        }
        let low = (SLAB_STEPS * least.clamp(-1.01, 1.0)).floor();
        let high = (SLAB_STEPS * most.clamp(-1.0, 1.01)).ceil();
        let [a, b, low, high] = [sides[0], sides[1], low, high].map(|value| value as i32 as u32 & 127);
        a << 4 | b << 11 | low << 18 | high << 25
    }

    /// Twin of `met_in`.
    fn met_bits(&self) -> u32 {
        let (cell_m, met) = (self.grid.cell_m, |k| self.met(self.cell, k));
        let (Some(one), Some(two)) = (met(0), met(1)) else { return 1 };
        let [_, _, neither] = self.cells.extents[self.grid.index(self.cell).expect("in the grid")];
        let mut lent: Vec<(usize, Plane)> = Vec::new();
        for k in if neither.0 == 0 { 2..2 } else { 2..14 } {
            let plane = met(k).filter(|it| is_missing(it, &one, &two, cell_m));
            let plane = plane.filter(|it| lent.iter().all(|(_, other)| !is_alike(it, other, cell_m)));
            lent.extend(plane.map(|it| (k, it)));
        }
        lent.iter().fold(3, |bits, (k, _)| bits | 1 << k)
    }
}

pub(super) fn cell_of_met(cell: IVec3, k: usize) -> IVec3 {
    let mut stored = cell;
    if k >= 2 {
        let face = (k >> 1) - 1;
        stored[face >> 1] += if face & 1 == 0 { -1 } else { 1 };
    }
    stored
}

fn is_missing(lent: &Plane, one: &Plane, two: &Plane, cell_m: f32) -> bool {
    let [x, y, z] = lent.normal.map(f32::abs);
    let is_through = lent.distance_m.abs() <= ((x + y) + z) * (FELT_HALF * cell_m);
    is_through && !is_alike(lent, one, cell_m) && !is_alike(lent, two, cell_m)
}

pub(super) fn bit(words: &[u32], i: usize) -> bool {
    words[i / 32] >> (i % 32) & 1 != 0
}

pub(super) fn dotted(a: Vec3, b: Vec3) -> f32 {
    (a.x * b.x + a.y * b.y) + a.z * b.z
}

fn is_alike(one: &Plane, other: &Plane, cell_m: f32) -> bool {
    let cosine = dotted(one.normal.into(), other.normal.into());
    let distance_m = if cosine < 0.0 { -other.distance_m } else { other.distance_m };
    cosine.abs() > ALIKE && (one.distance_m - distance_m).abs() <= STANDS_FOR * cell_m
}
