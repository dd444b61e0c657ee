// SPDX-License-Identifier: MIT OR Apache-2.0
//! The two-body problem in `f64`, exactly: what every integrator of the black hole is held against. Positions and
//! velocities are those of a particle as seen from the hole, which attracts with `mu / r^2` and absorbs at its horizon.
//!
//! Universal variables: Danby, "Fundamentals of Celestial Mechanics" (1988), 6.9; Laguerre's iteration: Conway, "An
//! improved algorithm due to Laguerre for the solution of Kepler's equation" (1986).

use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// A particle and what attracts it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    /// `G m` of the hole (m^3/s^2).
    pub mu_m3ps2: f64,
    /// From the hole (m).
    pub at_m: DVec3,
    /// (m/s).
    pub velocity_mps: DVec3,
}

/// Stumpff's `c0 .. c3`: `c_k(psi) = 1/k! - psi/(k+2)! + psi^2/(k+4)! - ..`.
pub fn stumpff(psi: f64) -> [f64; 4] {
    let mut x = psi;
    let mut quarterings = 0;
    while x.abs() > 0.1 {
        x *= 0.25;
        quarterings += 1;
    }
    // The terms left out are below 0.1^7 / 16! of the sum.
    let series = |first: f64, k: f64| {
        let term = |n: f64| x / ((2.0 * n + k - 1.0) * (2.0 * n + k));
        first * (1..=7).rev().fold(1.0, |sum, n| 1.0 - term(f64::from(n)) * sum)
    };
    let (mut c2, mut c3) = (series(0.5, 2.0), series(1.0 / 6.0, 3.0));
    let (mut c1, mut c0) = (1.0 - x * c3, 1.0 - x * c2);
    for _ in 0..quarterings {
        c3 = 0.25 * (c2 + c0 * c3);
        c2 = 0.5 * c1 * c1;
        c1 *= c0;
        c0 = 2.0 * c0 * c0 - 1.0;
    }
    [c0, c1, c2, c3]
}

/// `x` with `tan(sqrt(alpha) x) / sqrt(alpha) = w`, whatever the sign of `alpha`.
fn arctan(alpha: f64, w: f64) -> f64 {
    let z = alpha * w * w;
    if z.abs() < 0.01 {
        w * (0..9).rev().fold(0.0, |sum, n| 1.0 / f64::from(2 * n + 1) - z * sum)
    } else if z > 0.0 {
        (alpha.sqrt() * w).atan() / alpha.sqrt()
    } else {
        ((-alpha).sqrt() * w).atanh() / (-alpha).sqrt()
    }
}

impl Orbit {
    /// `v^2 / 2 - mu / r` (m^2/s^2).
    pub fn energy(&self) -> f64 {
        0.5 * self.velocity_mps.length_squared() - self.mu_m3ps2 / self.at_m.length()
    }

    /// `r x v` (m^2/s).
    pub fn angular_momentum(&self) -> DVec3 {
        self.at_m.cross(self.velocity_mps)
    }

    /// Runge and Lenz's vector over `mu`: to the periapsis, as long as the eccentricity.
    pub fn eccentricity(&self) -> DVec3 {
        self.velocity_mps.cross(self.angular_momentum()) / self.mu_m3ps2 - self.at_m.normalize_or_zero()
    }

    /// Reciprocal of the semi-major axis; zero of a parabola, negative of a hyperbola (1/m).
    pub fn alpha(&self) -> f64 {
        2.0 / self.at_m.length() - self.velocity_mps.length_squared() / self.mu_m3ps2
    }

    /// Closest that it ever comes (m).
    pub fn periapsis(&self) -> f64 {
        let h2 = self.angular_momentum().length_squared();
        h2 / (self.mu_m3ps2 * (1.0 + self.eccentricity().length()))
    }

