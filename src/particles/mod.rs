// SPDX-License-Identifier: MIT OR Apache-2.0
//! Particles.

pub mod kepler;
pub mod oracle;
