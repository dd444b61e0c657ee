// SPDX-License-Identifier: MIT OR Apache-2.0
//! Meshes made by rule: each closed where it says so, and with texture coordinates under which no two triangles overlap, so
//! that it can be painted.

use super::{Curve, Hold, Joint, Mesh, Node, Rig, Track, Value};
use glam::{vec2, vec3, Mat4, Quat, Vec2, Vec3};
use std::f32::consts::{PI, TAU};

/// A part of the texture: its corner and its size.
#[derive(Clone, Copy)]
pub(super) struct Patch {
    pub corner: Vec2,
    pub size: Vec2,
}

pub(super) const WHOLE: Patch = Patch { corner: Vec2::ZERO, size: Vec2::ONE };

impl Patch {
    /// The `i`-th of `columns` by `rows` patches, with a margin of a hundredth of the texture.
    pub fn of(i: usize, columns: usize, rows: usize) -> Self {
        let size = vec2(1.0 / columns as f32, 1.0 / rows as f32);
        let corner = size * vec2((i % columns) as f32, (i / columns) as f32);
        Self { corner: corner + 0.005, size: size - 0.01 }
    }
}

/// Points `place(u, v)` of `across` by `along` squares, u and v from 0 to 1, seen from outside with u to the right and v
/// down. Squares that have shrunk to a line or a point leave no triangle.
pub(super) fn sheet(across: u32, along: u32, patch: Patch, place: impl Fn(f32, f32) -> Vec3) -> Mesh {
    let (mut at_m, mut uv, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for j in 0..=along {
        for i in 0..=across {
            let (u, v) = (i as f32 / across as f32, j as f32 / along as f32);
            at_m.push(place(u, v));
            uv.push(patch.corner + patch.size * vec2(u, v));
        }
    }
    let mut add = |corners: [u32; 3]| {
        let [a, b, c] = corners.map(|i| at_m[i as usize]);
        if (b - a).cross(c - a).length() > 1e-12 {
            triangles.push(corners);
        }
    };
    for j in 0..along {
        for i in 0..across {
            let a = j * (across + 1) + i;
            let (b, c, d) = (a + 1, a + across + 1, a + across + 2);
            add([a, c, b]);
            add([b, c, d]);
        }
    }
    Mesh::still("sheet", at_m, uv, triangles).expect("a sheet has numbers that are finite")
}

/// Seams have two vertices in one place: both get the normal of both sides.
pub(super) fn smooth_seams(mut mesh: Mesh) -> Mesh {
    let key = |at: Vec3| (at * 1e5).round().to_array().map(|x| x as i64);
    let mut sums = std::collections::HashMap::<[i64; 3], Vec3>::new();
    for (at, normal) in mesh.at_m.iter().zip(&mesh.normals) {
        *sums.entry(key(*at)).or_default() += *normal;
    }
    let smooth = mesh.at_m.iter().map(|at| sums[&key(*at)].normalize_or_zero()).collect();
    mesh.normals = smooth;
    mesh
}

/// A box of six faces, `half_m` its half edges (m). Closed, edges sharp.
pub fn cuboid(half_m: Vec3) -> Mesh {
    // To the right, down and outward of each face.
    let faces = [
        (Vec3::NEG_Z, Vec3::NEG_Y, Vec3::X),
        (Vec3::Z, Vec3::NEG_Y, Vec3::NEG_X),
        (Vec3::X, Vec3::Z, Vec3::Y),
        (Vec3::X, Vec3::NEG_Z, Vec3::NEG_Y),
        (Vec3::X, Vec3::NEG_Y, Vec3::Z),
        (Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z),
    ];
    let face = |i: usize| {
        let (right, down, out) = faces[i];
        sheet(1, 1, Patch::of(i, 3, 2), |u, v| {
            half_m * (out + right * (2.0 * u - 1.0) + down * (2.0 * v - 1.0))
        })
    };
    rename((1..6).fold(face(0), |all, i| one_joint(all.with(&face(i)))), "box")
}

/// A sphere of `radius_m` (m), `around` squares round its equator. Closed.
pub fn sphere(radius_m: f32, around: u32) -> Mesh {
    let place = |u: f32, v: f32| {
        let ((sin_u, cos_u), (sin_v, cos_v)) = ((TAU * wrapped(u)).sin_cos(), (PI * v).sin_cos());
        let sin_v = if v == 0.0 || v == 1.0 { 0.0 } else { sin_v };
        radius_m * vec3(sin_u * sin_v, cos_v, cos_u * sin_v)
    };
    rename(smooth_seams(sheet(around.max(3), (around / 2).max(2), WHOLE, place)), "sphere")
}

/// A torus about the y axis: a ring of `ring_m` made of a tube of `tube_m` (m). Closed.
pub fn torus(ring_m: f32, tube_m: f32, around: u32) -> Mesh {
    let place = |u: f32, v: f32| {
        let ((sin_u, cos_u), (sin_v, cos_v)) = ((TAU * wrapped(u)).sin_cos(), (TAU * wrapped(v)).sin_cos());
        let far = ring_m + tube_m * sin_v;
        vec3(far * sin_u, tube_m * cos_v, far * cos_u)
    };
    rename(smooth_seams(sheet(around.max(3), around.max(3), WHOLE, place)), "torus")
}

/// Both ends of a circle are one place, to the bit.
pub(super) fn wrapped(u: f32) -> f32 {
    if u == 1.0 {
        0.0
    } else {
        u
    }
}

/// A capsule from `from_m` to `to_m` (m). Closed.
pub fn capsule(from_m: Vec3, to_m: Vec3, radius_m: f32, around: u32) -> Mesh {
    rename(capsule_on(from_m, to_m, radius_m, radius_m, around, WHOLE), "capsule")
}

fn capsule_on(
    from_m: Vec3,
    to_m: Vec3,
    from_radius_m: f32,
    to_radius_m: f32,
    around: u32,
    patch: Patch,
) -> Mesh {
    let axis = (from_m - to_m).normalize_or(Vec3::Y);
    let side = axis.any_orthonormal_vector();
    let other = axis.cross(side);
    let along = (around / 2).max(4) / 2 * 2;
    let place = |u: f32, v: f32| {
        let ((sin_u, cos_u), (sin_v, cos_v)) = ((TAU * wrapped(u)).sin_cos(), (PI * v).sin_cos());
        let sin_v = if v == 0.0 || v == 1.0 { 0.0 } else { sin_v };
        let (centre, radius_m) = if v <= 0.5 { (from_m, from_radius_m) } else { (to_m, to_radius_m) };
        centre + radius_m * (axis * cos_v + (side * cos_u + other * sin_u) * sin_v)
    };
    // A row twice at the middle: the straight part between the two halves of a sphere.
    let rows = along + 1;
    let row = |v: f32| {
        let j = (v * rows as f32).round();
        if j <= along as f32 / 2.0 {
            j / along as f32
        } else {
            ((j - 1.0) / along as f32).max(0.5 + 1e-6)
        }
    };
    smooth_seams(sheet(around.max(3), rows, patch, |u, v| place(u, row(v))))
}

/// A heightmap of `cells` samples, row by row, over `size_m` round the origin (m). Open.
pub fn terrain(cells: [u32; 2], size_m: Vec2, height_m: &[f32]) -> Mesh {
    let [w, h] = cells;
    assert!(
        w > 1 && h > 1 && height_m.len() == (w * h) as usize,
        "{cells:?} samples, {} heights",
        height_m.len()
    );
    let place = |u: f32, v: f32| {
        let (i, j) = ((u * (w - 1) as f32).round() as u32, (v * (h - 1) as f32).round() as u32);
        vec3((u - 0.5) * size_m.x, height_m[(j * w + i) as usize], (v - 0.5) * size_m.y)
    };
    rename(sheet(w - 1, h - 1, WHOLE, place), "terrain")
}

pub(super) fn rename(mut mesh: Mesh, name: &str) -> Mesh {
    mesh.name = name.into();
    mesh
}

/// Parts that share one joint that never moves.
pub(super) fn one_joint(mut mesh: Mesh) -> Mesh {
    mesh.rig = Rig::still();
    mesh.hold = vec![Hold::on(0); mesh.at_m.len()];
    mesh
}

/// Joints along the spine of [`lizard`].
const SPINE: usize = 10;
/// Keys a period, of motions that are sines.
const KEYS: usize = 24;

/// A lizard of `length_m` (m) that walks on the spot along +x, its back at a height of a fifth of its length: a skinned
/// body whose spine swings from side to side, and four legs of two joints. One period a second.
pub fn lizard(length_m: f32) -> Mesh {
    // Half width and half height along the body, of its length: nose, head, neck, trunk, hips, tail.
    let profile: [(f32, f32, f32); 9] = [
        (0.00, 0.004, 0.004),
        (0.05, 0.034, 0.026),
        (0.12, 0.045, 0.032),
        (0.19, 0.030, 0.028),
        (0.30, 0.058, 0.045),
        (0.42, 0.060, 0.047),
        (0.54, 0.042, 0.036),
        (0.74, 0.020, 0.018),
        (1.00, 0.002, 0.002),
    ];
    let thick = |s: f32| {
        let next = profile.iter().position(|p| p.0 >= s).unwrap_or(profile.len() - 1).max(1);
        let (a, b) = (profile[next - 1], profile[next]);
        let t = ((s - a.0) / (b.0 - a.0)).clamp(0.0, 1.0);
        let t = t * t * (3.0 - 2.0 * t);
        vec2(a.1 + (b.1 - a.1) * t, a.2 + (b.2 - a.2) * t)
    };
    const BACK: f32 = 0.13;
    let spine_at = |s: f32| vec3(0.5 - s, BACK, 0.0);
    let body_patch = Patch { corner: vec2(0.005, 0.005), size: vec2(0.59, 0.99) };
    let place = |u: f32, v: f32| {
        let (sin, cos) = (TAU * wrapped(u)).sin_cos();
        let half = thick(v) * if v == 0.0 || v == 1.0 { 0.0 } else { 1.0 };
        length_m * (spine_at(v) + vec3(0.0, half.y * cos, half.x * sin))
    };
    let mut body = smooth_seams(sheet(24, 64, body_patch, place));

    // The spine hangs on its middle, so that the body swings about it.
    let joint_s = |k: usize| k as f32 / (SPINE - 1) as f32;
    let mut rig = Rig { nodes: Vec::new(), joints: Vec::new(), tracks: Vec::new(), period_s: 1.0 };
    let at = |s: f32| length_m * spine_at(s);
    let rests = |rig: &mut Rig, parent: Option<usize>, at_m: Vec3, from_m: Vec3| {
        rig.nodes.push(Node { move_m: at_m - from_m, ..Node::at_parent(parent) });
        rig.joints.push(Joint { node: rig.nodes.len() - 1, node_from_rest: Mat4::from_translation(-at_m) });
        rig.nodes.len() - 1
    };
    let middle = SPINE * 2 / 5;
    let mut spine = [0; SPINE];
    spine[middle] = rests(&mut rig, None, at(joint_s(middle)), Vec3::ZERO);
    for k in (0..middle).rev() {
        spine[k] = rests(&mut rig, Some(spine[k + 1]), at(joint_s(k)), at(joint_s(k + 1)));
    }
    for k in middle + 1..SPINE {
        spine[k] = rests(&mut rig, Some(spine[k - 1]), at(joint_s(k)), at(joint_s(k - 1)));
    }
    for (k, &node) in spine.iter().enumerate() {
        let s = joint_s(k);
        let swing = 0.10 + 0.22 * (s - 0.4).abs();
        // A wave runs down the body from head to tail.
        rig.tracks.push(swinging(node, Vec3::Y, swing, 0.0, s));
    }
    body.hold = body
        .at_m
        .iter()
        .map(|v| between_joints((0.5 - v.x / length_m) * (SPINE - 1) as f32, &spine))
        .collect();
    body.rig = rig;

    // Legs: a hip that swings forth and back, and a foot that it carries.
    let mut lizard = body;
    for leg in 0..4 {
        let (is_front, side) = (leg < 2, if leg % 2 == 0 { 1.0 } else { -1.0 });
        let s = if is_front { 0.27 } else { 0.50 };
        let hip = at(s) + length_m * vec3(0.0, -0.01, 0.045 * side);
        let knee = hip + length_m * vec3(if is_front { -0.03 } else { 0.03 }, 0.015, 0.10 * side);
        let foot = vec3(knee.x + length_m * 0.02, length_m * 0.012, knee.z + length_m * 0.035 * side);
        let patch = |i: usize| {
            let own = Patch::of(i, 2, 4);
            Patch {
                corner: vec2(0.605 + 0.39 * own.corner.x, own.corner.y),
                size: vec2(0.39, 1.0) * own.size,
            }
        };
        let thigh = capsule_on(hip, knee, 0.022 * length_m, 0.015 * length_m, 12, patch(2 * leg));
        let shin = capsule_on(knee, foot, 0.015 * length_m, 0.012 * length_m, 12, patch(2 * leg + 1));
        let carrier = spine[(s * (SPINE - 1) as f32).round() as usize];
        let rig = &mut lizard.rig;
        let carrier_at = at(joint_s((s * (SPINE - 1) as f32).round() as usize));
        let phase = if is_front == (leg % 2 == 0) { 0.0 } else { 0.5 };
        let hip_node = rests(rig, Some(carrier), hip, carrier_at);
        rig.tracks.push(swinging(hip_node, Vec3::Y, 0.55 * side, 0.0, phase));
        let (hip_joint, knee_node) = (rig.joints.len() as u16 - 1, rests(rig, Some(hip_node), knee, hip));
        rig.tracks.push(swinging(knee_node, Vec3::X, 0.35 * side, -0.35 * side, phase + 0.25));
        let knee_joint = rig.joints.len() as u16 - 1;
        let rig = lizard.rig.clone();
        let first = lizard.hold.len();
        let thigh_ends = first + thigh.at_m.len();
        lizard = lizard.with(&thigh).with(&shin);
        lizard.rig = rig;
        for (i, hold) in lizard.hold.iter_mut().enumerate().skip(first) {
            *hold = Hold::on(if i < thigh_ends { hip_joint } else { knee_joint });
        }
    }
    rename(lizard, "lizard")
}

/// A turn about `axis` by a sine of `swing` about `rest` (radians), `phase` parts of a period late.
fn swinging(node: usize, axis: Vec3, swing: f32, rest: f32, phase: f32) -> Track {
    let times: Vec<f32> = (0..=KEYS).map(|i| i as f32 / KEYS as f32).collect();
    let angle = |t: f32| rest + swing * (TAU * (t - phase)).sin();
    let keys =
        times.iter().map(|&t| Quat::from_axis_angle(axis, angle(if t == 1.0 { 0.0 } else { t }))).collect();
    Track { node, time_s: times, value: Value::Turn(keys), curve: Curve::Linear }
}

/// A place along the spine, in joints from its head, shared by the two joints round it.
fn between_joints(place: f32, spine: &[usize; SPINE]) -> Hold {
    let place = place.clamp(0.0, (SPINE - 1) as f32);
    let (from, t) = (place.floor() as usize, place.fract());
    let to = (from + 1).min(SPINE - 1);
    Hold { joints: [spine[from] as u16, spine[to] as u16, 0, 0], weights: [1.0 - t, t, 0.0, 0.0] }
}
