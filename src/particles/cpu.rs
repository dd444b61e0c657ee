// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twin of the pool, in plain loops: `glsl/particles/{prepare.comp,advance.glsl,birth.glsl,drag.glsl}`.

use super::{Drag, EmitterState, EmitterWords, Particle, PoolInfo, Step};
use crate::random;
use glam::{vec3, DVec3, Vec3};

/// A law in f32 or f64: moves a particle, says whether it goes on.
pub type Law<'a> = &'a dyn Fn(&mut Particle, f32) -> bool;

/// 2^127: numbers of a particle stay below.
const MOST: f32 = 1.701_411_8e38;

/// Counts, as the GPU has them but whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
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

/// Twin of a pool whose survivors keep their order.
#[derive(Clone, Debug)]
pub struct Pool {
    /// Slots in their order, those who ended in the last step among them.
    pub slots: Vec<Particle>,
    /// One an emitter.
    pub emitters: Vec<EmitterWords>,
    /// One an emitter.
    pub births: Vec<EmitterState>,
    /// What has become of all.
    pub tally: Tally,
    /// Most particles.
    pub capacity: u32,
    /// Of every particle.
    pub life_ticks: u32,
    /// Of the births.
    pub seed: u32,
    /// Tick that the particles are at.
    pub now: u32,
}

impl Pool {
    /// An empty pool.
    pub fn new(info: &PoolInfo<'_>) -> Self {
        Self {
            slots: Vec::new(),
            emitters: info.emitters.iter().zip(0..).map(|(it, stream)| it.words(stream)).collect(),
            births: info.emitters.iter().map(|it| it.state(info.start)).collect(),
            tally: Tally::default(),
            capacity: info.capacity,
            life_ticks: info.life_ticks(),
            seed: info.seed,
            now: info.start,
        }
    }

    /// One step. `law` moves.
    pub fn step(&mut self, step: &Step, law: Law<'_>) {
        let births = self.prepare(step);
        self.advance(step, births, law);
    }

    /// Twin of `particles.prepare`: births of the step that find room.
    pub fn prepare(&mut self, step: &Step) -> u32 {
        let mut all = 0;
        for (emitter, state) in self.emitters.iter().zip(&mut self.births) {
            state.first = all;
            all += draw(emitter, state, step.now);
        }
        let alive = self.tally.born - self.tally.aged - self.tally.ended - self.tally.spoiled;
        let births = all.min(self.capacity - alive as u32);
        self.tally.born += u64::from(births);
        self.tally.dropped += u64::from(all - births);
        births
    }

    /// Twin of the advance, with the births that [`Pool::prepare`] let in.
    pub fn advance(&mut self, step: &Step, births: u32, law: Law<'_>) {
        let Step { now, dt_ticks, dt_s } = *step;
        let (start, life) = (now.wrapping_sub(dt_ticks), self.life_ticks);
        let mut moved: Vec<(Particle, f32)> = Vec::with_capacity(self.slots.len() + births as usize);
        let is_alive = |it: &Particle, at: u32| at.wrapping_sub(it.born) < life;
        moved.extend(self.slots.iter().filter(|it| is_alive(it, start)).map(|it| (*it, dt_s)));
        for j in 0..births {
            let e = self.births.iter().rposition(|state| state.first <= j).unwrap_or(0);
            let local = j - self.births[e].first;
            moved.push(birth(&self.emitters[e], &self.births[e], local, self.seed, now));
        }
        for (it, dt_s) in &mut moved {
            let goes_on = law(it, *dt_s);
            let is_sound = [it.at_m, it.velocity_mps].into_iter().all(|v| v.abs().max_element() < MOST);
            let is_young = is_alive(it, now);
            if !is_sound {
                (it.at_m, it.velocity_mps) = (Vec3::ZERO, Vec3::ZERO);
            }
            match (is_sound, goes_on, is_young) {
                (true, true, true) => continue,
                (false, ..) => self.tally.spoiled += 1,
                (_, false, _) => self.tally.ended += 1,
                _ => self.tally.aged += 1,
            }
            if is_young {
                it.born = now.wrapping_sub(life);
            }
        }
        self.slots = moved.into_iter().map(|(it, _)| it).collect();
        self.now = now;
    }

    /// Those that live.
    pub fn living(&self) -> Vec<Particle> {
        let is_alive = |it: &&Particle| self.now.wrapping_sub(it.born) < self.life_ticks;
        self.slots.iter().filter(is_alive).copied().collect()
    }
}

/// Particles that an emitter throws up to tick `now`, by division in 128 bits.
pub fn draw(emitter: &EmitterWords, state: &mut EmitterState, now: u32) -> u32 {
    let word = |low: u32, high: u32| u64::from(high) << 32 | u64::from(low);
    let period = word(emitter.period_low, emitter.period_high);
    if period == 0 {
        (state.next_low, state.next_high, state.births) = (0, now.wrapping_add(1), 0);
        return 0;
    }
    let next = word(state.next_low, state.next_high);
    let ahead = word(0, now).wrapping_sub(next); // on a clock that wraps: negative is beyond half
    let batches = if ahead >> 63 == 0 { ahead / period + 1 } else { 0 };
    let count = batches as u32 * emitter.batch;
    (state.from_low, state.from_high, state.from_serial) = (state.next_low, state.next_high, state.serial);
    state.births = count;
    state.serial = state.serial.wrapping_add(count);
    let next = next.wrapping_add(batches.wrapping_mul(period));
    (state.next_low, state.next_high) = (next as u32, (next >> 32) as u32);
    count
}

