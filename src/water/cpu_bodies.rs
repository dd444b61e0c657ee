// SPDX-License-Identifier: MIT OR Apache-2.0
//! CPU twins of `glsl/water/draught.comp` and `glsl/water/body.comp`: see [`cpu`](super::cpu).

use super::{
    bodies::{BodyParams, Pose},
    LAND_M,
};
use glam::{ivec2, vec2, IVec2, Vec2};

/// Twin of `glsl/water/draught.comp`.
pub fn draught(p: &BodyParams, height_m: &[f32], poses: &mut [Pose]) {
    for pose in poses {
        let (lo, hi) = pose.reach(p.cell_m);
        let mut lanes = [Vec2::ZERO; 64];
        for (i, c) in (lo.y..hi.y).flat_map(|y| (lo.x..hi.x).map(move |x| ivec2(x, y))).enumerate() {
            let draught = draught_of(c, pose, p.cell_m);
            let is_water = index(p, c).is_some_and(|i| height_m[i] != LAND_M);
            lanes[i % 64] += vec2(draught, if is_water { draught } else { 0.0 });
        }
        let total: Vec2 = lanes.into_iter().sum();
        let area = p.cell_m * p.cell_m;
        pose.scale = if total.x > 0.0 { pose.submerged_m3 / (area * total.x) } else { 0.0 };
        pose.displaced_m3 = pose.scale * area * total.y;
    }
}

/// Twin of `glsl/water/body.comp`, over the whole grid.
pub fn body(p: &BodyParams, height_m: &mut [f32], before: &[Pose], after: &[Pose]) {
    for c in (0..p.cells.y as i32).flat_map(|y| (0..p.cells.x as i32).map(move |x| ivec2(x, y))) {
        let Some(i) = index(p, c).filter(|&i| height_m[i] != LAND_M) else { continue };
        let mut rise = 0.0;
        for (before, after) in before.iter().zip(after) {
            rise +=
                after.scale * draught_of(c, after, p.cell_m) - before.scale * draught_of(c, before, p.cell_m);
        }
        height_m[i] += rise;
    }
}

fn index(p: &BodyParams, c: IVec2) -> Option<usize> {
    let is_in_grid = c.min_element() >= 0 && c.cmplt(p.cells.as_ivec2()).all();
    is_in_grid.then(|| ((c.y as u32 * p.pitch + c.x as u32) * p.stride) as usize)
}

fn draught_of(c: IVec2, b: &Pose, cell_m: f32) -> f32 {
    let (half, y) = (b.half_m, b.at_m.y);
    let from = (c.as_vec2() + 0.5) * cell_m - vec2(b.at_m.x, b.at_m.z);
    if b.is_box == 1 {
        let own = vec2(from.x * b.axis.x + from.y * b.axis.y, from.y * b.axis.x - from.x * b.axis.y).abs();
        let cover = ((vec2(half.x, half.z) - own) / cell_m + 0.5).clamp(Vec2::ZERO, Vec2::ONE);
        return cover.x * cover.y * ((half.y - y).max(0.0) - (-half.y - y).max(0.0));
    }
    let samples = (0..16).map(|i| {
        let at = from + (ivec2(i & 3, i >> 2).as_vec2() - 1.5) * (0.25 * cell_m);
        let root = (half.x * half.x - (at.x * at.x + at.y * at.y)).max(0.0).sqrt();
        (root - y).max(0.0) - (-root - y).max(0.0)
    });
    0.0625 * samples.fold(0.0, |sum, sample| sum + sample)
}
