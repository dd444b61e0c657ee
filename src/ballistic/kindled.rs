// SPDX-License-Identifier: MIT OR Apache-2.0
//! `kindled`: effects whose births are impacts. A ring on the GPU holds the impacts of the last while, in an order that does
//! not depend on who came first; each of them throws a burst in closed form. Reads
//! `glsl/ballistic/{ring,kindling,kindled}.glsl` and `{mark,turn,kindle,living}.comp`.
//!
//! After a step of those who collide, [`Kindling::record`]; before a picture, [`Kindling::record_living`]. Nothing comes to
//! the host: what lives is counted on the GPU, and drawn by its arguments. A ring that is too small loses its oldest, and
//! counts those that lived.
//!
//! A birth is at the end of the step of its impact, as impacts do not say when in the step they were.

use super::{
    effect::Params,
    emission::{Emission, Moment},
    stateless::Vertex,
};
use crate::{
    gpu::{self, Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Resource},
    impact::{Count, Stream},
    prims::{Scan, ScanBound, Sums},
    shaders,
};
use glam::Vec3;
use std::{ffi::CStr, mem::offset_of};

/// A birth: `Strike` in `glsl/ballistic/ring.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Strike {
    /// As in the impact (m).
    pub at_m: Vec3,
    /// End of the step that it was in, low word of the ticks.
    pub born_low: u32,
    /// As in the impact.
    pub normal: Vec3,
    /// High word of the ticks.
    pub born_high: u32,
    /// As in the impact (m/s).
    pub velocity_mps: Vec3,
    /// Likewise (m/s).
    pub impulse_mps: f32,
}

impl Strike {
    /// When its particles were born.
    pub fn born(&self) -> Moment {
        Moment { ticks: u64::from(self.born_high) << 32 | u64::from(self.born_low) }
    }
}

/// Where the ring is, and what lives: `Ring` in `glsl/ballistic/ring.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Ring {
    /// Serial number of the next birth: so many there have been; low word.
    pub next_low: u32,
    /// High word.
    pub next_high: u32,
    /// That the next birth takes.
    pub slot: u32,
    /// Births of the last step.
    pub step_births: u32,
    /// The moment of [`Ring::living`], low word of the ticks.
    pub now_low: u32,
    /// High word.
    pub now_high: u32,
    /// Births that live then, the newest.
    pub living: u32,
    /// Impacts beyond what their source said; since the start.
    pub lost: u32,
    /// Births that lived when others took their slots, since the start: low word.
    pub overwritten_low: u32,
    /// High word.
    pub overwritten_high: u32,
    /// Impacts with the order of another; since the start.
    pub twice: u32,
    /// Indirect draw of six vertices a particle, at [`Ring::QUADS`].
    pub quad_vertices: u32,
    /// The same.
    pub quad_instances: u32,
    /// The same.
    pub quad_first_vertex: u32,
    /// The same.
    pub quad_first_instance: u32,
    /// Indirect draw of a vertex a particle, at [`Ring::POINTS`].
    pub points: u32,
    /// The same.
    pub point_instances: u32,
    /// The same.
    pub point_first_vertex: u32,
    /// The same.
    pub point_first_instance: u32,
    /// Indirect dispatch of 512 particles a workgroup, at [`Ring::GROUPS`].
    pub groups_x: u32,
    /// The same.
    pub groups_y: u32,
    /// The same.
    pub groups_z: u32,
    /// Indirect dispatch of 128 particles a workgroup, at [`Ring::SPLATS`].
    pub splat_x: u32,
    /// The same.
    pub splat_y: u32,
    /// The same.
    pub splat_z: u32,
}

impl Ring {
    /// Offset of the arguments of a draw of six vertices a particle (bytes).
    pub const QUADS: u64 = offset_of!(Self, quad_vertices) as u64;
    /// Of a draw of one vertex a particle (bytes).
    pub const POINTS: u64 = offset_of!(Self, points) as u64;
    /// Of a dispatch of 512 particles a workgroup (bytes).
    pub const GROUPS: u64 = offset_of!(Self, groups_x) as u64;
    /// Of a dispatch of 128 particles a workgroup (bytes).
    pub const SPLATS: u64 = offset_of!(Self, splat_x) as u64;

    /// Births since the start.
    pub fn births(&self) -> u64 {
        u64::from(self.next_high) << 32 | u64::from(self.next_low)
    }

    /// Births that lived when others took their slots, since the start.
    pub fn overwritten(&self) -> u64 {
        u64::from(self.overwritten_high) << 32 | u64::from(self.overwritten_low)
    }

    /// Impacts whose place in the order nobody said, which threw nothing, and those with the place of another, of which one threw
    /// and which may differ from run to run; since the start, up to 2^31 of each.
    pub fn lost(&self) -> u64 {
        u64::from(self.lost) + u64::from(self.twice)
    }
}