/// Twin of `birth_of`: a particle at the moment of its birth, and what is left of the step then (s).
pub fn birth(
    emitter: &EmitterWords,
    state: &EmitterState,
    local: u32,
    seed: u32,
    now: u32,
) -> (Particle, f32) {
    let period = u64::from(emitter.period_high) << 32 | u64::from(emitter.period_low);
    let from = u64::from(state.from_high) << 32 | u64::from(state.from_low);
    let time = from.wrapping_add(u64::from(local / emitter.batch).wrapping_mul(period));
    let (tick, fraction) = ((time >> 32) as u32, time as u32);
    let left_s =
        (now.wrapping_sub(tick) as f32 - (fraction >> 8) as f32 * (1.0 / 16_777_216.0)) * (1.0 / 65536.0);
    let way = way(emitter, seed, state.from_serial.wrapping_add(local));
    let velocity_mps = emitter.velocity_mps + way * emitter.speed_mps;
    let at_m = emitter.at_m - emitter.velocity_mps * left_s;
    (Particle { at_m, velocity_mps, born: tick }, left_s)
}

/// Twin of `way_of`: unit vector of the particle `serial`.
pub fn way(emitter: &EmitterWords, seed: u32, serial: u32) -> Vec3 {
    if emitter.corners == 1 {
        let side = |bit: u32| if serial & bit == 0 { -0.577_350_27 } else { 0.577_350_27 };
        let units = random::units(random::bits(seed, emitter.stream, serial >> 3, 1));
        return turned(vec3(side(1), side(2), side(4)), units);
    }
    let [u, v, ..] = random::units(random::bits(seed, emitter.stream, serial, 0));
    random::direction_of([u, v])
}

/// Twin of `turned`: a rotation, all alike, of three units (Shoemake, "Uniform Random Rotations", Graphics Gems III, 1992).
pub fn turned(v: Vec3, units: [f32; 4]) -> Vec3 {
    let (a, b) = ((1.0 - units[0]).sqrt(), units[0].sqrt());
    let (one, other) = (random::cos_sin_of_turn(units[1]), random::cos_sin_of_turn(units[2]));
    let (q, w) = (vec3(a * one.y, a * one.x, b * other.y), b * other.x);
    let cross = |q: Vec3, v: Vec3| vec3(q.y * v.z - q.z * v.y, q.z * v.x - q.x * v.z, q.x * v.y - q.y * v.x);
    let t = 2.0 * cross(q, v);
    v + (w * t + cross(q, t))
}

/// Twin of the law `drag`.
pub fn drag(law: &Drag, it: &mut Particle, dt_s: f32) -> bool {
    let x = law.drag_per_s * dt_s;
    let [first, second] = faded(x);
    let s = first * dt_s;
    let ss = second * dt_s * dt_s;
    let velocity = it.velocity_mps;
    it.at_m += velocity * s + law.pull_mps2 * ss;
    it.velocity_mps = velocity + (law.pull_mps2 - velocity * law.drag_per_s) * s;
    true
}

/// The law `drag`, exactly: position (m) and velocity (m/s) after `t_s`.
pub fn drag_exactly(law: &Drag, at_m: DVec3, velocity_mps: DVec3, t_s: f64) -> (DVec3, DVec3) {
    let (drag, pull) = (f64::from(law.drag_per_s), law.pull_mps2.as_dvec3());
    if drag == 0.0 {
        return (at_m + velocity_mps * t_s + pull * (0.5 * t_s * t_s), velocity_mps + pull * t_s);
    }
    let terminal = pull / drag;
    let s = -(-drag * t_s).exp_m1() / drag;
    (
        at_m + terminal * t_s + (velocity_mps - terminal) * s,
        terminal + (velocity_mps - terminal) * (1.0 - drag * s),
    )
}

/// Twin of `faded`: `(1 - exp(-x)) / x` and `(x - 1 + exp(-x)) / x^2`.
fn faded(x: f32) -> [f32; 2] {
    let series = |terms: [f32; 6]| terms.into_iter().reduce(|sum, term| term + x * sum).unwrap_or(0.0);
    if x < 0.25 {
        return [
            series([-1.0 / 720.0, 1.0 / 120.0, -1.0 / 24.0, 1.0 / 6.0, -0.5, 1.0]),
            series([-1.0 / 5040.0, 1.0 / 720.0, -1.0 / 120.0, 1.0 / 24.0, -1.0 / 6.0, 0.5]),
        ];
    }
    let first = (1.0 - (-x).exp()) / x;
    [first, (1.0 - first) / x]
}
