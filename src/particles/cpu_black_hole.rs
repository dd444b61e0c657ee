// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twin of `glsl/particles/black_hole.glsl`: the same operations in the same order, in `f32` to be compared with the GPU
//! bit for bit, or in `f64` to part what a scheme gets wrong from what rounding does.

use super::{
    black_hole::{BlackHole, Hole, Integrator},
    kepler::{add, cross2, dot, fly, hold_energy, is_narrow, sub, times, Flight, Real, Triple},
};

/// A particle as the law sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body<T> {
    /// (m).
    pub at_m: Triple<T>,
    /// (m/s).
    pub velocity_mps: Triple<T>,
    /// Tick of birth.
    pub born: u32,
}

/// The law in the twin's precision.
#[derive(Clone, Debug)]
pub struct Law<T> {
    law: BlackHole,
    is_moving: bool,
    _real: std::marker::PhantomData<T>,
}

/// What the global variables of the shader hold, and the tick at the end of the step.
struct Step {
    tick: u32,
    is_deep: bool,
}

impl<T: Real> Law<T> {
    /// The twin of a law.
    pub fn new(law: &BlackHole) -> Self {
        Self { is_moving: law.moves(), law: law.clone(), _real: std::marker::PhantomData }
    }

    fn centre(&self, hole: &Hole, tick: u32, t_s: T) -> Triple<T> {
        let c = |x: f32| T::of(f64::from(x));
        let at = hole.at_m.map(c);
        if !self.is_moving {
            return at;
        }
        let time = T::of(f64::from(tick as f32)) * T::of(1.0 / 65536.0) + t_s;
        let phase = hole.phase.wrapping_add(tick.wrapping_mul(hole.turn_per_tick));
        let turns = T::of(f64::from(phase >> 8)) * T::of(1.0 / 16_777_216.0)
            + t_s * (T::of(f64::from(hole.turn_per_tick as f32)) * T::of(1.0 / 65536.0));
        let way = crate::random::cos_sin_of_turn((turns - turns.floor()).wide() as f32);
        let swung = |k: usize| {
            at[k]
                + time * c(hole.velocity_mps[k])
                + c(way.x) * c(hole.swing_u_m[k])
                + c(way.y) * c(hole.swing_w_m[k])
        };
        [swung(0), swung(1), swung(2)]
    }

    /// Pull of all holes, and the sum of `mu / r`.
    fn accelerate(&self, step: &mut Step, at: Triple<T>, t_s: T) -> (Triple<T>, T) {
        let (mut sum, mut depth) = ([T::of(0.0); 3], T::of(0.0));
        for hole in &self.law.holes {
            let d = sub(at, self.centre(hole, step.tick, t_s));
            let horizon = T::of(f64::from(hole.horizon_m));
            let least = (T::of(0.25) * horizon * horizon).most(T::of(1e-12));
            let mut r2 = dot(d, d);
            let is_outside = r2 > least; // no number is not
            if !is_outside {
                step.is_deep = true;
                r2 = least;
            }
            let well = T::of(f64::from(hole.mu_m3ps2)) / r2.root();
            let pull = well / r2;
            sum = sub(sum, times(pull, d));
            depth = depth + well;
        }
        (sum, depth)
    }

    fn entry_s(
        &self,
        step: &Step,
        (at0, v0): (Triple<T>, Triple<T>),
        (at1, v1): (Triple<T>, Triple<T>),
        t_s: T,
        h: T,
    ) -> Option<T> {
        let c = T::of;
        let middle = add(times(c(0.5), add(at0, at1)), times(c(0.125) * h, sub(v0, v1)));
        let mut first = c(2.0);
        for hole in &self.law.holes {
            let horizon = c(f64::from(hole.horizon_m));
            let p = sub(at0, self.centre(hole, step.tick, t_s));
            let m = sub(middle, self.centre(hole, step.tick, t_s + c(0.5) * h));
            let q = sub(at1, self.centre(hole, step.tick, t_s + h));
            let mut early = c(0.5) * entry(p, m, horizon);
            if early > c(0.5) {
                early = c(0.5) + c(0.5) * entry(m, q, horizon);
                if early > c(1.0) {
                    early = c(2.0);
                }
            }
            first = first.least(early);
        }
        if first > c(1.0) {
            return step.is_deep.then_some(t_s);
        }
        Some(t_s + first * h)
    }

    fn drift_kick_drift(&self, step: &mut Step, at: &mut Triple<T>, v: &mut Triple<T>, t_s: T, h: T) {
        let half = T::of(0.5) * h;
        let mid = add(*at, times(half, *v));
        let pull = self.accelerate(step, mid, t_s + half).0;
        *v = add(*v, times(h, pull));
        *at = add(mid, times(half, *v));
    }

