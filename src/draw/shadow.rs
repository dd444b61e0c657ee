// SPDX-License-Identifier: MIT OR Apache-2.0
//! The sun's shadow: a map of depth along its light, drawn before the picture, read by what is lit: `glsl/draw/shadow.glsl`.
//! Meshes and balls cast and receive it; terrain and water have the light that is baked into the heightmap.

use crate::gpu::{Access, Buffer, Gpu, Image, ImageUse, Recorder, Residence, Resource, Result, Target};
use glam::{Vec3, Vec4};
use std::slice;

/// What a shader knows of the map: `Shadow` in `glsl/draw/shadow.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ShadowView {
    /// Unit, across the light; w: half of the square (m).
    pub right: Vec4,
    /// Unit; w: texels along the square.
    pub up: Vec4,
    /// Unit; w: depth runs from 1 at so far towards the sun to 0 at so far behind (m).
    pub to_sun: Vec4,
    /// (m).
    pub centre_m: Vec4,
}

impl ShadowView {
    /// A map of `side` texels that sees a ball of `radius_m` round `centre_m` from the sun.
    pub fn new(centre_m: Vec3, radius_m: f32, to_sun: Vec3, side: u32) -> Self {
        let to_sun = to_sun.normalize_or(Vec3::Y);
        let right = to_sun.any_orthonormal_vector();
        let radius_m = radius_m.max(1e-3);
        Self {
            right: right.extend(radius_m),
            up: to_sun.cross(right).extend(side as f32),
            to_sun: to_sun.extend(8.0 * radius_m), // what is outside the ball may cast a shadow into it
            centre_m: centre_m.extend(0.0),
        }
    }
}

/// The map.
pub struct Shadow {
    view: ShadowView,
    views: Buffer,
    depth: Buffer,
    drawn: Image,
}

impl Shadow {
    /// How the map was written last, and what those who read it see it as.
    pub const EXIT: Access = Access::GraphicsRead;
    /// Of the map (bytes a texel): depth, and its copy that shaders read.
    pub const BYTES_A_TEXEL: u64 = 4 + 4;

    /// Of `side` texels along each side.
    ///
    /// # Errors
    /// If the device cannot draw, or has no room.
    pub fn new(gpu: &Gpu, side: u32) -> Result<Self> {
        let image = |name, purpose| Image::new(gpu, name, [side, side], purpose, 1);
        let views = Buffer::new(gpu, "draw.shadow.view", size_of::<ShadowView>() as u64, Residence::Device)?;
        Ok(Self {
            view: bytemuck::Zeroable::zeroed(),
            views,
            depth: Buffer::new(gpu, "draw.shadow", 4 * u64::from(side).pow(2), Residence::Device)?,
            drawn: image("draw.shadow.depth", ImageUse::CopiedDepth)?,
        })
    }

    /// Texels along a side.
    pub fn side(&self) -> u32 {
        self.drawn.size()[0]
    }

    /// What the next map shows: maps on their way are not disturbed.
    pub fn set_view(&mut self, view: &ShadowView) {
        self.view = *view;
    }

    /// `Shadows` and `ShadowDepth`, for pipelines that are lit.
    pub fn resources(&self) -> [(&'static str, Resource<'_>); 2] {
        [("Shadows", (&self.views).into()), ("ShadowDepth", (&self.depth).into())]
    }

    /// `Shadows`, for pipelines that draw into the map.
    pub fn views(&self) -> &Buffer {
        &self.views
    }

    /// Draws the map: what `casters` draw, by pipelines of [`Attachments::Depth`](crate::gpu::Attachments::Depth) and one
    /// sample a pixel. What they read must be visible as
    /// [`Access::GraphicsRead`].
    pub fn record(&self, rec: &mut Recorder<'_>, casters: impl FnOnce(&mut Recorder<'_>)) {
        let target = Target {
            color: None,
            depth: &self.drawn,
            resolved: None,
            resolved_depth: None,
            clear: Some([0.0; 4]), // and depth
            goes_on: true,
        };
        rec.barrier(Access::GraphicsRead, Access::FillWrite); // of the picture before this one
        rec.update(&self.views, slice::from_ref(&self.view));
        rec.barrier(Access::FillWrite, Access::GraphicsRead);
        rec.barrier(Access::CopyRead, Access::DepthWrite);
        rec.barrier(Access::DepthWrite, Access::DepthWrite);
        rec.span(c"draw.shadow", |rec| rec.render(&target, casters));
        rec.barrier(Access::DepthWrite, Access::CopyRead);
        rec.barrier(Access::GraphicsRead, Access::CopyWrite);
        rec.copy_depth(&self.drawn, &self.depth);
        rec.barrier(Access::CopyWrite, Self::EXIT);
    }
}
