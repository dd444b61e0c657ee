// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twins of `glsl/impact`.

use super::{Count, Impact};
use glam::{vec3, Vec2, Vec3};

/// Twin of `glsl/impact/close.comp`.
pub fn close(count: &mut Count) {
    let stored = count.appended.min(count.capacity);
    let dropped = count.dropped() + u64::from(count.appended - stored);
    let all = count.stored() + u64::from(stored);
    let groups = stored.div_ceil(64);
    let rows = groups.div_ceil(65_535).max(1);
    *count = Count {
        count: stored,
        capacity: count.capacity,
        dropped_low: dropped as u32,
        dropped_high: (dropped >> 32) as u32,
        groups_x: groups.div_ceil(rows),
        groups_y: rows,
        groups_z: 1,
        appended: 0,
        quad_vertices: stored.wrapping_mul(6), // buffers of more than 2^32 / 6 impacts there are none
        quad_instances: 1,
        quad_first_vertex: 0,
        quad_first_instance: 0,
        stored_low: all as u32,
        stored_high: (all >> 32) as u32,
    };
}

/// Triangles of all meshes: [`Surfaces`](super::Surfaces) on the host.
#[derive(Clone, Copy, Debug)]
pub struct Surfaces<'a> {
    /// A place a vertex (m).
    pub places: &'a [Vec3],
    /// Three vertices a triangle.
    pub triangles: &'a [[u32; 3]],
    /// Texture coordinates a vertex.
    pub uvs: &'a [Vec2],
    /// Of each mesh, then of all.
    pub first_triangle: &'a [u32],
}

/// Twin of `glsl/impact/locate.comp`, of one impact.
pub fn locate(on: &Surfaces<'_>, impact: &mut Impact) {
    let meshes = on.first_triangle.len() - 1;
    if impact.triangle == 0 || impact.triangle > on.first_triangle[meshes] {
        return;
    }
    let triangle = impact.triangle - 1;
    let corners = on.triangles[triangle as usize].map(|i| i as usize);
    let [a, b, c] = corners.map(|i| on.places[i]);
    let weights = nearest_weights(impact.at_m, a, b, c);
    let [one, two, three] = corners.map(|i| on.uvs[i]);
    let uv = (one * weights.x + two * weights.y) + three * weights.z;
    (impact.u, impact.v) = (uv.x, uv.y);
    impact.mesh = (on.first_triangle[..meshes].partition_point(|first| *first <= triangle) - 1) as u32;
}

/// Twin of `nearest_weights` in `glsl/impact/nearest.glsl`: how much each corner has in the point of a triangle that is
/// nearest to `at`.
pub fn nearest_weights(at: Vec3, a: Vec3, b: Vec3, c: Vec3) -> Vec3 {
    let dot = |a: Vec3, b: Vec3| (a.x * b.x + a.y * b.y) + a.z * b.z;
    let (ab, ac, ap, bp, cp) = (b - a, c - a, at - a, at - b, at - c);
    let (d1, d2) = (dot(ab, ap), dot(ac, ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return vec3(1.0, 0.0, 0.0);
    }
    let (d3, d4) = (dot(ab, bp), dot(ac, bp));
    if d3 >= 0.0 && d4 <= d3 {
        return vec3(0.0, 1.0, 0.0);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let w = d1 / (d1 - d3);
        return vec3(1.0 - w, w, 0.0);
    }
    let (d5, d6) = (dot(ab, cp), dot(ac, cp));
    if d6 >= 0.0 && d5 <= d6 {
        return vec3(0.0, 0.0, 1.0);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = d2 / (d2 - d6);
        return vec3(1.0 - w, 0.0, w);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return vec3(0.0, 1.0 - w, w);
    }
    let sum = (va + vb) + vc;
    let (v, w) = (vb / sum, vc / sum);
    vec3((1.0 - v) - w, v, w)
}