/// Push constants: `KindleParams` in `glsl/ballistic/kindling.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct KindleParams {
    /// Slots of the ring.
    pub capacity: u32,
    /// Particles of each birth.
    pub burst: u32,
    /// In the list.
    pub sources: u32,
    /// In the list; 0: on whatever it was.
    pub meshes: u32,
    /// A lesser impulse throws nothing (m/s).
    pub least_impulse_mps: f32,
    /// The word of `Sums` with the births of the step.
    pub total_at: u32,
    /// End of the step, or the moment of the picture: low word of the ticks.
    pub now_low: u32,
    /// High word.
    pub now_high: u32,
    /// Low word of the ticks.
    pub life_low: u32,
    /// High word.
    pub life_high: u32,
}

/// Which impacts throw, and how much is kept of them.
#[derive(Clone, Debug, PartialEq)]
pub struct KindlingInfo {
    /// Slots of the ring.
    pub most: u32,
    /// Particles of each birth.
    pub burst: u32,
    /// Of a particle (s).
    pub life_s: f64,
    /// A lesser impulse throws nothing (m/s).
    pub least_impulse_mps: f32,
    /// By the source that impacts say: its orders are below this; 0: it throws nothing, as do those that are not listed.
    pub sources: Vec<u32>,
    /// By mesh, whether it throws; empty: on meshes or not, all do.
    pub meshes: Vec<bool>,
}

impl KindlingInfo {
    /// Most slots of a ring: 3 GB of them.
    pub const MOST: u32 = 1 << 26;
    /// Most particles of a full ring: six vertices of each are counted in 32 bits.
    pub const MOST_PARTICLES: u64 = 1 << 28;
    /// Most orders of all sources: 16 million particles, 16 orders each.
    pub const MOST_ORDERS: u64 = 1 << 28;

    /// # Errors
    /// The first number that is out of range, and what is allowed.
    pub fn check(&self) -> Result<(), String> {
        if !(1..=Self::MOST).contains(&self.most) {
            return Err(format!("most = {}: 1 to {} is allowed", self.most, Self::MOST));
        }
        let particles = u64::from(self.most) * u64::from(self.burst);
        if self.burst == 0 || particles > Self::MOST_PARTICLES {
            return Err(format!(
                "most x burst = {} x {}: 1 to {} particles are allowed",
                self.most,
                self.burst,
                Self::MOST_PARTICLES
            ));
        }
        if Moment::from_s(self.life_s).ticks == 0 || self.life_s > Emission::LONGEST_S {
            return Err(format!("life_s = {}: above 0 to {} is allowed", self.life_s, Emission::LONGEST_S));
        }
        if !(0.0..=f32::MAX).contains(&self.least_impulse_mps) {
            return Err(format!("least_impulse_mps = {}: 0 or more is allowed", self.least_impulse_mps));
        }
        let orders = self.orders();
        if orders == 0 || orders > Self::MOST_ORDERS {
            return Err(format!(
                "{orders} orders of all sources: 1 to {} are allowed, 16 a particle",
                Self::MOST_ORDERS
            ));
        }
        Ok(())
    }

    fn orders(&self) -> u64 {
        self.sources.iter().map(|&orders| u64::from(orders)).sum()
    }

    /// The keys of each source: its first, and how many.
    pub fn keys(&self) -> Vec<[u32; 2]> {
        let mut first = 0;
        let keys = self.sources.iter().map(|&orders| {
            first += orders;
            [first - orders, orders]
        });
        keys.collect()
    }

