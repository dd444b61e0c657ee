// SPDX-License-Identifier: MIT OR Apache-2.0
//! What hard cases, benches and studies share: a basin of either model, run by name, and the time that a step takes.

mod basin;
mod numbers;
mod scheme;
mod timing;

pub use basin::{twin, Basin};
pub use numbers::{apart, farther, larger, rms, Uniform};
pub use scheme::{book_constants, Scheme, Tunings};
pub use timing::{time, Effort, Timing};