    /// Farthest that it ever goes, infinite if it is not bound (m).
    pub fn apocentre(&self) -> f64 {
        let alpha = self.alpha();
        if alpha > 0.0 {
            2.0 / alpha - self.periapsis()
        } else {
            f64::INFINITY
        }
    }

    /// Of a bound orbit (s).
    pub fn period_s(&self) -> Option<f64> {
        let alpha = self.alpha();
        (alpha > 0.0).then(|| TAU / (alpha * (self.mu_m3ps2 * alpha).sqrt()))
    }

    /// `t_s` later, or earlier if it is negative. A particle that falls straight into the hole comes straight back.
    pub fn after(&self, t_s: f64) -> Self {
        let root = self.mu_m3ps2.sqrt();
        let (r0, alpha) = (self.at_m.length(), self.alpha());
        let sigma = self.at_m.dot(self.velocity_mps) / root;
        let t_s = self.period_s().map_or(t_s, |period| t_s - period * (t_s / period).round());
        let wanted = root * t_s;
        // How far the flight is at the universal anomaly x, and how fast it goes on: the distance, so F only rises.
        let flight = |x: f64| {
            let [c0, c1, c2, c3] = stumpff(alpha * x * x);
            let (u1, u2, u3) = (x * c1, x * x * c2, x * x * x * c3);
            (r0 * u1 + sigma * u2 + u3, r0 * c0 + sigma * u1 + u2, sigma * c0 + (1.0 - alpha * r0) * u1)
        };
        let (mut low, mut high) = (0.0, 0.0);
        let mut reach = wanted / r0.max(1e-300);
        if wanted != 0.0 {
            reach = reach.abs().min((6.0 * wanted.abs()).cbrt().max(1e-300)) * wanted.signum();
            for _ in 0..200 {
                if (flight(reach).0 - wanted) * wanted.signum() >= 0.0 {
                    break;
                }
                low = reach;
                reach *= 1.5;
            }
            high = reach;
        }
        if low > high {
            (low, high) = (high, low);
        }
        let mut x = 0.5 * (low + high);
        for _ in 0..200 {
            let (f, r, slope) = flight(x);
            let missing = f - wanted;
            if missing > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let mut next = x - 5.0 * missing / (r + (16.0 * r * r - 20.0 * missing * slope).abs().sqrt());
            if !(low..=high).contains(&next) {
                next = 0.5 * (low + high);
            }
            let step = (next - x).abs();
            x = next;
            if step <= 1e-16 * x.abs() {
                break;
            }
        }
        let [_, c1, c2, _] = stumpff(alpha * x * x);
        let (u1, u2) = (x * c1, x * x * c2);
        let r = flight(x).1;
        let (f, g) = (1.0 - u2 / r0, (r0 * u1 + sigma * u2) / root);
        let (df, dg) = (-root * u1 / (r * r0), 1.0 - u2 / r);
        Self {
            at_m: f * self.at_m + g * self.velocity_mps,
            velocity_mps: df * self.at_m + dg * self.velocity_mps,
            ..*self
        }
    }

    /// When it first comes within `radius_m` of the hole, if ever: zero if it is there now (s).
    pub fn crossing_s(&self, radius_m: f64) -> Option<f64> {
        let (r0, mu) = (self.at_m.length(), self.mu_m3ps2);
        if r0 <= radius_m {
            return Some(0.0);
        }
        let alpha = self.alpha();
        let sigma = self.at_m.dot(self.velocity_mps) / mu.sqrt();
        let h2 = self.angular_momentum().length_squared() / mu;
        // Radial speed at the horizon, squared, over mu: none, and the orbit stays outside.
        let inward = 2.0 * radius_m - alpha * radius_m * radius_m - h2;
        if inward < 0.0 || (sigma >= 0.0 && alpha <= 0.0) {
            return None;
        }
        let inward = inward.sqrt();
        // Half of the universal anomaly from here to there, as a tangent: sums of what has one sign, so nothing cancels.
        let (half, is_beyond) = if sigma < 0.0 {
            ((r0 - radius_m) / (inward - sigma), false)
        } else {
            let half = (inward + sigma) / (alpha * (radius_m + r0) - 2.0);
            (half, half < 0.0)
        };
        let turn = if is_beyond { TAU / alpha.sqrt() } else { 0.0 };
        let x = 2.0 * arctan(alpha, half) + turn;
        let [_, c1, c2, c3] = stumpff(alpha * x * x);
        Some((r0 * x * c1 + sigma * x * x * c2 + x * x * x * c3) / mu.sqrt())
    }

