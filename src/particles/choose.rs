// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which integrator, and how many substeps, for a tolerance: the cheapest whose predicted error is within it.
//!
//! What counts is `eta = dt sqrt(mu / d^3)`, with d the distance at which the pull is strongest: the horizon, or the closest
//! that particles come if that is farther. With n substeps, over the distance of the apocentre, for 99 of 100 particles:
//!
//! | integrator  | error of a turn    | over N turns | forces |
//! | ----------- | ------------------ | ------------ | ------ |
//! | leapfrog    | `1.5 (eta / n)^2`  | N            | n      |
//! | forest-ruth | `1.5 (eta / n)^4`  | N            | 3 n    |
//! | rk4         | `1.0 (eta / n)^4`  | N^2          | 4 n    |
//! | logh        | `0.5 / n^2`        | N            | 2 pi n a turn, and one or two a frame |
//! | kepler      | rounding alone     |              | as long as five to ten forces |
//!
//! and what single precision rounds away besides: 3e-5 times the root of the kicks in a frame, times N. The constants are fitted to particles with
//! an apocentre of 60 m about the book's hole, 10 s at 60 Hz (`whitecap study black`), and hold as upper bounds for `eta / n`
//! below a half.

use super::black_hole::Integrator;
use std::fmt;

/// What a scene asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Need {
    /// Largest error of the place of 99 of 100 particles at the end of their life, over their apocentre.
    pub tolerance: f64,
    /// A step (s).
    pub dt_s: f64,
    /// Of a life (s).
    pub life_s: f64,
    /// Of the strongest hole (m^3/s^2).
    pub mu_m3ps2: f64,
    /// Of the strongest hole (m).
    pub horizon_m: f64,
    /// Closest to a hole that particles come without being swallowed; the horizon if it is not known (m).
    pub closest_m: f64,
    /// Farthest from the hole that particles go (m).
    pub farthest_m: f64,
    /// What moves.
    pub holes: Holes,
}

/// What attracts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holes {
    /// One hole at rest and nothing else, and particles that a constant fountain throws: nothing need be stored.
    OneAtRestWithFountain,
    /// One hole at rest or in even motion, and nothing else.
    One,
    /// Several holes, all at rest.
    ManyAtRest,
    /// Holes that move, or another force.
    Any,
}

/// How particles are to be moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// From birth, in closed form, without a memory.
    Stateless,
    /// Step by step.
    Stepped {
        /// By which.
        integrator: Integrator,
        /// Of a step; of `logh` steps a radian.
        substeps: u32,
    },
}

impl fmt::Display for Way {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stateless => f.write_str("kepler-stateless"),
            Self::Stepped { integrator, substeps: 1 } => write!(f, "{integrator}"),
            Self::Stepped { integrator, substeps } => write!(f, "{integrator}/x{substeps}"),
        }
    }
}

/// What was chosen, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// How.
    pub way: Way,
    /// As [`Need::tolerance`] counts it.
    pub predicted: f64,
    /// Whether it is within the tolerance; if not, it is the best there is.
    pub is_met: bool,
    /// For people.
    pub reason: String,
}

/// Single precision with one kick a step, over a life of a turn or less.
const ROUNDING: f64 = 3e-5;
/// Of a turn on a circle, from birth in closed form; measured: 2.4e-6.
const STATELESS: f64 = 3e-6;
const MOST_SUBSTEPS: u32 = 64;

impl Need {
    /// `dt sqrt(mu / d^3)`: how much of a turn about the strongest pull a step is (rad).
    pub fn eta(&self) -> f64 {
        let strongest = self.horizon_m.max(self.closest_m);
        self.dt_s * (self.mu_m3ps2 / strongest.powi(3)).sqrt()
    }

    /// Turns in a life, one at least.
    pub fn turns(&self) -> f64 {
        let a = 0.5 * (self.horizon_m.max(self.closest_m) + self.farthest_m);
        (self.life_s * (self.mu_m3ps2 / a.powi(3)).sqrt() / std::f64::consts::TAU).max(1.0)
    }

    /// Error that an integrator makes with `substeps`.
    pub fn predicted(&self, integrator: Integrator, substeps: u32) -> f64 {
        let (n, turns) = (f64::from(substeps), self.turns());
        let eta = self.eta() / n;
        let scheme = match integrator {
            Integrator::Euler => 3.0 * eta * turns,
            Integrator::HalfKick => 3.0 * eta * eta * turns,
            Integrator::Leapfrog => 1.5 * eta * eta * turns,
            Integrator::ForestRuth => 1.5 * eta.powi(4) * turns,
            Integrator::Rk4 => eta.powi(4) * turns * turns,
            Integrator::LogH => 0.5 / (n * n) * turns,
            Integrator::Kepler => 0.0,
        };
        // What holds for small steps says nothing of large ones.
        let is_small = eta <= 0.5 || matches!(integrator, Integrator::LogH | Integrator::Kepler);
        let kicks = match integrator {
            Integrator::LogH => 4.0,
            other => f64::from(substeps * other.forces().unwrap_or(1)),
        };
        if is_small {
            scheme + ROUNDING * kicks.sqrt() * turns
        } else {
            f64::INFINITY
        }
    }

