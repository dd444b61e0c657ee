// SPDX-License-Identifier: MIT OR Apache-2.0
//! CPU twins of `water.weigh` and `water.disturb`, in `f32`: what the GPU does, but for rounding.

use super::{Counts, DisturbParams, Disturbance, LAND_M};

/// Twin of `glsl/water/weigh.comp`: validates, and finds the scale that makes volumes exact.
pub fn weigh(p: &DisturbParams, height_m: &[f32], items: &mut [Disturbance], counts: &mut Counts) {
    for i in 0..items.len() {
        let d = items[i];
        let lead = if d.tied == 1 && i > 0 { items[i - 1] } else { d };
        let sane = is_sane(p, &d) && is_sane(p, &lead);
        let [(scale, most), (_, lead_most)] = [d, lead].map(|one| match sane {
            true => scale_and_most(p, height_m, &d, &one),
            false => (0.0, 0.0),
        });
        let absurd = most > p.limit_m || lead_most > p.limit_m;
        items[i].scale = if sane && !absurd { scale } else { 0.0 };
        match () {
            () if !sane || absurd => counts.rejected += 1,
            () if scale == 0.0 => counts.missed += 1,
            () => counts.applied += 1,
        }
    }
}

fn is_sane(p: &DisturbParams, d: &Disturbance) -> bool {
    let numbers = [d.at_m.x, d.at_m.y, d.radius_m, d.volume_m3, d.push_m3ps];
    numbers.iter().all(|n| n.is_finite()) && d.radius_m > 0.0 && (p.has_velocity == 1 || d.push_m3ps == 0.0)
}

/// The scale of `one`, summed over the columns of `d`, and what the column gets that gets most.
fn scale_and_most(p: &DisturbParams, height_m: &[f32], d: &Disturbance, one: &Disturbance) -> (f32, f32) {
    let (mut lanes, mut peak) = ([0f32; 64], 0f32);
    for (i, c) in footprint(d, p).into_iter().enumerate() {
        if height_m[((c[1] * p.pitch + c[0]) * p.stride) as usize] != LAND_M {
            let weight = weight_of(c, one, p);
            lanes[i % 64] += weight;
            peak = peak.max(weight);
        }
    }
    let total: f32 = lanes.into_iter().fold(0.0, |sum, lane| sum + lane);
    let scale = if total > 0.0 { 1.0 / (p.cell_m * p.cell_m * total) } else { 0.0 };
    (scale, one.volume_m3.abs().max(one.push_m3ps.abs()) * scale * peak)
}

/// Twin of `glsl/water/disturb.comp`: adds what [`weigh`] prepared.
pub fn disturb(p: &DisturbParams, items: &[Disturbance], height_m: &mut [f32], velocity_mps: &mut [f32]) {
    let mut rise = vec![0f32; height_m.len()];
    let mut speed = vec![0f32; velocity_mps.len()];
    for d in items.iter().filter(|d| d.scale > 0.0) {
        for c in footprint(d, p) {
            let i = (c[1] * p.pitch + c[0]) as usize;
            let share = weight_of(c, d, p) * d.scale;
            rise[i * p.stride as usize] += share * d.volume_m3;
            if p.has_velocity == 1 {
                speed[i] += share * d.push_m3ps;
            }
        }
    }
    for (height, rise) in height_m.iter_mut().zip(&rise).filter(|(height, _)| **height != LAND_M) {
        *height += rise;
    }
    for (i, (velocity, speed)) in velocity_mps.iter_mut().zip(&speed).enumerate() {
        if height_m[i * p.stride as usize] != LAND_M {
            *velocity += speed;
        }
    }
}

fn footprint(d: &Disturbance, p: &DisturbParams) -> Vec<[u32; 2]> {
    let most = p.cells.as_vec2();
    let lo = ((d.at_m - d.radius_m) / p.cell_m).floor().clamp(glam::Vec2::ZERO, most).as_uvec2();
    let hi = (((d.at_m + d.radius_m) / p.cell_m).floor() + 1.0).clamp(glam::Vec2::ZERO, most).as_uvec2();
    (lo.y..hi.y).flat_map(|y| (lo.x..hi.x).map(move |x| [x, y])).collect()
}

fn weight_of(c: [u32; 2], d: &Disturbance, p: &DisturbParams) -> f32 {
    let c = glam::UVec2::from(c).as_vec2();
    if d.radius_m <= 0.71 * p.cell_m {
        return if (d.at_m / p.cell_m).floor() == c { 1.0 } else { 0.0 };
    }
    let r = ((c + 0.5) * p.cell_m - d.at_m) / d.radius_m;
    let x = (1.0 - r.length_squared()).max(0.0);
    x * x
}
