// SPDX-License-Identifier: MIT OR Apache-2.0
//! All meshes of a scene on the GPU, in shared buffers: one list of vertices, one of triangles.

use super::{posed::at_rest, Mesh, MeshError, Pose, PoseParams};
use crate::gpu::{self, Access, Bound, Buffer, Gpu, Recorder, Residence};
use glam::{Mat4, Vec2};
use std::ops::Range;

/// Most triangles of all meshes, and most vertices: what a key of 32 bits has room for beside 8 bits of distance.
const MOST_OF_ALL: usize = (1 << 24) - 1;

/// A mesh in its place.
#[derive(Clone, Debug)]
pub struct Body {
    /// Triangles.
    pub mesh: Mesh,
    /// From the mesh to the world.
    pub world: Mat4,
    /// Whether it is somewhere else, or another shape, from step to step. Others are posed once.
    pub moves: bool,
}

/// Where a mesh is in the shared buffers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its vertices.
    pub vertices: Range<u32>,
    /// Its triangles.
    pub triangles: Range<u32>,
    /// Its joints.
    pub joints: Range<u32>,
    /// Whether it is posed in every step.
    pub moves: bool,
}

/// What can go wrong with the meshes of a scene.
#[derive(Debug, thiserror::Error)]
pub enum MeshesError {
    /// A mesh that cannot be used, or too many of them.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The device's.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
}

/// Meshes one behind the other, in the order of the scene. A triangle is known by its place in that list.
pub struct Meshes {
    bodies: Vec<Body>,
    parts: Vec<Part>,
    places: Buffer,
    triangles: Buffer,
    uvs: Buffer,
    rest: Buffer,
    matrices: Buffer,
    bound: Bound,
}

