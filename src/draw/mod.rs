// SPDX-License-Identifier: MIT OR Apache-2.0
//! What every picture has: a view, targets, sky, the heightmap under everything, and the way to bytes. Simulations draw
//! themselves into it, each in its own `draw` module, from the buffers that they wrote; nothing here steps anything.
//!
//! | kernel          | reads                       | writes       |
//! | --------------- | --------------------------- | ------------ |
//! | `draw.light`    | views, terrain, light       | light        |
//! | `draw.sky`      | views                       | colour       |
//! | `draw.terrain`  | views, terrain, light       | colour, depth |
//! | `draw.tonemap`  | views, colour               | pixels       |
//!
//! [`mesh`] draws triangles that `mesh.pose` has placed, with the sun's [`shadow`]; [`voxels`] shows a grid of cells, and
//! [`map_view`] the maps of painted meshes.
//! [`sprites`] draws particles: as triangles, or by a compute shader where they are small.

mod grid;
pub mod map_view;
pub mod mesh;
pub mod shadow;
pub mod sprites;
mod stage;
mod terrain;
mod view;
pub mod voxels;

pub use grid::Grid;
pub use stage::{Layers, Stage};
pub use terrain::{Built, Terrain, TerrainGrid};
pub use view::{Camera, View};
