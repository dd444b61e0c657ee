// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pool on the GPU. Reads `glsl/particles/{prepare.comp,advance.glsl,deferred.glsl,advance_deferred.glsl}`.

use super::{
    info::check,
    layout::{pack, unpack, CANARY, NOWHERE_M},
    options::{BLOCK, DEFERRED_WORDS},
    Compaction, Counts, EmitterState, EmitterWords, Error, Invalid, Law, Options, Particle, PoolInfo,
    PoolState, Snapshot, Step, StepParams,
};
use crate::{
    gpu::{self, Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Resource},
    shaders,
};
use std::ffi::CStr;

/// What every law finds bound; its own come after.
const BLOCKS: [&str; 7] = ["Pool", "Particles", "NewParticles", "Emitters", "Births", "Law", "Places"];

/// What the pass over those put off has bound.
const DEFERRED_BLOCKS: [&str; 4] = ["Pool", "NewParticles", "Places", "Law"];

/// First block of a law that puts particles off.
const DEFERRED: &str = "Deferred";

/// `DEFERRED_GROUP` in `glsl/particles/deferred.glsl`.
const DEFERRED_GROUP: u32 = 64;

/// The kernels, with a law. They hold no pool, so they step any number of them.
pub struct Particles {
    prepare: Kernel,
    advance: Kernel,
    deferred: Option<(&'static CStr, Kernel)>,
    defers: bool,
    name: &'static CStr,
    options: Options,
    gpu: Gpu,
}

impl Particles {
    /// What the pool must be visible to before [`Pool::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Pool::record`] touched it last. Whoever draws adds a barrier to [`Access::IndirectRead`] for the arguments and
    /// to [`Access::GraphicsRead`] for the particles.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// If the device does not take the tuning, or has no subgroups for [`Compaction::Subgroup`].
    ///
    /// # Panics
    /// If a workgroup takes no multiple of 32 slots, or gathers with fewer than 32 invocations.
    pub fn new(gpu: &Gpu, law: &Law<'_>, options: Options) -> gpu::Result<Self> {
        let Options { compaction, layout, tuning } = options;
        assert!(tuning.tile() > 0 && tuning.tile().is_multiple_of(32), "{tuning:?}: tiles of 32 slots");
        assert!(!tuning.gathers || tuning.group >= 32, "{tuning:?}: what is gathered leaves by 32");
        let prepare = KernelInfo {
            name: c"particles.prepare",
            spv: shaders::PARTICLES_PREPARE_COMP,
            blocks: &["Pool", "Emitters", "Births", "Places", "Deferred"],
            constants: &[256, compaction as u32, tuning.tile()],
        };
        let is_by_subgroup = compaction == Compaction::Subgroup;
        if is_by_subgroup && (law.subgroups.is_none() || !gpu.adapter().has("subgroup ballot")) {
            let what = format!("compaction by subgroups, and {} or the law has none", gpu.name());
            return Err(gpu::Error::Interface { kernel: law.name.to_string_lossy().into_owned(), what });
        }
        let spv = if is_by_subgroup { law.subgroups.unwrap_or(law.spv) } else { law.spv };
        let own = [
            tuning.group,
            compaction as u32,
            tuning.items,
            layout as u32,
            u32::from(tuning.gathers),
            tuning.group,
        ];
        let advance = KernelInfo {
            name: law.name,
            spv,
            blocks: &[&BLOCKS, law.blocks].concat(),
            constants: &[&own, law.constants].concat(),
        };
        let deferred = |(name, spv)| -> gpu::Result<_> {
            let blocks = &[&DEFERRED_BLOCKS, law.blocks].concat();
            let own = [DEFERRED_GROUP, compaction as u32, tuning.tile(), layout as u32];
            let constants = &[&own[..], law.constants].concat();
            Ok((name, Kernel::new::<StepParams>(gpu, &KernelInfo { name, spv, blocks, constants })?))
        };
        Ok(Self {
            deferred: law.deferred.map(deferred).transpose()?,
            defers: law.blocks.first() == Some(&DEFERRED),
            prepare: Kernel::new::<StepParams>(gpu, &prepare)?,
            advance: Kernel::new::<StepParams>(gpu, &advance)?,
            name: law.name,
            options,
            gpu: gpu.clone(),
        })
    }

