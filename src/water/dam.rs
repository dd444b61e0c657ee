// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exact solutions of the shallow-water equations, in `f64`, and basins that start as they do: dam breaks over wet
//! (Stoker) and dry ground (Ritter), and water that swings in bowls (Thacker). As collected by Delestre and others,
//! "SWASHES: a compilation of shallow water analytic solutions", Int. J. Numer. Meth. Fluids 72 (2013) 269,
//! arXiv:1110.0288, sections 4.1 and 4.2.

use super::depth::{Columns, DepthModel, Tier};
use glam::{dvec2, uvec2, DVec2, UVec2};

/// (m/s^2), as SWASHES has it.
pub const GRAVITY_MPS2: f64 = 9.81;

/// Water of two depths on level ground, and the dam between them gone at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DamBreak {
    /// Behind the dam (m).
    pub high_m: f64,
    /// Before it (m): 0 for dry ground.
    pub low_m: f64,
    /// Behind the bore (m).
    middle_m: f64,
}

impl DamBreak {
    /// Edge of the basin of [`DamBreak::columns`], with the dam in the middle (m).
    pub const LENGTH_M: f64 = 10.0;
    /// When solutions are compared (s): no wave has reached a wall.
    pub const TIME_S: f64 = 0.6;

    /// Finds the depth behind the bore, where the wave that runs back and the bore agree on the current, by bisection.
    pub fn new(high_m: f64, low_m: f64) -> Self {
        let current_of_wave = |h: f64| 2.0 * ((GRAVITY_MPS2 * high_m).sqrt() - (GRAVITY_MPS2 * h).sqrt());
        let current_of_bore = |h: f64| (h - low_m) * (0.5 * GRAVITY_MPS2 * (h + low_m) / (h * low_m)).sqrt();
        let (mut low, mut high) = (low_m, if low_m > 0.0 { high_m } else { 0.0 });
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            let is_below = current_of_wave(middle) > current_of_bore(middle);
            *(if is_below { &mut low } else { &mut high }) = middle;
        }
        Self { high_m, low_m, middle_m: high }
    }

    /// Depth (m) and current (m/s) at `x_m` beyond the dam, `t_s` after it broke.
    pub fn at(&self, x_m: f64, t_s: f64) -> (f64, f64) {
        let speed = |h: f64| (GRAVITY_MPS2 * h).sqrt();
        let (behind, xi) = (speed(self.high_m), x_m / t_s);
        let current = 2.0 * (behind - speed(self.middle_m));
        let bore = if self.low_m > 0.0 {
            self.middle_m * current / (self.middle_m - self.low_m)
        } else {
            current // the wave thins out to nothing: no bore
        };
        if xi <= -behind {
            (self.high_m, 0.0)
        } else if xi <= current - speed(self.middle_m) {
            ((2.0 * behind - xi).powi(2) / (9.0 * GRAVITY_MPS2), 2.0 / 3.0 * (xi + behind))
        } else if xi <= bore {
            (self.middle_m, current)
        } else {
            (self.low_m, 0.0)
        }
    }

    /// A channel of `cells` columns, one row wide, with a whole number of steps to [`DamBreak::TIME_S`].
    pub fn model(&self, tier: Tier, cells: u32) -> DepthModel {
        let model = DepthModel {
            cells: uvec2(cells, 1),
            cell_m: Self::LENGTH_M / f64::from(cells),
            gravity_mps2: GRAVITY_MPS2,
            deepest_m: self.high_m,
            // Where water is deep it is slow: the two together are at most twice the wave behind the dam, at the tip.
            fastest_mps: (GRAVITY_MPS2 * self.high_m).sqrt(),
            damping_per_s: 0.0,
            thin_m: 1e-6,
            dt_s: 1.0,
        };
        whole_steps(model, tier, Self::TIME_S)
    }

    /// The start, with the level at rest at the bottom.
    pub fn columns(&self, cells: UVec2) -> Columns {
        let is_behind = |i: usize| (i as u32 % cells.x) < cells.x / 2;
        let bed = vec![0.0; cells.element_product() as usize];
        Columns::at_rest(&bed, |i| if is_behind(i) { self.high_m } else { self.low_m })
    }

    /// Distance of depths from the exact ones at [`DamBreak::TIME_S`], of a metre of the step.
    pub fn distance(&self, depths_m: &[f64]) -> f64 {
        let cell_m = Self::LENGTH_M / depths_m.len() as f64;
        let exact = |i: usize| self.at((i as f64 + 0.5) * cell_m - 0.5 * Self::LENGTH_M, Self::TIME_S).0;
        let apart: f64 = depths_m.iter().enumerate().map(|(i, h)| (h - exact(i)).abs()).sum();
        apart * cell_m / (self.high_m - self.low_m)
    }
}

