// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exact solutions and invariants that the kernels are compared with, in `f64`.

use super::{cpu, Model, LAND_M};
use glam::UVec2;
use std::f64::consts::PI;

/// Symbol of the stencil, `-L / (1 + 2 w)` for the wave with `k` radians a column: 0 at rest, at most
/// `max(4, 8 / (1 + 2 w))`.
pub fn symbol(k: [f64; 2], diagonal: f64) -> f64 {
    let [x, y] = k;
    let sides = 2.0 * (1.0 - x.cos()) + 2.0 * (1.0 - y.cos());
    let corners = 2.0 * (1.0 - (x + y).cos()) + 2.0 * (1.0 - (x - y).cos());
    (sides + diagonal * corners) / (1.0 + 2.0 * diagonal)
}

/// Radians a column of the closed basin's mode with `m` half waves along each axis.
pub fn mode_k(cells: UVec2, m: UVec2) -> [f64; 2] {
    let cells = cells.as_dvec2();
    [PI * f64::from(m.x) / cells.x, PI * f64::from(m.y) / cells.y]
}

/// `cos(pi m (x + 1/2) / N) cos(pi n (y + 1/2) / M)`: an eigenvector of the scheme with folded walls.
pub fn mode(cells: UVec2, m: UVec2) -> Vec<f64> {
    let [kx, ky] = mode_k(cells, m);
    let along = |k: f64, n: u32| -> Vec<f64> { (0..n).map(|i| (k * (f64::from(i) + 0.5)).cos()).collect() };
    let (xs, ys) = (along(kx, cells.x), along(ky, cells.y));
    ys.iter().flat_map(|y| xs.iter().map(move |x| x * y)).collect()
}

/// How far a mode turns in a step (rad) when nothing is damped: `2 asin(courant sqrt(S) / 2)`.
pub fn turn(model: &Model, m: UVec2) -> f64 {
    2.0 * (0.5 * model.courant() * symbol(mode_k(model.cells, m), model.diagonal).sqrt()).asin()
}

/// Amplitude of a mode after `steps` undamped steps from rest, relative to the start, if the first step was
/// [`Params::first_from_rest`](super::Params::first_from_rest) (`half_kick`), or a step like the others.
pub fn swing(turn: f64, steps: u32, half_kick: bool) -> f64 {
    let n = f64::from(steps);
    if half_kick {
        (n * turn).cos()
    } else {
        ((n + 0.5) * turn).cos() / (0.5 * turn).cos()
    }
}

/// Amplitude of `mode` in `height_m`: the projection.
pub fn amplitude(height_m: &[f32], mode: &[f64]) -> f64 {
    let dot: f64 = height_m.iter().zip(mode).map(|(&h, m)| f64::from(h) * m).sum();
    dot / mode.iter().map(|m| m * m).sum::<f64>()
}

/// Sum of the heights of all water (m, times the area of a column it is a volume).
pub fn volume(height_m: &[f32]) -> f64 {
    height_m.iter().filter(|&&h| h != LAND_M).map(|&h| f64::from(h)).sum()
}

/// Discrete energy of an undamped basin, in units of (m/s)^2: with the flow half a step behind, the potential part is
/// the product of the two surfaces on either side of it, and the sum is constant to rounding.
pub fn energy(model: &Model, height_m: &[f32], velocity_mps: &[f32]) -> f64 {
    let now: Vec<f64> = height_m.iter().map(|&h| f64::from(h)).collect();
    let before: Vec<f64> =
        now.iter().zip(velocity_mps).map(|(h, &v)| h - model.dt_s * f64::from(v)).collect();
    let scale = (model.speed_mps / model.cell_m).powi(2) / (1.0 + 2.0 * model.diagonal);
    let kinetic: f64 = velocity_mps.iter().map(|&v| 0.5 * f64::from(v).powi(2)).sum();
    let pulls = cpu::laplacians(model, &before);
    let potential: f64 = now.iter().zip(pulls).map(|(h, pull)| -0.5 * scale * h * pull).sum();
    kinetic + potential
}

