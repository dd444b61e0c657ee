// SPDX-License-Identifier: MIT OR Apache-2.0
//! How far from its origin and how fast a mesh can be by its own keys: bounds that hold between the poses that are looked at.
//!
//! Between two times a < b that no key lies between, a point moves smoothly, and its velocity is nowhere farther from the
//! mean (p(b) - p(a)) / (b - a) than half of b - a times its largest acceleration. That follows from the keys, node by node:
//! of z = R S q + m, with the angular velocity w of R,
//!     |z'| <= |m'| + w |S q| + |(S q)'|,  |z''| <= |m''| + (w^2 + |w'|) |S q| + 2 w |(S q)'| + |(S q)''|.
//! Speed is convex in the place at rest, so of the vertices that hang on a joint the corners of their box are looked at, and a
//! vertex that hangs on several joints is no faster than the fastest of them.

use super::{
    rig::{unit, Curve, Track, Value},
    Mesh, Rig,
};
use glam::{Mat4, Quat, Vec3};
use std::ops::{Add, Mul, Sub};

/// Where a mesh can be, and how fast.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extent {
    /// No vertex is ever farther from the mesh's origin (m).
    pub reach_m: f32,
    /// No vertex goes a longer way in a step than this by the step's length (m/s).
    pub speed_mps: f32,
}

/// Parts of a period that are looked at, or more where keys are closer.
const LOOKS: u16 = 64;
/// As fast as what jumps (by second): what comes of it is far above any speed, and no infinity.
const JUMP: f64 = 1e30;

/// Bounds of something, of its first and of its second derivative (by second).
type Rates = [f64; 3];

/// Of a node: of its move, its largest factor, and (1, angular velocity, angular acceleration) of its turn.
#[derive(Clone, Copy)]
struct Motion {
    moves: Rates,
    scale: Rates,
    turn: Rates,
}

impl Mesh {
    /// Bounds over all times, for steps of `dt_s`, above 0. What jumps (keys that hold until the next) is as fast as its way
    /// by a step.
    pub fn extent(&self, dt_s: f64) -> Extent {
        let rig = &self.rig;
        let boxes = self.boxes();
        let mut all = Extent::default();
        let times = rig.times();
        let mut before = rig.pose_within(times[0]);
        all.reach_m = reach(&boxes, &before);
        for pair in times.windows(2) {
            let [from_s, to_s] = [pair[0], pair[1]];
            let after = rig.pose_within(to_s);
            let long_s = f64::from(to_s - from_s);
            let motions = rig.motions(from_s, to_s);
            for (joint, corners) in boxes.iter().enumerate().filter_map(|(i, it)| Some((i, it.as_ref()?))) {
                let chain = rig.chain(joint, &motions, corners);
                let way = farthest(corners, |x| {
                    after[joint].transform_point3(x) - before[joint].transform_point3(x)
                });
                let ends = farthest(corners, |x| after[joint].transform_point3(x))
                    .max(farthest(corners, |x| before[joint].transform_point3(x)));
                let speed = (way / long_s + 0.5 * long_s * chain[2]).min(chain[1]);
                let reach = (ends + 0.5 * long_s * speed).min(chain[0]);
                all.speed_mps = all.speed_mps.max(speed as f32);
                all.reach_m = all.reach_m.max(reach as f32);
            }
            before = after;
        }
        // What a loop that counts as closed lacks of it is gone in one step.
        if rig.moves() && !rig.jumps() {
            let first = rig.pose_within(0.0);
            let gaps = boxes.iter().enumerate().filter_map(|(i, corners)| {
                Some(farthest(corners.as_ref()?, |x| {
                    first[i].transform_point3(x) - before[i].transform_point3(x)
                }))
            });
            all.speed_mps += (gaps.fold(0.0, f64::max) / dt_s) as f32;
        }
        // Times are rounded, by up to an ulp of the period from one end of a step to the other.
        all.speed_mps *= 1.0 + f32::EPSILON * rig.period_s / dt_s as f32;
        all.speed_mps = all.speed_mps.min((2.0 * f64::from(all.reach_m) / dt_s) as f32);
        all
    }

