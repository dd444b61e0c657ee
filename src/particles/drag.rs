// SPDX-License-Identifier: MIT OR Apache-2.0
//! The law `drag`: linear drag and a constant pull, in closed form.

use super::Law;
use crate::shaders;
use glam::Vec3;

/// Numbers of the law: `DragLaw` in `glsl/particles/drag.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Drag {
    /// (m/s^2).
    pub pull_mps2: Vec3,
    /// Part of the velocity that is lost (1/s), 0 or more.
    pub drag_per_s: f32,
}

impl Drag {
    /// Its kernel.
    pub const LAW: Law<'static> = Law {
        name: c"particles.drag",
        spv: shaders::PARTICLES_DRAG_COMP,
        subgroups: Some(shaders::PARTICLES_DRAG_SUBGROUP_COMP),
        deferred: None,
        constants: &[],
        blocks: &[],
    };
}
