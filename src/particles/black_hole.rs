// SPDX-License-Identifier: MIT OR Apache-2.0
//! The black hole: holes that attract by Newton's law, and swallow what crosses their horizon. Reads
//! `glsl/particles/black_hole.glsl`; twin: [`super::cpu_black_hole`]; exact: [`super::oracle`].

use super::{Invalid, Law, TICKS_PER_S};
use crate::{check::hold, shaders};
use std::fmt;

/// How a particle is moved by a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Integrator {
    /// Kick, then drift, as the book: first order.
    Euler = 0,
    /// The same, with half a kick at birth: leapfrog between the steps.
    HalfKick = 1,
    /// Drift, kick, drift: second order, 1 force.
    Leapfrog = 2,
    /// Fourth order, symplectic, 3 forces.
    ForestRuth = 3,
    /// Fourth order, 4 forces.
    Rk4 = 4,
    /// Time-transformed leapfrog for holes at rest: on the right orbit whatever the step.
    LogH = 5,
    /// In closed form: one hole, at rest or in even motion.
    Kepler = 6,
}

impl Integrator {
    /// Every one.
    pub const ALL: [Self; 7] =
        [Self::Euler, Self::HalfKick, Self::Leapfrog, Self::ForestRuth, Self::Rk4, Self::LogH, Self::Kepler];

    /// As scenes and results name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Euler => "euler",
            Self::HalfKick => "half-kick",
            Self::Leapfrog => "leapfrog",
            Self::ForestRuth => "forest-ruth",
            Self::Rk4 => "rk4",
            Self::LogH => "logh",
            Self::Kepler => "kepler",
        }
    }

    /// The one of that name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }

    /// Evaluations of the force in a substep; of `LogH` for each step of its own time; `None` of the closed form.
    pub fn forces(self) -> Option<u32> {
        match self {
            Self::Euler | Self::HalfKick | Self::Leapfrog | Self::LogH => Some(1),
            Self::ForestRuth => Some(3),
            Self::Rk4 => Some(4),
            Self::Kepler => None,
        }
    }
}

impl fmt::Display for Integrator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A hole as the GPU has it: mirrors `Hole` of `glsl/particles/black_hole.glsl`. Its centre at time t is
/// `at + velocity t + swing_u cos(phase) + swing_w sin(phase)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Hole {
    /// At tick 0 (m).
    pub at_m: [f32; 3],
    /// `G m` (m^3/s^2).
    pub mu_m3ps2: f32,
    /// (m/s).
    pub velocity_mps: [f32; 3],
    /// Radius within which a particle ends (m).
    pub horizon_m: f32,
    /// Of a circular or elliptic motion (m).
    pub swing_u_m: [f32; 3],
    /// 2^-32 turns: wraps without loss.
    pub turn_per_tick: u32,
    /// Of a circular or elliptic motion (m).
    pub swing_w_m: [f32; 3],
    /// At tick 0 (2^-32 turns).
    pub phase: u32,
}

impl Hole {
    /// At rest.
    pub fn at(at_m: [f32; 3], mu_m3ps2: f32, horizon_m: f32) -> Self {
        Self { at_m, mu_m3ps2, horizon_m, ..Self::default() }
    }

    /// In even motion.
    pub fn moving(self, velocity_mps: [f32; 3]) -> Self {
        Self { velocity_mps, ..self }
    }

    /// Round and round: at `u` from its place at first, at `w` a quarter of a period later. The period is rounded so that
    /// a tick is a whole number of 2^-32 turns: by less than 1e-4 of it up to 10 s, more beyond.
    pub fn swinging(self, u_m: [f32; 3], w_m: [f32; 3], period_s: f64) -> Self {
        let turn_per_tick = (4_294_967_296.0 / (period_s * f64::from(TICKS_PER_S))).round() as u32;
        Self { swing_u_m: u_m, swing_w_m: w_m, turn_per_tick, ..self }
    }

    fn swings(&self) -> bool {
        self.turn_per_tick != 0 || self.swing_u_m != [0.0; 3]
    }

    fn moves(&self) -> bool {
        self.swings() || self.velocity_mps != [0.0; 3]
    }
}

/// The law: holes, and how particles are moved about them.
#[derive(Clone, Debug, PartialEq)]
pub struct BlackHole {
    /// One or more.
    pub holes: Vec<Hole>,
    /// How a step moves a particle.
    pub integrator: Integrator,
    /// Of a step; of [`Integrator::LogH`] steps a radian of an orbit.
    pub substeps: u32,
}