    /// Corners of the box at rest of what hangs on each joint (m).
    fn boxes(&self) -> Vec<Option<[Vec3; 8]>> {
        let mut boxes = vec![(Vec3::INFINITY, Vec3::NEG_INFINITY); self.rig.joints.len()];
        for (at, hold) in self.at_m.iter().zip(&self.hold) {
            for (&joint, weight) in hold.joints.iter().zip(hold.stored()) {
                let (low, high) = &mut boxes[usize::from(joint)];
                if weight > 0.0 {
                    (*low, *high) = (low.min(*at), high.max(*at));
                }
            }
        }
        let corners = |(low, high): (Vec3, Vec3)| {
            let pick = |k: usize| Vec3::from_array([0, 1, 2].map(|axis| [low, high][k >> axis & 1][axis]));
            (low.x <= high.x).then(|| std::array::from_fn(pick))
        };
        boxes.into_iter().map(corners).collect()
    }
}

fn farthest(corners: &[Vec3; 8], of: impl Fn(Vec3) -> Vec3) -> f64 {
    let far =
        |x: &Vec3| Some(f64::from(of(*x).length())).filter(|far| !far.is_nan()).unwrap_or(f64::INFINITY);
    corners.iter().map(far).fold(0.0, f64::max)
}

fn reach(boxes: &[Option<[Vec3; 8]>], pose: &[Mat4]) -> f32 {
    let all = boxes.iter().zip(pose).filter_map(|(it, joint)| Some((it.as_ref()?, joint)));
    all.map(|(corners, joint)| farthest(corners, |x| joint.transform_point3(x))).fold(0.0, f64::max) as f32
}

impl Rig {
    /// Rising from 0 to the period, all times of keys among them, and none far from the next (s).
    fn times(&self) -> Vec<f32> {
        if !self.moves() {
            return vec![0.0];
        }
        let keys = self.tracks.iter().flat_map(|track| track.time_s.iter().copied());
        let mut keys: Vec<f32> =
            keys.chain([0.0, self.period_s]).filter(|t| (0.0..=self.period_s).contains(t)).collect();
        keys.sort_by(f32::total_cmp);
        keys.dedup();
        let parts = |pair: &[f32]| {
            let (from, long) = (pair[0], pair[1] - pair[0]);
            let parts = (f32::from(LOOKS) * long / self.period_s).ceil().max(1.0);
            (0..parts as u16).map(move |k| from + long * f32::from(k) / parts).collect::<Vec<_>>()
        };
        keys.windows(2).flat_map(parts).chain([self.period_s]).collect()
    }

    /// Of all nodes, between two times that no key lies between.
    fn motions(&self, from_s: f32, to_s: f32) -> Vec<Motion> {
        let at_rest = self.nodes.iter().map(|node| Motion {
            moves: [f64::from(node.move_m.length()), 0.0, 0.0],
            scale: [f64::from(node.scale.abs().max_element()), 0.0, 0.0],
            turn: [1.0, 0.0, 0.0],
        });
        let mut motions: Vec<Motion> = at_rest.collect();
        for track in &self.tracks {
            let motion = &mut motions[track.node];
            match &track.value {
                Value::Move(keys) => motion.moves = track.rates(keys, from_s, to_s, |x| x.length()),
                Value::Scale(keys) => {
                    motion.scale = track.rates(keys, from_s, to_s, |x| x.abs().max_element())
                }
                Value::Turn(keys) => motion.turn = track.turns(keys, from_s, to_s),
            }
        }
        motions
    }

