// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twins of `glsl/ballistic`, to the bit, and the same in f64 with no care for cancellation.

use super::{effect::Params, Builtin};
use crate::random::{bits, cos_sin_of_turn, direction_of, units};
use glam::{dvec3, vec3, DVec3, Vec3, Vec4};

/// A number in two floats.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wide {
    /// Rounded.
    pub high: f32,
    /// What rounding took.
    pub low: f32,
}

/// Which particle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Who {
    /// Serial number of its birth.
    pub serial: u64,
    /// Which of its burst.
    pub member: u32,
}

/// What a particle starts with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Birth {
    /// (m).
    pub at_m: Vec3,
    /// (m/s).
    pub velocity_mps: Vec3,
    /// From birth to the begin of its path (s).
    pub delay_s: f32,
}

/// The impact that threw a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Struck {
    /// (m).
    pub at_m: Vec3,
    /// Of the surface, unit, towards what hit it.
    pub normal: Vec3,
    /// Of what hit it, before (m/s).
    pub velocity_mps: Vec3,
    /// Change of its velocity along the normal (m/s).
    pub impulse_mps: f32,
}

impl Struck {
    /// What those are told that no impact threw.
    pub fn at_rest(at_m: Vec3) -> Self {
        Self { at_m, normal: Vec3::Y, velocity_mps: Vec3::ZERO, impulse_mps: 0.0 }
    }

    /// `v` with its y along the normal.
    pub fn away(&self, v: Vec3) -> Vec3 {
        let n = self.normal;
        let side = if n.y < 0.0 { -1.0 } else { 1.0 };
        let a = -1.0 / (side + n.y);
        let b = n.x * n.z * a;
        let right = vec3(1.0 + side * (n.x * n.x * a), -side * n.x, side * b);
        let ahead = vec3(b, -n.z, side + n.z * n.z * a);
        (v.x * right + v.y * n) + v.z * ahead
    }
}

/// [`Birth`] in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BirthF64 {
    /// (m).
    pub at_m: DVec3,
    /// (m/s).
    pub velocity_mps: DVec3,
    /// From birth to the begin of its path (s).
    pub delay_s: f64,
}

/// A particle at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight {
    /// (m).
    pub at_m: Vec3,
    /// (m/s).
    pub velocity_mps: Vec3,
    /// Since its path began (s).
    pub age_s: f32,
    /// Of its life that has passed.
    pub share: f32,
    /// Since it met the ground (s); below 0 before.
    pub down_s: f32,
}

fn leading(x: f32) -> f32 {
    f32::from_bits(x.to_bits() & 0xffff_f000)
}

/// Four numbers, 0 to 1.
pub fn chance(p: &Params, who: Who, purpose: u32) -> [f32; 4] {
    let (low, high) = (who.serial as u32, (who.serial >> 32) as u32);
    units(bits(p.seed, p.stream | high << 16, low, purpose | who.member << 8))
}

/// What the whole burst has in common.
pub fn chance_of_burst(p: &Params, who: Who, purpose: u32) -> [f32; 4] {
    chance(p, Who { member: 0, ..who }, purpose | 128)
}

/// Age of the birth `back` before the newest.
pub fn age_of(p: &Params, back: u32) -> Wide {
    let (k1, k2) = ((back & 0xffff_f000) as f32, (back & 0xfff) as f32);
    let (a1, a2) = (k1 * p.interval_s, k2 * p.interval_s);
    let rest = (k1 + k2) * p.interval_low_s + p.since_low_s;
    let s = a1 + a2;
    let s_low = a2 - (s - a1);
    let high = s + p.since_s;
    let low = p.since_s - (high - s) + (s_low + rest);
    let sum = high + low;
    Wide { high: sum, low: low - (sum - high) }
}

/// Factors of the velocity and of the acceleration in the position, and of the velocity in the velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// (s).
    pub v: Wide,
    /// (s^2).
    pub a: Wide,
    /// `e^-kt`.
    pub keep: f32,
}

