// SPDX-License-Identifier: MIT OR Apache-2.0
//! Particles about one hole that nothing stores: where number n is follows from its birth, in closed form. Reads
//! `glsl/particles/kepler_stateless.comp`, and is its twin.
//!
//! The error grows with the turns that a particle has made, by 2e-6 rad a turn at the worst: the period of an orbit is
//! rounded once, the turns are counted in integers.

use super::{
    cpu_black_hole::Body,
    kepler::{add, cross2, fly, sub, times, Flight, Real, Triple},
};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    random, shaders,
};

/// What throws particles, and the hole they are thrown about: mirrors `Fountain` of the shader.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Fountain {
    /// Of the fountain (m).
    pub at_m: [f32; 3],
    /// At birth, in every direction alike (m/s).
    pub speed_mps: f32,
    /// (m).
    pub hole_m: [f32; 3],
    /// Of the hole (m^3/s^2).
    pub mu_m3ps2: f32,
    /// Of the hole (m).
    pub horizon_m: f32,
    /// Of random numbers.
    pub seed: u32,
    /// Of random numbers.
    pub stream: u32,
    /// Of every particle.
    pub life_ticks: u32,
    /// From one birth to the next: ticks.
    pub period_ticks: u32,
    /// And 2^-32 ticks.
    pub period_part: u32,
    /// Birth of number 0.
    pub first_tick: u32,
    /// To fill the last four words.
    pub unused: u32,
}

impl Fountain {
    /// The book's: at (-50, 10, 0), 5 m/s, a hole of `mu` 10 000 and horizon 5 at (50, 0, 0), lives of 10 s.
    pub fn book(births_per_s: f64) -> Self {
        let period = 65536.0 / births_per_s;
        Self {
            at_m: [-50.0, 10.0, 0.0],
            speed_mps: 5.0,
            hole_m: [50.0, 0.0, 0.0],
            mu_m3ps2: 1e4,
            horizon_m: 5.0,
            life_ticks: 655_360,
            period_ticks: period as u32,
            period_part: (period.fract() * 4_294_967_296.0) as u32,
            ..Self::default()
        }
    }

    /// Tick at which number `n` is born.
    pub fn born(&self, n: u32) -> u32 {
        let part = ((u64::from(n) * u64::from(self.period_part)) >> 32) as u32;
        self.first_tick.wrapping_add(n.wrapping_mul(self.period_ticks)).wrapping_add(part)
    }

    /// Particle number `n` when it is born, in the world.
    pub fn at_birth(&self, n: u32) -> Body<f32> {
        let [u, v, ..] = random::units(random::bits(self.seed, self.stream, n, 0));
        let way = random::direction_of([u, v]).to_array();
        Body { at_m: self.at_m, velocity_mps: times(self.speed_mps, way), born: self.born(n) }
    }

    /// Particle number `n` at tick `now`, and whether it is there: twin of `thrown_at`.
    pub fn thrown_at(&self, n: u32, now: u32) -> (Body<f32>, bool) {
        let birth = self.at_birth(n);
        let age = now.wrapping_sub(birth.born);
        let from = sub(birth.at_m, self.hole_m);
        let fell = (age < self.life_ticks)
            .then(|| fall(self.mu_m3ps2, self.horizon_m, age, from, birth.velocity_mps))
            .flatten();
        let (at, velocity_mps) = fell.unwrap_or((from, birth.velocity_mps));
        (Body { at_m: add(at, self.hole_m), velocity_mps, born: birth.born }, fell.is_some())
    }
}

/// Turns, in 2^-32, as the shader counts them.
fn turns_of(per_tick: f32, ticks: u32) -> u32 {
    let scaled = per_tick * 4_294_967_296.0;
    let whole = scaled.floor();
    let part = (scaled - whole) * 4_294_967_296.0;
    let high = ((u64::from(part as u32) * u64::from(ticks)) >> 32) as u32;
    (whole as u32).wrapping_mul(ticks).wrapping_add(high)
}