impl BlackHole {
    /// Most holes.
    pub const MOST_HOLES: usize = 64;
    /// Most substeps.
    pub const MOST_SUBSTEPS: u32 = 1024;

    /// The book's: `mu` 10 000 and a horizon of 5, at (50, 0, 0).
    pub fn book(integrator: Integrator, substeps: u32) -> Self {
        Self { holes: vec![Hole::at([50.0, 0.0, 0.0], 1e4, 5.0)], integrator, substeps }
    }

    /// # Errors
    /// The first thing that cannot be run.
    pub fn check(&self) -> Result<(), Invalid> {
        let (holes, steps) = (self.holes.len(), self.substeps);
        hold((1..=Self::MOST_HOLES).contains(&holes), "holes", holes, "1 to 64")?;
        hold((1..=Self::MOST_SUBSTEPS).contains(&steps), "substeps", steps, "1 to 1024")?;
        for hole in &self.holes {
            let (mu, horizon) = (hole.mu_m3ps2, hole.horizon_m);
            hold(mu > 0.0 && mu.is_finite(), "mu_m3ps2", mu, "above 0 and finite")?;
            hold(horizon >= 0.0 && horizon.is_finite(), "horizon_m", horizon, "0 or more, finite")?;
            let places = [hole.at_m, hole.velocity_mps, hole.swing_u_m, hole.swing_w_m];
            for x in places.as_flattened() {
                hold(x.is_finite(), "place of a hole", x, "finite")?;
            }
        }
        let fails = |allowed: &str| {
            let value = self.integrator.name().into();
            Err(Invalid { key: "integrator", value, allowed: allowed.into() })
        };
        match self.integrator {
            Integrator::Kepler if holes != 1 || self.holes[0].swings() => {
                fails("kepler for one hole alone, at rest or in even motion; others for any")
            }
            Integrator::LogH if self.moves() => fails("logh for holes at rest; others for any"),
            _ => Ok(()),
        }
    }

    /// Whether a hole moves.
    pub fn moves(&self) -> bool {
        self.holes.iter().any(Hole::moves)
    }

    /// Specialization constants of the law, from `LAW_CONSTANT` on.
    pub fn constants(&self) -> [u32; 4] {
        [self.integrator as u32, self.substeps, self.holes.len() as u32, u32::from(self.moves())]
    }

    /// The law for a pool, with [`BlackHole::constants`]; its numbers are [`BlackHole::numbers`].
    pub fn law(constants: &[u32; 4]) -> Law<'_> {
        let spv = shaders::PARTICLES_BLACK_HOLE_COMP;
        Law { name: c"particles.black_hole", spv, subgroups: None, deferred: None, constants, blocks: &[] }
    }

    /// The list of holes, as the GPU has it.
    pub fn numbers(&self) -> &[u8] {
        bytemuck::cast_slice(&self.holes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_run_is_refused_with_what_is_allowed() {
        let book = |integrator| BlackHole::book(integrator, 1);
        for integrator in Integrator::ALL {
            assert_eq!(book(integrator).check(), Ok(()));
            assert_eq!(Integrator::named(integrator.name()), Some(integrator));
        }
        let said = |law: BlackHole| law.check().unwrap_err().to_string();
        let hole = book(Integrator::Rk4).holes[0];
        let of = |integrator, holes: &[Hole]| BlackHole { holes: holes.to_vec(), ..book(integrator) };
        assert_eq!(
            said(BlackHole { substeps: 0, ..book(Integrator::Rk4) }),
            "substeps = 0: allowed is 1 to 1024"
        );
        assert_eq!(said(of(Integrator::Rk4, &[])), "holes = 0: allowed is 1 to 64");
        assert!(said(of(Integrator::Kepler, &[hole, hole]))
            .starts_with("integrator = kepler: allowed is kepler for one"));
        let swinging = hole.swinging([1.0, 0.0, 0.0], [0.0, 0.0, 1.0], 4.0);
        assert!(said(of(Integrator::Kepler, &[swinging])).starts_with("integrator = kepler"));
        assert!(said(of(Integrator::LogH, &[swinging]))
            .starts_with("integrator = logh: allowed is logh for holes at rest"));
        assert_eq!(of(Integrator::Kepler, &[hole.moving([1.0, 0.0, 0.0])]).check(), Ok(()));
        let bad = Hole { mu_m3ps2: f32::NAN, ..hole };
        assert_eq!(said(of(Integrator::Rk4, &[bad])), "mu_m3ps2 = NaN: allowed is above 0 and finite");
    }
}
