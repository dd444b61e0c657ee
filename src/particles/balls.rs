// SPDX-License-Identifier: MIT OR Apache-2.0
//! Draws a pool as balls, lit by the sun and with shadows, by a ray a pixel: `glsl/particles/balls*`.

use super::PoolState;
use crate::{
    draw::{shadow::Shadow, Stage},
    gpu::{
        Access, Attachments, Blend, Bound, Buffer, Depth, Gpu, Raster, RasterInfo, Recorder, Result, Topology,
    },
    shaders,
};
use glam::Vec4;

/// Push constants: `BallParams` in `glsl/particles/ball_params.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct BallParams {
    /// Linear albedo; w: radius (m).
    pub color: Vec4,
    /// Colours are between the two, by the time of birth; w: how much of the sun is mirrored.
    pub far_color: Vec4,
}

/// Two pipelines for one of the two buffers of a pool: into the picture, and into the map of shadows.
pub struct BallsDraw {
    draw: Bound,
    cast: Bound,
    state: Buffer,
    params: BallParams,
}

impl BallsDraw {
    /// What particles must be visible to before [`BallsDraw::record`], and their counts as well; the arguments to
    /// [`Access::IndirectRead`].
    pub const ENTRY: Access = Access::GraphicsRead;

    /// `state` and `particles`: of a pool in planes.
    ///
    /// # Errors
    /// If the device cannot draw.
    pub fn new(
        gpu: &Gpu,
        stage: &Stage,
        shadow: &Shadow,
        (state, particles): (&Buffer, &Buffer),
        params: BallParams,
    ) -> Result<Self> {
        let [shadows, shadow_depth] = shadow.resources();
        let draw = RasterInfo {
            name: c"particles.balls",
            vertex: shaders::PARTICLES_BALLS_VERT,
            geometry: None,
            fragment: shaders::PARTICLES_BALLS_FRAG,
            blocks: &["Views", "Shadows", "ShadowDepth", "Pool", "Particles"],
            constants: &[],
            topology: Topology::Triangles,
            blend: Blend::Opaque,
            depth: Depth::Write,
            samples: stage.samples(),
        };
        let cast = RasterInfo {
            name: c"particles.balls_shadow",
            vertex: shaders::PARTICLES_BALLS_SHADOW_VERT,
            fragment: shaders::PARTICLES_BALLS_SHADOW_FRAG,
            blocks: &["Shadows", "Pool", "Particles"],
            samples: 1,
            ..draw
        };
        let (pool, particles) = (("Pool", state.into()), ("Particles", particles.into()));
        let views = ("Views", stage.views().into());
        Ok(Self {
            draw: Raster::new::<BallParams>(gpu, &draw)?.bind(&[
                views,
                shadows,
                shadow_depth,
                pool,
                particles,
            ])?,
            cast: Raster::onto::<BallParams>(gpu, &cast, Attachments::Depth)?.bind(&[
                ("Shadows", shadow.views().into()),
                pool,
                particles,
            ])?,
            state: state.clone(),
            params,
        })
    }

    /// Draws all that live, inside [`Stage::record`].
    pub fn record(&self, rec: &mut Recorder<'_>) {
        rec.draw_indirect(&self.draw, &self.state, PoolState::QUADS, &self.params);
    }

    /// Draws their depth, inside [`Shadow::record`].
    pub fn record_shadow(&self, rec: &mut Recorder<'_>) {
        rec.draw_indirect(&self.cast, &self.state, PoolState::QUADS, &self.params);
    }
}
