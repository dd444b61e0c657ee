// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pool on the GPU. Reads `glsl/particles/{prepare.comp,advance.glsl}`.

use super::{
    Emitter, EmitterState, EmitterWords, Error, Invalid, Law, Particle, Step, StepParams, TICKS_PER_S,
};
use crate::{
    gpu::{self, Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence},
    shaders,
};
use std::ffi::CStr;

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

/// How a particle lies in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// Seven planes of words: 28 bytes. What readers outside know.
    #[default]
    Planes,
    /// Five planes, 20 bytes: velocity in halves, birth to 2^-6 s.
    Packed,
    /// Seven words side by side, 28 bytes, as the book has them.
    Records,
}

impl Layout {
    /// Words of a particle.
    pub fn words(self) -> u32 {
        match self {
            Self::Packed => 5,
            Self::Planes | Self::Records => 7,
        }
    }
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
const BLOCK: u32 = 256;

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

/// The kernels, with a law. They hold no pool, so they step any number of them.
pub struct Particles {
    prepare: Kernel,
    advance: Kernel,
    name: &'static CStr,
    options: Options,
    gpu: Gpu,
}

/// A pool to be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoolInfo<'a> {
    /// Most particles.
    pub capacity: u32,
    /// Life of every particle (s), to the tick.
    pub life_s: f64,
    /// Of the births.
    pub seed: u32,
    /// Tick at which it begins.
    pub start: u32,
    /// What throws particles into it.
    pub emitters: &'a [Emitter],
    /// Numbers of the law.
    pub law: &'a [u8],
}

impl PoolInfo<'_> {
    /// Life of every particle.
    pub fn life_ticks(&self) -> u32 {
        (self.life_s * f64::from(TICKS_PER_S)).round() as u32
    }
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
    /// If a workgroup takes no multiple of 32 slots.
    pub fn new(gpu: &Gpu, law: &Law<'_>, options: Options) -> gpu::Result<Self> {
        let Options { compaction, layout, tuning } = options;
        assert!(tuning.tile() > 0 && tuning.tile().is_multiple_of(32), "{tuning:?}: tiles of 32 slots");
        let prepare = KernelInfo {
            name: c"particles.prepare",
            spv: shaders::PARTICLES_PREPARE_COMP,
            blocks: &["Pool", "Emitters", "Births", "Places"],
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
            blocks: &["Pool", "Particles", "NewParticles", "Emitters", "Births", "Law", "Places"],
            constants: &[&own, law.constants].concat(),
        };
        Ok(Self {
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
        let Options { compaction, layout, tuning } = self.options;
        let tile = tuning.tile();
        let life_ticks = check(info, self.options, &self.gpu)?;
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
            turn: 1,
            ..PoolState::default()
        };
        let state = gpu.upload("particles.pool", &[state])?;
        // A step reads as many slots as there are at the most, and as many births again where all of them have ended.
        let tiles = (2 * u64::from(info.capacity)).div_ceil(u64::from(tile));
        let words = match compaction {
            Compaction::InPlace => 2 * u64::from(info.capacity),
            _ => 2 * tiles + 3 * tiles.div_ceil(BLOCK.into()),
        };
        let mut clear = vec![0; words as usize];
        clear.push(CANARY);
        let places = gpu.upload("particles.places", &clear)?;
        gpu.once(|rec| {
            particles.iter().take(if is_still { 1 } else { 2 }).for_each(|it| rec.fill(it, CANARY));
            rec.barrier(Access::FillWrite, Self::ENTRY);
        })?;
        let prepare = self.prepare.bind(&[
            ("Pool", (&state).into()),
            ("Emitters", (&emitters).into()),
            ("Births", (&births).into()),
            ("Places", (&places).into()),
        ])?;
        let bind = |from: usize| {
            self.advance.bind(&[
                ("Pool", (&state).into()),
                ("Particles", (&particles[from]).into()),
                ("NewParticles", (&particles[1 - from]).into()),
                ("Emitters", (&emitters).into()),
                ("Births", (&births).into()),
                ("Law", (&law).into()),
                ("Places", (&places).into()),
            ])
        };
        let advance = [bind(0)?, bind(1)?];
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
            prepare,
            advance,
            params,
            name: self.name,
            options: self.options,
            gpu: gpu.clone(),
        })
    }
}

