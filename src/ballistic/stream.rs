// SPDX-License-Identifier: MIT OR Apache-2.0
//! `stream`: the stored list, written by transform feedback and drawn by its byte count, as the book does with stream-out and
//! DrawAuto. To port from and to; where the device has none, [`StoredEffect`](super::StoredEffect) does the same.

use super::{emission::Moment, stored::Particle, Effect, GroundGrid, Params};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Recorder, Result, Stream, StreamDraw, StreamInfo},
    shaders,
};
use std::ffi::CStr;

/// The lists of one emitter, and the pipeline that steps them.
pub struct StreamedEffect {
    effect: Effect,
    lists: [Buffer; 2],
    /// Bytes that each list holds.
    counters: [Buffer; 2],
    /// What reads the one list.
    sides: [Bound; 2],
    now: Option<Moment>,
    current: usize,
}

const STRIDE: u32 = size_of::<Particle>() as u32;

impl StreamedEffect {
    /// What the lists must be visible to before `record`.
    pub const ENTRY: Access = Access::StreamRead;
    /// How `record` touched them last.
    pub const EXIT: Access = Access::StreamWrite;

    /// Room for `capacity` particles of `effect`, whose vertex shader is `vertex`, and none of them yet. Submits to the queue
    /// and waits.
    ///
    /// # Errors
    /// If the device has no room, or `vertex` is no such shader.
    ///
    /// # Panics
    /// If the device has no transform feedback ([`Gpu::has_transform_feedback`]), or the effect ends on the ground.
    pub fn new(gpu: &Gpu, name: &CStr, vertex: &[u8], effect: &Effect, capacity: u32) -> Result<Self> {
        assert!(!effect.has_ground, "`{}` ends on the ground: it is not stored", effect.name);
        let bytes = u64::from(capacity.max(1)) * u64::from(STRIDE);
        let list = |name| Buffer::for_stream(gpu, name, bytes);
        let lists = [list("ballistic.stream_a")?, list("ballistic.stream_b")?];
        let counter = |name| -> Result<Buffer> {
            let buffer = Buffer::for_stream(gpu, name, 4)?;
            gpu.upload_to(&buffer, &[0u32])?;
            Ok(buffer)
        };
        let counters = [counter("ballistic.captured_a")?, counter("ballistic.captured_b")?];
        let info = StreamInfo { name, vertex, geometry: shaders::BALLISTIC_STREAM_GEOM, blocks: &["Before"] };
        let stream = Stream::new::<Params>(gpu, &info)?;
        let sides = [
            stream.bind(&[("Before", (&lists[0]).into())])?,
            stream.bind(&[("Before", (&lists[1]).into())])?,
        ];
        gpu.once(|rec| rec.barrier(Access::CopyWrite, Access::StreamRead))?;
        Ok(Self { effect: effect.clone(), lists, counters, sides, now: None, current: 0 })
    }

    /// Records the way from the last moment to `now`: at the first, all that live by then are born; after that, ages pass
    /// and the newborn come. Returns how many particles are born.
    ///
    /// # Panics
    /// If `now` is before the last moment.
    pub fn record(&mut self, rec: &mut Recorder<'_>, now: Moment, seed: u32, stream: u32) -> u32 {
        assert!(self.now.is_none_or(|before| before <= now), "stored particles do not go back in time");
        let emission = self.effect.emission();
        let born = emission.born(self.now, now);
        let born = (born.end - born.start).min(emission.live(now).births) as u32;
        let dt_s = self.now.map_or(0.0, |before| Moment { ticks: now.ticks - before.ticks }.as_s() as f32);
        let params = self.effect.params(now, seed, stream, &GroundGrid::FLAT, u32::MAX);
        let (from, to) = (self.current, 1 - self.current);
        let counter = &self.counters[from];
        let mut draws = vec![(
            StreamDraw::Captured { counter, stride: STRIDE },
            Params { births: 0, since_s: dt_s, ..params },
        )];
        if born > 0 {
            let particles = born * self.effect.burst;
            draws.push((StreamDraw::Points(particles), Params { births: born, ..params }));
        }
        // The list that is written was read by the frame before.
        rec.barrier(Access::StreamRead, Access::StreamWrite);
        rec.barrier(Access::StreamWrite, Access::StreamWrite);
        rec.span(c"ballistic.stream", |rec| {
            rec.stream(&self.sides[from], &self.lists[to], &self.counters[to], &draws);
        });
        (self.now, self.current) = (Some(now), to);
        born * self.effect.burst
    }

    /// The particles, sorted by age. Submits to the queue and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu) -> Result<Vec<Particle>> {
        gpu.once(|rec| rec.barrier(Access::StreamWrite, Access::CopyRead))?;
        let bytes: u32 = gpu.download(&self.counters[self.current])?[0];
        let mut list: Vec<Particle> = gpu.download(&self.lists[self.current])?;
        list.truncate((bytes / STRIDE) as usize);
        list.sort_by(|a, b| b.at_age[3].total_cmp(&a.at_age[3]));
        Ok(list)
    }
}
