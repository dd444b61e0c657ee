// SPDX-License-Identifier: MIT OR Apache-2.0
//! Paint on meshes, left by particles: where one touches, or comes near, the surface takes a coat of its colour (Microsoft's
//! sample "AdvancedParticles", Advanced Real-Time Rendering in 3D Graphics and Games, SIGGRAPH 2007, whose gather is kept as
//! [`Method::Brute`]).
//!
//! | kernel         | reads                                   | writes                      | CPU twin           |
//! | -------------- | --------------------------------------- | --------------------------- | ------------------ |
//! | `paint.place`  | texels, triangles, places               | positions, boxes of tiles   | [`cpu::place`]     |
//! | `paint.blocks` | boxes of tiles                          | boxes of blocks             | [`cpu::boxes`]     |
//! | `paint.brute`  | drops, coats, positions                 | paint                       | [`cpu::gather`]    |
//! | `paint.tiles`  | drops, coats, positions, boxes          | paint                       | [`cpu::gather`]    |
//! | `paint.begin`  | sums                                    | work                        | -                  |
//! | `paint.sift`   | drops, boxes of blocks                  | masks, touched blocks       | [`cpu::sift`]      |
//! | `paint.sifted` | drops, coats, positions, boxes, masks   | paint                       | [`cpu::gather`]    |
//! | `paint.mark`   | impacts                                 | marks                       | [`cpu::in_order`]  |
//! | `paint.bits`   | marks                                   | sums                        | [`cpu::in_order`]  |
//! | `paint.drops`  | impacts, marks, sums                    | drops, homes                | [`cpu::in_order`]  |
//! | `paint.take`   | particles in planes                     | drops                       | [`cpu::take`]      |
//! | `paint.resolve`| paint                                   | rows                        | [`cpu::rows`]      |
//!
//! A mesh has a *position map*: for each texel of its texture the place in the world ([`Atlas`], [`Canvas`]), and a *paint map*
//! of premultiplied colour and opacity. A [`Gather`] paints from particles, and what `brute` paints, `tiles` and `sifted`
//! paint to the bit. A [`Splat`] paints from the impact stream: impacts are put in their order first, so that two runs are
//! equal to the bit, and whoever touched has painted.
//!
//! Scheme and limit: a texel is painted as a whole or not at all, by the distance to its centre; a wall thinner than the
//! radius is painted on both sides. Left out: soft edges, paint that runs, dries or washes off, normal maps of paint.

pub mod atlas;
mod canvas;
pub mod cpu;
mod gather;
mod splat;
mod take;

pub use atlas::{Atlas, Charts, Overlap, Texel};
pub use canvas::{Canvas, Cover, Paint, Rows};
pub use gather::{Gather, Method, Taken};
pub use splat::{Splat, SplatParams};
pub use take::{Take, TakeParams};

use crate::{gpu, mesh::MeshError};
use glam::{UVec2, Vec3};

/// Texels along a side of a tile.
pub const TILE_SIDE: u32 = 8;
/// Texels along a side of a block.
pub const BLOCK_SIDE: u32 = 64;
/// Texels of a tile.
pub const TILE: usize = 64;
/// Texels of a block.
pub const BLOCK: usize = 4096;

/// Where the map of a mesh lies: `Map` in `glsl/paint/map.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Map {
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// Where it begins.
    pub first_block: u32,
    /// Blocks of a row.
    pub blocks_x: u32,
}

impl Map {
    /// A map that begins with block `first_block`.
    pub fn new(size: UVec2, first_block: u32) -> Self {
        Self { width: size.x, height: size.y, first_block, blocks_x: size.x.div_ceil(BLOCK_SIDE) }
    }

    /// Texels across and down.
    pub fn size(&self) -> UVec2 {
        UVec2::new(self.width, self.height)
    }

    /// How many blocks it has.
    pub fn blocks(&self) -> u32 {
        self.blocks_x * self.height.div_ceil(BLOCK_SIDE)
    }