/// Exact solution of `h_tt = c^2 laplace(h)` in a closed box from rest, by the cosine transform: every mode swings at
/// `c |k|`.
pub struct Exact {
    cells: UVec2,
    /// Along each axis, those that are kept.
    modes: UVec2,
    coefficients: Vec<f64>,
    cosines: [Vec<f64>; 2],
}

impl Exact {
    /// Transforms the start; columns are taken as samples at their centres.
    pub fn new(cells: UVec2, height_m: &[f32]) -> Self {
        Self::smooth(cells, height_m, u32::MAX)
    }

    /// Of a start so smooth that modes of more than `most` half waves along an axis are nothing in it.
    pub fn smooth(cells: UVec2, height_m: &[f32], most: u32) -> Self {
        let modes = cells.min(UVec2::splat(most));
        let table = |n: u32, modes: u32| -> Vec<f64> {
            let n = n as usize;
            let angle = |m: usize, i: usize| PI * m as f64 * (i as f64 + 0.5) / n as f64;
            (0..modes as usize).flat_map(|m| (0..n).map(move |i| angle(m, i).cos())).collect()
        };
        let cosines = [table(cells.x, modes.x), table(cells.y, modes.y)];
        let (w, h) = (cells.x as usize, cells.y as usize);
        let (mw, mh) = (modes.x as usize, modes.y as usize);
        let start: Vec<f64> = height_m.iter().map(|&h| f64::from(h)).collect();
        // Rows, then columns; the zeroth mode has half the weight.
        let weight = |m: usize, n: usize| if m == 0 { 1.0 } else { 2.0 } / n as f64;
        let mut rows = vec![0.0; mw * h];
        for y in 0..h {
            for m in 0..mw {
                let row = &start[y * w..(y + 1) * w];
                let dot: f64 = row.iter().zip(&cosines[0][m * w..]).map(|(h, c)| h * c).sum();
                rows[y * mw + m] = weight(m, w) * dot;
            }
        }
        let mut coefficients = vec![0.0; mw * mh];
        for n in 0..mh {
            for y in 0..h {
                let c = weight(n, h) * cosines[1][n * h + y];
                for m in 0..mw {
                    coefficients[n * mw + m] += c * rows[y * mw + m];
                }
            }
        }
        Self { cells, modes, coefficients, cosines }
    }

    /// The surface when waves have run `distance` columns, `c t / dx`.
    pub fn after(&self, distance: f64) -> Vec<f64> {
        let (w, h) = (self.cells.x as usize, self.cells.y as usize);
        let (mw, mh) = (self.modes.x as usize, self.modes.y as usize);
        let mut swung = self.coefficients.clone();
        for n in 0..mh {
            for m in 0..mw {
                let k = (PI * m as f64 / w as f64).hypot(PI * n as f64 / h as f64);
                swung[n * mw + m] *= (k * distance).cos();
            }
        }
        let mut rows = vec![0.0; mw * h];
        for y in 0..h {
            for n in 0..mh {
                let c = self.cosines[1][n * h + y];
                for m in 0..mw {
                    rows[y * mw + m] += c * swung[n * mw + m];
                }
            }
        }
        let mut out = vec![0.0; w * h];
        for y in 0..h {
            for m in 0..mw {
                let a = rows[y * mw + m];
                for x in 0..w {
                    out[y * w + x] += a * self.cosines[0][m * w + x];
                }
            }
        }
        out
    }
}

/// `|got - want| / |want|`, each by the root of the sum of squares.
pub fn relative_l2(got: &[f32], want: &[f64]) -> f64 {
    let error: f64 = got.iter().zip(want).map(|(&a, b)| (f64::from(a) - b).powi(2)).sum();
    (error / want.iter().map(|b| b * b).sum::<f64>()).sqrt()
}
