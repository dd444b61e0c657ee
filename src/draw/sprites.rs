// SPDX-License-Identifier: MIT OR Apache-2.0
//! Particles as sprites: `glsl/draw/sprite.glsl` says what a sprite is, and what an effect has to say.

use super::Stage;
use crate::{
    gpu::{
        Access, Blend, Bound, Buffer, Depth, Error, Gpu, Kernel, KernelInfo, Raster, RasterInfo, Recorder,
        Residence, Resource, Result, Topology,
    },
    shaders,
};
use std::ffi::CStr;

/// How triangles come about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Path<'a> {
    /// `draw/sprites_vert.glsl`: six vertices a sprite.
    Quads {
        /// SPIR-V of the effect's vertex shader.
        vertex: &'a [u8],
    },
    /// `draw/sprites_geom.glsl`: one vertex a sprite, as the book has it.
    Geometry {
        /// SPIR-V of the effect's geometry shader.
        geometry: &'a [u8],
    },
}

/// What an effect needs to be drawn.
#[derive(Clone, Copy)]
pub struct SpritesInfo<'a> {
    /// `module.pass`.
    pub name: &'a CStr,
    /// The effect's shader.
    pub path: Path<'a>,
    /// Blocks of the effect, in binding order: `Terrain` and `Light` if it asks for the ground, and those from 8 on.
    pub resources: &'a [(&'a str, Resource<'a>)],
    /// Instead of a soft disc.
    pub texture: Option<&'a Texture>,
    /// Fades where it meets the scene: for sprites that are large. The stage must copy its depth.
    pub soft: bool,
    /// Specialization constants.
    pub constants: &'a [u32],
}

/// An effect as triangles, blended over the picture: premultiplied, so that alpha 0 adds. Depth is tested and not written.
/// What covers is laid over in the order of its numbers, which is right for the oldest first and a guess for the rest;
/// what adds needs no order.
pub struct Sprites {
    bound: Bound,
    vertices: u32,
}

impl Sprites {
    /// What the effect's buffers must be visible to before [`Sprites::record`].
    pub const ENTRY: Access = Access::GraphicsRead;
    /// Vertices a sprite of [`Path::Quads`]; of [`Path::Geometry`] it is one.
    pub const VERTICES: u32 = 6;

    /// `P`: push constants of the effect.
    ///
    /// # Errors
    /// If the device cannot draw, lacks geometry shaders, or the effect's blocks differ.
    ///
    /// # Panics
    /// If soft sprites are asked for on a stage that copies no depth.
    pub fn new<P>(gpu: &Gpu, stage: &Stage, info: &SpritesInfo<'_>) -> Result<Self> {
        let mut used = vec![("Views", stage.views().into())];
        let is_ground = |name: &str| name == "Terrain" || name == "Light";
        used.extend(info.resources.iter().filter(|(name, _)| is_ground(name)));
        used.extend(info.texture.map(|texture| ("Texture", (&texture.texels).into())));
        if info.soft {
            used.push(("Depth", stage.depth().expect("a stage that copies depth").into()));
        }
        used.extend(info.resources.iter().filter(|(name, _)| !is_ground(name)));
        let blocks: Vec<&str> = used.iter().map(|(name, _)| *name).collect();
        let (vertex, geometry, topology, vertices) = match info.path {
            Path::Quads { vertex } => (vertex, None, Topology::Triangles, Self::VERTICES),
            Path::Geometry { geometry } => {
                (shaders::DRAW_SPRITES_POINT_VERT, Some(geometry), Topology::Points, 1)
            }
        };
        let raster = RasterInfo {
            name: info.name,
            vertex,
            geometry,
            fragment: match (info.texture.is_some(), info.soft) {
                (false, false) => shaders::DRAW_SPRITES_FRAG,
                (false, true) => shaders::DRAW_SPRITES_SOFT_FRAG,
                (true, false) => shaders::DRAW_SPRITES_TEXTURE_FRAG,
                (true, true) => shaders::DRAW_SPRITES_TEXTURE_SOFT_FRAG,
            },
            blocks: &blocks,
            constants: info.constants,
            topology,
            blend: Blend::Over,
            depth: Depth::Test,
            samples: stage.samples(),
        };
        Ok(Self { bound: Raster::new::<P>(gpu, &raster)?.bind(&used)?, vertices })
    }

