// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twin of `glsl/mesh/pose.comp`.

use super::Mesh;
use glam::{Mat4, Vec3};

/// Where the vertices are (m) and how they move (m/s), of the joints now and of two poses whose difference by `rate_per_s`
/// is the velocity.
pub fn pose(mesh: &Mesh, now: &[Mat4], from: &[Mat4], to: &[Mat4], rate_per_s: f32) -> Vec<(Vec3, Vec3)> {
    let at = |joints: &[Mat4], i: usize| -> Vec3 {
        let (hold, weights) = (&mesh.hold[i], mesh.hold[i].stored());
        (0..4).fold(Vec3::ZERO, |sum, k| {
            let matrix = joints[usize::from(hold.joints[k])];
            sum + placed(&matrix, mesh.at_m[i]) * weights[k]
        })
    };
    (0..mesh.at_m.len()).map(|i| (at(now, i), (at(to, i) - at(from, i)) * rate_per_s)).collect()
}

/// In the order of the shader, so that both round alike.
fn placed(matrix: &Mat4, at: Vec3) -> Vec3 {
    let [x, y, z, w] = [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis].map(|c| c.truncate());
    ((x * at.x + y * at.y) + z * at.z) + w
}
