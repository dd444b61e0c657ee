// SPDX-License-Identifier: MIT OR Apache-2.0
//! Position maps and paint maps on the GPU. Reads `glsl/paint/{place,blocks,resolve}.comp`.

use super::{
    atlas::GUTTER, gather::Culling, Atlas, Bounds, Format, Map, PlaceParams, Position, BLOCK_SIDE, TILE,
};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};

/// The kernels. They hold no canvas, so one set paints any number of them.
pub struct Paint {
    place: Kernel,
    blocks: Kernel,
    resolve: Kernel,
    pub(super) take: Kernel,
    pub(super) particles: Culling,
    pub(super) impacts: Culling,
    pub(super) order: super::splat::Order,
    format: Format,
    pub(super) gpu: Gpu,
}

impl Paint {
    /// What the canvas must be visible to before anything is recorded.
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How it was touched last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// For canvases of this format.
    ///
    /// # Errors
    /// If the device does not take the kernels.
    pub fn new(gpu: &Gpu, format: Format) -> Result<Self> {
        Self::tuned(gpu, format, 64)
    }

    /// [`Paint::new`] with workgroups of so many invocations, 64 or more, where a tile or its part is painted: it changes no
    /// bit.
    ///
    /// # Errors
    /// If the device does not take the kernels.
    ///
    /// # Panics
    /// If a tile does not fit.
    pub fn tuned(gpu: &Gpu, format: Format, group: u32) -> Result<Self> {
        assert!(group as usize >= TILE, "workgroups of {group} for tiles of {TILE} texels");
        let kernel = |name, spv, blocks| {
            Kernel::new::<PlaceParams>(gpu, &KernelInfo { name, spv, blocks, constants: &[] })
        };
        let resolve = KernelInfo {
            name: c"paint.resolve",
            spv: shaders::PAINT_RESOLVE_COMP,
            blocks: &["Paint", "Rows"],
            constants: &[format as u32],
        };
        let take = KernelInfo {
            name: c"paint.take",
            spv: shaders::PAINT_TAKE_COMP,
            blocks: &["Planes", "Counts", "Drops"],
            constants: &[],
        };
        Ok(Self {
            place: kernel(
                c"paint.place",
                shaders::PAINT_PLACE_COMP,
                &["Texels", "Triangles", "Places", "Positions", "Tiles"],
            )?,
            blocks: kernel(c"paint.blocks", shaders::PAINT_BLOCKS_COMP, &["Tiles", "Blocks"])?,
            resolve: Kernel::new::<Map>(gpu, &resolve)?,
            take: Kernel::new::<super::TakeParams>(gpu, &take)?,
            particles: Culling::new(gpu, 0, format, group)?,
            impacts: Culling::new(gpu, 1, format, group)?,
            order: super::splat::Order::new(gpu)?,
            format,
            gpu: gpu.clone(),
        })
    }

    /// Maps of the meshes of `atlas`, unpainted and not placed yet: [`Canvas::record_place`]. `places` has six `f32` a vertex
    /// (place, velocity), `triangles` three vertices a triangle, both of all meshes one after the other.
    ///
    /// # Errors
    /// If the device has no room, or sees no buffer of that size.
    ///
    /// # Panics
    /// If the atlas is empty.
    pub fn canvas(&self, atlas: &Atlas, places: &Buffer, triangles: &Buffer) -> Result<Canvas> {
        assert!(!atlas.maps.is_empty(), "an atlas of no mesh");
        let gpu = &self.gpu;
        let texels = gpu.upload("paint.texels", &atlas.texels)?;
        let device = |name: &str, bytes: u64| Buffer::new(gpu, name, bytes, Residence::Device);
        let count = atlas.texels.len() as u64;
        let positions = device("paint.positions", 16 * count)?;
        let tiles = device("paint.tiles", 32 * count / TILE as u64)?;
        let blocks = device("paint.blocks", 32 * u64::from(atlas.blocks()))?;
        let paint = device("paint.paint", self.format.bytes() * count)?;
        let canvas = Canvas {
            place: self.place.bind(&[
                ("Texels", (&texels).into()),
                ("Triangles", triangles.into()),
                ("Places", places.into()),
                ("Positions", (&positions).into()),
                ("Tiles", (&tiles).into()),
            ])?,
            bound_blocks: self.blocks.bind(&[("Tiles", (&tiles).into()), ("Blocks", (&blocks).into())])?,
            map_table: gpu.upload("paint.maps", &atlas.maps)?,
            maps: atlas.maps.clone(),
            texels: atlas.charts.iter().map(|charts| charts.covered + charts.gutter).collect(),
            positions,
            tiles,
            blocks,
            paint,
            format: self.format,
        };
        gpu.once(|rec| canvas.record_clear(rec))?;
        Ok(canvas)
    }

    /// How a texel is stored.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Room for the rows of the map of a mesh.
    ///
    /// # Errors
    /// If the device has no room.
    pub fn rows(&self, canvas: &Canvas, mesh: usize) -> Result<Rows> {
        let map = canvas.maps[mesh];
        let bytes = self.format.bytes() * u64::from(map.width) * u64::from(map.height);
        let rows = Buffer::new(&self.gpu, "paint.rows", bytes, Residence::Device)?;
        let bound = self.resolve.bind(&[("Paint", (&canvas.paint).into()), ("Rows", (&rows).into())])?;
        Ok(Rows { bound, rows, map })
    }
}

