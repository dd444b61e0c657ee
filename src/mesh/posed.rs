// SPDX-License-Identifier: MIT OR Apache-2.0
//! A mesh on the GPU, posed in the world. Reads `glsl/mesh/pose.comp`.

use super::Mesh;
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};
use glam::Mat4;

/// Words of a vertex at rest: place, normal, texture coordinates, joints, weights.
pub const VERTEX_WORDS: usize = 13;

/// Push constants: `PoseParams` in `glsl/mesh/pose.comp`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct PoseParams {
    /// Vertices of the mesh.
    pub vertices: u32,
    /// Joints of the mesh; of matrices there are three times as many.
    pub joints: u32,
    /// What turns the difference of the second and the third pose into a velocity (1/s).
    pub rate_per_s: f32,
    /// First vertex of the mesh, where several share the buffers.
    pub first_vertex: u32,
    /// Its first joint.
    pub first_joint: u32,
}

/// The kernel. It holds no mesh, so it poses any number of them.
pub struct Pose {
    pose: Kernel,
    gpu: Gpu,
}

impl Pose {
    /// What the matrices must be visible to before [`Posed::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Posed::record`] touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// The device's.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let info = KernelInfo {
            name: c"mesh.pose",
            spv: shaders::MESH_POSE_COMP,
            blocks: &["Rest", "Matrices", "Places"],
            constants: &[],
        };
        Ok(Self { pose: Kernel::new::<PoseParams>(gpu, &info)?, gpu: gpu.clone() })
    }

    /// `mesh` on the device, not posed yet.
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    pub fn mesh(&self, mesh: &Mesh) -> Result<Posed> {
        let gpu = &self.gpu;
        let words = at_rest(mesh);
        let device = |name: &str, bytes: usize| Buffer::new(gpu, name, bytes as u64, Residence::Device);
        let rest = device("mesh.rest", 4 * words.len())?;
        gpu.upload_to(&rest, &words)?;
        let triangles = device("mesh.triangles", 12 * mesh.triangles.len())?;
        gpu.upload_to(&triangles, &mesh.triangles)?;
        let joints = mesh.rig.joints.len();
        let matrices = device("mesh.matrices", 3 * 48 * joints)?;
        let places = device("mesh.places", 24 * mesh.at_m.len())?;
        let bound = self.bind(&rest, &matrices, &places)?;
        Ok(Posed { rest, triangles, matrices, places, bound, mesh: mesh.clone() })
    }

    pub(super) fn bind(&self, rest: &Buffer, matrices: &Buffer, places: &Buffer) -> Result<Bound> {
        self.pose.bind(&[("Rest", rest.into()), ("Matrices", matrices.into()), ("Places", places.into())])
    }
}

/// [`VERTEX_WORDS`] for each vertex.
pub(super) fn at_rest(mesh: &Mesh) -> Vec<f32> {
    let mut words: Vec<f32> = Vec::with_capacity(VERTEX_WORDS * mesh.at_m.len());
    for (i, hold) in mesh.hold.iter().enumerate() {
        let [a, b, c, d] = hold.joints.map(u32::from);
        words.extend(mesh.at_m[i].to_array());
        words.extend(mesh.normals[i].to_array());
        words.extend(mesh.uv.get(i).copied().unwrap_or_default().to_array());
        words.extend([a | b << 16, c | d << 16].map(f32::from_bits));
        words.extend(&hold.weights[..3]); // the last is what is left to 1
    }
    words
}

/// A mesh on the device.
pub struct Posed {
    rest: Buffer,
    triangles: Buffer,
    matrices: Buffer,
    places: Buffer,
    bound: Bound,
    mesh: Mesh,
}

impl Posed {
    /// Poses the mesh as it is at `time_s`, placed by `world`, with the velocities of the step of `dt_s` before; `world` one
    /// step before is `world_before`.
    pub fn record(&self, rec: &mut Recorder<'_>, time_s: f64, dt_s: f64, world: Mat4, world_before: Mat4) {
        let (matrices, rate_per_s) = self.matrices_at(time_s, dt_s, world, world_before);
        rec.barrier(Access::ComputeRead, Access::FillWrite);
        rec.update(&self.matrices, &matrices);
        rec.barrier(Access::FillWrite, Access::ComputeRead);
        let vertices = self.mesh.at_m.len() as u32;
        let joints = self.mesh.rig.joints.len() as u32;
        let params = PoseParams { vertices, joints, rate_per_s, first_vertex: 0, first_joint: 0 };
        rec.span(c"mesh.pose", |rec| rec.dispatch(&self.bound, [vertices, 1, 1], &params));
    }

    /// Three matrices of three rows a joint (now, and the two whose difference is the velocity), and what turns that
    /// difference into a velocity (1/s).
    pub fn matrices_at(
        &self,
        time_s: f64,
        dt_s: f64,
        world: Mat4,
        world_before: Mat4,
    ) -> (Vec<[f32; 12]>, f32) {
        self.mesh.rig.matrices_at(time_s, dt_s, world, world_before)
    }

    /// For each vertex place (m) and velocity (m/s), six `f32`.
    pub fn places(&self) -> &Buffer {
        &self.places
    }

    /// For each vertex [`VERTEX_WORDS`] words: place, normal, texture coordinates, two joints a word, weights.
    pub fn rest(&self) -> &Buffer {
        &self.rest
    }

    /// Three corners a triangle, `u32`.
    pub fn triangles(&self) -> &Buffer {
        &self.triangles
    }

    /// What is posed.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }
}
