// SPDX-License-Identifier: MIT OR Apache-2.0
//! Particles against their twins.
#![allow(missing_docs)]

#[path = "../common/mod.rs"]
mod common;
mod layouts;
mod pool;
