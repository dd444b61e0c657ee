// SPDX-License-Identifier: MIT OR Apache-2.0
//! Particles as drops. Reads `glsl/paint/take.comp`.

use super::{Drop, Paint};
use crate::gpu::{Bound, Buffer, Recorder, Result};

/// Push constants: `TakeParams` in `glsl/paint/take.comp`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct TakeParams {
    /// Drops to write.
    pub most: u32,
    /// Words from one plane to the next.
    pub stride: u32,
    /// Word of the counts that says how many particles there are.
    pub count_at: u32,
    /// Whose paint they leave.
    pub source: u32,
    /// The first drop to write.
    pub to: u32,
}

impl Paint {
    /// From `planes`, x, y and z of particles, `f32`, as many as a word of `counts` says, to `drops`.
    ///
    /// # Errors
    /// The device's.
    pub fn take(&self, planes: &Buffer, counts: &Buffer, drops: &Buffer) -> Result<Take> {
        let bound = self.take.bind(&[
            ("Planes", planes.into()),
            ("Counts", counts.into()),
            ("Drops", drops.into()),
        ])?;
        let words = |buffer: &Buffer| buffer.bytes() / 4;
        let room = (drops.bytes() / size_of::<Drop>() as u64) as u32;
        Ok(Take { bound, planes: words(planes), counts: words(counts), room })
    }
}

/// Particles of one pool on their way to one buffer of drops.
pub struct Take {
    bound: Bound,
    planes: u64,
    counts: u64,
    room: u32,
}

impl Take {
    /// Records it. Submits nothing, waits for nothing, allocates nothing.
    ///
    /// # Panics
    /// If there are no such planes, no such word, or no room.
    pub fn record(&self, rec: &mut Recorder<'_>, p: &TakeParams) {
        let last = 2 * u64::from(p.stride) + u64::from(p.most);
        assert!(p.most <= p.stride && last <= self.planes, "{p:?} of {} words", self.planes);
        assert!(u64::from(p.count_at) < self.counts, "{p:?} of {} counts", self.counts);
        assert!(u64::from(p.to) + u64::from(p.most) <= u64::from(self.room), "{p:?} in {} drops", self.room);
        let threads = super::spread(p.most.div_ceil(256), 256);
        rec.span(c"paint.take", |rec| rec.dispatch(&self.bound, threads, p));
    }
}