    /// Buffers of it, with their bytes on the device.
    pub fn buffers(&self) -> [(&'static str, u64); 3] {
        let words = self.orders().div_ceil(32);
        let tables = 8 * self.sources.len() + 4 * self.meshes.len().max(1);
        [
            ("ballistic.strikes", u64::from(self.most) * size_of::<Strike>() as u64),
            ("ballistic.marks, .marked, .before", 12 * words),
            ("ballistic.ring, .sources, .meshes", (size_of::<Ring>() + tables) as u64),
        ]
    }
}

/// The ring of one effect, and the passes that fill it.
pub struct Kindling {
    strikes: Buffer,
    ring: Buffer,
    marks: Buffer,
    count: Buffer,
    mark: Bound,
    scan: ScanBound,
    turn: Bound,
    kindle: Bound,
    living: Bound,
    params: KindleParams,
    words: u32,
    gpu: Gpu,
}

impl Kindling {
    /// What the ring must be visible to before its passes: [`Kindling::record`] and [`Kindling::record_living`] see to it,
    /// also where it was drawn in between.
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How they touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// A ring for the impacts of `stream`, without a birth. Submits to the queue and waits.
    ///
    /// # Errors
    /// If the device has no room, or sees no buffer of that size.
    ///
    /// # Panics
    /// If [`KindlingInfo::check`] does not hold.
    pub fn new(gpu: &Gpu, stream: &Stream, info: &KindlingInfo) -> gpu::Result<Self> {
        info.check().unwrap_or_else(|what| panic!("{what}"));
        let words = info.orders().div_ceil(32) as u32;
        let device = |name, bytes: u64| Buffer::new(gpu, name, bytes, Residence::Device);
        let strikes = device("ballistic.strikes", u64::from(info.most) * size_of::<Strike>() as u64)?;
        let list = |name| device(name, 4 * u64::from(words));
        let (marks, marked, before) =
            (list("ballistic.marks")?, list("ballistic.marked")?, list("ballistic.before")?);
        let still =
            Ring { quad_instances: 1, point_instances: 1, groups_z: 1, splat_z: 1, ..Ring::default() };
        let ring = gpu.upload("ballistic.ring", &[still])?;
        let sources = gpu.upload("ballistic.sources", &info.keys())?;
        let mut meshes: Vec<u32> = info.meshes.iter().map(|&throws| u32::from(throws)).collect();
        meshes.resize(meshes.len().max(1), 0);
        let meshes = gpu.upload("ballistic.meshes", &meshes)?;
        gpu.once(|rec| {
            rec.fill(&strikes, 0);
            rec.fill(&marked, 0);
        })?;
        let bind = |name, spv, all: &[(&str, Resource<'_>)]| {
            let blocks: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
            let info = KernelInfo { name, spv, blocks: &blocks, constants: &[] };
            Kernel::new::<KindleParams>(gpu, &info)?.bind(all)
        };
        let scan = Scan::clearing(gpu, Sums::for_device(gpu))?.bind(&marked, &before)?;
        let impacts = [
            ("Impacts", stream.impacts().into()),
            ("Count", stream.count().into()),
            ("Sources", (&sources).into()),
            ("Meshes", (&meshes).into()),
            ("Marks", (&marks).into()),
        ];
        let (rings, kept) = (("Rings", (&ring).into()), ("Strikes", (&strikes).into()));
        let [marking, kindling] = [
            [&impacts[..], &[("Marked", (&marked).into()), rings]].concat(),
            [&impacts[..], &[("Before", (&before).into()), rings, kept]].concat(),
        ];
        let mark = bind(c"ballistic.mark", shaders::BALLISTIC_MARK_COMP, &marking)?;
        let kindle = bind(c"ballistic.kindle", shaders::BALLISTIC_KINDLE_COMP, &kindling)?;
        let turning = [kept, rings, ("Sums", scan.sums().into())];
        let turn = bind(c"ballistic.turn", shaders::BALLISTIC_TURN_COMP, &turning)?;
        let living = bind(c"ballistic.living", shaders::BALLISTIC_LIVING_COMP, &[kept, rings])?;
        let life = Moment::from_s(info.life_s).ticks;
        let params = KindleParams {
            capacity: info.most,
            burst: info.burst,
            sources: info.sources.len() as u32,
            meshes: info.meshes.len() as u32,
            least_impulse_mps: info.least_impulse_mps,
            total_at: ScanBound::total_at(words) as u32,
            now_low: 0,
            now_high: 0,
            life_low: life as u32,
            life_high: (life >> 32) as u32,
        };
        let (count, gpu) = (stream.count().clone(), gpu.clone());
        Ok(Self { strikes, ring, marks, count, mark, scan, turn, kindle, living, params, words, gpu })
    }

    fn params(&self, now: Moment) -> KindleParams {
        KindleParams { now_low: now.ticks as u32, now_high: (now.ticks >> 32) as u32, ..self.params }
    }

    /// The ring may have been drawn, by whatever way.
    fn record_begin(&self, rec: &mut Recorder<'_>) {
        rec.barrier(Access::GraphicsRead, Access::ComputeWrite);
        rec.barrier(Access::IndirectRead, Access::ComputeWrite);
        rec.barrier(Self::EXIT, Self::ENTRY);
    }

    /// Records the births of the impacts of a step that ends at `now`, after [`Stream::record_end`].
    ///
    /// mark --B-- scan --B-- turn --B-- kindle
    pub fn record(&self, rec: &mut Recorder<'_>, now: Moment) {
        let (both, p) = (Access::ComputeReadWrite, self.params(now));
        self.record_begin(rec);
        rec.barrier(Stream::EXIT, Access::IndirectRead);
        rec.barrier(both, Access::FillWrite);
        rec.fill(&self.marks, 0);
        rec.barrier(Access::FillWrite, both);
        let groups = Count::GROUPS;
        rec.span(c"ballistic.mark", |rec| rec.dispatch_indirect(&self.mark, &self.count, groups, &p));
        rec.barrier(both, both);
        self.scan.record(rec, self.words);
        rec.barrier(both, both);
        rec.span(c"ballistic.turn", |rec| rec.dispatch(&self.turn, [1, 1, 1], &p));
        rec.barrier(both, both);
        rec.span(c"ballistic.kindle", |rec| rec.dispatch_indirect(&self.kindle, &self.count, groups, &p));
        rec.barrier(both, both);
    }

    /// Records how many live at `now`, and the arguments of those who draw them; it is left visible to them.
    pub fn record_living(&self, rec: &mut Recorder<'_>, now: Moment) {
        self.record_begin(rec);
        let p = self.params(now);
        rec.span(c"ballistic.living", |rec| rec.dispatch(&self.living, [1, 1, 1], &p));
        for reader in [Access::IndirectRead, Access::GraphicsRead, Access::ComputeRead] {
            rec.barrier(Self::EXIT, reader);
        }
    }

    /// Particles of a full ring.
    pub fn most_particles(&self) -> u32 {
        self.params.capacity * self.params.burst
    }

    /// What a shader that includes `ballistic/kindled.glsl` binds.
    pub fn resources(&self) -> [(&'static str, Resource<'_>); 2] {
        [("Rings", (&self.ring).into()), ("Strikes", (&self.strikes).into())]
    }

    /// [`Ring`].
    pub fn ring(&self) -> &Buffer {
        &self.ring
    }

    /// The numbers of the ring. Submits to the queue and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn counts(&self) -> gpu::Result<Ring> {
        Ok(self.gpu.download::<Ring>(&self.ring)?[0])
    }