    fn runge_kutta(&self, step: &mut Step, at: &mut Triple<T>, v: &mut Triple<T>, t_s: T, h: T) {
        let half = T::of(0.5) * h;
        let a1 = self.accelerate(step, *at, t_s).0;
        let (at2, v2) = (add(*at, times(half, *v)), add(*v, times(half, a1)));
        let a2 = self.accelerate(step, at2, t_s + half).0;
        let (at3, v3) = (add(*at, times(half, v2)), add(*v, times(half, a2)));
        let a3 = self.accelerate(step, at3, t_s + half).0;
        let (at4, v4) = (add(*at, times(h, v3)), add(*v, times(h, a3)));
        let a4 = self.accelerate(step, at4, t_s + h).0;
        let sixth = h * T::of(1.0 / 6.0);
        let mean = |a, b, c, d| times(sixth, add(add(a, d), times(T::of(2.0), add(b, c))));
        (*at, *v) = (add(*at, mean(*v, v2, v3, v4)), add(*v, mean(a1, a2, a3, a4)));
    }

    fn symplectic(&self, step: &mut Step, at: &mut Triple<T>, v: &mut Triple<T>, t_s: T, h: T) {
        if self.law.integrator == Integrator::ForestRuth {
            let first = T::of(1.351_207_191_959_657_8) * h;
            let second = T::of(-1.702_414_383_919_315_5) * h;
            let after = t_s + first;
            self.drift_kick_drift(step, at, v, t_s, first);
            self.drift_kick_drift(step, at, v, after, second);
            self.drift_kick_drift(step, at, v, after + second, first);
        } else {
            self.drift_kick_drift(step, at, v, t_s, h);
        }
    }

    fn hold_orbit(&self, step: &mut Step, at: &mut Triple<T>, v: &mut Triple<T>, energy: T, total: T) {
        let c = T::of;
        let (pull, well) = self.accelerate(step, *at, c(0.0));
        if well < energy.size() {
            return;
        }
        let way = times(total / (well * well).most(c(1e-30)), pull);
        let (v2, way2) = (dot(*v, *v), dot(way, way));
        let excess = (c(0.5) * v2 - well) - energy;
        let part = excess / (well * well * way2 + v2 * v2).most(c(1e-30));
        *at = add(*at, times(part * total, way));
        *v = sub(*v, times(part * v2, *v));
    }

    fn advance_logh(&self, step: &mut Step, at: &mut Triple<T>, v: &mut Triple<T>, dt_s: T) -> Option<T> {
        let c = T::of;
        let tiny = c(1e-30);
        let potential = self.accelerate(step, *at, -dt_s).1;
        let energy = c(0.5) * dot(*v, *v) - potential;
        let total = self.law.holes.iter().fold(c(0.0), |sum, hole| sum + c(f64::from(hole.mu_m3ps2)));
        let a = total / (c(2.0) * energy.size()).most(tiny);
        let reach = c(if energy < c(0.0) { 100.0 } else { 1.0 });
        let mut t = c(0.0);
        for _ in 0..4096 {
            let left = dt_s - t;
            if left <= c(2e-6) * dt_s {
                break;
            }
            let kinetic = c(0.5) * dot(*v, *v) - energy;
            let per_radian = c(f64::from(self.law.substeps));
            let r = reach * (total / kinetic.most(tiny));
            let mut s = (total * a.least(r)).root() / per_radian;
            let (mut at1, mut v1, mut took) = (*at, *v, c(0.0));
            for round in 0..6 {
                let before = c(0.5) * s / kinetic.most(tiny);
                let mid = add(*at, times(before, *v));
                let (force, well) = self.accelerate(step, mid, -dt_s);
                v1 = add(*v, times(s / well, force));
                let after = c(0.5) * s / (c(0.5) * dot(v1, v1) - energy).most(tiny);
                at1 = add(mid, times(after, v1));
                took = before + after;
                if took <= c(1.000_001) * left && (round == 0 || took >= c(0.999_999) * left) {
                    break;
                }
                s = s * (left / took);
            }
            if let Some(entry) = self.entry_s(step, (*at, *v), (at1, v1), t - dt_s, took) {
                return Some(dt_s + entry);
            }
            (*at, *v) = (at1, v1);
            t = t + took;
        }
        self.hold_orbit(step, at, v, energy, total);
        None
    }

    fn advance_kepler(&self, step: &Step, at: &mut Triple<T>, v: &mut Triple<T>, dt_s: T) -> Option<T> {
        let hole = &self.law.holes[0];
        let speed = hole.velocity_mps.map(|x| T::of(f64::from(x)));
        let root = T::of(f64::from(hole.mu_m3ps2)).root();
        let d = sub(*at, self.centre(hole, step.tick, -dt_s));
        let w = (if self.is_moving { sub(*v, speed) } else { *v }).map(|x| x / root);
        let q = dt_s * root;
        let flight = Flight::new(d, w);
        let crossing = flight.crossing(cross2(d, w), T::of(f64::from(hole.horizon_m)));
        if crossing >= T::of(0.0) && crossing <= q {
            return Some(crossing / root);
        }
        let (to_at, to_w) = fly(&flight, flight.within_period(q), d, w);
        let (new_d, new_w) = (add(d, to_at), add(w, to_w));
        *at = add(*at, to_at);
        *v = add(*v, times(root, to_w));
        if self.is_moving {
            *at = add(*at, times(dt_s, speed));
        }
        if is_narrow(flight.alpha, new_d, to_at) {
            let (held_d, held_w) = hold_energy(flight.alpha, new_d, new_w);
            *at = add(self.centre(hole, step.tick, T::of(0.0)), held_d);
            *v = times(root, held_w);
            if self.is_moving {
                *v = add(*v, speed);
            }
        }
        None
    }

