// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a flight ends: twin of `glsl/ballistic/ground.glsl`, and the same in f64.

use super::{
    cpu::{
        fall_time, fall_time_f64, position, position_f64, reach_of, velocity, velocity_f64, Birth, BirthF64,
        Wide,
    },
    effect::Params,
};
use glam::{dvec2, dvec3, vec2, vec3, DVec2, Vec2, Vec3};

/// Heights of the samples of [`Params::ground_cells`], row by row from -z (m).
#[derive(Clone, Copy, Debug)]
pub struct Ground<'a>(pub &'a [f32]);

impl Ground<'_> {
    fn sample(&self, p: &Params, x: i32, z: i32) -> f32 {
        let [w, h] = p.ground_cells.to_array().map(|n| n as i32);
        self.0[(z.clamp(0, h - 1) * w + x.clamp(0, w - 1)) as usize]
    }

    /// Ground or water, whichever is higher (m).
    pub fn height(&self, p: &Params, xz_m: Vec2) -> f32 {
        let cells = p.ground_cells.as_vec2();
        let grid = (xz_m / p.ground_size_m + 0.5) * cells - 0.5;
        let at = grid.clamp(Vec2::ZERO, cells - 1.0);
        let (x, z) = (at.x as i32, at.y as i32);
        let f = at - vec2(x as f32, z as f32);
        let row = |z| self.sample(p, x, z) * (1.0 - f.x) + self.sample(p, x + 1, z) * f.x;
        let height = row(z) * (1.0 - f.y) + row(z + 1) * f.y;
        height.max(p.water_m)
    }

    /// [`Ground::height`] in f64.
    pub fn height_f64(&self, p: &Params, xz_m: DVec2) -> f64 {
        let cells = p.ground_cells.as_dvec2();
        let grid = (xz_m / p.ground_size_m.as_dvec2() + 0.5) * cells - 0.5;
        let at = grid.clamp(DVec2::ZERO, cells - 1.0);
        let (x, z) = (at.x as i32, at.y as i32);
        let f = at - dvec2(f64::from(x), f64::from(z));
        let sample = |x, z| f64::from(self.sample(p, x, z));
        let row = |z| sample(x, z) * (1.0 - f.x) + sample(x + 1, z) * f.x;
        (row(z) * (1.0 - f.y) + row(z + 1) * f.y).max(f64::from(p.water_m))
    }

    /// Of [`Ground::height`], unit, upwards.
    pub fn normal(&self, p: &Params, xz_m: Vec2) -> Vec3 {
        if self.height(p, xz_m) <= p.water_m {
            return Vec3::Y;
        }
        let cells = p.ground_cells.as_vec2();
        let grid = (xz_m / p.ground_size_m + 0.5) * cells - 0.5;
        let at = grid.clamp(Vec2::ZERO, cells - 1.0);
        let (x, z) = (at.x as i32, at.y as i32);
        let (f, samples_a_m) = (at - vec2(x as f32, z as f32), cells / p.ground_size_m);
        let [here, east] = [0, 1].map(|i| self.sample(p, x + i, z));
        let [north, across] = [0, 1].map(|i| self.sample(p, x + i, z + 1));
        let along_x = ((east - here) * (1.0 - f.y) + (across - north) * f.y) * samples_a_m.x;
        let along_z = ((north - here) * (1.0 - f.x) + (across - east) * f.x) * samples_a_m.y;
        let length = (1.0 + (along_x * along_x + along_z * along_z)).sqrt();
        vec3(-along_x / length, 1.0 / length, -along_z / length)
    }

    /// Age at which a flight meets the ground (s), 1e30 if it does not fall.
    pub fn hit(&self, p: &Params, birth: &Birth) -> f32 {
        let (a, drag) = (p.acceleration.truncate(), p.acceleration.w);
        let mut under = vec2(birth.at_m.x, birth.at_m.z);
        let mut t = 1e30;
        for _ in 0..6 {
            let above = birth.at_m.y - self.height(p, under);
            t = fall_time(above, birth.velocity_mps.y, a.y);
            if t <= 0.0 || t >= 1e30 {
                return t;
            }
            for _ in 0..if drag > 0.0 { 5 } else { 0 } {
                let r = reach_of(Wide { high: t, low: 0.0 }, drag);
                let left = position(vec3(0.0, above, 0.0), birth.velocity_mps, a, &r).y;
                let fall = velocity(birth.velocity_mps, a, &r).y;
                if fall >= 0.0 {
                    return 1e30;
                }
                t -= left / fall;
            }
            let r = reach_of(Wide { high: t, low: 0.0 }, drag);
            let at = position(birth.at_m, birth.velocity_mps, a, &r);
            under = vec2(at.x, at.z);
        }
        t
    }

    /// [`Ground::hit`] in f64, to the end: rounds go on until nothing changes.
    pub fn hit_f64(&self, p: &Params, birth: &BirthF64) -> f64 {
        let (a, drag) = (p.acceleration.truncate().as_dvec3(), f64::from(p.acceleration.w));
        let mut under = dvec2(birth.at_m.x, birth.at_m.z);
        let mut t = 1e30;
        for _ in 0..100 {
            let above = birth.at_m.y - self.height_f64(p, under);
            let before = t;
            t = fall_time_f64(above, birth.velocity_mps.y, a.y);
            if t <= 0.0 || t >= 1e30 {
                return t;
            }
            for _ in 0..if drag > 0.0 { 50 } else { 0 } {
                let left = position_f64(dvec3(0.0, above, 0.0), birth.velocity_mps, a, t, drag).y;
                let fall = velocity_f64(birth.velocity_mps, a, t, drag).y;
                if fall >= 0.0 {
                    return 1e30;
                }
                t -= left / fall;
            }
            if (t - before).abs() <= 1e-15 * t {
                break;
            }
            let at = position_f64(birth.at_m, birth.velocity_mps, a, t, drag);
            under = dvec2(at.x, at.z);
        }
        t
    }
}
