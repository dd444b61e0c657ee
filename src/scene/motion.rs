// SPDX-License-Identifier: MIT OR Apache-2.0
//! Where a mesh of a scene is at which time, and how fast it moves.

use glam::{Mat4, Quat, Vec3};
use serde::Serialize;

/// Place and turn of a mesh at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Key {
    /// (s), 0 or more, after the key before.
    pub t_s: f64,
    /// (m).
    pub at_m: [f32; 3],
    /// About x, then y, then z of the world (degrees). Between two keys the angles themselves change evenly, so that 0 and
    /// 360 are a whole turn.
    pub turn_deg: [f32; 3],
}

/// A rigid motion: keys, or one that holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// At least one.
    pub keys: Vec<Key>,
    /// Begins again after the last key.
    pub loops: bool,
    /// Factor of the mesh.
    pub scale: f32,
}

impl Motion {
    /// Whether anything moves.
    pub fn moves(&self) -> bool {
        self.keys.len() > 1
    }

    fn period_s(&self) -> f64 {
        self.keys.last().map_or(0.0, |key| key.t_s)
    }

    /// Time within the keys.
    fn within(&self, time_s: f64) -> f64 {
        let period_s = self.period_s();
        match self.loops && period_s > 0.0 {
            true => time_s.rem_euclid(period_s),
            false => time_s.clamp(0.0, period_s),
        }
    }

    fn pose(&self, t_s: f64) -> Mat4 {
        let next = self.keys.partition_point(|key| key.t_s <= t_s);
        let (from, to) = (self.keys[next.max(1) - 1], self.keys[next.min(self.keys.len() - 1)]);
        let share =
            if to.t_s > from.t_s { ((t_s - from.t_s) / (to.t_s - from.t_s)).clamp(0.0, 1.0) } else { 0.0 };
        let at = Vec3::from(from.at_m).lerp(to.at_m.into(), share as f32);
        let [x, y, z] = [0, 1, 2].map(|k| {
            let (a, b) = (f64::from(from.turn_deg[k]), f64::from(to.turn_deg[k]));
            (a + (b - a) * share).rem_euclid(360.0).to_radians() as f32
        });
        let turn = Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x);
        Mat4::from_scale_rotation_translation(Vec3::splat(self.scale), turn, at)
    }

    /// From the mesh to the world at `time_s`.
    pub fn at(&self, time_s: f64) -> Mat4 {
        self.pose(self.within(time_s))
    }

    /// The same, and where the mesh was a step of `dt_s` before: what lies between is its way in the step, and by its length
    /// its velocity. Where a loop jumps in the step, it is taken to have come as fast as it goes on. A step of no length
    /// moves nothing.
    pub fn step(&self, time_s: f64, dt_s: f64) -> [Mat4; 2] {
        let now = self.at(time_s);
        if !self.moves() || dt_s <= 0.0 {
            return [now, now];
        }
        let t_s = self.within(time_s);
        if self.loops && t_s < dt_s && self.jumps() {
            return [now, now - (self.pose((t_s + dt_s).min(self.period_s())) - now)];
        }
        [now, self.at(time_s - dt_s)]
    }

    /// Whether the last key is another place than the first, by more than how their numbers are written.
    fn jumps(&self) -> bool {
        let (first, last) = (&self.keys[0], &self.keys[self.keys.len() - 1]);
        let (from, to) = (Vec3::from(first.at_m), Vec3::from(last.at_m));
        let turns = (0..3).any(|k| {
            let apart = (f64::from(last.turn_deg[k]) - f64::from(first.turn_deg[k])).rem_euclid(360.0);
            apart.min(360.0 - apart) > 1e-3
        });
        turns || from.distance(to) > 1e-6 * from.length().max(to.length())
    }

    /// No point of the mesh within `reach_m` of its origin is faster (m/s), by these keys.
    pub fn fastest_mps(&self, reach_m: f32) -> f32 {
        let between = self.keys.windows(2).map(|pair| {
            let [from, to] = [&pair[0], &pair[1]];
            let dt_s = (to.t_s - from.t_s).max(1e-9) as f32;
            let far = Vec3::from(from.at_m).distance(to.at_m.into());
            let turns: f32 = (0..3).map(|k| (to.turn_deg[k] - from.turn_deg[k]).abs().to_radians()).sum();
            (far + turns * reach_m * self.scale.abs()) / dt_s
        });
        between.fold(0.0, f32::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spin() -> Motion {
        let key = |t_s, turn| Key { t_s, at_m: [0.0, t_s as f32, 0.0], turn_deg: [0.0, turn, 0.0] };
        Motion { keys: vec![key(0.0, 0.0), key(2.0, 360.0)], loops: true, scale: 1.0 }
    }

    #[test]
    fn a_whole_turn_is_a_turn_and_a_loop_begins_again() {
        let point = |t| spin().at(t).transform_point3(Vec3::X);
        assert!(point(0.5).distance(Vec3::new(0.0, 0.5, -1.0)) < 1e-6);
        assert!(point(2.5).distance(point(0.5)) < 1e-6);
    }

    #[test]
    fn velocities_are_those_of_the_keys_even_at_the_seam() {
        for t in [0.0, 1e-3, 1.0, 1.999, 2.0, 2.004, 400.005] {
            let [now, before] = spin().step(t, 0.01);
            let origin = (now.transform_point3(Vec3::ZERO) - before.transform_point3(Vec3::ZERO)) / 0.01;
            assert!(origin.distance(Vec3::Y) < 2e-3, "{t}: {origin}");
            let there = (now * Vec3::X.extend(0.0) - before * Vec3::X.extend(0.0)) / 0.01;
            assert!((there.length() - std::f32::consts::PI).abs() < 0.01, "{t}: {there}");
        }
        let [now, before] = spin().step(1.0, 0.0);
        assert_eq!(now, before);
        let once = Motion { loops: false, ..spin() };
        let [now, before] = once.step(3.0, 0.01);
        assert_eq!(now, before);
    }

    #[test]
    fn what_turns_round_at_the_seam_or_ends_moves_by_its_way_in_the_step() {
        let key = |t_s, x: f32, turn| Key { t_s, at_m: [x, 0.0, 0.3], turn_deg: [0.0, turn, 0.0] };
        let swing = Motion {
            keys: vec![key(0.0, 0.0, 0.0), key(1.0, 2.0, 90.0), key(2.0, 0.0, 0.0)],
            loops: true,
            scale: 1.5,
        };
        let once = Motion { loops: false, ..swing.clone() };
        let late = Motion { keys: vec![key(0.5, 0.0, 0.0), key(1.0, 2.0, 90.0)], ..once.clone() };
        let dt_s = 1.0 / 60.0;
        for motion in [swing, once, late] {
            for t_s in [
                0.0,
                0.25 * dt_s,
                dt_s,
                1.0,
                1.0 + 0.3 * dt_s,
                2.0,
                2.0 + 0.4 * dt_s,
                2.0 + dt_s,
                40.0 + 0.9 * dt_s,
            ] {
                let [now, before] = motion.step(t_s, dt_s);
                assert_eq!((now, before), (motion.at(t_s), motion.at(t_s - dt_s)), "{t_s} s");
            }
        }
    }
}
