// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twin of `glsl/particles/{near.comp,cell_bits.glsl}`.

use crate::cells::{Grid, Plane};
use glam::{vec3, IVec3, Vec3};

const ALIKE: f32 = 0.985;
const OFF: f32 = 0.1;

/// Twin of `near.comp`: from every occupied cell outwards, a ring of cells at a time.
pub fn near(grid: &Grid, occupied: &[u32], planes: &[Plane], reach: u32) -> Vec<u32> {
    let count = grid.count();
    let words = count.div_ceil(8);
    let mut near = vec![0u32; words + 3 * count];
    let mut gaps = vec![reach + 1; count];
    let mut ring: Vec<usize> = (0..count).filter(|i| bit(occupied, *i)).collect();
    for &i in &ring {
        gaps[i] = 0;
        let known = known_of(grid, occupied, planes, grid.cell(i));
        near[words + 2 * i..][..2].copy_from_slice(&known);
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
        let round = Around { grid, occupied, planes, cell: grid.cell(i) };
        near[words + 2 * count + i] = if gap == 0 { round.slab(&near) } else { NO_SLAB | gap };
    }
    near
}

/// Twin of `normal_of_slab` and `bounds_of_slab`: the normal, scaled so that |x| + |y| + z = 1, and between what all lies along it
/// that is met in the cells round a corner, in cells from there.
pub fn slab(near: &[u32], count: usize, corner: usize) -> (Vec3, [f32; 2]) {
    let word = near[count.div_ceil(8) + 2 * count + corner];
    let [a, b, low, high] = [4, 11, 18, 25].map(|from| ((word << (25 - from)) as i32 >> 25) as f32);
    (normal_of_slab([a, b]), [low, high].map(|bound| bound / SLAB_STEPS))
}

/// Planes that are met in an occupied cell: the cell that each is stored in, and the slot there.
pub fn met_in(grid: &Grid, near: &[u32], cell: IVec3) -> Vec<(IVec3, usize)> {
    let bits = grid.index(cell).map_or(0, |i| met_of(known(near, grid.count(), i)));
    (0..14).filter(|k| bits >> k & 1 != 0).map(|k| (cell_of_met(cell, k), k & 1)).collect()
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

/// Twin of `known_at`.
pub(super) fn known(near: &[u32], count: usize, cell: usize) -> [u32; 2] {
    [0, 1].map(|word| near[count.div_ceil(8) + 2 * cell + word])
}

/// Twin of `met_of`: numbers of planes, as bits.
pub(super) fn met_of([x, _]: [u32; 2]) -> u32 {
    (x & 0xfff) << 2 | if x >> 12 & 3 == 3 { 1 } else { 3 }
}

/// Twin of `sides_of`: where plane k goes on, of the cell's own two.
pub(super) fn sides_of([x, y]: [u32; 2], k: usize) -> [u32; 2] {
    let sides = match k {
        0 if x >> 12 & 3 == 3 => 0,
        0 => (x >> 12 & 3) << 2,
        1 => x >> 14 & 3,
        2..6 => x >> (4 * k + 8),
        _ => y >> (4 * k - 24),
    };
    [sides & 3, sides >> 2 & 3]
}

const RIM: f32 = 1.0e-3;
const SLAB_SIDES: f32 = 63.0;
const SLAB_STEPS: f32 = 62.0;
const NO_SLAB: u32 = 0x80fc_0000;

struct Around<'a> {
    grid: &'a Grid,
    occupied: &'a [u32],
    planes: &'a [Plane],
    cell: IVec3,
}

