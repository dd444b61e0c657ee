// SPDX-License-Identifier: MIT OR Apache-2.0
//! Debug views of a grid of cells: a box where something is, or the planes that cells hold: `glsl/draw/{voxels,planes}*`.

use super::Stage;
use crate::{
    cells::{Cells, Grid},
    gpu::{Access, Blend, Bound, Depth, Gpu, Raster, RasterInfo, Recorder, Result, Topology},
    shaders,
};

/// Push constants: `VoxelParams` in `glsl/draw/voxels.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct VoxelParams {
    /// Where and how many.
    pub grid: Grid,
    /// Of the two planes of a cell.
    pub slot: u32,
}

/// A pipeline for one grid.
pub struct VoxelsDraw {
    bound: Bound,
    grid: Grid,
    as_planes: bool,
}

impl VoxelsDraw {
    /// What cells must be visible to before [`VoxelsDraw::record`].
    pub const ENTRY: Access = Access::GraphicsRead;

    /// Boxes, or the planes in them.
    ///
    /// # Errors
    /// If the device cannot draw.
    pub fn new(gpu: &Gpu, stage: &Stage, cells: &Cells, as_planes: bool) -> Result<Self> {
        let info = RasterInfo {
            name: if as_planes { c"draw.planes" } else { c"draw.voxels" },
            vertex: if as_planes { shaders::DRAW_PLANES_VERT } else { shaders::DRAW_VOXELS_VERT },
            geometry: None,
            fragment: shaders::DRAW_VOXELS_FRAG,
            blocks: &["Views", "Occupied", "Planes"],
            constants: &[],
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            depth: Depth::Write,
            samples: stage.samples(),
        };
        let bound = Raster::new::<VoxelParams>(gpu, &info)?.bind(&[
            ("Views", stage.views().into()),
            ("Occupied", cells.occupied().into()),
            ("Planes", cells.planes().into()),
        ])?;
        Ok(Self { bound, grid: cells.grid(), as_planes })
    }

    /// Draws all cells, inside [`Stage::record`].
    pub fn record(&self, rec: &mut Recorder<'_>) {
        let (vertices, slots) = if self.as_planes { (6, 2) } else { (36, 1) };
        for slot in 0..slots {
            let params = VoxelParams { grid: self.grid, slot };
            rec.draw(&self.bound, vertices, self.grid.count() as u32, &params);
        }
    }
}
