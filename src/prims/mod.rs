// SPDX-License-Identifier: MIT OR Apache-2.0
//! What several simulations need: scan, compaction and counting sort, with the contract of a simulation.
//!
//! | kernel            | reads               | writes         | CPU twin                |
//! | ----------------- | ------------------- | -------------- | ----------------------- |
//! | `prims.reduce`    | values              | sums of tiles  | [`cpu::exclusive_scan`] |
//! | `prims.flags`     | flags               | sums of tiles  | [`cpu::compact`]        |
//! | `prims.sums`      | sums                | sums           | [`cpu::exclusive_scan`] |
//! | `prims.scan`      | values, sums        | scanned        | [`cpu::exclusive_scan`] |
//! | `prims.compact`   | flags, values, sums | kept           | [`cpu::compact`]        |
//! | `prims.bin_count` | keys                | counts, ranks  | [`cpu::sort_by_key`]    |
//! | `prims.bin_place` | keys, firsts, ranks | order          | [`cpu::sort_by_key`]    |
//! | `prims.bin_order` | firsts, order       | order          | [`cpu::sort_by_key`]    |
//!
//! All add up in tiles, then over tiles, then in tiles again (reduce, then scan): three dispatches, a scan of up to four
//! million elements two, and no workgroup waits for another. Within a workgroup sums go through subgroups where the device has their arithmetic, else
//! through shared memory.

pub mod bins;
pub mod compact;
pub mod cpu;
pub mod scan;

pub use bins::{Bins, BinsBound};
pub use compact::{Compact, CompactBound};
pub use scan::{Scan, ScanBound};

use crate::gpu::{Gpu, Kernel, KernelInfo, Result};
use std::ffi::CStr;

/// Invocations of every workgroup.
const GROUP: u32 = 256;
/// Elements that a workgroup of a scan takes.
pub const TILE: u32 = 16 * GROUP;

/// Tiles up to which a scan is two dispatches: `FEW_TILES` in `glsl/prims/params.glsl`.
const FEW_TILES: u32 = 1024;

/// Push constants: `Push` in `glsl/prims/params.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Params {
    /// Elements.
    pub count: u32,
    /// Of [`TILE`] elements each.
    pub tiles: u32,
    /// Keys are below.
    pub bins: u32,
}

/// How a workgroup adds up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sums {
    /// In subgroups.
    Subgroups,
    /// In shared memory: any device.
    Shared,
}

impl Sums {
    /// The better one that the device has.
    pub fn for_device(gpu: &Gpu) -> Self {
        match gpu.adapter().has("subgroup arithmetic") {
            true => Self::Subgroups,
            false => Self::Shared,
        }
    }

    fn of<'a>(self, subgroups: &'a [u8], shared: &'a [u8]) -> &'a [u8] {
        match self {
            Self::Subgroups => subgroups,
            Self::Shared => shared,
        }
    }
}

fn kernel(gpu: &Gpu, name: &CStr, spv: &[u8], blocks: &[&str]) -> Result<Kernel> {
    tuned_kernel(gpu, name, spv, blocks, &[])
}

fn tuned_kernel(gpu: &Gpu, name: &CStr, spv: &[u8], blocks: &[&str], constants: &[u32]) -> Result<Kernel> {
    Kernel::new::<Params>(gpu, &KernelInfo { name, spv, blocks, constants })
}

/// Invocations for `groups` workgroups, in rows that every device can count.
fn threads(groups: u32) -> [u32; 3] {
    let rows = groups.div_ceil(65_535).max(1);
    [groups.div_ceil(rows) * GROUP, rows, 1]
}