    /// Of points that hang on a joint, in the mesh.
    fn chain(&self, joint: usize, motions: &[Motion], corners: &[Vec3; 8]) -> Rates {
        let joint = &self.joints[joint];
        let mut point = [farthest(corners, |x| joint.node_from_rest.transform_point3(x)), 0.0, 0.0];
        let mut next = Some(joint.node);
        while let Some(node) = next {
            let Motion { moves, scale, turn } = &motions[node];
            let [p, v, a] = point;
            let [p, v, a] =
                [scale[0] * p, scale[1] * p + scale[0] * v, scale[2] * p + 2.0 * scale[1] * v + scale[0] * a];
            let (w, w_dot) = (turn[1], turn[2]);
            point = [moves[0] + p, moves[1] + w * p + v, moves[2] + (w * w + w_dot) * p + 2.0 * w * v + a];
            next = self.nodes[node].parent;
        }
        point
    }
}

impl Track {
    /// The key that the span from `from_s` to `to_s` lies behind, and the one before it, if it lies between two.
    fn between(&self, from_s: f32, to_s: f32) -> Option<[usize; 2]> {
        let middle = from_s + 0.5 * (to_s - from_s);
        let next = self.time_s.partition_point(|&t| t <= middle);
        (next > 0 && next < self.time_s.len()).then(|| [next - 1, next])
    }

    fn rates<T>(&self, keys: &[T], from_s: f32, to_s: f32, size: impl Fn(T) -> f32) -> Rates
    where
        T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T>,
    {
        let Some([one, other]) = self.between(from_s, to_s) else {
            let values = keys.iter().map(|key| f64::from(size(*key)));
            return [values.fold(0.0, f64::max), 0.0, 0.0];
        };
        let size = |value: T| f64::from(size(value));
        let long_s = self.time_s[other] - self.time_s[one];
        let most = |values: &[T]| values.iter().map(|value| size(*value)).fold(0.0, f64::max);
        match self.curve {
            Curve::Step => {
                let jumps = if size(keys[other] - keys[one]) > 0.0 { JUMP } else { 0.0 };
                [most(&[keys[one], keys[other]]), jumps, jumps]
            }
            Curve::Linear => {
                [most(&[keys[one], keys[other]]), size(keys[other] - keys[one]) / f64::from(long_s), 0.0]
            }
            // As a curve of Bezier: it, and its derivatives, lie in the hull of their points.
            Curve::Cubic => {
                let (start, end) = (keys[3 * one + 1], keys[3 * other + 1]);
                let third = long_s / 3.0;
                let points = [start, start + keys[3 * one + 2] * third, end - keys[3 * other] * third, end];
                let first = [0, 1, 2].map(|i| (points[i + 1] - points[i]) * (3.0 / long_s));
                let second = [0, 1].map(|i| (first[i + 1] - first[i]) * (2.0 / long_s));
                [most(&points), most(&first), most(&second)]
            }
        }
    }

    fn turns(&self, keys: &[Quat], from_s: f32, to_s: f32) -> Rates {
        let Some([one, other]) = self.between(from_s, to_s) else { return [1.0, 0.0, 0.0] };
        match self.curve {
            Curve::Step => self.rates(keys, from_s, to_s, Quat::length),
            Curve::Linear => {
                let (a, b) = (unit(keys[one]).as_dquat(), unit(keys[other]).as_dquat());
                let chord = (a - b).length().min((a + b).length());
                // A thousandth and a fiftieth: short arcs go along their chord.
                let turned = 1.001 * 4.0 * (0.5 * chord).min(1.0).asin();
                let w = turned / f64::from(self.time_s[other] - self.time_s[one]);
                [1.0, w, 0.02 * w * w]
            }
            // What is turned by is the cubic, made unit: fast where it is short.
            Curve::Cubic => {
                let [_, u1, u2] = self.rates(keys, from_s, to_s, Quat::length);
                let ends = [from_s, to_s].map(|t| f64::from(self.at(keys, t, |a, _, _| a).length()));
                let shortest = ends[0].max(ends[1]) - u1 * f64::from(to_s - from_s);
                if shortest < 1e-5 {
                    return [1.0, JUMP, JUMP];
                }
                let [by_one, by_two] = [u1 / shortest, u2 / shortest];
                [1.0, 2.0 * by_one, 2.0 * (by_two + 3.0 * by_one * by_one)]
            }
        }
    }
}