/// Place and velocity as seen from the hole, `age` ticks later; `None`: it was swallowed before. Twin of `fall`.
pub fn fall(
    mu: f32,
    horizon: f32,
    age: u32,
    at: Triple<f32>,
    velocity: Triple<f32>,
) -> Option<(Triple<f32>, Triple<f32>)> {
    let root = mu.sqrt();
    let w = velocity.map(|v| v / root);
    let flight = Flight::new(at, w);
    let mut q = age as f32 * (1.0 / 65536.0) * root;
    let crossing = flight.crossing(cross2(at, w), horizon);
    if crossing >= 0.0 && crossing <= q {
        return None;
    }
    if flight.alpha > 0.0 {
        let period = flight.period();
        if q > 0.5 * period {
            let per_tick = root / (period * 65536.0);
            q = turns_of(per_tick, age) as i32 as f32 * (1.0 / 4_294_967_296.0) * period;
        }
    }
    let (to_at, to_w) = fly(&flight, q, at, w);
    Some((add(at, to_at), add(velocity, times(root, to_w))))
}

/// When a particle as seen from the hole is swallowed, in closed form, in single precision (s).
pub fn swallowed_s(mu: f32, horizon: f32, at: Triple<f32>, velocity: Triple<f32>) -> Option<f32> {
    let root = mu.root();
    let w = velocity.map(|v| v / root);
    let flight = Flight::new(at, w);
    let crossing = flight.crossing(cross2(at, w), horizon);
    (crossing >= 0.0).then_some(crossing / root)
}

/// Mirrors `StatelessParams` of the shader.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct StatelessParams {
    /// Tick.
    pub now: u32,
    /// Number of the first particle.
    pub first: u32,
    /// How many.
    pub count: u32,
}

/// The kernel with a fountain.
pub struct Stateless {
    bound: Bound,
    places: Buffer,
    gpu: Gpu,
}

impl Stateless {
    /// What the fountain must be visible to before [`Stateless::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Stateless::record`] touched the places last.
    pub const EXIT: Access = Access::ComputeWrite;

    /// With room for `count` particles; `writes`: their places are written, else only computed.
    ///
    /// # Errors
    /// The device's.
    pub fn new(gpu: &Gpu, fountain: &Fountain, count: u32, writes: bool) -> Result<Self> {
        let info = KernelInfo {
            name: c"particles.kepler_stateless",
            spv: shaders::PARTICLES_KEPLER_STATELESS_COMP,
            blocks: &["Law", "Places"],
            constants: &[128, u32::from(writes)],
        };
        let kernel = Kernel::new::<StatelessParams>(gpu, &info)?;
        let law = gpu.upload("particles.fountain", &[*fountain])?;
        let bytes = 16 * u64::from(if writes { count.max(1) } else { 1 });
        let places = Buffer::new(gpu, "particles.places", bytes, Residence::Device)?;
        let bound = kernel.bind(&[("Law", (&law).into()), ("Places", (&places).into())])?;
        Ok(Self { bound, places, gpu: gpu.clone() })
    }

    /// Records one evaluation of each of `count` particles from number `first` on, at tick `now`.
    pub fn record(&self, rec: &mut Recorder<'_>, now: u32, first: u32, count: u32) {
        let params = StatelessParams { now, first, count };
        rec.span(c"particles.kepler_stateless", |rec| {
            rec.dispatch(&self.bound, [count, 1, 1], &params);
        });
    }

    /// Where they are (m), and whether they are there.
    ///
    /// # Errors
    /// The device's.
    pub fn places(&self, now: u32, first: u32, count: u32) -> Result<Vec<([f32; 3], bool)>> {
        self.gpu.once(|rec| self.record(rec, now, first, count))?;
        let places: Vec<[f32; 4]> = self.gpu.download(&self.places)?;
        Ok(places
            .into_iter()
            .take(count as usize)
            .map(|[x, y, z, there]| ([x, y, z], there == 1.0))
            .collect())
    }
}