/// The life in ticks, if all is in range.
fn check(info: &PoolInfo<'_>, options: Options, gpu: &Gpu) -> Result<u32, Error> {
    let invalid = |key, value: String, allowed: String| Error::Invalid(Invalid { key, value, allowed });
    let words = options.layout.words();
    let range = u64::from(gpu.limits().max_storage_buffer_range).min(4 * u64::from(u32::MAX));
    let per_particle = if options.compaction == Compaction::InPlace { words.max(2) } else { words };
    // Indices of words and vertices stay below 2^32, in whole lines of 32.
    let most = (range / u64::from(4 * per_particle)).min(u64::from(u32::MAX / 7)) / 32 * 32 - 1;
    if !(1..=most).contains(&u64::from(info.capacity)) {
        let allowed =
            format!("1 to {most}, what {} sees of a buffer at {} bytes each", gpu.name(), 4 * words);
        return Err(invalid("capacity", info.capacity.to_string(), allowed));
    }
    let tile = options.tuning.tile();
    if options.compaction == Compaction::Ring && !info.capacity.is_multiple_of(tile) {
        let allowed = format!("a multiple of {tile} in a ring");
        return Err(invalid("capacity", info.capacity.to_string(), allowed));
    }
    // An age is told from a time to come by half a round of the clock; a packed birth has less.
    let most = match options.layout {
        Layout::Packed => 512.0,
        Layout::Planes | Layout::Records => f64::from(1u32 << 31) / f64::from(TICKS_PER_S),
    };
    if !(1.0 / f64::from(TICKS_PER_S)..=most).contains(&info.life_s) {
        let allowed = format!("2^-16 s to {most} s");
        return Err(invalid("life_s", info.life_s.to_string(), allowed));
    }
    if info.emitters.len() > Emitter::MOST {
        let allowed = format!("at most {}", Emitter::MOST);
        return Err(invalid("emitters", info.emitters.len().to_string(), allowed));
    }
    info.emitters.iter().try_for_each(Emitter::check)?;
    let all: f64 = info.emitters.iter().map(|it| it.rate_per_s).sum();
    if all > Emitter::MOST_PER_S {
        let allowed = format!("at most {:e} of all emitters", Emitter::MOST_PER_S);
        return Err(invalid("rate_per_s", all.to_string(), allowed));
    }
    if info.law.is_empty() || !info.law.len().is_multiple_of(4) {
        return Err(invalid(
            "law",
            format!("{} bytes", info.law.len()),
            "words of 4 bytes, one at least".into(),
        ));
    }
    Ok(info.life_ticks())
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
    prepare: Bound,
    advance: [Bound; 2],
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
        let others = [&self.state, &self.emitters, &self.births, &self.law, &self.places];
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
            turn: 1,
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

/// Where nobody is: of a free slot. `NOWHERE_M` in `glsl/particles/particle.glsl`.
const NOWHERE_M: f32 = 3.0e38;

/// A word that no pass reads or writes stands behind every plane and every list of a pool, and stays what it is.
const CANARY: u32 = 0xdead_beef;

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

/// Particles as words of a layout, for `stride` slots.
pub fn pack(particles: &[Particle], layout: Layout, stride: u32) -> Vec<u32> {
    let stride = stride as usize;
    let mut words = vec![CANARY; layout.words() as usize * stride];
    for (i, it) in particles.iter().enumerate() {
        let ([x, y, z], [vx, vy, vz]) = (it.at_m.to_array(), it.velocity_mps.to_array());
        let [x, y, z] = [x, y, z].map(f32::to_bits);
        let (own, count) = if layout == Layout::Packed {
            let (one, other) = (u32::from(half(vx)) | u32::from(half(vy)) << 16, u32::from(half(vz)));
            ([x, y, z, one, other | (it.born >> 10) << 16, 0, 0], 5)
        } else {
            ([x, y, z, vx.to_bits(), vy.to_bits(), vz.to_bits(), it.born], 7)
        };
        for (w, word) in own[..count].iter().enumerate() {
            words[if layout == Layout::Records { 7 * i + w } else { w * stride + i }] = *word;
        }
    }
    words
}

/// The inverse of [`pack`], at tick `now`.
pub fn unpack(words: &[u32], layout: Layout, stride: u32, now: u32) -> Vec<Particle> {
    let stride = stride as usize;
    let of = |i: usize| {
        let word = |w: usize| words[if layout == Layout::Records { 7 * i + w } else { w * stride + i }];
        let float = |w: usize| f32::from_bits(word(w));
        let at_m = glam::vec3(float(0), float(1), float(2));
        if layout == Layout::Packed {
            let steps = (now >> 10).wrapping_sub(word(4) >> 16) & 0xffff;
            let velocity_mps = glam::vec3(unhalf(word(3)), unhalf(word(3) >> 16), unhalf(word(4)));
            return Particle { at_m, velocity_mps, born: (now >> 10).wrapping_sub(steps) << 10 };
        }
        Particle { at_m, velocity_mps: glam::vec3(float(3), float(4), float(5)), born: word(6) }
    };
    (0..stride).map(of).collect()
}

/// To the nearest half, ties to even; beyond the largest, infinity.
fn half(x: f32) -> u16 {
    let (sign, bits) = ((x.to_bits() >> 16) as u16 & 0x8000, x.to_bits() & 0x7fff_ffff);
    if bits >= 0x4780_0000 {
        return sign | if bits > 0x7f80_0000 { 0x7e00 } else { 0x7c00 };
    }
    if bits < 0x3880_0000 {
        // Below the smallest normal half: adding 0.5 lets the float unit round at the right bit.
        return sign | ((f32::from_bits(bits) + 0.5).to_bits() - 0.5f32.to_bits()) as u16;
    }
    let even = (bits >> 13) & 1;
    sign | ((bits + 0xfff + even - 0x3800_0000) >> 13) as u16
}

fn unhalf(word: u32) -> f32 {
    let (sign, magnitude) = ((word & 0x8000) << 16, word & 0x7fff);
    let value = match magnitude {
        0..0x400 => magnitude as f32 * (1.0 / 16_777_216.0),
        0x7c00.. => f32::from_bits(0x7f80_0000 | (magnitude & 0x3ff) << 13),
        _ => f32::from_bits((magnitude << 13) + 0x3800_0000),
    };
    f32::from_bits(value.to_bits() | sign)
}

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
    /// Which half of the counts of tiles the last step read: it counted in the other.
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
    fn of(state: &PoolState) -> Self {
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
