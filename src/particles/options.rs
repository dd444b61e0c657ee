// SPDX-License-Identifier: MIT OR Apache-2.0
//! How a pool is built: compaction, layout, tuning.

use super::Layout;
use crate::gpu::Gpu;

/// How gaps are closed that ended particles leave.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Compaction {
    /// Survivors keep their order, and a run repeats to the bit. Who ends is left out by the next step.
    #[default]
    Stable,
    /// Survivors of a workgroup go together: one atomic for all.
    Group,
    /// One atomic a subgroup.
    Subgroup,
    /// One atomic a particle, as the book has it.
    Atomic,
    /// Nobody moves; births fill free slots.
    InPlace,
    /// Nobody moves; births go to the end, and the beginning is freed by whole tiles. For lives that all last alike: a slot
    /// is free again when all before it are.
    Ring,
}

/// How the slots are cut up. It changes the speed, never the result of [`Compaction::Stable`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tuning {
    /// Invocations of a workgroup.
    pub group: u32,
    /// Particles of an invocation.
    pub items: u32,
    /// Survivors of a workgroup are gathered in shared memory, so that they leave in whole lines.
    pub gathers: bool,
}

impl Tuning {
    /// The fastest of `whitecap bench particles` (docs/particles.md).
    pub fn for_device(gpu: &Gpu) -> Self {
        match gpu.adapter().is_software() {
            true => Self { group: 32, items: 16, gathers: false },
            false => Self { group: 256, items: 2, gathers: true },
        }
    }

    /// Slots that a workgroup takes.
    pub fn tile(self) -> u32 {
        self.group * self.items
    }
}

/// Tiles that are added up together: `BLOCK` in `glsl/particles/step.glsl`.
pub(super) const BLOCK: u32 = 256;

/// Of a particle that is put off: `deferred.words` in `glsl/particles/deferred.glsl`.
pub(super) const DEFERRED_WORDS: u32 = 10;

/// What a pool is built with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// How gaps are closed.
    pub compaction: Compaction,
    /// How a particle lies in memory.
    pub layout: Layout,
    /// How the slots are cut up.
    pub tuning: Tuning,
}

impl Options {
    /// Deterministic, in planes.
    pub fn for_device(gpu: &Gpu) -> Self {
        Self { compaction: Compaction::Stable, layout: Layout::Planes, tuning: Tuning::for_device(gpu) }
    }
}
