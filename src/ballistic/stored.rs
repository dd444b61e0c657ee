// SPDX-License-Identifier: MIT OR Apache-2.0
//! `stored`: a list of what particles began with and how old they are, as the book has it, but with the emitter outside the
//! list, births by the clock and not by the frame, and each born at its own time within the frame. Two lists in turn: the
//! living are appended to the other one.

use super::{emission::Moment, Effect, GroundGrid, Params};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};
use std::ffi::CStr;

/// A particle: `Stored` in `glsl/ballistic/stored.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Particle {
    /// Where its path begins (m), and its age (s).
    pub at_age: [f32; 4],
    /// (m/s).
    pub velocity: [f32; 4],
}

/// `Counter` in `glsl/ballistic/stored.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Counter {
    /// Particles in the list.
    pub count: u32,
    /// Particles that found no room since the start.
    pub dropped: u32,
    /// Of the next frame's dispatch.
    pub groups: [u32; 3],
    /// Of the draw: vertices, instances, first vertex, first instance.
    pub draw: [u32; 4],
}

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct AgeParams {
    dt_s: f32,
    life_s: f32,
    capacity: u32,
    group: u32,
}

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct CountParams {
    capacity: u32,
    group: u32,
    row: u32,
    vertices: u32,
}

const GROUP: u32 = 256;
/// Workgroups of a row: devices count 65535 along an axis at the least.
const ROW: u32 = 32768;
/// Invocations of a row of the emission.
const EMIT_ROW: u32 = GROUP * 4096;
/// Byte of [`Counter::groups`] and of [`Counter::draw`].
const GROUPS_AT: u64 = 8;

struct Side {
    age: Bound,
    emit: Bound,
    count: Bound,
}

/// The lists of one emitter, and the kernels that step them.
pub struct StoredEffect {
    effect: Effect,
    lists: [Buffer; 2],
    counters: [Buffer; 2],
    /// What steps from the one list to the other.
    sides: [Side; 2],
    capacity: u32,
    now: Option<Moment>,
    /// The list that holds the particles.
    current: usize,
}

impl StoredEffect {
    /// What the lists must be visible to before `record`, beside [`Access::IndirectRead`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How `record` touched them last.
    pub const EXIT: Access = Access::ComputeReadWrite;
    /// Byte of a counter where the arguments of a draw begin.
    pub const DRAW_AT: u64 = 20;
    /// Vertices of a sprite, in the arguments of the draw.
    pub const VERTICES: u32 = 6;

    /// Room for `capacity` particles of `effect`, whose emission is the SPIR-V `emit`, and none of them yet. Submits to the
    /// queue and waits.
    ///
    /// # Errors
    /// If the device has no room, or `emit` is no emission.
    ///
    /// # Panics
    /// If the effect ends on the ground, which takes what its particles do not store.
    pub fn new(gpu: &Gpu, name: &CStr, emit: &[u8], effect: &Effect, capacity: u32) -> Result<Self> {
        assert!(!effect.has_ground, "`{}` ends on the ground: it is not stored", effect.name);
        let bytes = u64::from(capacity.max(1)) * size_of::<Particle>() as u64;
        let list = |name| Buffer::new(gpu, name, bytes, Residence::Device);
        let lists = [list("ballistic.list_a")?, list("ballistic.list_b")?];
        let empty = [Counter { groups: [0, 0, 1], draw: [0, 1, 0, 0], ..Counter::default() }];
        let counters =
            [gpu.upload("ballistic.counter_a", &empty)?, gpu.upload("ballistic.counter_b", &empty)?];
        let kernel = |name, spv, blocks, constants| KernelInfo { name, spv, blocks, constants };
        let age = Kernel::new::<AgeParams>(
            gpu,
            &kernel(
                c"ballistic.age",
                shaders::BALLISTIC_AGE_COMP,
                &["Before", "CountsBefore", "After", "Counts"],
                &[GROUP],
            ),
        )?;
        let emit = Kernel::new::<Params>(gpu, &kernel(name, emit, &["After", "Counts"], &[GROUP]))?;
        let count = Kernel::new::<CountParams>(
            gpu,
            &kernel(c"ballistic.count", shaders::BALLISTIC_COUNT_COMP, &["Counts", "CountsBefore"], &[]),
        )?;
        let side = |from: usize| -> Result<Side> {
            let to = 1 - from;
            Ok(Side {
                age: age.bind(&[
                    ("Before", (&lists[from]).into()),
                    ("CountsBefore", (&counters[from]).into()),
                    ("After", (&lists[to]).into()),
                    ("Counts", (&counters[to]).into()),
                ])?,
                emit: emit.bind(&[("After", (&lists[to]).into()), ("Counts", (&counters[to]).into())])?,
                count: count.bind(&[
                    ("Counts", (&counters[to]).into()),
                    ("CountsBefore", (&counters[from]).into()),
                ])?,
            })
        };
        let sides = [side(0)?, side(1)?];
        Ok(Self { effect: effect.clone(), lists, counters, sides, capacity, now: None, current: 0 })
    }

    /// Records the way from the last moment to `now`: at the first, all that live by then are born; after that, ages pass
    /// and the newborn come. Returns how many particles are born.
    ///
    /// age --B-- emit --B-- count
    ///
    /// # Panics
    /// If `now` is before the last moment.
    pub fn record(&mut self, rec: &mut Recorder<'_>, now: Moment, seed: u32, stream: u32) -> u32 {
        assert!(self.now.is_none_or(|before| before <= now), "stored particles do not go back in time");
        let emission = self.effect.emission();
        let born = emission.born(self.now, now);
        let born = (born.end - born.start).min(emission.live(now).births) as u32;
        let dt_s = self.now.map(|before| Moment { ticks: now.ticks - before.ticks }.as_s() as f32);
        let side = &self.sides[self.current];
        if let Some(dt_s) = dt_s {
            let life_s = emission.life_s() as f32;
            let params = AgeParams { dt_s, life_s, capacity: self.capacity, group: GROUP };
            rec.span(c"ballistic.age", |rec| {
                rec.dispatch_indirect(&side.age, &self.counters[self.current], GROUPS_AT, &params);
            });
            rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        }
        if born > 0 {
            let params = self.effect.params(now, seed, stream, &GroundGrid::FLAT, self.capacity);
            let params = Params { births: born, ..params };
            let particles = born * self.effect.burst;
            let threads = [particles.min(EMIT_ROW), particles.div_ceil(EMIT_ROW), 1];
            rec.span(c"ballistic.emit", |rec| rec.dispatch(&side.emit, threads, &params));
            rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        }
        let params =
            CountParams { capacity: self.capacity, group: GROUP, row: ROW, vertices: Self::VERTICES };
        rec.span(c"ballistic.count", |rec| rec.dispatch(&side.count, [1, 1, 1], &params));
        (self.now, self.current) = (Some(now), 1 - self.current);
        born * self.effect.burst
    }

    /// [`Particle`] each, as many as [`StoredEffect::counter`] says, in an order that differs from run to run.
    pub fn list(&self) -> &Buffer {
        &self.lists[self.current]
    }

    /// [`Counter`] of the list.
    pub fn counter(&self) -> &Buffer {
        &self.counters[self.current]
    }

    /// The particles, sorted by age, and the counter. Submits to the queue and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu) -> Result<(Vec<Particle>, Counter)> {
        let counter: Counter = gpu.download(self.counter())?[0];
        let mut list: Vec<Particle> = gpu.download(self.list())?;
        list.truncate(counter.count as usize);
        list.sort_by(|a, b| b.at_age[3].total_cmp(&a.at_age[3]));
        Ok((list, counter))
    }
}
