// SPDX-License-Identifier: MIT OR Apache-2.0
//! `[[attractor]]`: what pulls particles.

use super::{
    parse::{Rule::Within, Table},
    schema::{LENGTH, PLACE},
};
use crate::particles;
use serde::Serialize;

/// Pulls the particles of every `black_hole`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Attractor {
    /// At the start, or the middle of its orbit (m).
    pub at_m: [f32; 3],
    /// G m (m³/s²), more than 0.
    pub mu_m3ps2: f32,
    /// Radius within which particles end (m), default 0.
    pub horizon_m: f32,
    /// (m/s), default 0.
    pub velocity_mps: [f32; 3],
    /// Radius of a level circle round `at_m` (m), default 0.
    pub orbit_m: f32,
    /// Time of a round of it (s), needed with `orbit_m`.
    pub period_s: f64,
    /// Where it is on it at the start, from +z towards +x (degrees), default 0.
    pub start_deg: f32,
}

pub(super) fn attractors(root: &mut Table<'_>) -> Vec<Attractor> {
    let most = particles::black_hole::BlackHole::MOST_HOLES.min(MOST_CENTRES);
    let tables = root.tables("attractor");
    if tables.len() > most {
        let message = format!("has {} of them; allowed: {most}", tables.len());
        root.blame("attractor", super::ProblemKind::OutOfRange, message);
    }
    tables.into_iter().map(attractor).collect()
}

/// That colours can go by: as many as `Glow` has in `glsl/particles/glow.glsl`.
pub(crate) const MOST_CENTRES: usize = 16;

fn attractor(mut table: Table<'_>) -> Attractor {
    let attractor = Attractor {
        at_m: table.number("at_m", PLACE),
        mu_m3ps2: table.number("mu_m3ps2", Within(1e-12, 1e12)),
        horizon_m: table.maybe("horizon_m", Within(0.0, 1e7)).unwrap_or(0.0),
        velocity_mps: table.maybe("velocity_mps", Within(-1e6, 1e6)).unwrap_or([0.0; 3]),
        orbit_m: table.maybe("orbit_m", LENGTH).unwrap_or(0.0),
        period_s: table.maybe("period_s", Within(1e-2, 1e5)).unwrap_or(0.0),
        start_deg: table.maybe("start_deg", Within(-360.0, 360.0)).unwrap_or(0.0),
    };
    if (attractor.orbit_m > 0.0) != (attractor.period_s > 0.0) {
        table.conflict("orbit_m", "and period_s go together");
    }
    table.finish();
    attractor
}

impl Attractor {
    /// As the law has it.
    pub fn hole(&self) -> particles::black_hole::Hole {
        let hole = particles::black_hole::Hole::at(self.at_m, self.mu_m3ps2, self.horizon_m)
            .moving(self.velocity_mps);
        if self.orbit_m == 0.0 {
            return hole;
        }
        let (sin, cos) = self.start_deg.to_radians().sin_cos();
        let r = self.orbit_m;
        hole.swinging([r * sin, 0.0, r * cos], [r * cos, 0.0, -r * sin], self.period_s)
    }

    /// Where it is at `time_s` (m): to look at, the law has its own clock.
    pub fn at(&self, time_s: f64) -> [f32; 3] {
        let turn = if self.period_s > 0.0 { (time_s / self.period_s).rem_euclid(1.0) } else { 0.0 };
        let angle = std::f64::consts::TAU * turn + f64::from(self.start_deg).to_radians();
        let (sin, cos) = angle.sin_cos();
        let swing = [sin, 0.0, cos].map(|x| f64::from(self.orbit_m) * x);
        std::array::from_fn(|k| {
            (f64::from(self.at_m[k]) + time_s * f64::from(self.velocity_mps[k]) + swing[k]) as f32
        })
    }
}