impl Around<'_> {
    fn plane(&self, cell: IVec3, slot: usize) -> Option<Plane> {
        let stored = self.grid.index(cell).filter(|j| bit(self.occupied, *j))?;
        Some(self.planes[2 * stored + slot]).filter(|it| it.triangle != 0)
    }

    fn met(&self, k: usize) -> Option<Plane> {
        self.plane(cell_of_met(self.cell, k), k & 1)
    }

    /// Twin of `slab_round`, of the cell's least corner.
    fn slab(&self, near: &[u32]) -> u32 {
        let (grid, count) = (self.grid, self.grid.count());
        let touching = (0..8).map(|k| self.cell - IVec3::new(k & 1, k >> 1 & 1, k >> 2));
        let occupied = touching.filter(|cell| grid.index(*cell).is_some_and(|i| bit(self.occupied, i)));
        let met = occupied.flat_map(|cell| {
            let bits = met_of(known(near, count, grid.index(cell).expect("in the grid")));
            (0..14).filter(move |k| bits >> k & 1 != 0).map(move |k| (cell, k))
        });
        let met: Vec<(IVec3, Plane)> = met
            .map(|(cell, k)| {
                let stored = cell_of_met(cell, k);
                let mut plane = self.planes[2 * grid.index(stored).expect("in the grid") + (k & 1)];
                plane.distance_m += dotted(plane.normal.into(), (cell - stored).as_vec3() * grid.cell_m);
                (cell, plane)
            })
            .collect();
        let sum = met.iter().fold(Vec3::ZERO, |sum, (_, plane)| {
            let normal = Vec3::from(plane.normal);
            sum + if dotted(sum, normal) < 0.0 { -normal } else { normal }
        });
        let up = if sum.z < 0.0 { -sum } else { sum };
        let length = (up.x.abs() + up.y.abs()) + up.z;
        let sides = if length > 0.0 { [(up.x + up.y) / length, (up.x - up.y) / length] } else { [0.0; 2] };
        let sides = sides.map(|side| (SLAB_SIDES * side.clamp(-1.0, 1.0)).round_ties_even());
        let n = normal_of_slab(sides);
        let (mut least, mut most) = (2.0f32, -2.0f32);
        for (cell, plane) in &met {
            let normal = Vec3::from(plane.normal);
            let along = dotted(n, normal);
            let rest = (n - normal * along).abs();
            let spread = (0.5 + 2.0 * RIM) * ((rest.x + rest.y) + rest.z);
            let middle =
                dotted(n, (*cell - self.cell).as_vec3() + 0.5) - along * plane.distance_m / grid.cell_m;
            (least, most) = (least.min(middle - spread), most.max(middle + spread));
        }
        let low = (SLAB_STEPS * least.clamp(-1.01, 1.0)).floor();
        let high = (SLAB_STEPS * most.clamp(-1.0, 1.01)).ceil();
        let [a, b, low, high] = [sides[0], sides[1], low, high].map(|value| value as i32 as u32 & 127);
        a << 4 | b << 11 | low << 18 | high << 25
    }

    /// Where plane k is seen, of the two, and how often.
    fn seen(&self, k: usize, own: &Plane, two: &[Plane; 2]) -> ([u32; 2], u32) {
        let cell_m = self.grid.cell_m;
        let (edge, half) = (OFF * cell_m, 0.5 * cell_m);
        let (mut seen, mut count) = ([0; 2], 0);
        for n in 0..27 {
            let by = IVec3::new(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
            let middle = by.as_vec3() * cell_m;
            let there = [0, 1].map(|slot| self.plane(self.cell + by, slot));
            let is_at = |plane: &Plane, from: Vec3| {
                let is_same = |it: &Plane| {
                    let foot = foot_in_cell(it, middle, half) - from;
                    is_alike(it, plane)
                        && (dotted(plane.normal.into(), foot) + plane.distance_m).abs() <= edge
                };
                there.map(|it| it.filter(is_same))
            };
            let from = (cell_of_met(self.cell, k) - self.cell).as_vec3() * cell_m;
            for it in is_at(own, from).into_iter().flatten() {
                count += 1;
                let foot = foot_in_cell(&it, middle, half);
                for (bits, plane) in seen.iter_mut().zip(two) {
                    // Where the two meet in that cell as well, its middle does not say which part of it is there.
                    if is_at(plane, Vec3::ZERO).iter().any(Option::is_some) {
                        continue;
                    }
                    let over = dotted(plane.normal.into(), foot) + plane.distance_m;
                    *bits |= if over < -edge { 1 } else { u32::from(over > edge) << 1 };
                }
            }
        }
        (seen.map(|bits| if bits == 3 { 0 } else { bits }), count)
    }
}

/// The point of a plane that is nearest to the middle of its cell, as far as that reaches.
fn foot_in_cell(plane: &Plane, middle: Vec3, half: f32) -> Vec3 {
    let foot = middle - Vec3::from(plane.normal) * plane.distance_m;
    foot.max(middle - half).min(middle + half)
}

fn known_of(grid: &Grid, occupied: &[u32], planes: &[Plane], cell: IVec3) -> [u32; 2] {
    let around = Around { grid, occupied, planes, cell };
    let (Some(one), Some(two)) = (around.met(0), around.met(1)) else { return [3 << 12, 0] };
    let mut met = vec![(0, one), (1, two)];
    for k in 2..14 {
        let lent = around.met(k).filter(|it| is_missing(it, &one, &two, (k >> 1) - 1, grid.cell_m));
        met.extend(lent.filter(|lent| met[2..].iter().all(|(_, it)| !is_alike(lent, it))).map(|it| (k, it)));
    }
    let mut known = 0u64;
    for (k, plane) in met {
        let ([of_one, of_two], count) = around.seen(k, &plane, &[one, two]);
        match k {
            0 => known |= u64::from(of_two) << 12,
            1 => known |= u64::from(of_one) << 14,
            _ if count > 1 => known |= 1 << (k - 2) | u64::from(of_one | of_two << 2) << (4 * k + 8),
            _ => (),
        }
    }
    [known as u32, (known >> 32) as u32]
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