/// How far velocity and acceleration reach in a time.
pub fn reach_of(age: Wide, drag: f32) -> Reach {
    if drag == 0.0 {
        let t1 = leading(age.high);
        let t2 = age.high - t1 + age.low;
        let a = Wide { high: 0.5 * (t1 * t1), low: t2 * (t1 + 0.5 * t2) };
        return Reach { v: age, a, keep: 1.0 };
    }
    let x = drag * age.high;
    let (mut y, mut doublings) = (x, 0);
    while y > 1.0 && doublings < 7 {
        y *= 0.5;
        doublings += 1;
    }
    let mut f2 = 0.5
        - y * (1.666_666_7e-1
            - y * (4.166_666_7e-2
                - y * (8.333_333e-3
                    - y * (1.388_888_9e-3
                        - y * (1.984_127e-4
                            - y * (2.480_158_7e-5
                                - y * (2.755_731_9e-6
                                    - y * (2.755_732e-7 - y * (2.505_210_8e-8 - y * 2.087_675_7e-9)))))))));
    let mut f1 = 1.0 - y * f2;
    let mut keep = 1.0 - y * f1;
    for _ in 0..doublings {
        keep *= keep;
    }
    if x > 128.0 {
        keep = 0.0;
    }
    if doublings > 0 {
        f1 = (1.0 - keep) / x;
        f2 = (1.0 - f1) / x;
    }
    let v = Wide { high: age.high * f1, low: age.low * keep };
    Reach { v, a: Wide { high: age.high * age.high * f2, low: age.low * v.high }, keep }
}

/// `p0 + r.v v0 + r.a a`.
pub fn position(p0_m: Vec3, v0_mps: Vec3, a_mps2: Vec3, r: &Reach) -> Vec3 {
    let (mv, ma) = (leading(r.v.high), leading(r.a.high));
    let (rv, ra) = (r.v.high - mv + r.v.low, r.a.high - ma + r.a.low);
    let pulled = |p0: f32, v0: f32, a: f32| {
        let (v1, a1) = (leading(v0), leading(a));
        let (one, other) = (mv * v1, ma * a1);
        let low = mv * (v0 - v1) + rv * v0 + (ma * (a - a1) + ra * a);
        let way = one + other;
        let back = way - one;
        let way_low = (one - (way - back)) + (other - back);
        (p0 + way) + (way_low + low)
    };
    let [x, y, z] = [0, 1, 2].map(|k| pulled(p0_m[k], v0_mps[k], a_mps2[k]));
    vec3(x, y, z)
}

/// `r.keep v0 + r.v a`.
pub fn velocity(v0_mps: Vec3, a_mps2: Vec3, r: &Reach) -> Vec3 {
    r.keep * v0_mps + r.v.high * a_mps2
}

/// When something `above` a level first falls to it.
pub fn fall_time(above: f32, rise: f32, pull: f32) -> f32 {
    let d = rise * rise - 2.0 * pull * above;
    if above <= 0.0 {
        return 0.0;
    }
    if d < 0.0 {
        return 1e30;
    }
    let s = d.sqrt();
    let (down, up) = (s - rise, -(s + rise));
    let t = if rise <= 0.0 { 2.0 * above / down } else { up / pull };
    if t > 0.0 && t < 1e30 {
        t
    } else {
        1e30
    }
}

/// The same in f64, by the same form.
pub fn fall_time_f64(above: f64, rise: f64, pull: f64) -> f64 {
    let d = rise * rise - 2.0 * pull * above;
    if above <= 0.0 {
        return 0.0;
    }
    if d < 0.0 {
        return 1e30;
    }
    let s = d.sqrt();
    let t = if rise <= 0.0 { 2.0 * above / (s - rise) } else { -(s + rise) / pull };
    if t > 0.0 && t < 1e30 {
        t
    } else {
        1e30
    }
}

/// `(t f1(k t), t^2 f2(k t), e^-kt)` in f64.
pub fn reach_f64(age_s: f64, drag: f64) -> [f64; 3] {
    let x = drag * age_s;
    if x < 1e-2 {
        let f2 = 0.5 - x / 6.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * (1.0 - x / 6.0 * (1.0 - x / 7.0))));
        let f1 = 1.0 - x * f2;
        return [age_s * f1, age_s * age_s * f2, 1.0 - x * f1];
    }
    let f1 = -(-x).exp_m1() / x;
    [age_s * f1, age_s * age_s * (1.0 - f1) / x, (-x).exp()]
}

/// Closed form in f64.
pub fn position_f64(p0_m: DVec3, v0_mps: DVec3, a_mps2: DVec3, age_s: f64, drag: f64) -> DVec3 {
    let [v, a, _] = reach_f64(age_s, drag);
    p0_m + v0_mps * v + a_mps2 * a
}

/// Velocity in f64.
pub fn velocity_f64(v0_mps: DVec3, a_mps2: DVec3, age_s: f64, drag: f64) -> DVec3 {
    let [v, _, keep] = reach_f64(age_s, drag);
    v0_mps * keep + a_mps2 * v
}

