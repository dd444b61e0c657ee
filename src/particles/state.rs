// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a pool counts on the GPU, and a pool at rest.

use super::layout::CANARY;
#[cfg(doc)]
use super::{EmitterState, EmitterWords, Layout, Pool};

/// Counts and arguments on the GPU: `PoolState` in `glsl/particles/state.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct PoolState {
    /// Indirect dispatch of the advance.
    pub groups_x: u32,
    /// The same.
    pub groups_y: u32,
    /// The same.
    pub groups_z: u32,
    /// In use, from `first` on; in some a particle has ended.
    pub slots: u32,
    /// Indirect draw of six vertices a slot, at [`PoolState::QUADS`].
    pub quad_vertices: u32,
    /// The same.
    pub quad_instances: u32,
    /// The same.
    pub quad_first_vertex: u32,
    /// The same.
    pub quad_first_instance: u32,
    /// Indirect draw of a vertex a slot, at [`PoolState::POINTS`].
    pub point_vertices: u32,
    /// The same.
    pub point_instances: u32,
    /// The same.
    pub point_first_vertex: u32,
    /// The same.
    pub point_first_instance: u32,
    /// Indirect dispatch of workgroups of 256, an invocation a slot, at [`PoolState::READERS`].
    pub reader_groups_x: u32,
    /// The same.
    pub reader_groups_y: u32,
    /// The same.
    pub reader_groups_z: u32,
    /// Slot of the first: not 0 in a ring.
    pub first: u32,
    /// Most particles.
    pub capacity: u32,
    /// Words from one plane to the next.
    pub stride: u32,
    /// Tick that the particles are at.
    pub now: u32,
    /// Of every particle.
    pub life_ticks: u32,
    /// Slots that the last step read.
    pub sources: u32,
    /// Of the last step.
    pub births: u32,
    /// Slots written in the last step by those who count them as they go.
    pub appended: u32,
    /// Where the queue of free slots begins.
    pub free_first: u32,
    /// Its length.
    pub free_count: u32,
    /// By the births of the last step.
    pub taken: u32,
    /// Which third of the counts of tiles the last step read: it counted in the next.
    pub turn: u32,
    /// Workgroups of the last step, where they are counted.
    pub finished: u32,
    /// Low word of [`Counts::born`].
    pub born: u32,
    /// Low word.
    pub dropped: u32,
    /// Low word.
    pub aged: u32,
    /// Low word.
    pub ended: u32,
    /// Low word.
    pub spoiled: u32,
    /// High word.
    pub born_high: u32,
    /// High word.
    pub dropped_high: u32,
    /// High word.
    pub aged_high: u32,
    /// High word.
    pub ended_high: u32,
    /// High word.
    pub spoiled_high: u32,
}

impl PoolState {
    /// Offset of the arguments of a draw of six vertices a slot (bytes).
    pub const QUADS: u64 = std::mem::offset_of!(Self, quad_vertices) as u64;
    /// Offset of the arguments of a draw of a vertex a slot (bytes).
    pub const POINTS: u64 = std::mem::offset_of!(Self, point_vertices) as u64;
    /// Offset of the arguments of a dispatch of workgroups of 256, an invocation a slot (bytes).
    pub const READERS: u64 = std::mem::offset_of!(Self, reader_groups_x) as u64;
}

/// What has become of all particles so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Taken into the pool.
    pub born: u64,
    /// Born when there was no room.
    pub dropped: u64,
    /// Ended by age.
    pub aged: u64,
    /// Ended by the law.
    pub ended: u64,
    /// Ended because a number was none.
    pub spoiled: u64,
}

impl Counts {
    pub(super) fn of(state: &PoolState) -> Self {
        let both = |low: u32, high: u32| u64::from(high) << 32 | u64::from(low);
        Self {
            born: both(state.born, state.born_high),
            dropped: both(state.dropped, state.dropped_high),
            aged: both(state.aged, state.aged_high),
            ended: both(state.ended, state.ended_high),
            spoiled: both(state.spoiled, state.spoiled_high),
        }
    }

    /// In the pool now.
    pub fn alive(&self) -> u64 {
        self.born - self.aged - self.ended - self.spoiled
    }
}

/// A pool at rest: words of its buffers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Snapshot {
    /// In the pool's layout.
    pub particles: Vec<u32>,
    /// [`PoolState`].
    pub state: Vec<u32>,
    /// [`EmitterWords`].
    pub emitters: Vec<u32>,
    /// [`EmitterState`].
    pub births: Vec<u32>,
    /// Of the law.
    pub law: Vec<u32>,
    /// Counts of tiles, or free slots.
    pub places: Vec<u32>,
    /// Tick that the particles are at.
    pub now: u32,
}

impl Snapshot {
    /// Words behind planes and lists that something has overwritten; not of [`Layout::Records`].
    pub fn trespasses(&self, capacity: u32) -> usize {
        let stride = (capacity + 1).next_multiple_of(32) as usize;
        let planes = self.particles.len() / stride;
        let behind =
            (0..planes).flat_map(|w| &self.particles[w * stride + capacity as usize..(w + 1) * stride]);
        let last = |list: &[u32], words: usize| list[list.len() - words..].to_vec();
        let lists = [last(&self.emitters, 12), last(&self.births, 8), last(&self.places, 1)].concat();
        behind.chain(&lists).filter(|word| **word != CANARY).count()
    }
}