    /// An empty pool.
    ///
    /// # Errors
    /// [`Error::Invalid`] names what is out of range; else the device's.
    pub fn pool(&self, info: &PoolInfo<'_>) -> Result<Pool, Error> {
        self.pool_with(info, &[])
    }

    /// An empty pool whose law reads or writes more: what [`Law::blocks`] names, in that order.
    ///
    /// # Errors
    /// As [`Particles::pool`], or if a name or a kind differs from the law's.
    pub fn pool_with(&self, info: &PoolInfo<'_>, resources: &[(&str, Resource<'_>)]) -> Result<Pool, Error> {
        let Options { compaction, layout, tuning } = self.options;
        let tile = tuning.tile();
        let life_ticks = check(info, self.options, self.defers, &self.gpu)?;
        let gpu = &self.gpu;
        let stride = (info.capacity + 1).next_multiple_of(32);
        let bytes = 4 * u64::from(layout.words()) * u64::from(stride);
        let buffer = |name: &str, bytes| Buffer::new(gpu, name, bytes, Residence::Device);
        let is_still = matches!(compaction, Compaction::InPlace | Compaction::Ring);
        let first = buffer("particles.particles.0", bytes)?;
        let second = if is_still { first.clone() } else { buffer("particles.particles.1", bytes)? };
        let particles = [first, second];
        let emitters: Vec<_> = info.emitters.iter().zip(0..).map(|(it, stream)| it.words(stream)).collect();
        let births: Vec<_> = info.emitters.iter().map(|it| it.state(info.start)).collect();
        // One more than there are, which nobody touches.
        let unused: EmitterWords = bytemuck::cast([CANARY; 12]);
        let emitters = gpu.upload("particles.emitters", &[&emitters[..], &[unused]].concat())?;
        let unused: EmitterState = bytemuck::cast([CANARY; 8]);
        let births = gpu.upload("particles.births", &[&births[..], &[unused]].concat())?;
        let law = gpu.upload("particles.law", info.law)?;
        let state = PoolState {
            capacity: info.capacity,
            stride,
            now: info.start,
            life_ticks,
            turn: 2,
            ..PoolState::default()
        };
        let state = gpu.upload("particles.pool", &[state])?;
        // A step reads as many slots as there are at the most, and as many births again where all of them have ended.
        let tiles = (2 * u64::from(info.capacity)).div_ceil(u64::from(tile));
        let words = match compaction {
            Compaction::InPlace => 2 * u64::from(info.capacity),
            _ => 3 * tiles + 4 * tiles.div_ceil(BLOCK.into()),
        };
        let mut clear = vec![0; words as usize];
        clear.push(CANARY);
        let places = gpu.upload("particles.places", &clear)?;
        // Without a law that puts particles off only its head, which `prepare` clears.
        let most = if self.defers { u64::from(DEFERRED_WORDS * stride) } else { 1 };
        let list = buffer("particles.deferred", 4 * (4 + most))?;
        gpu.once(|rec| {
            particles.iter().take(if is_still { 1 } else { 2 }).for_each(|it| rec.fill(it, CANARY));
            rec.barrier(Access::FillWrite, Self::ENTRY);
        })?;
        let prepare = self.prepare.bind(&[
            ("Pool", (&state).into()),
            ("Emitters", (&emitters).into()),
            ("Births", (&births).into()),
            ("Places", (&places).into()),
            ("Deferred", (&list).into()),
        ])?;
        let listed = self.defers.then(|| (DEFERRED, Resource::from(&list)));
        let bind = |from: usize| {
            let own = [&state, &particles[from], &particles[1 - from], &emitters, &births, &law, &places];
            let own = BLOCKS.into_iter().zip(own.map(Resource::from));
            self.advance.bind(&own.chain(listed).chain(resources.iter().copied()).collect::<Vec<_>>())
        };
        let advance = [bind(0)?, bind(1)?];
        let bind_deferred = |kernel: &Kernel, to: usize| {
            let own = [&state, &particles[to], &places, &law];
            let own = DEFERRED_BLOCKS.into_iter().zip(own.map(Resource::from));
            kernel.bind(&own.chain(listed).chain(resources.iter().copied()).collect::<Vec<_>>())
        };
        let deferred = match &self.deferred {
            Some((name, kernel)) => Some((*name, [bind_deferred(kernel, 1)?, bind_deferred(kernel, 0)?])),
            None => None,
        };
        let params = StepParams {
            now: info.start,
            dt_ticks: 0,
            dt_s: 0.0,
            life_ticks,
            seed: info.seed,
            capacity: info.capacity,
            stride,
            emitters: info.emitters.len() as u32,
        };
        Ok(Pool {
            particles,
            current: 0,
            state,
            emitters,
            births,
            law,
            places,
            list,
            prepare,
            advance,
            deferred,
            params,
            name: self.name,
            options: self.options,
            gpu: gpu.clone(),
        })
    }
}