/// How water swings in a bowl.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Swing {
    /// A level surface tilts to and fro in a parabolic valley: one row of columns.
    Tilting,
    /// A paraboloid rises and falls in a round bowl.
    Rising,
    /// A level surface that stays tilted runs round a round bowl.
    Circling,
}

/// A parabolic bowl with water that swings for ever: its shore moves, and nothing breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bowl {
    /// How.
    pub swing: Swing,
    /// Depth of the middle below the level at rest (m).
    pub depth_m: f64,
    /// Radius of the shore at rest (m).
    pub radius_m: f64,
    /// How far: of the radius the way of the middle of the water, or for [`Swing::Rising`] the smallest radius of the
    /// shore.
    pub reach: f64,
}

impl Bowl {
    /// Edge of the basin of [`Bowl::columns`], with the bowl in the middle (m).
    pub const LENGTH_M: f64 = 4.0;

    /// With the measures of SWASHES.
    pub fn new(swing: Swing) -> Self {
        let (depth_m, reach) = match swing {
            Swing::Tilting => (0.5, 0.5),
            Swing::Rising => (0.1, 0.8),
            Swing::Circling => (0.1, 0.5),
        };
        Self { swing, depth_m, radius_m: 1.0, reach }
    }

    fn omega(&self) -> f64 {
        let factor = if self.swing == Swing::Rising { 8.0 } else { 2.0 };
        (factor * GRAVITY_MPS2 * self.depth_m).sqrt() / self.radius_m
    }

    /// (s).
    pub fn period_s(&self) -> f64 {
        std::f64::consts::TAU / self.omega()
    }

    fn along(&self, at_m: DVec2) -> DVec2 {
        let at = at_m / self.radius_m;
        if self.swing == Swing::Tilting {
            dvec2(at.x, 0.0)
        } else {
            at
        }
    }

    /// Ground above the level at rest at `at_m` from the middle (m).
    pub fn bed_m(&self, at_m: DVec2) -> f64 {
        self.depth_m * (self.along(at_m).length_squared() - 1.0)
    }

    /// Surface above the level at rest, where it is above the ground (m).
    pub fn surface_m(&self, at_m: DVec2, t_s: f64) -> f64 {
        let (at, (sin, cos)) = (self.along(at_m), (self.omega() * t_s).sin_cos());
        let a = self.reach;
        match self.swing {
            Swing::Tilting => -self.depth_m * (2.0 * at.x * a * cos + a * a * cos * cos),
            Swing::Rising => {
                let a = (1.0 - a * a) / (1.0 + a * a);
                let wide = (1.0 - a * a).sqrt() / (1.0 - a * cos);
                self.depth_m * (wide - 1.0 - at.length_squared() * (wide * wide - 1.0))
            }
            Swing::Circling => self.depth_m * a * (2.0 * (at.x * cos + at.y * sin) - a),
        }
    }

    /// Current (m/s) where there is water.
    pub fn velocity_mps(&self, at_m: DVec2, t_s: f64) -> DVec2 {
        let (omega, (sin, cos)) = (self.omega(), (self.omega() * t_s).sin_cos());
        match self.swing {
            Swing::Tilting => dvec2(self.reach * self.radius_m * omega * sin, 0.0),
            Swing::Rising => {
                let a = (1.0 - self.reach * self.reach) / (1.0 + self.reach * self.reach);
                at_m * (0.5 * omega * a * sin / (1.0 - a * cos))
            }
            Swing::Circling => self.reach * self.radius_m * omega * dvec2(-sin, cos),
        }
    }

