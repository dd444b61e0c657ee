// SPDX-License-Identifier: MIT OR Apache-2.0
//! GPU simulations for real-time scenes, in Vulkan and GLSL, each checked against an f64 twin on the CPU.
//!
//! - [`gpu`]: thin Vulkan core; a device of its own, or the caller's.
//! - [`mesh`]: triangles for simulations, from files or made, posed on the GPU.
//! - [`random`]: random numbers by hash, the same on every device.
//! - [`draw`]: what every picture has: view, targets, sky, terrain.
//! - [`water`]: heightfield water by virtual pipes.
//! - `scene`: scene files, checked and explained (feature `tools`).
//! - `run`: the headless runner: clock, pictures, clip, statistics (feature `tools`).
//! - `study`: hard cases, throughput, speed against error (feature `tools`).
#![warn(missing_docs)]

pub mod clock;
pub mod draw;
pub mod gpu;
pub mod mesh;
pub mod random;
#[cfg(feature = "tools")]
pub mod run;
#[cfg(feature = "tools")]
pub mod scene;
#[cfg(feature = "tools")]
pub mod study;
pub mod water;

/// SPIR-V of every file under `glsl/`, compiled when the crate is built.
pub mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}