    /// When the hole swallows it, if it does before its life ends (s).
    pub fn capture_s(&self, radius_m: f64, life_s: f64) -> Option<f64> {
        self.crossing_s(radius_m).filter(|&t| t < life_s)
    }
}

/// Distance from the hole and true anomaly of a parabola of semi-latus rectum `p_m`, `t_s` after its periapsis: Barker's
/// equation `t = sqrt(p^3 / mu) (d + d^3 / 3) / 2` with `d = tan(nu / 2)` (m, rad).
pub fn barker(mu_m3ps2: f64, p_m: f64, t_s: f64) -> (f64, f64) {
    let b = 3.0 * t_s * (mu_m3ps2 / (p_m * p_m * p_m)).sqrt();
    let y = (b.abs() + (b * b + 1.0).sqrt()).cbrt();
    let d = b.signum() * (y - 1.0 / y);
    (0.5 * p_m * (1.0 + d * d), 2.0 * d.atan())
}

/// From rest at `from_m` to `to_m` (s).
pub fn fall_from_rest_s(mu_m3ps2: f64, from_m: f64, to_m: f64) -> f64 {
    let x = to_m / from_m;
    (from_m.powi(3) / (2.0 * mu_m3ps2)).sqrt() * ((x * (1.0 - x)).sqrt() + x.sqrt().acos())
}

/// From `from_m` to `to_m`, straight in, at the speed of escape (s).
pub fn fall_at_escape_s(mu_m3ps2: f64, from_m: f64, to_m: f64) -> f64 {
    2.0 / 3.0 * (from_m.powf(1.5) - to_m.powf(1.5)) / (2.0 * mu_m3ps2).sqrt()
}

/// From `from_m` to `to_m`, straight in, with `speed_mps` left at infinity (s).
pub fn fall_from_infinity_s(mu_m3ps2: f64, speed_mps: f64, from_m: f64, to_m: f64) -> f64 {
    let a = mu_m3ps2 / (speed_mps * speed_mps);
    let time = |r: f64| {
        let x = r / a;
        (x * (x + 2.0)).sqrt() - (1.0 + x).acosh()
    };
    (a.powi(3) / mu_m3ps2).sqrt() * (time(from_m) - time(to_m))
}