    /// The way to go.
    pub fn choose(&self) -> Choice {
        let (eta, turns) = (self.eta(), self.turns());
        let tolerance = self.tolerance;
        if self.holes == Holes::OneAtRestWithFountain {
            // Turns are as wrong as alpha is; at the periapsis, speed is sqrt(r_a / r_p) times the mean.
            let ratio = self.farthest_m / self.horizon_m.max(self.closest_m);
            let predicted = STATELESS * ratio.max(1.0).sqrt() * turns;
            return Choice {
                way: Way::Stateless,
                predicted,
                is_met: predicted <= tolerance,
                reason: "one hole at rest and a constant fountain: from birth in closed form, nothing stored"
                    .into(),
            };
        }
        let mut candidates = Vec::new();
        for substeps in 1..=MOST_SUBSTEPS {
            for integrator in [Integrator::Leapfrog, Integrator::ForestRuth, Integrator::Rk4] {
                let forces = f64::from(substeps * integrator.forces().unwrap_or(1));
                candidates.push((integrator, substeps, forces));
            }
            if self.holes != Holes::Any {
                let a_frame = turns * std::f64::consts::TAU * f64::from(substeps) * self.dt_s / self.life_s;
                candidates.push((Integrator::LogH, substeps, 3.0 + a_frame.max(1.0)));
            }
        }
        if self.holes == Holes::One {
            candidates.push((Integrator::Kepler, 1, 8.0));
        }
        let with_error = candidates.iter().map(|&(it, n, cost)| (it, n, cost, self.predicted(it, n)));
        let met = with_error.clone().filter(|it| it.3 <= tolerance).min_by(|a, b| a.2.total_cmp(&b.2));
        let is_met = met.is_some();
        let best = met.or_else(|| with_error.min_by(|a, b| a.3.total_cmp(&b.3)));
        let (integrator, substeps, _, predicted) = best.expect("there are candidates");
        let what = match self.holes {
            Holes::OneAtRestWithFountain | Holes::One => "one hole",
            Holes::ManyAtRest => "several holes at rest",
            Holes::Any => "holes that move, or another force",
        };
        let word = if is_met { "the cheapest within" } else { "the best there is, not within" };
        let reason = format!("{what}, eta {eta:.3}, {turns:.1} turns a life: {word} {tolerance:e}");
        Choice { way: Way::Stepped { integrator, substeps }, predicted, is_met, reason }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn need(tolerance: f64, holes: Holes) -> Need {
        Need {
            tolerance,
            dt_s: 1.0 / 60.0,
            life_s: 10.0,
            mu_m3ps2: 1e4,
            horizon_m: 5.0,
            closest_m: 5.5,
            farthest_m: 60.0,
            holes,
        }
    }

    #[test]
    fn a_tighter_tolerance_never_gets_a_larger_error() {
        for holes in [Holes::OneAtRestWithFountain, Holes::One, Holes::ManyAtRest, Holes::Any] {
            let mut last = f64::INFINITY;
            for tolerance in [1.0, 0.1, 0.03, 0.01, 1e-3, 2e-4] {
                let choice = need(tolerance, holes).choose();
                assert!(choice.is_met && choice.predicted <= tolerance, "{holes:?} {tolerance}: {choice:?}");
                assert!(choice.predicted <= last * 1.0001 || choice.predicted <= tolerance);
                last = choice.predicted;
            }
            let choice = need(1e-9, holes).choose();
            assert!(!choice.is_met && choice.predicted < 2e-4, "{choice:?}");
        }
    }

    #[test]
    fn the_rules_say_what_the_specification_says() {
        let way = |tolerance, holes| need(tolerance, holes).choose().way.to_string();
        assert_eq!(way(2e-4, Holes::OneAtRestWithFountain), "kepler-stateless");
        assert_eq!(way(0.1, Holes::Any), "leapfrog");
        assert_eq!(way(1e-3, Holes::Any), "forest-ruth");
        assert_eq!(way(5e-5, Holes::One), "kepler");
        assert!((need(0.1, Holes::Any).eta() - 0.1292).abs() < 1e-4);
    }
}