    /// Texels in memory.
    pub fn texels(&self) -> usize {
        BLOCK * self.blocks() as usize
    }

    /// Where it begins.
    pub fn first_texel(&self) -> usize {
        BLOCK * self.first_block as usize
    }

    /// Where a texel is.
    pub fn texel(&self, x: u32, y: u32) -> usize {
        let block = self.first_block + self.blocks_x * (y / BLOCK_SIDE) + x / BLOCK_SIDE;
        let tile = 8 * (y / TILE_SIDE % 8) + x / TILE_SIDE % 8;
        let texel = 8 * (y % TILE_SIDE) + x % TILE_SIDE;
        BLOCK * block as usize + TILE * tile as usize + texel as usize
    }

    /// The texel under texture coordinates.
    pub fn texel_at(&self, u: f32, v: f32) -> usize {
        let along = |t: f32, side: u32| ((t.clamp(0.0, 1.0) * side as f32) as u32).min(side - 1);
        self.texel(along(u, self.width), along(v, self.height))
    }
}

/// Where a texel is on its mesh: `Position` in `glsl/paint/map.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Position {
    /// (m).
    pub at_m: Vec3,
    /// As [`Texel::triangle`]: 0 where there is no mesh, or where its place is not finite.
    pub triangle: u32,
}

/// Box round a tile or a block: `Box` in `glsl/paint/map.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Bounds {
    /// (m).
    pub low_m: Vec3,
    /// Whose map it is of.
    pub mesh: u32,
    /// (m).
    pub high_m: Vec3,
    /// Texels with a place; 0: there is no box.
    pub covered: u32,
}

/// Push constants of `paint.place` and `paint.blocks`: `PlaceParams` there.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct PlaceParams {
    /// Tile, or block.
    pub first: u32,
    /// Of them.
    pub count: u32,
    /// Whose map it is.
    pub mesh: u32,
}

/// What paints: `Drop` in `glsl/paint/drops.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Drop {
    /// (m). What is not finite paints nothing.
    pub at_m: Vec3,
    /// Low half: whose paint; from [`Coat`]s on: nobody's. High half, of an impact: the mesh.
    pub source: u32,
}

/// What a source leaves: `Coat` in `glsl/paint/drops.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Coat {
    /// Colour times opacity, opacity.
    pub paint: [f32; 4],
    /// Of an impact: square of the radius (m^2).
    pub reach_sq_m2: f32,
    /// Of an impact: its place in the order is this and its `order`, so that sources do not share places.
    pub first_order: u32,
    /// Its `order` is below this.
    pub orders: u32,
    /// Unused.
    pub unused: u32,
}

impl Coat {
    /// A coat of linear `color`, which covers `opacity` of what is below it.
    ///
    /// # Errors
    /// Opacity outside 0 to 1, colour outside 0 to [`Coat::BRIGHTEST`], a radius that is none.
    pub fn new(color: Vec3, opacity: f32, radius_m: f32) -> Result<Self, Invalid> {
        let fail = |key, value: String, allowed: &str| Err(Invalid { key, value, allowed: allowed.into() });
        if !(0.0..=1.0).contains(&opacity) {
            return fail("opacity", opacity.to_string(), "0 to 1");
        }
        let is_color = |x: f32| (0.0..=Self::BRIGHTEST).contains(&x);
        if !color.to_array().into_iter().all(is_color) {
            return fail("color", color.to_string(), "0 to 60000 each");
        }
        if !(radius_m >= 0.0 && radius_m.is_finite()) {
            return fail("radius_m", radius_m.to_string(), "0 or more");
        }
        let [r, g, b] = (color * opacity).to_array();
        let paint = [r, g, b, opacity];
        Ok(Self { paint, reach_sq_m2: radius_m * radius_m, first_order: 0, orders: 0, unused: 0 })
    }