    /// Vertices of a sprite.
    pub fn vertices(&self) -> u32 {
        self.vertices
    }

    /// Draws `count` sprites, inside [`Stage::record_layers`].
    ///
    /// # Panics
    /// If `params` is not the effect's.
    pub fn record<P: bytemuck::Pod>(&self, rec: &mut Recorder<'_>, count: u32, params: &P) {
        rec.draw(&self.bound, self.vertices * count, 1, params);
    }

    /// Draws as four words at `offset` of `args` say: `VERTICES` times the number of sprites, 1, 0, 0.
    ///
    /// # Panics
    /// As [`Sprites::record`].
    pub fn record_indirect<P: bytemuck::Pod>(
        &self,
        rec: &mut Recorder<'_>,
        args: &Buffer,
        offset: u64,
        params: &P,
    ) {
        rec.draw_indirect(&self.bound, args, offset, params);
    }
}

/// The sums of splatted sprites: `glsl/draw/splats.glsl`. One serves all effects of a stage.
pub struct Splats {
    sums: Buffer,
    over: Bound,
    size: [u32; 2],
}

impl Splats {
    /// Of the sums (bytes a pixel).
    pub const BYTES_A_PIXEL: u64 = 16;

    /// # Errors
    /// The device's.
    pub fn new(gpu: &Gpu, stage: &Stage) -> Result<Self> {
        Self::of(gpu, stage, c"draw.splat_over", shaders::DRAW_SPLAT_OVER_COMP)
    }

    /// Of effects that are compiled with `SPLATS_PACKED`.
    ///
    /// # Errors
    /// [`Error::Interface`] on a device without atomics of 64 bits, see [`Gpu::has_wide_atomics`]; else the device's.
    pub fn packed(gpu: &Gpu, stage: &Stage) -> Result<Self> {
        if !gpu.has_wide_atomics() {
            let what = format!("{} has no atomics of 64 bits", gpu.name());
            return Err(Error::Interface { kernel: "draw.splat_over_packed".into(), what });
        }
        Self::of(gpu, stage, c"draw.splat_over_packed", shaders::DRAW_SPLAT_OVER_PACKED_COMP)
    }

    fn of(gpu: &Gpu, stage: &Stage, name: &CStr, spv: &[u8]) -> Result<Self> {
        let size = stage.size();
        let bytes = Self::BYTES_A_PIXEL * size.as_u64vec2().element_product();
        let sums = Buffer::new(gpu, "draw.splats", bytes, Residence::Device)?;
        gpu.once(|rec| {
            rec.fill(&sums, 0);
            rec.barrier(Access::FillWrite, Access::ComputeReadWrite);
        })?;
        let over = KernelInfo { name, spv, blocks: &["Views", "color", "Splats"], constants: &[] };
        let over = Kernel::new::<()>(gpu, &over)?.bind(&[
            ("Views", stage.views().into()),
            ("color", stage.color().into()),
            ("Splats", (&sums).into()),
        ])?;
        Ok(Self { sums, over, size: size.to_array() })
    }

    /// Lays the sums over the picture and clears them: after all effects, in the splats of [`Stage::record_layers`].
    pub fn record_over(&self, rec: &mut Recorder<'_>) {
        rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        let [width, height] = self.size;
        rec.span(c"draw.splat_over", |rec| rec.dispatch(&self.over, [width, height, 1], &()));
    }
}

/// An effect whose sprites are splatted by a compute shader: for sprites of a few pixels, in any order.
pub struct SplatSprites {
    bound: Bound,
    name: &'static CStr,
}

impl SplatSprites {
    /// What the effect's buffers must be visible to before [`SplatSprites::record`].
    pub const ENTRY: Access = Access::ComputeRead;
    /// Sprites in a row of as many workgroups of 128 as every device allows.
    const ROW: u32 = 65_535 * 128;

