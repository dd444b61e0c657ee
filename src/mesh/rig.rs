// SPDX-License-Identifier: MIT OR Apache-2.0
//! Nodes that hang on each other, keys that move them, and the matrices that come of it.

use glam::{Mat3, Mat4, Quat, Vec3};

/// A tree of nodes and what moves them.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// Parents before their children.
    pub nodes: Vec<Node>,
    /// What vertices hang on.
    pub joints: Vec<Joint>,
    /// What moves the nodes.
    pub tracks: Vec<Track>,
    /// The keys begin again after it (s); 0 without keys.
    pub period_s: f32,
}

/// A frame of reference in that of its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// An earlier node; `None`: the mesh itself.
    pub parent: Option<usize>,
    /// At rest (m).
    pub move_m: Vec3,
    /// At rest.
    pub turn: Quat,
    /// At rest.
    pub scale: Vec3,
}

/// A node that vertices hang on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Index of the node.
    pub node: usize,
    /// From the mesh at rest to the node.
    pub node_from_rest: Mat4,
}

/// What a track moves, and its keys.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// (m).
    Move(Vec<Vec3>),
    /// Unit quaternions.
    Turn(Vec<Quat>),
    /// Factors.
    Scale(Vec<Vec3>),
}

/// What happens between two keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    /// The earlier key holds.
    Step,
    /// A straight line, or the shorter arc.
    Linear,
    /// A cubic; three values a key: tangent in, value, tangent out.
    Cubic,
}

/// Keys of one property of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// Index of the node.
    pub node: usize,
    /// When, rising (s).
    pub time_s: Vec<f32>,
    /// What.
    pub value: Value,
    /// How between.
    pub curve: Curve,
}

impl Node {
    /// Where its parent is.
    pub fn at_parent(parent: Option<usize>) -> Self {
        Self { parent, move_m: Vec3::ZERO, turn: Quat::IDENTITY, scale: Vec3::ONE }
    }
}

impl Rig {
    /// One joint that never moves.
    pub fn still() -> Self {
        let joints = vec![Joint { node: 0, node_from_rest: Mat4::IDENTITY }];
        Self { nodes: vec![Node::at_parent(None)], joints, tracks: Vec::new(), period_s: 0.0 }
    }

    /// Whether anything moves.
    pub fn moves(&self) -> bool {
        self.period_s > 0.0 && !self.tracks.is_empty()
    }

    /// Joints from the mesh at rest to the mesh at `time_s`, which wraps round the period.
    pub fn pose(&self, time_s: f64) -> Vec<Mat4> {
        let time_s = if self.moves() { time_s.rem_euclid(f64::from(self.period_s)) as f32 } else { 0.0 };
        self.pose_within(time_s)
    }

    /// Two times of which the difference of poses, by the returned rate (1/s), is the velocity at `time_s` of a step of
    /// `dt_s`: the way in the step by its length. Where the loop jumps in the step, the mesh is taken to have come as fast as
    /// the loop begins. A step of no length moves nothing.
    pub fn velocity_window(&self, time_s: f64, dt_s: f64) -> (f32, f32, f32) {
        if !self.moves() || dt_s <= 0.0 {
            return (0.0, 0.0, 0.0);
        }
        let (period_s, rate) = (f64::from(self.period_s), (1.0 / dt_s) as f32);
        if time_s.rem_euclid(period_s) < dt_s && self.jumps() {
            return (0.0, dt_s.min(period_s) as f32, rate);
        }
        let within = |time_s: f64| time_s.rem_euclid(period_s) as f32;
        (within(time_s - dt_s), within(time_s), rate)
    }

    /// Whether the mesh is elsewhere at the end of its keys than at their start, by more than how files round.
    pub(super) fn jumps(&self) -> bool {
        let (first, last) = (self.pose_within(0.0), self.pose_within(self.period_s));
        first.iter().zip(&last).any(|(one, other)| {
            let largest = one.to_cols_array().into_iter().fold(1f32, |most, x| most.max(x.abs()));
            !one.abs_diff_eq(*other, 1e-4 * largest)
        })
    }

    /// The pose at a time within the period.
    pub fn pose_within(&self, time_s: f32) -> Vec<Mat4> {
        let mut nodes = self.nodes.clone();
        for track in &self.tracks {
            track.apply(&mut nodes[track.node], time_s);
        }
        let mut world: Vec<Mat4> = Vec::with_capacity(nodes.len());
        for node in &nodes {
            let own = Mat4::from_scale_rotation_translation(node.scale, node.turn, node.move_m);
            world.push(node.parent.map_or(own, |parent| world[parent] * own));
        }
        self.joints.iter().map(|joint| world[joint.node] * joint.node_from_rest).collect()
    }

