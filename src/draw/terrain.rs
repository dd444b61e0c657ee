// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::{
    gpu::{
        Access, Blend, Bound, Buffer, Depth, Gpu, Kernel, KernelInfo, Raster, RasterInfo, Recorder, Result,
        Topology,
    },
    shaders,
};
use glam::{UVec2, Vec2};

use super::Grid;

/// Heights on a regular grid, row by row from -z, each in the middle of its cell, round the origin.
#[derive(Clone, Debug, PartialEq)]
pub struct TerrainGrid {
    /// Samples along x and z.
    pub cells: UVec2,
    /// Extent (m).
    pub size_m: Vec2,
    /// (m), world y.
    pub height_m: Vec<f32>,
    /// What stands there, one a sample; empty if there is nothing but ground.
    pub built: Vec<Built>,
}

/// What the surface of a sample is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum Built {
    /// Soil, sand, rock.
    #[default]
    Ground = 0,
    /// A wall of stone.
    Stone = 128,
    /// Plaster and tiles.
    House = 255,
}

impl TerrainGrid {
    /// The bed of a basin without a heightmap.
    pub fn flat(size_m: Vec2, height_m: f32) -> Self {
        Self { cells: UVec2::splat(2), size_m, height_m: vec![height_m; 4], built: Vec::new() }
    }
}

/// A heightmap on the GPU, with the light that reaches it.
pub struct Terrain {
    grid: TerrainGrid,
    height: Buffer,
    light: Buffer,
    bake: Bound,
    draw: Bound,
    indices: Buffer,
}

impl Terrain {
    pub(super) fn new(
        gpu: &Gpu,
        grid: TerrainGrid,
        views: &Buffer,
        indices: &Grid,
        samples: u32,
    ) -> Result<Self> {
        let height = gpu.upload("draw.terrain_m", &grid.height_m)?;
        let built = |i| u32::from(grid.built.get(i).copied().unwrap_or_default() as u8) << 16;
        let light: Vec<u32> = (0..grid.height_m.len()).map(built).collect();
        let light = gpu.upload("draw.light", &light)?;
        let bake = KernelInfo {
            name: c"draw.light",
            spv: shaders::DRAW_LIGHT_COMP,
            blocks: &["Views", "Terrain", "Light"],
            constants: &[],
        };
        let draw = RasterInfo {
            name: c"draw.terrain",
            vertex: shaders::DRAW_TERRAIN_VERT,
            geometry: None,
            fragment: shaders::DRAW_TERRAIN_FRAG,
            blocks: &["Views", "Terrain", "Light"],
            constants: &[],
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            depth: Depth::Write,
            samples,
        };
        let resources = [("Views", views.into()), ("Terrain", (&height).into()), ("Light", (&light).into())];
        Ok(Self {
            bake: Kernel::new::<()>(gpu, &bake)?.bind(&resources)?,
            draw: Raster::new::<()>(gpu, &draw)?.bind(&resources)?,
            indices: indices.indices().clone(),
            grid,
            height,
            light,
        })
    }

    /// Samples and extent.
    pub fn grid(&self) -> &TerrainGrid {
        &self.grid
    }

    /// `f32` a sample (m).
    pub fn height(&self) -> &Buffer {
        &self.height
    }

    /// `[f32; 2]` a sample: share of the sun and of the sky that arrives.
    pub fn light(&self) -> &Buffer {
        &self.light
    }

    /// Bakes the light, once after the view's sun has changed.
    pub(super) fn record_light(&self, rec: &mut Recorder<'_>) {
        let [w, h] = self.grid.cells.to_array();
        rec.span(c"draw.light", |rec| rec.dispatch(&self.bake, [w, h, 1], &()));
        rec.barrier(Access::ComputeWrite, Access::GraphicsRead);
    }

    pub(super) fn record_draw(&self, rec: &mut Recorder<'_>) {
        rec.draw_indexed(&self.draw, &self.indices, Grid::tiles(self.grid.cells), &());
    }
}