    /// Of a colour: what a half holds.
    pub const BRIGHTEST: f32 = 6e4;

    /// Gives each its own places in the order, one after the other: `orders[i]` of source i, which is how many particles
    /// can move in a step, times 8. Says how many places there are.
    ///
    /// # Errors
    /// If they are more than [`Coat::MOST_ORDERS`].
    ///
    /// # Panics
    /// If there are not as many.
    pub fn take_turns(coats: &mut [Self], orders: &[u32]) -> Result<u32, Invalid> {
        assert_eq!(coats.len(), orders.len(), "an order for each source");
        let mut first = 0u64;
        for (coat, &orders) in coats.iter_mut().zip(orders) {
            (coat.first_order, coat.orders) = (first as u32, orders);
            first += u64::from(orders);
            if first > u64::from(Self::MOST_ORDERS) {
                let allowed = format!("up to {} for all sources", Self::MOST_ORDERS);
                return Err(Invalid { key: "orders", value: first.to_string(), allowed });
            }
        }
        Ok(first as u32)
    }

    /// Of all sources: 32 million particles, 8 bounces each.
    pub const MOST_ORDERS: u32 = 1 << 28;
}

/// Most drops that are culled: what a row of workgroups of 256 has.
pub const MOST_DROPS: u32 = 65_535 * 256;

/// Push constants of all that gathers: `GatherParams` in `glsl/paint/drops.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct GatherParams {
    /// Drops in the buffer.
    pub total: u32,
    /// Of them, `first`, `first + stride` and so on take part.
    pub first: u32,
    /// From one to the next.
    pub stride: u32,
    /// Of the maps.
    pub blocks: u32,
    /// Of a block's mask.
    pub words: u32,
    /// Sources.
    pub coats: u32,
    /// Of a particle: square of the radius (m^2).
    pub reach_sq_m2: f32,
    /// Of impacts: the word of the sums that says how many.
    pub total_at: u32,
}

/// Written and read on the GPU: `Work` in `glsl/paint/drops.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Work {
    /// That take part.
    pub drops: u32,
    /// Indirect dispatch of `paint.sift`, at [`Work::SIFT`].
    pub sift: [u32; 3],
    /// Indirect dispatch of `paint.sifted`, at [`Work::TILES`]; the second is the number of blocks with a drop near.
    pub tiles: [u32; 3],
    /// Impacts on a mesh, of no source or of no order; since the start.
    pub lost: u32,
    /// Impacts with the order of another; since the start.
    pub twice: u32,
    /// Unused.
    pub unused: [u32; 3],
}

impl Work {
    /// (bytes).
    pub const SIFT: u64 = std::mem::offset_of!(Self, sift) as u64;
    /// (bytes).
    pub const TILES: u64 = std::mem::offset_of!(Self, tiles) as u64;
}

/// How a texel is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Four halves, 8 bytes: faint coats, one a step, stop short of full cover (docs/paint.md).
    Halves,
    /// Four floats, 16 bytes.
    Floats,
}

impl Format {
    /// Of a texel.
    pub fn bytes(self) -> u64 {
        match self {
            Self::Halves => 8,
            Self::Floats => 16,
        }
    }
}

/// A number out of range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} = {value}: allowed is {allowed}")]
pub struct Invalid {
    /// Name of the field.
    pub key: &'static str,
    /// Its value.
    pub value: String,
    /// What is allowed.
    pub allowed: String,
}

/// What can go wrong with paint.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A mesh that cannot be painted.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Bad input.
    #[error(transparent)]
    Invalid(#[from] Invalid),
    /// The device's.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
}

/// Workgroups of `group` invocations for each of `count`, in rows of no more than every device takes.
fn spread(count: u32, group: u32) -> [u32; 3] {
    let rows = count.div_ceil(1 << 15).max(1);
    [count.div_ceil(rows) * group, rows, 1]
}