/// Where an emitter that is at `at_m` and, on its circle of radius `at_m.w`, at `turn` was `age` ago.
pub fn emitter_before(p: &Params, at_m: Vec4, turn: f32, age: Wide) -> Vec3 {
    let at = at_m.truncate() - age.high * p.emitter_mps.truncate();
    if at_m.w == 0.0 {
        return at;
    }
    let turns = turn - age.high * p.turns_per_s;
    let way = cos_sin_of_turn(turns - turns.floor());
    at + at_m.w * vec3(way.x, 0.0, way.y)
}

/// Where the emitter was when something was born that is `age` old now.
pub fn emitter_at(p: &Params, age: Wide) -> Vec3 {
    emitter_before(p, p.emitter_m, p.emitter_mps.w, age)
}

/// `birth` of each built-in effect.
pub fn birth(effect: Builtin, p: &Params, who: Who, emitter_m: Vec3) -> Birth {
    birth_of(effect, p, who, &Struck::at_rest(emitter_m))
}

/// The same, thrown by an impact.
pub fn birth_of(effect: Builtin, p: &Params, who: Who, struck: &Struck) -> Birth {
    let emitter_m = struck.at_m;
    let [a, b, c, d] = chance(p, who, 0);
    let still = |at_m, velocity_mps| Birth { at_m, velocity_mps, delay_s: 0.0 };
    match effect {
        Builtin::Fire => still(emitter_m, direction_of([a, b]) * vec3(2.0, 4.0, 2.0)),
        Builtin::Rain => still(emitter_m + vec3(70.0 * a - 35.0, 20.0, 70.0 * b - 35.0), Vec3::ZERO),
        Builtin::Smoke => still(
            emitter_m + vec3(0.5 * a - 0.25, 0.0, 0.5 * b - 0.25),
            direction_of([c, d]) * vec3(0.5, 0.2, 0.5) + vec3(0.0, 1.4, 0.0),
        ),
        Builtin::Sparks => still(
            emitter_m,
            struck
                .away((direction_of([a, b]) * vec3(0.45, 0.3, 0.45) + vec3(0.0, 0.9, 0.0)) * (5.0 + 6.0 * c)),
        ),
        Builtin::Dust => {
            let (n, came) = (struck.normal, struck.velocity_mps);
            let into = (came.x * n.x + came.y * n.y) + came.z * n.z;
            let mirrored = came - (2.0 * into) * n;
            let lobe = direction_of([a, b]) + Vec3::Y;
            let (share, off_mps) = (0.1 * c * c, 0.25 + 0.02 * struck.impulse_mps);
            still(emitter_m, share * mirrored + off_mps * struck.away(lobe))
        }
        Builtin::Snow => still(
            emitter_m + vec3(30.0 * a - 15.0, 0.0, 30.0 * b - 15.0),
            vec3(0.8 * c - 0.4, -1.1, 0.8 * d - 0.4),
        ),
        Builtin::Fireworks => {
            let [e, f, g, h] = chance_of_burst(p, who, 0);
            let fuse_s = 1.3 + 0.4 * e;
            let launch = vec3(8.0 * f - 4.0, 24.0 + 4.0 * g, 8.0 * h - 4.0);
            let r = reach_of(Wide { high: fuse_s, low: 0.0 }, p.acceleration.w);
            let pull = p.acceleration.truncate();
            let at_m = position(emitter_m, launch, pull, &r);
            let thrown_mps = if who.member == 0 { 0.0 } else { 7.0 + 1.5 * c };
            let velocity_mps = velocity(launch, pull, &r) + direction_of([a, b]) * thrown_mps;
            Birth { at_m, velocity_mps, delay_s: fuse_s }
        }
    }
}

fn direction_f64([u, v]: [f64; 2]) -> DVec3 {
    let y = 2.0 * u - 1.0;
    let (sin, cos) = (std::f64::consts::TAU * v).sin_cos();
    let radius = (1.0 - y * y).max(0.0).sqrt();
    dvec3(radius * cos, y, radius * sin)
}

