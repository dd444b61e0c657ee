// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{Grid, Terrain, TerrainGrid, View};
use crate::{
    gpu::{
        Access, Blend, Bound, Buffer, Depth, Gpu, Image, ImageUse, Kernel, KernelInfo, Raster, RasterInfo,
        Recorder, Residence, Result, Target, Topology,
    },
    shaders,
};
use glam::UVec2;

/// Targets, sky and terrain of a picture of fixed size.
pub struct Stage {
    color: Image,
    depth: Image,
    resolved: Option<Image>,
    views: Buffer,
    grid: Grid,
    terrain: Terrain,
    sky: Bound,
    tonemap: Bound,
    pixels: Buffer,
    readback: Buffer,
    size: UVec2,
    needs_light: bool,
    /// Draw sky and terrain. Without, the picture is cleared to `clear`.
    pub has_surroundings: bool,
    /// Colour of an empty picture, linear.
    pub clear: [f32; 4],
}

impl Stage {
    /// # Errors
    /// If the device cannot draw, or has no room.
    pub fn new(gpu: &Gpu, size: UVec2, terrain: TerrainGrid) -> Result<Self> {
        let four = ash::vk::SampleCountFlags::TYPE_4;
        let limits = gpu.limits();
        let allowed = limits.framebuffer_color_sample_counts & limits.framebuffer_depth_sample_counts;
        let samples = if allowed.contains(four) { 4 } else { 1 };
        let image = |name, purpose, samples| Image::new(gpu, name, size.to_array(), purpose, samples);
        let (color, resolved) = if samples > 1 {
            (
                image("draw.samples", ImageUse::SampledColor, samples)?,
                Some(image("draw.color", ImageUse::Color, 1)?),
            )
        } else {
            (image("draw.color", ImageUse::Color, 1)?, None)
        };
        let depth = image("draw.depth", ImageUse::Depth, samples)?;
        let views = Buffer::new(gpu, "draw.views", size_of::<View>() as u64, Residence::Upload)?;
        let bytes = 4 * size.as_u64vec2().element_product();
        let pixels = Buffer::new(gpu, "draw.pixels", bytes, Residence::Device)?;
        let readback = Buffer::new(gpu, "draw.pixels.readback", bytes, Residence::Readback)?;
        let grid = Grid::new(gpu)?;
        let terrain = Terrain::new(gpu, terrain, &views, &grid, samples)?;
        let sky = RasterInfo {
            name: c"draw.sky",
            vertex: shaders::DRAW_SKY_VERT,
            fragment: shaders::DRAW_SKY_FRAG,
            blocks: &["Views"],
            constants: &[],
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            depth: Depth::Test,
            samples,
        };
        let tonemap = KernelInfo {
            name: c"draw.tonemap",
            spv: shaders::DRAW_TONEMAP_COMP,
            blocks: &["Views", "color", "Pixels"],
            constants: &[],
        };
        Ok(Self {
            sky: Raster::new::<()>(gpu, &sky)?.bind(&[("Views", (&views).into())])?,
            tonemap: Kernel::new::<()>(gpu, &tonemap)?.bind(&[
                ("Views", (&views).into()),
                ("color", resolved.as_ref().unwrap_or(&color).into()),
                ("Pixels", (&pixels).into()),
            ])?,
            color,
            depth,
            resolved,
            views,
            grid,
            terrain,
            pixels,
            readback,
            size,
            needs_light: true,
            has_surroundings: true,
            clear: [0.0, 0.0, 0.0, 1.0],
        })
    }

    /// What the next picture shows. The last one must be finished.
    pub fn set_view(&mut self, view: &View) {
        let grid = self.terrain.grid();
        self.views.write(0, &[View { terrain_size_m: grid.size_m, terrain_cells: grid.cells, ..*view }]);
    }

    /// Draws a picture: terrain and sky, then what `body` draws, and turns it to bytes for [`Stage::read`]. What `body`
    /// reads must be visible as [`Access::GraphicsRead`].
    pub fn record(&mut self, rec: &mut Recorder<'_>, body: impl FnOnce(&mut Recorder<'_>)) {
        if std::mem::take(&mut self.needs_light) {
            self.terrain.record_light(rec);
        }
        let resolved = self.resolved.as_ref();
        let target = Target { color: &self.color, depth: &self.depth, resolved, clear: self.clear };
        // The picture before this one may still be on its way to bytes.
        rec.barrier(Access::ComputeRead, Access::ColorWrite);
        rec.barrier(Access::ColorWrite, Access::ColorWrite);
        rec.barrier(Access::DepthWrite, Access::DepthWrite);
        rec.span(c"draw.scene", |rec| {
            rec.render(&target, |rec| {
                if self.has_surroundings {
                    self.terrain.record_draw(rec);
                }
                body(rec);
                if self.has_surroundings {
                    rec.draw(&self.sky, 3, 1, &()); // last: only where nothing else is
                }
            });
        });
        rec.barrier(Access::ColorWrite, Access::ComputeRead);
        rec.barrier(Access::CopyRead, Access::ComputeWrite);
        rec.span(c"draw.tonemap", |rec| rec.dispatch(&self.tonemap, [self.size.x, self.size.y, 1], &()));
        rec.barrier(Access::ComputeWrite, Access::CopyRead);
        rec.copy(&self.pixels, &self.readback);
        rec.barrier(Access::CopyWrite, Access::HostRead);
    }

    /// The finished picture: four bytes a pixel, sRGB, row by row from the top.
    pub fn read(&self) -> Vec<u8> {
        self.readback.read()
    }

    /// Of the picture (pixels).
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// Samples a pixel: pipelines that draw here are made for it.
    pub fn samples(&self) -> u32 {
        self.color.samples()
    }

    /// `View`, for pipelines that draw here.
    pub fn views(&self) -> &Buffer {
        &self.views
    }

    /// The index list of grids.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The heightmap.
    pub fn terrain(&self) -> &Terrain {
        &self.terrain
    }
}