/// One pool of particles.
pub struct Pool {
    particles: [Buffer; 2],
    current: usize,
    state: Buffer,
    emitters: Buffer,
    births: Buffer,
    law: Buffer,
    places: Buffer,
    list: Buffer,
    prepare: Bound,
    advance: [Bound; 2],
    deferred: Option<(&'static CStr, [Bound; 2])>,
    params: StepParams,
    name: &'static CStr,
    options: Options,
    gpu: Gpu,
}

impl Pool {
    /// Records one step. Submits nothing, waits for nothing, allocates nothing.
    ///
    /// # Panics
    /// If the step does not begin where the last has ended, or is longer than a second.
    pub fn record(&mut self, rec: &mut Recorder<'_>, step: &Step) {
        let Step { now, dt_ticks, dt_s } = *step;
        assert!((1..=Step::MOST_TICKS).contains(&dt_ticks), "{step:?}");
        assert_eq!(now.wrapping_sub(dt_ticks), self.params.now, "start of the step and tick of the pool");
        self.params = StepParams { now, dt_ticks, dt_s, ..self.params };
        let params = self.params;
        rec.span(c"particles.prepare", |rec| rec.dispatch(&self.prepare, [1, 1, 1], &params));
        rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        rec.barrier(Access::ComputeWrite, Access::IndirectRead);
        rec.span(self.name, |rec| {
            rec.dispatch_indirect(&self.advance[self.current], &self.state, 0, &params)
        });
        if let Some((name, deferred)) = &self.deferred {
            rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
            rec.barrier(Access::ComputeWrite, Access::IndirectRead);
            rec.span(name, |rec| rec.dispatch_indirect(&deferred[self.current], &self.list, 0, &params));
        }
        self.current = 1 - self.current;
    }

    /// Particles as they are after the steps recorded so far, in the pool's layout.
    pub fn particles(&self) -> &Buffer {
        &self.particles[self.current]
    }

    /// The two between which the steps go to and fro, the current one first; one and the same if nobody moves.
    pub fn both(&self) -> [&Buffer; 2] {
        [&self.particles[self.current], &self.particles[1 - self.current]]
    }

    /// [`PoolState`]: counts, and the arguments of whoever dispatches or draws.
    pub fn state(&self) -> &Buffer {
        &self.state
    }

    /// [`EmitterWords`], one an emitter: write them between steps to move or switch one.
    pub fn emitters(&self) -> &Buffer {
        &self.emitters
    }

    /// Numbers of the law: write them between steps to change them.
    pub fn law(&self) -> &Buffer {
        &self.law
    }

    /// Tick that the particles are at.
    pub fn now(&self) -> u32 {
        self.params.now
    }

    /// How it is built.
    pub fn options(&self) -> Options {
        self.options
    }

    /// Most particles.
    pub fn capacity(&self) -> u32 {
        self.params.capacity
    }

    /// Of every particle.
    pub fn life_ticks(&self) -> u32 {
        self.params.life_ticks
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        let moving = if self.particles[0].is(&self.particles[1]) { 1 } else { 2 };
        let others = [&self.state, &self.emitters, &self.births, &self.law, &self.places, &self.list];
        moving * self.particles[0].bytes() + others.iter().map(|it| it.bytes()).sum::<u64>()
    }

    /// Adds up what has become of all particles. Submits and waits: for tools and tests, not for a frame loop.
    ///
    /// # Errors
    /// The device's.
    pub fn counts(&self) -> gpu::Result<Counts> {
        Ok(Counts::of(&self.gpu.download::<PoolState>(&self.state)?[0]))
    }

