// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{Grid, Terrain, TerrainGrid, View};
use crate::{
    gpu::{
        Access, Blend, Bound, Buffer, Depth, Gpu, Image, ImageUse, Kernel, KernelInfo, Raster, RasterInfo,
        Recorder, Residence, Result, Target, Topology,
    },
    shaders,
};
use bytemuck::Zeroable;
use glam::{UVec2, Vec4};
use std::slice;

/// Depth that shaders can read.
struct CopiedDepth {
    /// Of one sample; the depth target itself where that has one.
    image: Option<Image>,
    depth: Buffer,
}

impl CopiedDepth {
    fn new(gpu: &Gpu, size: UVec2) -> Result<Self> {
        let image = Image::new(gpu, "draw.depth.copied", size.to_array(), ImageUse::CopiedDepth, 1)?;
        let bytes = 4 * size.as_u64vec2().element_product();
        let depth = Buffer::new(gpu, "draw.scene_depth", bytes, Residence::Device)?;
        Ok(Self { image: Some(image), depth })
    }
}

/// What has the size of the picture.
struct Targets {
    color: Image,
    depth: Image,
    resolved: Option<Image>,
    pixels: Buffer,
    readback: Buffer,
    tonemap: Bound,
}

impl Targets {
    fn new(gpu: &Gpu, size: UVec2, samples: u32, tonemap: &Kernel, views: &Buffer) -> Result<Self> {
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
        let bytes = 4 * size.as_u64vec2().element_product();
        let pixels = Buffer::new(gpu, "draw.pixels", bytes, Residence::Device)?;
        let readback = Buffer::new(gpu, "draw.pixels.readback", bytes, Residence::Readback)?;
        let tonemap = tonemap.bind(&[
            ("Views", views.into()),
            ("color", resolved.as_ref().unwrap_or(&color).into()),
            ("Pixels", (&pixels).into()),
        ])?;
        Ok(Self { color, depth, resolved, pixels, readback, tonemap })
    }
}

/// What a picture consists of, from the back. Each part draws itself, or is not there and costs nothing.
pub struct Layers<'a> {
    /// What hides what is behind it.
    pub opaque: &'a mut dyn FnMut(&mut Recorder<'_>),
    /// Sprites over it, as triangles: they see copied depth, if the stage copies it.
    pub sprites: Option<&'a mut dyn FnMut(&mut Recorder<'_>)>,
    /// Kernels that splat sprites, after all else, and end with [`Splats::record_over`](super::sprites::Splats::record_over).
    pub splats: Option<&'a mut dyn FnMut(&mut Recorder<'_>)>,
}

/// Targets, sky and terrain of a picture of fixed size.
pub struct Stage {
    color: Image,
    depth: Image,
    resolved: Option<Image>,
    copied: Option<CopiedDepth>,
    views: Buffer,
    grid: Grid,
    surroundings: Option<(Terrain, Bound)>,
    kernel: Kernel,
    tonemap: Bound,
    pixels: Buffer,
    readback: Buffer,
    size: UVec2,
    view: View,
    /// Of the light that is baked into the terrain.
    baked_sun: Option<Vec4>,
    to_sun: Vec4,
    /// Colour of an empty picture, linear.
    pub clear: [f32; 4],
}

impl Stage {
    /// With `terrain` under everything and the sky above it, or with nothing.
    ///
    /// # Errors
    /// If the device cannot draw, or has no room.
    pub fn new(gpu: &Gpu, size: UVec2, terrain: Option<TerrainGrid>) -> Result<Self> {
        Self::with_samples(gpu, size, terrain, gpu.samples())
    }