    /// `spv`: the effect's kernel, of `draw/sprites_splat.glsl`; `resources` as in [`SpritesInfo`]; `P`: its push constants.
    ///
    /// # Errors
    /// If the effect's blocks differ.
    ///
    /// # Panics
    /// If the stage copies no depth.
    pub fn new<P>(
        gpu: &Gpu,
        stage: &Stage,
        splats: &Splats,
        (name, spv): (&'static CStr, &[u8]),
        resources: &[(&str, Resource<'_>)],
    ) -> Result<Self> {
        let is_ground = |name: &str| name == "Terrain" || name == "Light";
        let mut used: Vec<(&str, Resource<'_>)> = vec![("Views", stage.views().into())];
        used.extend(resources.iter().filter(|(name, _)| is_ground(name)));
        used.push(("Depth", stage.depth().expect("a stage that copies depth").into()));
        used.push(("Splats", (&splats.sums).into()));
        used.extend(resources.iter().filter(|(name, _)| !is_ground(name)));
        let blocks: Vec<&str> = used.iter().map(|(name, _)| *name).collect();
        let info = KernelInfo { name, spv, blocks: &blocks, constants: &[] };
        Ok(Self { bound: Kernel::new::<P>(gpu, &info)?.bind(&used)?, name })
    }

    /// Adds the light of `count` sprites at the most (the effect knows its last), in the splats of
    /// [`Stage::record_layers`].
    ///
    /// # Panics
    /// If `params` is not the effect's.
    pub fn record<P: bytemuck::Pod>(&self, rec: &mut Recorder<'_>, count: u32, params: &P) {
        let threads = [count.min(Self::ROW), count.div_ceil(Self::ROW), 1];
        rec.span(self.name, |rec| rec.dispatch(&self.bound, threads, params));
    }

    /// The same of as many as three words at `offset` of `args` say: workgroups of 128.
    ///
    /// # Panics
    /// As [`SplatSprites::record`].
    pub fn record_indirect<P: bytemuck::Pod>(
        &self,
        rec: &mut Recorder<'_>,
        args: &Buffer,
        offset: u64,
        params: &P,
    ) {
        rec.span(self.name, |rec| rec.dispatch_indirect(&self.bound, args, offset, params));
    }
}

/// A picture on a sprite: linear, premultiplied, with all its levels, in a buffer.
pub struct Texture {
    texels: Buffer,
}

impl Texture {
    /// Of `rgba`, 8-bit sRGB and alpha, row by row from the top.
    ///
    /// # Errors
    /// The device's.
    ///
    /// # Panics
    /// If `rgba` is not of that size, or empty.
    pub fn new(gpu: &Gpu, [width, height]: [u32; 2], rgba: &[u8]) -> Result<Self> {
        let (mut w, mut h) = (width as usize, height as usize);
        assert!(w * h > 0 && rgba.len() == 4 * w * h, "{} bytes for {width} x {height}", rgba.len());
        let linear = |byte: u8| {
            let x = f32::from(byte) / 255.0;
            if x <= 0.04045 {
                x / 12.92
            } else {
                ((x + 0.055) / 1.055).powf(2.4)
            }
        };
        let texel = |t: &[u8]| {
            let alpha = f32::from(t[3]) / 255.0;
            [linear(t[0]) * alpha, linear(t[1]) * alpha, linear(t[2]) * alpha, alpha]
        };
        let mut level: Vec<[f32; 4]> = rgba.chunks_exact(4).map(texel).collect();
        let mut levels = 1;
        let mut all = level.clone();
        while w.max(h) > 1 {
            // Each half as large, an odd last row or column left out.
            let (nw, nh) = ((w / 2).max(1), (h / 2).max(1));
            let at = |x: usize, y: usize| level[y.min(h - 1) * w + x.min(w - 1)];
            let mean = |i: usize| {
                let (x, y) = (2 * (i % nw), 2 * (i / nw));
                let four = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
                std::array::from_fn(|k| 0.25 * four.iter().map(|t| t[k]).sum::<f32>())
            };
            level = (0..nw * nh).map(mean).collect();
            (w, h, levels) = (nw, nh, levels + 1);
            all.extend(&level);
        }
        let mut words: Vec<f32> = [width, height, levels, 0].map(f32::from_bits).to_vec();
        words.extend(all.as_flattened());
        Ok(Self { texels: gpu.upload("draw.texture", &words)? })
    }
}

/// Sprites that stand in a list: `glsl/draw/list.glsl`. Mirrors `Sprite` word by word.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Sprite {
    /// Centre (m).
    pub at_m: [f32; 3],
    /// Half of a streak, from the centre to its head (m); zero faces the eye.
    pub along_m: [f32; 3],
    /// Half width and half height (m); of a streak, half width.
    pub half_m: [f32; 2],
    /// Counter-clockwise, part of a turn.
    pub turn: f32,
    /// Linear, premultiplied; alpha 0 adds.
    pub color: [f32; 4],
}
