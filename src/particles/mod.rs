// SPDX-License-Identifier: MIT OR Apache-2.0
//! Particles.

pub mod black_hole;
pub mod cpu_black_hole;
pub mod black_hole_fate;
pub mod kepler;
pub mod oracle;