/// Position maps and paint maps of the meshes of a scene.
pub struct Canvas {
    place: Bound,
    bound_blocks: Bound,
    maps: Vec<Map>,
    /// By mesh: texels of charts and gutters.
    texels: Vec<u64>,
    pub(super) map_table: Buffer,
    pub(super) positions: Buffer,
    pub(super) tiles: Buffer,
    pub(super) blocks: Buffer,
    pub(super) paint: Buffer,
    format: Format,
}

impl Canvas {
    /// Takes all paint off.
    pub fn record_clear(&self, rec: &mut Recorder<'_>) {
        rec.barrier(Access::ComputeReadWrite, Access::FillWrite);
        rec.span(c"paint.clear", |rec| rec.fill(&self.paint, 0));
        rec.barrier(Access::FillWrite, Paint::ENTRY);
    }

    /// place --B-- blocks, for these meshes: each when it has been posed, one that does not move once.
    ///
    /// # Panics
    /// If there is no such mesh.
    pub fn record_place(&self, rec: &mut Recorder<'_>, meshes: &[usize]) {
        let each = |of: u32| {
            meshes.iter().map(move |&mesh| {
                let map = self.maps[mesh];
                PlaceParams { first: of * map.first_block, count: of * map.blocks(), mesh: mesh as u32 }
            })
        };
        let tiles_of_block = (BLOCK_SIDE / 8).pow(2);
        rec.span(c"paint.place", |rec| {
            each(tiles_of_block).for_each(|p| rec.dispatch(&self.place, super::spread(p.count, 64), &p));
        });
        rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        rec.span(c"paint.blocks", |rec| {
            each(1).for_each(|p| rec.dispatch(&self.bound_blocks, super::spread(p.count, 64), &p));
        });
    }

    /// Where the map of each mesh lies.
    pub fn maps(&self) -> &[Map] {
        &self.maps
    }

    /// The same on the device, [`Map`] a mesh, for `paint/lookup.glsl`.
    pub fn map_table(&self) -> &Buffer {
        &self.map_table
    }

    /// [`Position`] a texel.
    pub fn positions(&self) -> &Buffer {
        &self.positions
    }

    /// [`Bounds`] a tile.
    pub fn tiles(&self) -> &Buffer {
        &self.tiles
    }

    /// [`Bounds`] a block.
    pub fn boxes(&self) -> &Buffer {
        &self.blocks
    }

    /// Premultiplied paint, [`Format::bytes`] a texel.
    pub fn paint(&self) -> &Buffer {
        &self.paint
    }

    /// How a texel is stored.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Blocks of all maps.
    pub fn block_count(&self) -> u32 {
        self.maps.iter().map(Map::blocks).sum()
    }

    /// Bytes on the device, of what was allocated here.
    pub fn bytes(&self) -> u64 {
        let texels = u64::from(self.block_count()) * super::BLOCK as u64;
        12 * texels
            + [&self.positions, &self.tiles, &self.blocks, &self.paint].iter().map(|b| b.bytes()).sum::<u64>()
    }

    /// Paint of all texels. Submits and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu) -> Result<Vec<[f32; 4]>> {
        Ok(match self.format {
            Format::Floats => gpu.download(&self.paint)?,
            Format::Halves => {
                let halves = gpu.download::<[u16; 4]>(&self.paint)?;
                halves.into_iter().map(|four| four.map(super::cpu::float_of)).collect()
            }
        })
    }

    /// By mesh, how much of it is painted. Submits and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn covers(&self, gpu: &Gpu) -> Result<Vec<Cover>> {
        let (paint, positions) = (self.download(gpu)?, gpu.download::<Position>(&self.positions)?);
        let of = |(map, texels): (&Map, &u64)| {
            let all = map.first_texel()..map.first_texel() + map.texels();
            let mut cover = Cover { painted: 0, nowhere: *texels };
            for (paint, position) in paint[all.clone()].iter().zip(&positions[all]) {
                cover.nowhere -= u64::from(position.triangle != 0);
                let is_own = position.triangle != 0 && position.triangle & GUTTER == 0;
                cover.painted += u64::from(is_own && paint[3] > 0.0);
            }
            cover
        };
        Ok(self.maps.iter().zip(&self.texels).map(of).collect())
    }

    /// Places and boxes of tiles and of blocks. Submits and waits.
    ///
    /// # Errors
    /// The device's.
    #[allow(clippy::type_complexity)]
    pub fn download_places(&self, gpu: &Gpu) -> Result<(Vec<Position>, Vec<Bounds>, Vec<Bounds>)> {
        Ok((gpu.download(&self.positions)?, gpu.download(&self.tiles)?, gpu.download(&self.blocks)?))
    }
}

/// What became of a paint map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cover {
    /// Texels of triangles with paint on them. Those beside a triangle take the paint of its border and do not count.
    pub painted: u64,
    /// Texels that have not been placed, or whose place is not finite: nothing paints them.
    pub nowhere: u64,
}

/// The paint map of a mesh, row by row.
pub struct Rows {
    bound: Bound,
    rows: Buffer,
    map: Map,
}

impl Rows {
    /// Makes them what the paint map is now.
    pub fn record(&self, rec: &mut Recorder<'_>) {
        let threads = [self.map.width, self.map.height, 1];
        rec.span(c"paint.resolve", |rec| rec.dispatch(&self.bound, threads, &self.map));
    }

    /// Premultiplied paint, [`Format::bytes`] a texel, from the top.
    pub fn rows(&self) -> &Buffer {
        &self.rows
    }
}