    /// The numbers, and the births that are still in the ring, oldest first. Submits to the queue and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self) -> gpu::Result<(Ring, Vec<Strike>)> {
        let ring = self.counts()?;
        let mut strikes = self.gpu.download::<Strike>(&self.strikes)?;
        // Where it has gone round, the oldest is the one that is next to go.
        if ring.births() < strikes.len() as u64 {
            strikes.truncate(ring.births() as usize);
        } else {
            strikes.rotate_left(ring.slot as usize);
        }
        Ok((ring, strikes))
    }

    /// All words of the ring. Submits to the queue and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn state(&self) -> gpu::Result<Vec<u32>> {
        let mut words = self.gpu.download::<u32>(&self.ring)?;
        words.extend(self.gpu.download::<u32>(&self.strikes)?);
        Ok(words)
    }

    /// Goes on from a state. `false` if it is of another ring.
    ///
    /// # Errors
    /// The device's.
    pub fn restore(&self, words: &[u32]) -> gpu::Result<bool> {
        let head = size_of::<Ring>() / 4;
        let is_ours = 4 * words.len() as u64 == self.ring.bytes() + self.strikes.bytes();
        if !is_ours || words[2] >= self.params.capacity {
            return Ok(false);
        }
        self.gpu.upload_to(&self.ring, &words[..head])?;
        self.gpu.upload_to(&self.strikes, &words[head..])?;
        Ok(true)
    }

    /// Room for the vertices of a full ring, written by the kernel `spv` of an effect, as `sparks_kindled.comp` is one;
    /// `ground_m`: the heights for an effect that ends on the ground.
    ///
    /// # Errors
    /// If the device has no room, or the SPIR-V is no such kernel.
    pub fn vertices(
        &self,
        name: &CStr,
        spv: &[u8],
        ground_m: Option<&Buffer>,
    ) -> gpu::Result<KindledVertices> {
        let bytes = u64::from(self.most_particles()) * size_of::<Vertex>() as u64;
        let buffer = Buffer::new(&self.gpu, "ballistic.vertices", bytes, Residence::Device)?;
        let mut all: Vec<(&str, Resource<'_>)> = vec![("Vertices", (&buffer).into())];
        all.extend(self.resources());
        all.extend(ground_m.map(|ground_m| ("Ground", ground_m.into())));
        let blocks: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
        // 512 particles a workgroup, as `ballistic.living` counts them.
        let info = KernelInfo { name, spv, blocks: &blocks, constants: &[256, 2, 256] };
        let bound = Kernel::new::<Params>(&self.gpu, &info)?.bind(&all)?;
        Ok(KindledVertices { bound, buffer, ring: self.ring.clone() })
    }
}

/// Room for the vertices of a ring.
pub struct KindledVertices {
    bound: Bound,
    buffer: Buffer,
    ring: Buffer,
}

impl KindledVertices {
    /// Records the particles that live, oldest first, after [`Kindling::record_living`]. `params` of the effect, with the
    /// ring's slots as `capacity`: [`super::Effect::kindled_params`].
    pub fn record(&self, rec: &mut Recorder<'_>, params: &Params) {
        rec.span(c"ballistic.materialise", |rec| {
            rec.dispatch_indirect(&self.bound, &self.ring, Ring::GROUPS, params)
        });
    }

    /// [`Vertex`] each.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }
}