impl Meshes {
    /// What [`Meshes::record`] waits for: reads of places by compute and by graphics.
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Meshes::record`] touched the places last.
    pub const EXIT: Access = Access::ComputeWrite;

    /// Poses those that do not move. Submits, and waits.
    ///
    /// # Errors
    /// [`Mesh::check`]'s, by name of the mesh; too many triangles or vertices; the device's.
    pub fn new(gpu: &Gpu, bodies: &[Body]) -> Result<Self, MeshesError> {
        let (mut rest, mut corners, mut uvs, mut parts) =
            (Vec::new(), Vec::<[u32; 3]>::new(), Vec::<Vec2>::new(), Vec::<Part>::new());
        let mut joints = 0;
        for body in bodies {
            let mesh = &body.mesh;
            mesh.check()?;
            let (vertex, triangle) = (uvs.len(), corners.len());
            if vertex + mesh.at_m.len() > MOST_OF_ALL || triangle + mesh.triangles.len() > MOST_OF_ALL {
                let what =
                    format!("with it the meshes have more than {MOST_OF_ALL} vertices or triangles in all");
                return Err(MeshError { name: mesh.name.clone(), what }.into());
            }
            let count = mesh.rig.joints.len() as u32;
            let to = |first: usize, count: usize| first as u32..(first + count) as u32;
            parts.push(Part {
                vertices: to(vertex, mesh.at_m.len()),
                triangles: to(triangle, mesh.triangles.len()),
                joints: joints..joints + count,
                moves: body.moves,
            });
            joints += count;
            rest.extend(at_rest(mesh));
            corners.extend(mesh.triangles.iter().map(|it| it.map(|corner| corner + vertex as u32)));
            uvs.extend(&mesh.uv);
            uvs.resize(vertex + mesh.at_m.len(), Vec2::ZERO);
        }
        if parts.is_empty() {
            return Err(MeshError { name: "meshes".into(), what: "none; allowed: 1 or more".into() }.into());
        }
        let rest = gpu.upload("meshes.rest", &rest)?;
        let triangles = gpu.upload("meshes.triangles", &corners)?;
        let uvs: Vec<[f32; 2]> = uvs.iter().map(|uv| uv.to_array()).collect();
        let matrices = Buffer::new(gpu, "meshes.matrices", 3 * 48 * u64::from(joints), Residence::Device)?;
        let places = Buffer::new(gpu, "meshes.places", 24 * uvs.len() as u64, Residence::Device)?;
        let uvs = gpu.upload("meshes.uvs", &uvs)?;
        let bound = Pose::new(gpu)?.bind(&rest, &matrices, &places)?;
        let meshes = Self { bodies: bodies.to_vec(), parts, places, triangles, uvs, rest, matrices, bound };
        gpu.once(|rec| {
            meshes.pose(rec, false, 0.0, 0.0, &[]);
            for reader in [Access::ComputeReadWrite, Access::GraphicsRead] {
                rec.barrier(Self::EXIT, reader);
            }
        })?;
        Ok(meshes)
    }

    /// Poses those that move, as they are at `time_s`, with the velocities of the step of `dt_s` before. `worlds` has for each
    /// mesh of the scene where it is now, and where it was a step before; empty, if all stay where they were put.
    ///
    /// # Panics
    /// If `worlds` is neither empty nor one for each mesh.
    pub fn record(&self, rec: &mut Recorder<'_>, time_s: f64, dt_s: f64, worlds: &[[Mat4; 2]]) {
        self.pose(rec, true, time_s, dt_s, worlds);
    }

    fn pose(&self, rec: &mut Recorder<'_>, moving: bool, time_s: f64, dt_s: f64, worlds: &[[Mat4; 2]]) {
        assert!(worlds.is_empty() || worlds.len() == self.bodies.len(), "{} places of meshes", worlds.len());
        if self.parts.iter().all(|part| part.moves != moving) {
            return;
        }
        let mut rates = Vec::new();
        let mut rows = Vec::new();
        for (i, body) in self.bodies.iter().enumerate() {
            let [world, before] = worlds.get(i).copied().unwrap_or([body.world; 2]);
            // The others' are not read: they are there because the whole buffer is written.
            let (own, rate_per_s) = body.mesh.rig.matrices_at(time_s, dt_s, world, before);
            rates.push(if moving { rate_per_s } else { 0.0 });
            rows.extend(own);
        }
        rec.barrier(Access::ComputeRead, Access::FillWrite);
        rec.update(&self.matrices, &rows);
        rec.barrier(Access::FillWrite, Access::ComputeRead);
        rec.span(c"mesh.pose", |rec| {
            for (part, rate_per_s) in self.parts.iter().zip(rates).filter(|(part, _)| part.moves == moving) {
                let params = PoseParams {
                    vertices: part.vertices.len() as u32,
                    joints: part.joints.len() as u32,
                    rate_per_s,
                    first_vertex: part.vertices.start,
                    first_joint: part.joints.start,
                };
                rec.dispatch(&self.bound, [params.vertices, 1, 1], &params);
            }
        });
    }

    /// For each vertex place (m) and velocity (m/s), six `f32`: `Places`.
    pub fn places(&self) -> &Buffer {
        &self.places
    }

    /// For each triangle three vertices of all: `Triangles`.
    pub fn triangles(&self) -> &Buffer {
        &self.triangles
    }

    /// For each vertex texture coordinates, two `f32`: `Uvs`; zero where a mesh has none.
    pub fn uvs(&self) -> &Buffer {
        &self.uvs
    }

    /// For each vertex [`VERTEX_WORDS`](super::VERTEX_WORDS) words: `Rest`.
    pub fn rest(&self) -> &Buffer {
        &self.rest
    }

    /// For each mesh three poses of three rows of four a joint, the first of which is now: `Matrices`.
    pub fn matrices(&self) -> &Buffer {
        &self.matrices
    }

    /// Where each mesh is in the buffers.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The meshes, in the order of the scene.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Triangles of all meshes.
    pub fn count(&self) -> u32 {
        self.parts.last().map_or(0, |part| part.triangles.end)
    }

    /// Triangles of the meshes that move, or of those that do not, in as few runs as there are.
    pub fn runs(&self, moving: bool) -> Vec<Range<u32>> {
        let mut runs: Vec<Range<u32>> = Vec::new();
        for part in self.parts.iter().filter(|part| part.moves == moving) {
            match runs.last_mut() {
                Some(last) if last.end == part.triangles.start => last.end = part.triangles.end,
                _ => runs.push(part.triangles.clone()),
            }
        }
        runs
    }
}