    /// As [`Stage::new`], with `samples` a pixel.
    ///
    /// # Errors
    /// As [`Stage::new`].
    pub fn with_samples(gpu: &Gpu, size: UVec2, terrain: Option<TerrainGrid>, samples: u32) -> Result<Self> {
        let views = Buffer::new(gpu, "draw.views", size_of::<View>() as u64, Residence::Upload)?;
        let grid = Grid::new(gpu)?;
        let sky = RasterInfo {
            name: c"draw.sky",
            vertex: shaders::DRAW_SKY_VERT,
            geometry: None,
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
        let surroundings = match terrain {
            Some(terrain) => {
                let sky = Raster::new::<()>(gpu, &sky)?.bind(&[("Views", (&views).into())])?;
                Some((Terrain::new(gpu, terrain, &views, &grid, samples)?, sky))
            }
            None => None,
        };
        let kernel = Kernel::new::<()>(gpu, &tonemap)?;
        let Targets { color, depth, resolved, pixels, readback, tonemap } =
            Targets::new(gpu, size, samples, &kernel, &views)?;
        Ok(Self {
            surroundings,
            kernel,
            tonemap,
            color,
            depth,
            resolved,
            copied: None,
            views,
            grid,
            pixels,
            readback,
            size,
            view: View::zeroed(),
            baked_sun: None,
            to_sun: Vec4::Y,
            clear: [0.0, 0.0, 0.0, 1.0],
        })
    }

    /// Pictures have another size from now on. What draws to the stage stays bound to it, but for what uses
    /// [`Stage::color`] or [`Stage::depth`], which are new. Pictures on their way keep what they use.
    ///
    /// # Errors
    /// If the device has no room; then nothing has changed.
    pub fn resize(&mut self, gpu: &Gpu, size: UVec2) -> Result<()> {
        let targets = Targets::new(gpu, size, self.samples(), &self.kernel, &self.views)?;
        let copied = self.copied.as_ref().map(|_| CopiedDepth::new(gpu, size)).transpose()?;
        let Targets { color, depth, resolved, pixels, readback, tonemap } = targets;
        (self.color, self.depth, self.resolved) = (color, depth, resolved);
        (self.pixels, self.readback, self.tonemap, self.size) = (pixels, readback, tonemap, size);
        self.copied = None;
        if let Some(copied) = copied {
            self.use_copied(copied);
        }
        Ok(())
    }

    /// From now on copies the depth of what is opaque, for soft and for splatted sprites: costs a second pass over the
    /// targets, and a copy.
    ///
    /// # Errors
    /// If the device has no room.
    pub fn copy_depth(&mut self, gpu: &Gpu) -> Result<()> {
        let copied = CopiedDepth::new(gpu, self.size)?;
        self.use_copied(copied);
        Ok(())
    }

    fn use_copied(&mut self, mut copied: CopiedDepth) {
        if self.samples() == 1 {
            self.depth = copied.image.take().expect("just made");
        }
        self.copied = Some(copied);
    }

    /// What the next picture shows. It gets there with the commands of that picture, so the last one need not be finished.
    pub fn set_view(&mut self, view: &View) {
        let mut view = *view;
        if let Some((terrain, _)) = &self.surroundings {
            let grid = terrain.grid();
            (view.terrain_size_m, view.terrain_cells) = (grid.size_m, grid.cells);
        }
        self.to_sun = view.to_sun;
        self.view = view;
    }

    /// Draws a picture: terrain and sky, then what `body` draws, and turns it to bytes for [`Stage::read`]. What `body`
    /// reads must be visible as [`Access::GraphicsRead`].
    pub fn record(&mut self, rec: &mut Recorder<'_>, body: impl FnOnce(&mut Recorder<'_>)) {
        let mut body = Some(body);
        let mut opaque = |rec: &mut Recorder<'_>| body.take().into_iter().for_each(|body| body(rec));
        self.record_layers(rec, Layers { opaque: &mut opaque, sprites: None, splats: None });
    }

    /// As [`Stage::record`], with sprites over it. What splats read must be visible as [`Access::ComputeRead`].
    pub fn record_layers(&mut self, rec: &mut Recorder<'_>, layers: Layers<'_>) {
        self.record_picture(rec, layers);
        self.record_readback(rec);
    }

    /// Brings the picture to where [`Stage::read`] finds it.
    pub fn record_readback(&self, rec: &mut Recorder<'_>) {
        rec.copy(&self.pixels, &self.readback);
        rec.barrier(Access::CopyWrite, Access::HostRead);
    }

