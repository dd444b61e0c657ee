// SPDX-License-Identifier: MIT OR Apache-2.0
//! Draws meshes that `mesh.pose` has placed: sun with shadow, sky, lamp, either side, and paint over it where there is some:
//! `glsl/draw/mesh*`. Vertices are pulled by the number of their triangle.

use super::{shadow::Shadow, Stage};
use crate::{
    gpu::{Access, Blend, Bound, Buffer, Depth, Gpu, Raster, RasterInfo, Recorder, Resource, Result, Topology},
    shaders,
};
use glam::Vec4;

/// Push constants: `MeshParams` in `glsl/draw/mesh.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct MeshParams {
    /// Linear albedo; w: how much of the sun is mirrored.
    pub color: Vec4,
    /// In the list.
    pub first_triangle: u32,
    /// Of the mesh among the places.
    pub first_vertex: u32,
    /// Edge of the tiles of a checkered floor (m); 0: plain.
    pub tile_m: f32,
    /// Unused.
    pub reserved: u32,
    /// Where its paint map is: `Map` in `glsl/paint/map.glsl`.
    pub map: [u32; 4],
}

/// Where a mesh is on the device.
#[derive(Clone, Copy)]
pub struct MeshBuffers<'a> {
    /// Three numbers of vertices a triangle, from the first of `places` on.
    pub triangles: &'a Buffer,
    /// `mesh.pose` writes them: six `f32` a vertex.
    pub places: &'a Buffer,
    /// [`VERTEX_WORDS`](crate::mesh::VERTEX_WORDS) words a vertex of this mesh.
    pub rest: &'a Buffer,
    /// Of its joints.
    pub matrices: &'a Buffer,
    /// Its paint, if it takes any, and how a texel of it is stored (`glsl/paint/texel.glsl`).
    pub paint: Option<(&'a Buffer, u32)>,
    /// How many.
    pub count: u32,
}

/// Two pipelines for one mesh: into the picture, and into the map of shadows.
pub struct MeshDraw {
    draw: Bound,
    cast: Bound,
    params: MeshParams,
    vertices: u32,
}

impl MeshDraw {
    /// What the mesh must be visible to before [`MeshDraw::record`] and [`MeshDraw::record_shadow`].
    pub const ENTRY: Access = Access::GraphicsRead;

    /// # Errors
    /// If the device cannot draw.
    pub fn new(
        gpu: &Gpu,
        stage: &Stage,
        shadow: &Shadow,
        mesh: &MeshBuffers<'_>,
        params: MeshParams,
    ) -> Result<Self> {
        let [shadows, shadow_depth] = shadow.resources();
        let mut used: Vec<(&str, Resource<'_>)> = vec![
            ("Views", stage.views().into()),
            shadows,
            shadow_depth,
            ("Triangles", mesh.triangles.into()),
            ("Places", mesh.places.into()),
            ("Rest", mesh.rest.into()),
            ("Matrices", mesh.matrices.into()),
        ];
        used.extend(mesh.paint.map(|(paint, _)| ("Paint", paint.into())));
        let format: Vec<u32> = mesh.paint.iter().map(|(_, format)| *format).collect();
        let blocks: Vec<&str> = used.iter().map(|(name, _)| *name).collect();
        let draw = RasterInfo {
            name: c"draw.mesh",
            vertex: shaders::DRAW_MESH_VERT,
            geometry: None,
            fragment: match mesh.paint {
                Some(_) => shaders::DRAW_MESH_PAINTED_FRAG,
                None => shaders::DRAW_MESH_FRAG,
            },
            blocks: &blocks,
            constants: &format,
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            depth: Depth::Write,
            samples: stage.samples(),
        };
        let cast = RasterInfo {
            name: c"draw.mesh_shadow",
            vertex: shaders::DRAW_MESH_SHADOW_VERT,
            fragment: shaders::DRAW_SHADOW_FRAG,
            blocks: &["Shadows", "Triangles", "Places"],
            constants: &[],
            samples: 1,
            ..draw
        };
        let cast = Raster::new::<MeshParams>(gpu, &cast)?.bind(&[
            ("Shadows", shadow.views().into()),
            ("Triangles", mesh.triangles.into()),
            ("Places", mesh.places.into()),
        ])?;
        let draw = Raster::new::<MeshParams>(gpu, &draw)?.bind(&used)?;
        Ok(Self { draw, cast, params, vertices: 3 * mesh.count })
    }

    /// Draws the mesh, inside [`Stage::record`].
    pub fn record(&self, rec: &mut Recorder<'_>) {
        rec.draw(&self.draw, self.vertices, 1, &self.params);
    }

    /// Draws its depth, inside [`Shadow::record`].
    pub fn record_shadow(&self, rec: &mut Recorder<'_>) {
        rec.draw(&self.cast, self.vertices, 1, &self.params);
    }
}