    /// Moves a particle by `dt_s`, to tick `now`. `Some`: it was swallowed that long into the step (s), and stays where it
    /// was.
    pub fn advance(&self, body: &mut Body<T>, now: u32, dt_s: T) -> Option<T> {
        let mut step = Step { tick: now, is_deep: false };
        let (mut at, mut v) = (body.at_m, body.velocity_mps);
        for hole in &self.law.holes {
            let d = sub(at, self.centre(hole, now, -dt_s));
            let horizon = T::of(f64::from(hole.horizon_m));
            let is_outside = dot(d, d) > (horizon * horizon).most(T::of(1e-12));
            if !is_outside {
                return Some(T::of(0.0));
            }
        }
        let swallowed = match self.law.integrator {
            Integrator::Kepler => self.advance_kepler(&step, &mut at, &mut v, dt_s),
            Integrator::LogH => self.advance_logh(&mut step, &mut at, &mut v, dt_s),
            integrator => {
                let h = dt_s / T::of(f64::from(self.law.substeps));
                let age = T::of(f64::from(now.wrapping_sub(body.born) as f32));
                let is_newborn = age < dt_s * T::of(65536.0) + T::of(0.75);
                let is_first = integrator == Integrator::HalfKick && is_newborn;
                (0..self.law.substeps).find_map(|i| {
                    let t = T::of(f64::from(i)) * h - dt_s;
                    let (at0, v0) = (at, v);
                    match integrator {
                        Integrator::Rk4 => self.runge_kutta(&mut step, &mut at, &mut v, t, h),
                        Integrator::Euler | Integrator::HalfKick => {
                            let kick = if is_first && i == 0 { T::of(0.5) * h } else { h };
                            v = add(v, times(kick, self.accelerate(&mut step, at, t).0));
                            at = add(at, times(h, v));
                        }
                        _ => self.symplectic(&mut step, &mut at, &mut v, t, h),
                    }
                    self.entry_s(&step, (at0, v0), (at, v), t, h).map(|entry| dt_s + entry)
                })
            }
        };
        let is_number = dot(at, at) < T::of(3e38) && dot(v, v) < T::of(3e38);
        if swallowed.is_none() && !is_number {
            return Some(T::of(0.0));
        }
        if swallowed.is_none() {
            (body.at_m, body.velocity_mps) = (at, v);
        }
        swallowed
    }

    /// `steps` steps of `dt_ticks` from tick `from`. `Some`: swallowed that long after (s).
    pub fn run(&self, body: &mut Body<T>, from: u32, dt_ticks: u32, steps: u32) -> Option<f64> {
        let dt_s = T::of(f64::from(dt_ticks) / 65536.0);
        (0..steps).find_map(|i| {
            let now = from.wrapping_add((i + 1).wrapping_mul(dt_ticks));
            let swallowed = self.advance(body, now, dt_s)?;
            Some(f64::from(i) * dt_s.wide() + swallowed.wide())
        })
    }
}

/// The part of the way from `p` to `q` at which it first comes within the horizon; 2 if nowhere.
fn entry<T: Real>(p: Triple<T>, q: Triple<T>, horizon: T) -> T {
    let d = sub(q, p);
    let c = dot(p, p) - horizon * horizon;
    if c <= T::of(0.0) {
        return T::of(0.0);
    }
    let (b, a) = (dot(p, d), dot(d, d));
    let inside = b * b - a * c;
    if b >= T::of(0.0) || inside < T::of(0.0) {
        return T::of(2.0);
    }
    let part = c / (inside.root() - b);
    if part <= T::of(1.0) {
        part
    } else {
        T::of(2.0)
    }
}

impl From<super::Particle> for Body<f32> {
    fn from(it: super::Particle) -> Self {
        Self { at_m: it.at_m.to_array(), velocity_mps: it.velocity_mps.to_array(), born: it.born }
    }
}

/// The book's step, to the letter: force from the place before, kick, drift; then it ends if it *was* within the horizon.
/// Nothing guards the centre.
pub fn book_step(hole: &Hole, body: &mut Body<f32>, dt_s: f32) -> bool {
    let d = sub(hole.at_m, body.at_m);
    let r = dot(d, d).sqrt();
    let pull = times(hole.mu_m3ps2 / (r * r), d.map(|x| x / r));
    body.velocity_mps = add(body.velocity_mps, times(dt_s, pull));
    body.at_m = add(body.at_m, times(dt_s, body.velocity_mps));
    r > hole.horizon_m
}
