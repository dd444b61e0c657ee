// SPDX-License-Identifier: MIT OR Apache-2.0
//! Draws meshes that `mesh.pose` has placed: sun with shadow, sky, lamp, either side, and paint over it where there is some:
//! `glsl/draw/mesh*`. Vertices are pulled by the number of their triangle.

use super::{shadow::Shadow, Stage};
use crate::{
    gpu::{
        Access, Attachments, Blend, Bound, Buffer, Depth, Gpu, Raster, RasterInfo, Recorder, Resource,
        Result, Topology,
    },
    mesh::Meshes,
    shaders,
};
use glam::{Vec3, Vec4};

/// Push constants: `MeshParams` in `glsl/draw/mesh_params.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct MeshParams {
    /// Linear albedo; w: how much of the sun is mirrored.
    pub color: Vec4,
    /// Of all meshes.
    pub first_triangle: u32,
    /// Of all meshes.
    pub first_joint: u32,
    /// Edge of the tiles of a checkered floor (m); 0: plain.
    pub tile_m: f32,
    /// Unused.
    pub reserved: u32,
    /// Where its paint map is: `Map` in `glsl/paint/map.glsl`.
    pub map: [u32; 4],
}

/// What a mesh looks like.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Linear albedo.
    pub color: Vec3,
    /// How much of the sun is mirrored.
    pub mirrors: f32,
    /// Edge of the tiles of a checkered floor (m); 0: plain.
    pub tile_m: f32,
    /// Where its paint map is, if it takes paint.
    pub map: Option<[u32; 4]>,
}

/// A mesh to draw: its numbers, how many vertices, whether it is painted.
type Part = (MeshParams, u32, bool);

/// Pipelines for the meshes of a scene: into the picture, and into the map of shadows.
pub struct MeshesDraw {
    plain: Bound,
    painted: Option<Bound>,
    cast: Bound,
    parts: Vec<Part>,
}

impl MeshesDraw {
    /// What places and paint must be visible to before [`MeshesDraw::record`] and [`MeshesDraw::record_shadow`].
    pub const ENTRY: Access = Access::GraphicsRead;

    /// `looks`: one a mesh. `paint`: of those that have a map, and how a texel of it is stored (`glsl/paint/texel.glsl`).
    ///
    /// # Errors
    /// If the device cannot draw.
    ///
    /// # Panics
    /// If there are not as many looks as meshes, or a mesh has a map and there is no paint.
    pub fn new(
        gpu: &Gpu,
        stage: &Stage,
        shadow: &Shadow,
        meshes: &Meshes,
        looks: &[Look],
        paint: Option<(&Buffer, u32)>,
    ) -> Result<Self> {
        assert_eq!(looks.len(), meshes.parts().len(), "a look for each mesh");
        assert!(paint.is_some() || looks.iter().all(|look| look.map.is_none()), "a map without paint");
        let [shadows, shadow_depth] = shadow.resources();
        let (triangles, places) =
            (("Triangles", meshes.triangles().into()), ("Places", meshes.places().into()));
        let mut used: Vec<(&str, Resource<'_>)> = vec![
            ("Views", stage.views().into()),
            shadows,
            shadow_depth,
            triangles,
            places,
            ("Rest", meshes.rest().into()),
            ("Matrices", meshes.matrices().into()),
        ];
        let draw = RasterInfo {
            name: c"draw.mesh",
            vertex: shaders::DRAW_MESH_VERT,
            geometry: None,
            fragment: shaders::DRAW_MESH_FRAG,
            blocks: &["Views", "Shadows", "ShadowDepth", "Triangles", "Places", "Rest", "Matrices"],
            constants: &[],
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
            samples: 1,
            ..draw
        };
        let raster = |info: &RasterInfo<'_>| Raster::new::<MeshParams>(gpu, info);
        let cast = Raster::onto::<MeshParams>(gpu, &cast, Attachments::Depth)?.bind(&[
            ("Shadows", shadow.views().into()),
            triangles,
            places,
        ])?;
        let plain = raster(&draw)?.bind(&used)?;
        let painted = match paint.filter(|_| looks.iter().any(|look| look.map.is_some())) {
            Some((paint, format)) => {
                used.push(("Paint", paint.into()));
                let blocks: Vec<&str> = used.iter().map(|(name, _)| *name).collect();
                let painted = RasterInfo {
                    name: c"draw.mesh_painted",
                    fragment: shaders::DRAW_MESH_PAINTED_FRAG,
                    blocks: &blocks,
                    constants: &[format],
                    ..draw
                };
                Some(raster(&painted)?.bind(&used)?)
            }
            None => None,
        };
        let part = |(look, part): (&Look, &crate::mesh::Part)| {
            let params = MeshParams {
                color: look.color.extend(look.mirrors),
                first_triangle: part.triangles.start,
                first_joint: part.joints.start,
                tile_m: look.tile_m,
                reserved: 0,
                map: look.map.unwrap_or_default(),
            };
            (params, 3 * part.triangles.len() as u32, look.map.is_some())
        };
        let parts = looks.iter().zip(meshes.parts()).map(part).collect();
        Ok(Self { plain, painted, cast, parts })
    }

    /// Draws all meshes, inside [`Stage::record`].
    pub fn record(&self, rec: &mut Recorder<'_>) {
        for (params, vertices, is_painted) in &self.parts {
            let bound = self.painted.as_ref().filter(|_| *is_painted).unwrap_or(&self.plain);
            rec.draw(bound, *vertices, 1, params);
        }
    }

    /// Draws their depth, inside [`Shadow::record`].
    pub fn record_shadow(&self, rec: &mut Recorder<'_>) {
        for (params, vertices, _) in &self.parts {
            rec.draw(&self.cast, *vertices, 1, params);
        }
    }
}