    /// Three matrices of three rows a joint (now, and the two whose difference is the velocity), and what turns that
    /// difference into a velocity (1/s): at `time_s`, placed by `world`, after a step of `dt_s` before which it was placed by
    /// `world_before`.
    pub fn matrices_at(
        &self,
        time_s: f64,
        dt_s: f64,
        world: Mat4,
        world_before: Mat4,
    ) -> (Vec<[f32; 12]>, f32) {
        let (mut from_s, mut to_s, mut rate) = self.velocity_window(time_s, dt_s);
        if !self.moves() && world != world_before {
            (from_s, to_s, rate) = (0.0, 0.0, if dt_s > 0.0 { 1.0 / dt_s as f32 } else { 0.0 });
        }
        let rows = |world: Mat4, joints: Vec<Mat4>| -> Vec<[f32; 12]> {
            joints
                .into_iter()
                .map(|joint| {
                    let m = world * joint;
                    let basis = Mat3::from_mat4(m).transpose();
                    let row = |r: glam::Vec3, w: f32| [r.x, r.y, r.z, w];
                    let [a, b, c] = [
                        row(basis.x_axis, m.w_axis.x),
                        row(basis.y_axis, m.w_axis.y),
                        row(basis.z_axis, m.w_axis.z),
                    ];
                    std::array::from_fn(|i| [a, b, c][i / 4][i % 4])
                })
                .collect()
        };
        let mut all = rows(world, self.pose(time_s));
        all.extend(rows(world_before, self.pose_within(from_s)));
        all.extend(rows(world, self.pose_within(to_s)));
        (all, rate)
    }

    pub(super) fn check(&self) -> Result<(), String> {
        for (i, node) in self.nodes.iter().enumerate() {
            if node.parent.is_some_and(|parent| parent >= i) {
                return Err(format!("node {i} comes before its parent"));
            }
            if !(node.move_m.is_finite() && node.turn.is_finite() && node.scale.is_finite()) {
                return Err(format!("node {i} is not finite"));
            }
        }
        if let Some(i) =
            self.joints.iter().position(|it| it.node >= self.nodes.len() || !it.node_from_rest.is_finite())
        {
            return Err(format!("joint {i} has no node, or a matrix that is not finite"));
        }
        if !(0.0..=1e6).contains(&self.period_s) {
            return Err(format!("its keys last {} s; allowed: 0 to 1e6", self.period_s));
        }
        for (i, track) in self.tracks.iter().enumerate() {
            let each = if track.curve == Curve::Cubic { 3 } else { 1 };
            let (values, is_finite) = match &track.value {
                Value::Move(keys) | Value::Scale(keys) => {
                    (keys.len(), keys.iter().all(|key| key.is_finite()))
                }
                Value::Turn(keys) => (keys.len(), keys.iter().all(|key| key.is_finite())),
            };
            let rises = track.time_s.windows(2).all(|pair| pair[0] < pair[1])
                && track.time_s.iter().all(|t| (0.0..=1e6).contains(t));
            if track.node >= self.nodes.len()
                || track.time_s.is_empty()
                || values != each * track.time_s.len()
            {
                return Err(format!(
                    "track {i}: {values} values for {} keys of node {}",
                    track.time_s.len(),
                    track.node
                ));
            }
            if !rises || !is_finite {
                return Err(format!(
                    "track {i}: keys that are not finite, or whose times do not rise from 0"
                ));
            }
        }
        Ok(())
    }

    pub(super) fn append(&mut self, other: &Self) {
        let nodes = self.nodes.len();
        let shifted = |node: &Node| Node { parent: node.parent.map(|parent| parent + nodes), ..*node };
        self.nodes.extend(other.nodes.iter().map(shifted));
        self.joints.extend(other.joints.iter().map(|joint| Joint { node: joint.node + nodes, ..*joint }));
        self.tracks
            .extend(other.tracks.iter().map(|track| Track { node: track.node + nodes, ..track.clone() }));
        self.period_s = self.period_s.max(other.period_s);
    }
}

/// A turn; none, if it is no quaternion to speak of.
pub(super) fn unit(q: Quat) -> Quat {
    if q.length_squared() > 1e-12 {
        q.normalize()
    } else {
        Quat::IDENTITY
    }
}

impl Track {
    fn apply(&self, node: &mut Node, time_s: f32) {
        match &self.value {
            Value::Move(keys) => node.move_m = self.at(keys, time_s, Vec3::lerp),
            Value::Scale(keys) => node.scale = self.at(keys, time_s, Vec3::lerp),
            Value::Turn(keys) => {
                let turn = self.at(keys, time_s, |a, b, t| unit(a).slerp(unit(b), t));
                node.turn = unit(turn);
            }
        }
    }

    pub(super) fn at<T>(&self, keys: &[T], time_s: f32, between: impl Fn(T, T, f32) -> T) -> T
    where
        T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f32, Output = T>,
    {
        let last = self.time_s.len() - 1;
        let next = self.time_s.partition_point(|&t| t <= time_s);
        let value = |key: usize| if self.curve == Curve::Cubic { keys[3 * key + 1] } else { keys[key] };
        if next == 0 || next > last {
            return value(next.min(last));
        }
        let (from, to) = (self.time_s[next - 1], self.time_s[next]);
        let (span, t) = (to - from, (time_s - from) / (to - from));
        match self.curve {
            Curve::Step => value(next - 1),
            Curve::Linear => between(value(next - 1), value(next), t),
            // Hermite, tangents by second (glTF 2.0, appendix C).
            Curve::Cubic => {
                let (t2, t3) = (t * t, t * t * t);
                value(next - 1) * (2.0 * t3 - 3.0 * t2 + 1.0)
                    + keys[3 * (next - 1) + 2] * (span * (t3 - 2.0 * t2 + t))
                    + value(next) * (3.0 * t2 - 2.0 * t3)
                    + keys[3 * next] * (span * (t3 - t2))
            }
        }
    }
}
