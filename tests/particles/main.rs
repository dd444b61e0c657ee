// SPDX-License-Identifier: MIT OR Apache-2.0
//! Particles against their twins and exact solutions.
#![allow(missing_docs)]

mod black_hole;
mod colliding;
#[path = "../common/mod.rs"]
mod common;
mod kepler;
mod layouts;
mod pool;
