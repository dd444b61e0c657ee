// SPDX-License-Identifier: MIT OR Apache-2.0
//! Draws a surface from the buffer that the simulation wrote: `glsl/water/surface.*`, and the book's debug view,
//! `glsl/water/wire.*`.

use super::Surface;
use crate::{
    draw::{Grid, Stage},
    gpu::{Access, Blend, Bound, Depth, Gpu, Raster, RasterInfo, Recorder, Result, Topology},
    shaders,
};
use ash::vk;
use glam::{UVec2, Vec2};

/// How a surface is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Clear water.
    Shaded,
    /// Lines, in two colours that change with the tiles of 16 x 16 columns.
    Wireframe,
}

/// Push constants: `SurfaceParams` in `glsl/water/surface.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SurfaceParams {
    /// Columns along x and z.
    pub cells: UVec2,
    /// Columns from one row to the next.
    pub pitch: u32,
    /// Floats from one column to the next.
    pub stride: u32,
    /// Extent, round the origin (m).
    pub size_m: Vec2,
    /// Height of the surface at rest (m).
    pub level_m: f32,
    /// Slope of the fine ripples that the grid is too coarse for.
    pub ripple: f32,
    /// Depth below which there is foam (m).
    pub foam_m: f32,
    /// Unused.
    pub reserved: u32,
}

/// A pipeline for the two surfaces between which a model goes to and fro.
pub struct SurfaceDraw {
    bound: [(vk::Buffer, Bound); 2],
    look: Look,
    indices: crate::gpu::Buffer,
}

impl SurfaceDraw {
    /// What surfaces must be visible to before [`SurfaceDraw::record`].
    pub const ENTRY: Access = Access::GraphicsRead;

    /// # Errors
    /// If the device cannot draw.
    pub fn new(gpu: &Gpu, stage: &Stage, surfaces: [Surface<'_>; 2], look: Look) -> Result<Self> {
        let shaded = RasterInfo {
            name: c"water.surface",
            vertex: shaders::WATER_SURFACE_VERT,
            fragment: shaders::WATER_SURFACE_FRAG,
            blocks: &["Views", "Terrain", "Light", "Height"],
            constants: &[],
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            depth: Depth::Write,
            samples: stage.samples(),
        };
        let info = match look {
            Look::Shaded => shaded,
            Look::Wireframe => RasterInfo {
                name: c"water.wire",
                vertex: shaders::WATER_WIRE_VERT,
                fragment: shaders::WATER_WIRE_FRAG,
                blocks: &["Views", "Height"],
                topology: Topology::Lines,
                ..shaded
            },
        };
        let raster = Raster::new::<SurfaceParams>(gpu, &info)?;
        let terrain = stage.terrain();
        let bind = |surface: &Surface<'_>| -> Result<_> {
            let all = [
                ("Views", stage.views().into()),
                ("Terrain", terrain.height().into()),
                ("Light", terrain.light().into()),
                ("Height", surface.height_m.into()),
            ];
            let used: Vec<_> = all.into_iter().filter(|(name, _)| info.blocks.contains(name)).collect();
            Ok((surface.height_m.raw(), raster.bind(&used)?))
        };
        let bound = [bind(&surfaces[0])?, bind(&surfaces[1])?];
        Ok(Self { bound, look, indices: stage.grid().indices().clone() })
    }

    /// Draws `surface`, inside [`Stage::record`].
    ///
    /// # Panics
    /// If `surface` is not one of the two that this was made for.
    pub fn record(&self, rec: &mut Recorder<'_>, surface: &Surface<'_>, params: &SurfaceParams) {
        let bound = self.bound.iter().find(|(height, _)| *height == surface.height_m.raw());
        let (_, bound) = bound.expect("a surface that this was made for");
        match self.look {
            Look::Shaded => rec.draw_indexed(bound, &self.indices, Grid::tiles(params.cells), params),
            Look::Wireframe => rec.draw(bound, 6 * params.cells.element_product(), 1, params),
        }
    }
}