    /// Depth (m).
    pub fn depth_at_m(&self, at_m: DVec2, t_s: f64) -> f64 {
        (self.surface_m(at_m, t_s) - self.bed_m(at_m)).max(0.0)
    }

    /// `cells` columns along each axis, or along the valley, with a whole number of steps to `time_s`.
    pub fn model(&self, tier: Tier, cells: u32, time_s: f64) -> DepthModel {
        let (deepest_m, fastest_mps) = match self.swing {
            // The paraboloid is highest at the start, as deep as its volume in the narrowest shore.
            Swing::Rising => (self.surface_m(DVec2::ZERO, 0.0) + self.depth_m, 0.25 * self.omega()),
            _ => (self.depth_m, self.reach * self.radius_m * self.omega()),
        };
        let model = DepthModel {
            cells: if self.swing == Swing::Tilting { uvec2(cells, 1) } else { UVec2::splat(cells) },
            cell_m: Self::LENGTH_M / f64::from(cells),
            gravity_mps2: GRAVITY_MPS2,
            deepest_m,
            fastest_mps,
            damping_per_s: 0.0,
            thin_m: 1e-6,
            dt_s: 1.0,
        };
        whole_steps(model, tier, time_s)
    }

    /// The start; velocities, which [`Tier::Shallow`] takes, half a step before it.
    pub fn columns(&self, tier: Tier, model: &DepthModel) -> Columns {
        let places = |offset| places(model, offset);
        let bed: Vec<f64> = places(DVec2::ZERO).map(|at| self.bed_m(at)).collect();
        let surface: Vec<f64> = places(DVec2::ZERO).map(|at| self.surface_m(at, 0.0)).collect();
        let mut columns = Columns::at_rest(&bed, |i| surface[i]);
        if tier == Tier::Shallow {
            let before = -0.5 * model.dt_s;
            let speed = |at: DVec2| {
                let is_wet = self.depth_at_m(at, before) > 0.0;
                if is_wet {
                    self.velocity_mps(at, before)
                } else {
                    DVec2::ZERO
                }
            };
            columns.east = places(dvec2(0.5, 0.0)).map(|at| speed(at).x as f32).collect();
            if self.swing != Swing::Tilting {
                columns.south = places(dvec2(0.0, 0.5)).map(|at| speed(at).y as f32).collect();
            }
        }
        columns
    }

    /// Sum of the differences from the exact depths at `t_s`, of the sum of these.
    pub fn distance(&self, model: &DepthModel, depths_m: &[f64], t_s: f64) -> f64 {
        let exact: Vec<f64> = places(model, DVec2::ZERO).map(|at| self.depth_at_m(at, t_s)).collect();
        let apart: f64 = depths_m.iter().zip(&exact).map(|(a, b)| (a - b).abs()).sum();
        apart / exact.iter().sum::<f64>()
    }
}

/// Middles of the columns, from the middle of the grid (m), `offset` columns aside.
fn places(model: &DepthModel, offset: DVec2) -> impl Iterator<Item = DVec2> {
    let (cells, cell_m) = (model.cells, model.cell_m);
    (0..cells.y).flat_map(move |y| {
        (0..cells.x).map(move |x| (uvec2(x, y).as_dvec2() + 0.5 + offset - 0.5 * cells.as_dvec2()) * cell_m)
    })
}

/// The longest step of a whole number to `time_s`.
fn whole_steps(model: DepthModel, tier: Tier, time_s: f64) -> DepthModel {
    let steps = (time_s / model.longest_stable_s(tier)).ceil();
    DepthModel { dt_s: time_s / steps, ..model }
}

/// Steps of `model` to `time_s`.
pub fn steps_to(model: &DepthModel, time_s: f64) -> u32 {
    (time_s / model.dt_s).round() as u32
}