    /// [`Stage::record_layers`] up to the finished bytes, which are in [`Stage::pixels`] for [`Access::CopyRead`].
    pub fn record_picture(&mut self, rec: &mut Recorder<'_>, layers: Layers<'_>) {
        let Layers { opaque, mut sprites, splats } = layers;
        for reader in [Access::GraphicsRead, Access::ComputeRead] {
            rec.barrier(reader, Access::FillWrite); // of the picture before this one
        }
        rec.update(&self.views, slice::from_ref(&self.view));
        for reader in [Access::GraphicsRead, Access::ComputeRead] {
            rec.barrier(Access::FillWrite, reader);
        }
        if let Some((terrain, _)) = self.surroundings.as_ref().filter(|_| self.baked_sun != Some(self.to_sun))
        {
            rec.barrier(Access::GraphicsRead, Access::ComputeReadWrite);
            terrain.record_light(rec);
            self.baked_sun = Some(self.to_sun);
        }
        let resolved = self.resolved.as_ref();
        let copied = self.copied.as_ref();
        let has_second_pass = copied.is_some() && sprites.is_some();
        let target = Target {
            color: Some(&self.color),
            depth: &self.depth,
            resolved: resolved.filter(|_| !has_second_pass),
            resolved_depth: copied.and_then(|copied| copied.image.as_ref()),
            clear: Some(self.clear),
            goes_on: copied.is_some(),
        };
        // The picture before this one may still be on its way to bytes.
        rec.barrier(Access::ComputeRead, Access::ColorWrite);
        rec.barrier(Access::ColorWrite, Access::ColorWrite);
        rec.barrier(Access::DepthWrite, Access::DepthWrite);
        if copied.is_some() {
            rec.barrier(Access::CopyRead, Access::DepthWrite);
            rec.barrier(Access::CopyRead, Access::ColorWrite);
        }
        rec.span(c"draw.scene", |rec| {
            rec.render(&target, |rec| {
                if let Some((terrain, _)) = &self.surroundings {
                    terrain.record_draw(rec);
                }
                opaque(rec);
                if let Some((_, sky)) = &self.surroundings {
                    rec.draw(sky, 3, 1, &()); // last: only where nothing else is
                }
                if let Some(sprites) = sprites.as_mut().filter(|_| !has_second_pass) {
                    sprites(rec);
                }
            });
        });
        if let Some(copied) = copied {
            rec.barrier(Access::DepthWrite, Access::CopyRead);
            rec.barrier(Access::ColorWrite, Access::CopyRead); // where depth is resolved
            rec.barrier(Access::ComputeRead, Access::CopyWrite);
            rec.barrier(Access::GraphicsRead, Access::CopyWrite);
            let image = copied.image.as_ref().unwrap_or(&self.depth);
            rec.span(c"draw.depth", |rec| rec.copy_depth(image, &copied.depth));
            rec.barrier(Access::CopyWrite, Access::GraphicsRead);
            rec.barrier(Access::CopyWrite, Access::ComputeRead);
        }
        self.record_over(rec, sprites.filter(|_| has_second_pass), splats);
        rec.barrier(Access::ColorWrite, Access::ComputeRead);
        rec.barrier(Access::CopyRead, Access::ComputeWrite);
        rec.span(c"draw.tonemap", |rec| rec.dispatch(&self.tonemap, [self.size.x, self.size.y, 1], &()));
        rec.barrier(Access::ComputeWrite, Access::CopyRead);
    }

    /// The second half of [`Stage::record_layers`] on a stage that copies depth: sprites over what its targets hold.
    pub fn record_over(
        &self,
        rec: &mut Recorder<'_>,
        sprites: Option<&mut dyn FnMut(&mut Recorder<'_>)>,
        splats: Option<&mut dyn FnMut(&mut Recorder<'_>)>,
    ) {
        if let Some(sprites) = sprites {
            let (color, depth, resolved) = (Some(&self.color), &self.depth, self.resolved.as_ref());
            let target = Target { color, depth, resolved, resolved_depth: None, clear: None, goes_on: true };
            rec.barrier(Access::ColorWrite, Access::ColorWrite);
            rec.barrier(Access::DepthWrite, Access::DepthWrite);
            rec.span(c"draw.sprites", |rec| rec.render(&target, sprites));
        }
        if let Some(splats) = splats {
            rec.barrier(Access::ColorWrite, Access::ComputeReadWrite);
            splats(rec);
            rec.barrier(Access::ComputeReadWrite, Access::ComputeRead);
        }
    }

    /// The finished picture: four bytes a pixel, sRGB, row by row from the top.
    pub fn read(&self) -> Vec<u8> {
        self.readback.read()
    }

    /// The same on the device.
    pub fn pixels(&self) -> &Buffer {
        &self.pixels
    }

    /// Of the picture (pixels).
    pub fn size(&self) -> UVec2 {
        self.size
    }

    /// What kernels draw over: half floats, one sample a pixel.
    pub fn color(&self) -> &Image {
        self.resolved.as_ref().unwrap_or(&self.color)
    }

    /// `f32` a pixel, row by row from the top, if [`Stage::copy_depth`] was called.
    pub fn depth(&self) -> Option<&Buffer> {
        self.copied.as_ref().map(|copied| &copied.depth)
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

    /// The heightmap, if the stage has one.
    pub fn terrain(&self) -> Option<&Terrain> {
        self.surroundings.as_ref().map(|(terrain, _)| terrain)
    }
}