/// `birth` of each built-in effect in f64, from the same random bits.
pub fn birth_f64(effect: Builtin, p: &Params, who: Who, emitter_m: DVec3) -> BirthF64 {
    let [a, b, c, d] = chance(p, who, 0).map(f64::from);
    let still = |at_m, velocity_mps| BirthF64 { at_m, velocity_mps, delay_s: 0.0 };
    match effect {
        Builtin::Fire => still(emitter_m, direction_f64([a, b]) * dvec3(2.0, 4.0, 2.0)),
        Builtin::Rain => still(emitter_m + dvec3(70.0 * a - 35.0, 20.0, 70.0 * b - 35.0), DVec3::ZERO),
        Builtin::Smoke => still(
            emitter_m + dvec3(0.5 * a - 0.25, 0.0, 0.5 * b - 0.25),
            direction_f64([c, d]) * dvec3(0.5, 0.2, 0.5) + dvec3(0.0, 1.4, 0.0),
        ),
        Builtin::Sparks => still(
            emitter_m,
            (direction_f64([a, b]) * dvec3(0.45, 0.3, 0.45) + dvec3(0.0, 0.9, 0.0)) * (5.0 + 6.0 * c),
        ),
        Builtin::Dust => still(emitter_m, (direction_f64([a, b]) + DVec3::Y) * 0.25),
        Builtin::Snow => still(
            emitter_m + dvec3(30.0 * a - 15.0, 0.0, 30.0 * b - 15.0),
            dvec3(0.8 * c - 0.4, -1.1, 0.8 * d - 0.4),
        ),
        Builtin::Fireworks => {
            let [e, f, g, h] = chance_of_burst(p, who, 0).map(f64::from);
            let fuse_s = 1.3 + 0.4 * e;
            let launch = dvec3(8.0 * f - 4.0, 24.0 + 4.0 * g, 8.0 * h - 4.0);
            let (pull, drag) = (p.acceleration.truncate().as_dvec3(), f64::from(p.acceleration.w));
            let thrown_mps = if who.member == 0 { 0.0 } else { 7.0 + 1.5 * c };
            let v = velocity_f64(launch, pull, fuse_s, drag) + direction_f64([a, b]) * thrown_mps;
            let at_m = position_f64(emitter_m, launch, pull, fuse_s, drag);
            BirthF64 { at_m, velocity_mps: v, delay_s: fuse_s }
        }
    }
}

/// What `look` moves: snow sways, and a splash stands on the ground.
pub(super) fn moved(effect: Builtin, p: &Params, who: Who, f: &Flight) -> Vec3 {
    match effect {
        Builtin::Snow => {
            let [a, b, ..] = chance(p, who, 1);
            let turns = a + f.age_s * (0.15 + 0.2 * b);
            let way = cos_sin_of_turn(turns - turns.floor());
            f.at_m + 0.25 * vec3(way.x, 0.0, way.y)
        }
        Builtin::Rain if (0.0..0.22).contains(&f.down_s) => vec3(f.at_m.x, f.at_m.y + 0.03, f.at_m.z),
        _ => f.at_m,
    }
}

/// Serial number, burst member, and births before the newest, of particle `i`: 0 is the oldest.
pub fn who(p: &Params, i: u32) -> (Who, u32) {
    let birth = i / p.burst;
    let back = p.births - 1 - birth;
    let newest = u64::from(p.newest) | u64::from(p.newest_high) << 32;
    (Who { serial: newest.wrapping_sub(u64::from(back)), member: i - birth * p.burst }, back)
}

/// Particle `i` of an effect over `ground`, if it is to be seen: `flight_of`, and what `look` moves.
pub fn flight(effect: Builtin, p: &Params, ground: Option<&super::Ground<'_>>, i: u32) -> Option<Flight> {
    let (who, back) = who(p, i);
    let age = age_of(p, back);
    fly(effect, p, ground, who, (age, birth(effect, p, who, emitter_at(p, age))))
}

/// The rest of it, of an age and from a birth.
pub(super) fn fly(
    effect: Builtin,
    p: &Params,
    ground: Option<&super::Ground<'_>>,
    who: Who,
    (mut age, start): (Wide, Birth),
) -> Option<Flight> {
    let share = age.high * p.lives_per_s;
    if start.delay_s > 0.0 {
        let later = age.high - start.delay_s;
        let low = (age.high - later) - start.delay_s + age.low;
        age = Wide { high: later, low };
        if later < 0.0 {
            return None;
        }
    }
    let mut down_s = -1.0;
    if let Some(ground) = ground {
        let end = ground.hit(p, &start);
        if age.high >= end {
            down_s = age.high - end;
            age = Wide { high: end, low: 0.0 };
        }
    }
    let r = reach_of(age, p.acceleration.w);
    let pull = p.acceleration.truncate();
    let mut flight = Flight {
        at_m: position(start.at_m, start.velocity_mps, pull, &r),
        velocity_mps: velocity(start.velocity_mps, pull, &r),
        age_s: age.high,
        share,
        down_s,
    };
    flight.at_m = moved(effect, p, who, &flight);
    Some(flight)
}
