// SPDX-License-Identifier: MIT OR Apache-2.0
//! GPU simulations for real-time scenes, in Vulkan and GLSL, each checked against an f64 twin on the CPU.
//!
//! - [`gpu`]: thin Vulkan core; a device of its own, or the caller's.
//! - [`water`]: heightfield water by virtual pipes.
#![warn(missing_docs)]

pub mod gpu;
pub mod water;

/// SPIR-V of every file under `glsl/`, compiled when the crate is built.
pub mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}