    /// Replaces all particles, as if they had been born one by one. Submits and waits.
    ///
    /// # Errors
    /// [`Error::Invalid`] if they do not fit, or one is no number or no longer lives.
    pub fn upload(&mut self, particles: &[Particle]) -> Result<(), Error> {
        let invalid =
            |value: String, allowed: String| Error::Invalid(Invalid { key: "particles", value, allowed });
        let params = self.params;
        if particles.len() > params.capacity as usize {
            let allowed = format!("at most {}", params.capacity);
            return Err(invalid(particles.len().to_string(), allowed));
        }
        let is_good = |it: &Particle| {
            it.at_m.is_finite()
                && it.velocity_mps.is_finite()
                && params.now.wrapping_sub(it.born) < params.life_ticks
        };
        if let Some(bad) = particles.iter().find(|it| !is_good(it)) {
            return Err(invalid(format!("{bad:?}"), "finite numbers, and younger than a life".into()));
        }
        let words = pack(particles, self.options.layout, params.stride);
        self.gpu.upload_to(self.particles(), &words)?;
        let before = self.gpu.download::<PoolState>(&self.state)?[0];
        let count = particles.len() as u32;
        let state = PoolState {
            slots: count,
            capacity: before.capacity,
            stride: before.stride,
            now: before.now,
            life_ticks: before.life_ticks,
            turn: 2,
            born: count,
            ..PoolState::default()
        };
        self.gpu.upload_to(&self.state, &[state])?;
        if self.options.compaction != Compaction::InPlace {
            let tile = self.options.tuning.tile() as usize;
            let mut places = vec![0u32; self.places.bytes() as usize / 4];
            places[self.places.bytes() as usize / 4 - 1] = CANARY;
            for (living, part) in places.iter_mut().zip(particles.chunks(tile)) {
                *living = part.len() as u32;
            }
            let tiles = (2 * params.capacity as usize).div_ceil(tile);
            for (living, part) in places[tiles..].iter_mut().zip(particles.chunks(tile * BLOCK as usize)) {
                *living = part.len() as u32;
            }
            self.gpu.upload_to(&self.places, &places)?;
        }
        Ok(())
    }

    /// Slots in their order, ended particles among them, and the counts. Submits and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self) -> gpu::Result<(Vec<Particle>, PoolState)> {
        let state = self.gpu.download::<PoolState>(&self.state)?[0];
        let words = self.gpu.download::<u32>(self.particles())?;
        let all = unpack(&words, self.options.layout, self.params.stride, self.params.now);
        let slot = |i: u32| all[((state.first + i) % state.capacity) as usize];
        Ok(((0..state.slots).map(slot).collect(), state))
    }

    /// Those that live, in the order of their slots. Submits and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn living(&self) -> gpu::Result<Vec<Particle>> {
        let (mut all, state) = self.download()?;
        // A slot that is free keeps its birth: on a clock that wraps it would look young again.
        all.retain(|it| state.now.wrapping_sub(it.born) < state.life_ticks && it.at_m.x != NOWHERE_M);
        Ok(all)
    }

    /// All that a pool is, to be put back by [`Pool::restore`]. Submits and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn snapshot(&self) -> gpu::Result<Snapshot> {
        let read = |buffer| self.gpu.download::<u32>(buffer);
        Ok(Snapshot {
            particles: read(self.particles())?,
            state: read(&self.state)?,
            emitters: read(&self.emitters)?,
            births: read(&self.births)?,
            law: read(&self.law)?,
            places: read(&self.places)?,
            now: self.params.now,
        })
    }

    /// Puts back what [`Pool::snapshot`] took, of this pool or of one made alike. Submits and waits.
    ///
    /// # Errors
    /// The device's.
    ///
    /// # Panics
    /// If the pool that it was taken of was made otherwise.
    pub fn restore(&mut self, from: &Snapshot) -> gpu::Result<()> {
        let write = |buffer: &Buffer, words: &[u32]| self.gpu.upload_to(buffer, words);
        write(self.particles(), &from.particles)?;
        write(&self.state, &from.state)?;
        write(&self.emitters, &from.emitters)?;
        write(&self.births, &from.births)?;
        write(&self.law, &from.law)?;
        write(&self.places, &from.places)?;
        self.params.now = from.now;
        Ok(())
    }
}
