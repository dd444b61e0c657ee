// SPDX-License-Identifier: MIT OR Apache-2.0
use crate::gpu::{Buffer, Gpu, Result};
use glam::UVec2;

/// Indices of one tile of a grid of vertices; a grid is drawn as one instance a tile: `glsl/draw/grid.glsl`. One list
/// serves every grid, and neighbouring triangles share vertices in the cache.
pub struct Grid {
    indices: Buffer,
}

impl Grid {
    const TILE: u32 = 32;
    /// Of the index list.
    pub const BYTES: u64 = 2 * 6 * (Self::TILE * Self::TILE) as u64;

    /// # Errors
    /// The device's.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let at = |x: u32, y: u32| (y * (Self::TILE + 1) + x) as u16;
        let quads = (0..Self::TILE).flat_map(|y| (0..Self::TILE).map(move |x| (x, y)));
        let corners =
            |(x, y)| [at(x, y), at(x, y + 1), at(x + 1, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
        let list: Vec<u16> = quads.flat_map(corners).collect();
        Ok(Self { indices: gpu.upload("draw.grid", &list)? })
    }

    /// Six a quad.
    pub fn indices(&self) -> &Buffer {
        &self.indices
    }

    /// How many tiles cover a grid of that many vertices.
    pub fn tiles(vertices: UVec2) -> u32 {
        let along = |n: u32| n.saturating_sub(1).div_ceil(Self::TILE).max(1);
        along(vertices.x) * along(vertices.y)
    }
}
