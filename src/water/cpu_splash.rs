// SPDX-License-Identifier: MIT OR Apache-2.0
//! CPU twin of `water.splash`.

use super::{Disturbance, SplashParams, LAND_M};
use crate::impact::Impact;
use glam::{vec2, Vec3};

/// Twin of `glsl/water/splash.comp`: the disturbances that impacts are, and how many impacts missed the water.
pub fn splash(p: &SplashParams, height_m: &[f32], impacts: &[Impact]) -> (Vec<Disturbance>, u64) {
    let mut taken: Vec<&Impact> = impacts.iter().filter(|it| is_over_water(p, height_m, it.at_m)).collect();
    taken.sort_by_key(|it| it.order);
    let missed = impacts.len() - taken.len();
    let of = |it: &Impact| {
        let pushes = p.items == 2 && !is_by_land(p, height_m, it.at_m);
        let pushed_m3ps = if pushes { p.push_m2 * it.impulse_mps } else { 0.0 };
        let here = Disturbance {
            at_m: vec2(it.at_m.x, it.at_m.z) - p.corner_m,
            radius_m: p.radius_m,
            volume_m3: p.volume_m3,
            push_m3ps: -pushed_m3ps,
            ..Disturbance::default()
        };
        let round = Disturbance {
            radius_m: 2.0 * p.radius_m,
            volume_m3: 0.0,
            push_m3ps: pushed_m3ps,
            tied: 1,
            ..here
        };
        [here, round].into_iter().take(p.items as usize)
    };
    (taken.into_iter().flat_map(of).collect(), missed as u64)
}

fn is_by_land(p: &SplashParams, height_m: &[f32], at_m: Vec3) -> bool {
    let (at, reach, most) = (vec2(at_m.x, at_m.z) - p.corner_m, 2.0 * p.radius_m, p.cells.as_vec2());
    let lo = ((at - reach) / p.cell_m).floor().clamp(vec2(0.0, 0.0), most).as_uvec2();
    let hi = (((at + reach) / p.cell_m).floor() + 1.0).clamp(vec2(0.0, 0.0), most).as_uvec2();
    let is_land = |x: u32, y: u32| height_m[((y * p.pitch + x) * p.stride) as usize] == LAND_M;
    (lo.y..hi.y).any(|y| (lo.x..hi.x).any(|x| is_land(x, y)))
}

fn is_over_water(p: &SplashParams, height_m: &[f32], at_m: Vec3) -> bool {
    let c = ((vec2(at_m.x, at_m.z) - p.corner_m) / p.cell_m).floor();
    let is_inside = c.cmpge(vec2(0.0, 0.0)).all() && c.cmplt(p.cells.as_vec2()).all();
    is_inside && height_m[((c.y as u32 * p.pitch + c.x as u32) * p.stride) as usize] != LAND_M
}
