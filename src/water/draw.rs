// SPDX-License-Identifier: MIT OR Apache-2.0
//! Draws a surface from the buffer that the simulation wrote: `glsl/water/surface.*`, and the book's debug view,
//! `glsl/water/wire.*`.

use super::Surface;
use crate::{
    draw::{Grid, Stage},
    gpu::{Access, Blend, Bound, Buffer, Depth, Gpu, Raster, RasterInfo, Recorder, Result, Topology},
    shaders,
};
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
    bound: [(Buffer, Bound); 2],
    look: Look,
    indices: Buffer,
}

impl SurfaceDraw {
    /// What surfaces must be visible to before [`SurfaceDraw::record`].
    pub const ENTRY: Access = Access::GraphicsRead;

    /// # Errors
    /// If the device cannot draw.
    ///
    /// # Panics
    /// If clear water is to be drawn on a stage without terrain: there is nothing to see through it.
    pub fn new(gpu: &Gpu, stage: &Stage, surfaces: [Surface<'_>; 2], look: Look) -> Result<Self> {
        let shaded = RasterInfo {
            name: c"water.surface",
            vertex: shaders::WATER_SURFACE_VERT,
            geometry: None,
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
        let bind = |surface: &Surface<'_>| -> Result<_> {
            let mut used = vec![("Views", stage.views().into())];
            if look == Look::Shaded {
                let terrain = stage.terrain().expect("a stage with terrain");
                used.extend([("Terrain", terrain.height().into()), ("Light", terrain.light().into())]);
            }
            used.push(("Height", surface.height_m.into()));
            Ok((surface.height_m.clone(), raster.bind(&used)?))
        };
        let bound = [bind(&surfaces[0])?, bind(&surfaces[1])?];
        Ok(Self { bound, look, indices: stage.grid().indices().clone() })
    }

    /// Draws `surface`, inside [`Stage::record`].
    ///
    /// # Panics
    /// If `surface` is not one of the two that this was made for, or `params` are of another grid.
    pub fn record(&self, rec: &mut Recorder<'_>, surface: &Surface<'_>, params: &SurfaceParams) {
        let bound = self.bound.iter().find(|(height, _)| height.is(surface.height_m));
        let (_, bound) = bound.expect("a surface that this was made for");
        let (asked, there) =
            ((params.cells, params.pitch, params.stride), (surface.cells, surface.pitch, surface.stride));
        assert_eq!(asked, there, "grid of the parameters and of the surface");
        match self.look {
            Look::Shaded => rec.draw_indexed(bound, &self.indices, Grid::tiles(params.cells), params),
            Look::Wireframe => rec.draw(bound, 6 * params.cells.element_product(), 1, params),
        }
    }
}