/// Eccentric anomaly of mean anomaly `mean` (rad), by bisection and Newton's steps: an oracle for the oracle.
pub fn eccentric_anomaly(mean: f64, e: f64) -> f64 {
    let mean = mean - TAU * (mean / TAU).round();
    let (mut low, mut high) = (-PI, PI);
    let mut x = mean;
    for _ in 0..200 {
        let f = x - e * x.sin() - mean;
        if f > 0.0 {
            high = x;
        } else {
            low = x;
        }
        let mut next = x - f / (1.0 - e * x.cos());
        if !(low..=high).contains(&next) {
            next = 0.5 * (low + high);
        }
        if (next - x).abs() <= 1e-16 {
            break;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    const MU: f64 = 1e4;

    fn states(count: u32) -> impl Iterator<Item = Orbit> {
        (0..count).map(|serial| {
            let [u, v, w, s] = crate::random::units(crate::random::bits(5, 0, serial, 0)).map(f64::from);
            let [a, b, ..] = crate::random::units(crate::random::bits(5, 1, serial, 0));
            let at = (6.0 + 90.0 * u) * crate::random::direction_of([v as f32, w as f32]).as_dvec3();
            let escape = (2.0 * MU / at.length()).sqrt();
            let way = crate::random::direction_of([a, b]).as_dvec3();
            Orbit { mu_m3ps2: MU, at_m: at, velocity_mps: 1.5 * s * escape * way }
        })
    }

    fn apart(a: &Orbit, b: &Orbit) -> f64 {
        let scale = a.at_m.length().max(b.at_m.length());
        let speed = a.velocity_mps.length().max(b.velocity_mps.length());
        ((a.at_m - b.at_m).length() / scale).max((a.velocity_mps - b.velocity_mps).length() / speed)
    }

    #[test]
    fn stumpff_is_trigonometry() {
        for i in -400..400 {
            let psi = 0.1 * f64::from(i) + 0.05;
            let x = psi.abs().sqrt();
            let (c, s) = if psi > 0.0 { (x.cos(), x.sin()) } else { (x.cosh(), x.sinh()) };
            let want = [c, s / x, (1.0 - c) / psi, (x - s) / (psi * x)];
            for (got, want) in stumpff(psi).into_iter().zip(want) {
                assert!((got - want).abs() <= 4e-14 * (1.0 + c.abs()), "{psi}: {got} {want}");
            }
        }
    }

    #[test]
    fn there_and_back_ends_at_the_start_and_keeps_what_is_conserved() {
        for orbit in states(2000) {
            let r = orbit.periapsis() / orbit.at_m.length();
            for t in [1e-3, 0.1, 1.0, 10.0] {
                let later = orbit.after(t);
                // A path that grazes the centre turns any rounding there into a change of course.
                let grain = 1e-12 * (1.0 + t) / r.min(1.0);
                assert!(apart(&later.after(-t), &orbit) < 10.0 * grain, "{orbit:?} after {t}");
                let scale = MU / orbit.at_m.length().min(later.at_m.length());
                assert!((later.energy() - orbit.energy()).abs() < 1e-11 * scale);
                let [now, then] = [later, orbit].map(|o| o.angular_momentum());
                assert!((now - then).length() < 1e-11 * then.length().max(1.0), "{orbit:?} after {t}");
                assert!((later.eccentricity() - orbit.eccentricity()).length() < 10.0 * grain);
            }
        }
    }

    #[test]
    fn ellipses_are_those_of_keplers_equation() {
        for e in [0.0, 0.3, 0.9, 0.99, 0.9999] {
            let (a, n) = (30.0f64, (MU / 30f64.powi(3)).sqrt());
            let at = |mean: f64| {
                let x = eccentric_anomaly(mean, e);
                let b = a * (1.0 - e * e).sqrt();
                let rate = n / (1.0 - e * x.cos());
                Orbit {
                    mu_m3ps2: MU,
                    at_m: dvec3(a * (x.cos() - e), b * x.sin(), 0.0),
                    velocity_mps: dvec3(-a * x.sin() * rate, b * x.cos() * rate, 0.0),
                }
            };
            let from = at(PI);
            for i in 0..200 {
                let mean = PI + 0.37 * f64::from(i);
                let got = from.after((mean - PI) / n);
                let allowed = 1e-12 * (1.0 + f64::from(i)) / (1.0 - e).sqrt();
                assert!((got.at_m - at(mean).at_m).length() < allowed * a, "{e}, {mean}");
            }
        }
    }

    #[test]
    fn hyperbolas_are_those_of_the_hyperbolic_equation() {
        for e in [1.01f64, 1.5, 4.0] {
            let (a, b) = (7.0f64, 7.0 * (e * e - 1.0).sqrt());
            let n = (MU / a.powi(3)).sqrt();
            let at = |x: f64| {
                let rate = n / (e * x.cosh() - 1.0);
                Orbit {
                    mu_m3ps2: MU,
                    at_m: dvec3(a * (e - x.cosh()), b * x.sinh(), 0.0),
                    velocity_mps: dvec3(-a * x.sinh() * rate, b * x.cosh() * rate, 0.0),
                }
            };
            let time = |x: f64| (e * x.sinh() - x) / n;
            for (x, y) in [(-3.0, 2.0), (0.0, 4.0), (-1.0, -0.5), (2.0, 6.0)] {
                let got = at(x).after(time(y) - time(x));
                let missed = (got.at_m - at(y).at_m).length() / at(y).at_m.length();
                // The periapsis is a difference, e - 1, and the energy a difference of what that makes large.
                assert!(missed < 1e-12 / (e - 1.0).powi(2).min(1.0), "{e}: {x} to {y}: {missed:e}");
            }
        }
    }

    #[test]
    fn parabolas_are_barkers() {
        let p = 11.0;
        let at = |t: f64| {
            let (r, nu) = barker(MU, p, t);
            let speed = (MU / p).sqrt();
            Orbit {
                mu_m3ps2: MU,
                at_m: dvec3(r * nu.cos(), r * nu.sin(), 0.0),
                velocity_mps: dvec3(-speed * nu.sin(), speed * (1.0 + nu.cos()), 0.0),
            }
        };
        for (from, to) in [(-4.0, 3.0), (-0.2, 0.1), (0.0, 9.0), (2.0, -1.0)] {
            assert!(apart(&at(from).after(to - from), &at(to)) < 1e-12, "{from} to {to}");
        }
        let from = at(-4.0);
        let crossing = from.crossing_s(6.0).unwrap();
        assert!((from.after(crossing).at_m.length() - 6.0).abs() < 1e-11);
    }

    #[test]
    fn falls_are_those_of_the_closed_forms() {
        let at_m = dvec3(100.0, 0.0, 0.0);
        let falls = |speed: f64| Orbit { mu_m3ps2: MU, at_m, velocity_mps: dvec3(-speed, 0.0, 0.0) };
        let escape = (2.0 * MU / 100.0).sqrt();
        for to in [5.0, 0.5, 60.0] {
            let rest = fall_from_rest_s(MU, 100.0, to);
            let par = fall_at_escape_s(MU, 100.0, to);
            let hyper = fall_from_infinity_s(MU, 10.0, 100.0, to);
            for (orbit, time) in
                [(falls(0.0), rest), (falls(escape), par), (falls((escape * escape + 100.0).sqrt()), hyper)]
            {
                let crossing = orbit.crossing_s(to).unwrap();
                assert!((crossing / time - 1.0).abs() < 1e-13, "{crossing} {time}");
                let there = orbit.after(time).at_m;
                assert!((there.x - to).abs() < 1e-10 && there.y == 0.0, "{there} {to}");
            }
        }
    }

    #[test]
    fn captures_are_where_the_orbit_crosses_and_nowhere_before() {
        let (radius, mut captured) = (5.0, 0);
        for orbit in states(4000) {
            match orbit.crossing_s(radius) {
                Some(t) => {
                    captured += 1;
                    assert!(orbit.periapsis() <= radius * (1.0 + 1e-12));
                    let there = orbit.after(t);
                    assert!(
                        (there.at_m.length() - radius).abs() < 1e-9,
                        "{orbit:?}: {}",
                        there.at_m.length()
                    );
                    assert!(there.at_m.dot(there.velocity_mps) <= 0.0);
                    let before = |part: f64| orbit.after(part * t).at_m.length();
                    assert!((1..100).all(|i| before(0.01 * f64::from(i)) > radius), "{orbit:?}");
                }
                None => {
                    let out = orbit.at_m.dot(orbit.velocity_mps) >= 0.0 && orbit.alpha() <= 0.0;
                    assert!(out || orbit.periapsis() >= radius * (1.0 - 1e-12), "{orbit:?}");
                }
            }
        }
        assert!(captured > 400, "{captured}");
    }
}
