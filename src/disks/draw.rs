// SPDX-License-Identifier: MIT OR Apache-2.0
//! Draws disks from above, and spheres by a ray a pixel, from the buffers that the simulation wrote: `glsl/disks/draw*`.

use super::{SortedState, Space};
use crate::{
    draw::Stage,
    gpu::{Access, Blend, Bound, Depth, Gpu, Raster, RasterInfo, Recorder, Result, Topology},
    shaders,
};
use glam::Vec3;

/// Push constants: `DrawParams` in `glsl/disks/draw.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DrawParams {
    /// The box (m).
    pub size_m: [f32; 4],
    /// Where its lowest corner is in the world (m).
    pub origin_m: [f32; 4],
    /// Of the simulation.
    pub step: u32,
    /// (s).
    pub dt_s: f32,
    /// Unused.
    pub reserved: [u32; 2],
}

/// A pipeline for one box.
pub struct DisksDraw {
    bound: Bound,
    origin_m: Vec3,
}

impl DisksDraw {
    /// What the state must be visible to before [`DisksDraw::record`].
    pub const ENTRY: Access = Access::GraphicsRead;

    /// A box of disks fills the picture; a box of spheres has its lowest corner at `origin_m` of the world.
    ///
    /// # Errors
    /// If the device cannot draw.
    pub fn new(gpu: &Gpu, stage: &Stage, state: &SortedState, origin_m: Vec3) -> Result<Self> {
        let flat = RasterInfo {
            name: c"disks.draw",
            vertex: shaders::DISKS_DRAW_VERT,
            geometry: None,
            fragment: shaders::DISKS_DRAW_FRAG,
            blocks: &["Views", "Place", "Hit"],
            constants: &[],
            topology: Topology::Triangles,
            blend: Blend::Over,
            depth: Depth::Test,
            samples: stage.samples(),
        };
        let (views, place) = (("Views", stage.views().into()), ("Place", state.place().into()));
        let hit = ("Hit", state.hits().into());
        let bound = match state.space() {
            Space::Flat => Raster::new::<DrawParams>(gpu, &flat)?.bind(&[views, place, hit])?,
            Space::Solid => {
                let solid = RasterInfo {
                    name: c"disks.draw_solid",
                    vertex: shaders::DISKS_DRAW_SOLID_VERT,
                    fragment: shaders::DISKS_DRAW_SOLID_FRAG,
                    blocks: &["Views", "Place", "Motion", "Hit"],
                    blend: Blend::Opaque,
                    depth: Depth::Write,
                    ..flat
                };
                let motion = ("Motion", state.motion().into());
                Raster::new::<DrawParams>(gpu, &solid)?.bind(&[views, place, motion, hit])?
            }
        };
        Ok(Self { bound, origin_m })
    }

    /// Draws all disks, inside [`Stage::record`].
    pub fn record(&self, rec: &mut Recorder<'_>, state: &SortedState) {
        let p = state.params();
        let params = DrawParams {
            size_m: p.size_m,
            origin_m: self.origin_m.extend(0.0).to_array(),
            step: p.step,
            dt_s: p.dt_s,
            reserved: [0; 2],
        };
        rec.draw(&self.bound, 6, p.disks, &params);
    }
}
