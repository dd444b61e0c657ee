// SPDX-License-Identifier: MIT OR Apache-2.0
//! Draws a surface from the buffers that the simulation wrote: `glsl/water/*surface.*`, and the book's debug view,
//! `glsl/water/*wire.*`.

use super::{DepthState, PipesState, Surface};
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
    /// Depth below which there is foam along shores (m), 0 for none.
    pub foam_m: f32,
    /// [`Speeds`] as the shaders have it.
    pub speeds: f32,
    /// Speed above which water is white where it outruns its waves (m/s).
    pub white_mps: f32,
}

/// What a stored flow is as a speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speeds {
    /// So many times itself (m/s).
    Times(f32),
    /// A flow (m^2/s), to be divided by the depth.
    ByDepth,
}

impl From<Speeds> for f32 {
    fn from(speeds: Speeds) -> f32 {
        match speeds {
            Speeds::Times(x) => x,
            Speeds::ByDepth => 0.0,
        }
    }
}

/// What is drawn.
pub enum Drawn<'a> {
    /// Heights alone: the two surfaces between which a model goes to and fro.
    Level([Surface<'a>; 2]),
    /// Heights, white where the pipes are fast.
    Pipes(&'a PipesState),
    /// Water over ground, white where it is fast, unseen where it is dry.
    Depth(&'a DepthState),
}

impl<'a> Drawn<'a> {
    fn surfaces(&self) -> [Surface<'a>; 2] {
        match self {
            Self::Level(surfaces) => *surfaces,
            Self::Pipes(state) => state.surfaces(),
            Self::Depth(state) => state.surfaces(),
        }
    }

    /// Vertex shaders, shaded and as lines.
    fn vertex(&self) -> [&'static [u8]; 2] {
        match self {
            Self::Level(_) => [shaders::WATER_SURFACE_VERT, shaders::WATER_WIRE_VERT],
            Self::Pipes(_) => [shaders::WATER_PIPES_SURFACE_VERT, shaders::WATER_WIRE_VERT],
            Self::Depth(_) => [shaders::WATER_DEPTH_SURFACE_VERT, shaders::WATER_DEPTH_WIRE_VERT],
        }
    }

    /// Blocks beside the heights, of each of the surfaces.
    fn blocks(&self, look: Look) -> [Vec<(&'static str, &'a Buffer)>; 2] {
        [0, 1].map(|i| {
            let mut blocks = Vec::new();
            match self {
                Self::Level(_) => {}
                Self::Pipes(state) if look == Look::Shaded => {
                    blocks.extend(state.rates()[i].map(|flow| ("Flow", flow)));
                }
                Self::Pipes(_) => {}
                Self::Depth(state) => {
                    if look == Look::Shaded {
                        blocks.push(("Flow", state.flows()[i]));
                    }
                    blocks.push(("Bed", state.bed()));
                }
            }
            blocks
        })
    }
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
    pub fn new(gpu: &Gpu, stage: &Stage, drawn: &Drawn<'_>, look: Look) -> Result<Self> {
        let [shaded, wire] = drawn.vertex();
        let [first, second] = drawn.blocks(look);
        let mut used = vec![("Views", stage.views())];
        if look == Look::Shaded {
            let terrain = stage.terrain().expect("a stage with terrain");
            used.extend([("Terrain", terrain.height()), ("Light", terrain.light())]);
        }
        let blocks: Vec<&str> =
            used.iter().chain(&[("Height", stage.views())]).chain(&first).map(|(name, _)| *name).collect();
        let info = RasterInfo {
            name: c"water.surface",
            vertex: shaded,
            geometry: None,
            fragment: shaders::WATER_SURFACE_FRAG,
            blocks: &blocks,
            constants: &[],
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            depth: Depth::Write,
            samples: stage.samples(),
        };
        let info = match look {
            Look::Shaded => info,
            Look::Wireframe => RasterInfo {
                name: c"water.wire",
                vertex: wire,
                fragment: shaders::WATER_WIRE_FRAG,
                topology: Topology::Lines,
                ..info
            },
        };
        let raster = Raster::new::<SurfaceParams>(gpu, &info)?;
        let bind = |surface: &Surface<'_>, more: &[(&'static str, &Buffer)]| -> Result<_> {
            let height = [("Height", surface.height_m)];
            let all: Vec<_> =
                used.iter().chain(&height).chain(more).map(|&(name, of)| (name, of.into())).collect();
            Ok((surface.height_m.clone(), raster.bind(&all)?))
        };
        let surfaces = drawn.surfaces();
        let bound = [bind(&surfaces[0], &first)?, bind(&surfaces[1], &second)?];
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
