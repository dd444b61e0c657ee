// SPDX-License-Identifier: MIT OR Apache-2.0
//! GPU simulations for real-time scenes, in Vulkan and GLSL, each checked against an f64 twin on the CPU.
//!
//! - [`gpu`]: thin Vulkan core; a device of its own, or the caller's.
//! - [`check`]: what a simulation says of a parameter that it cannot run with.
//! - [`random`]: random numbers by hash, the same on every device.
//! - [`prims`]: scan, compaction, counting sort.
//! - [`impact`]: the impact stream, from those who move to those who paint.
//! - [`mesh`]: triangles from files or made, posed on the GPU.
//! - [`cells`]: a grid of cells with planes of the scene: what is collided with.
//! - [`draw`]: what every picture has: view, targets, sky, terrain, sprites.
//! - [`water`]: heightfield water by virtual pipes.
//! - [`particles`]: pools of particles with a law: black holes, drag, the user's own.
//! - [`ballistic`]: closed-form effects: fire, rain and the like, without a state.
//! - [`disks`]: disks and spheres that collide, sorted into cells.
//! - [`paint`]: paint on meshes, from impacts or from particles that are near.
//! - [`volume`]: which cells the scene is in, with planes and velocities of its surface.
//! - `scene`: scene files, checked and explained (feature `tools`).
//! - `run`: the headless runner: clock, pictures, clip, statistics (feature `tools`).
//! - `view`: a scene in a window (feature `viewer`).
//! - `study`: hard cases, throughput, speed against error (feature `tools`).
#![warn(missing_docs)]

pub mod ballistic;
pub mod cells;
pub mod check;
pub mod clock;
pub mod disks;
pub mod draw;
pub mod gpu;
pub mod impact;
pub mod mesh;
pub mod paint;
pub mod particles;
pub mod prims;
pub mod random;
#[cfg(feature = "tools")]
pub mod run;
#[cfg(feature = "tools")]
pub mod scene;
#[cfg(feature = "tools")]
pub mod study;
#[cfg(feature = "viewer")]
pub mod view;
pub mod volume;
pub mod water;

/// SPIR-V of every file under `glsl/`, compiled when the crate is built.
pub mod shaders {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}
