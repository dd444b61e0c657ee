// SPDX-License-Identifier: MIT OR Apache-2.0
//! CPU twin of `glsl/water/fourth.comp`: see [`cpu`](super::cpu).

use super::{
    cpu::{pulls, Numbers, Real},
    Model, LAND_M,
};

/// Twin of `glsl/water/fourth.comp`.
#[derive(Clone, Debug)]
pub struct Fourth<T> {
    /// (m above rest), [`LAND_M`] for land.
    pub height_m: Vec<T>,
    /// (m/s).
    pub velocity_mps: Vec<T>,
    numbers: Numbers<T>,
    sharpen: T,
}

impl<T: Real> Fourth<T> {
    /// A basin at rest with the surface `height_m`.
    pub fn at_rest(model: &Model, height_m: &[f32]) -> Self {
        Self {
            height_m: height_m.iter().map(|&h| T::of(f64::from(h))).collect(),
            velocity_mps: vec![T::default(); height_m.len()],
            numbers: Numbers::new(model),
            sharpen: T::of(model.fourth_order_sharpen()),
        }
    }

    /// One step with half the pull: see [`super::Params::first_from_rest`].
    pub fn first_step_from_rest(&mut self) {
        self.step_with(self.numbers.first_from_rest());
    }

    /// One step.
    pub fn step(&mut self) {
        self.step_with(self.numbers);
    }

    fn step_with(&mut self, p: Numbers<T>) {
        let land = T::of(f64::from(LAND_M));
        let old = &self.height_m;
        let place = |i: usize| (i % p.width, i / p.width);
        let sum = |of: &[T], i: usize| pulls(&p, of, place(i).0, place(i).1);
        let sharp = |i: usize| sum(old, i).map_or(land, |sum| old[i] - self.sharpen * sum);
        let g: Vec<T> = (0..old.len()).map(sharp).collect();
        for i in 0..g.len() {
            let Some(sum) = sum(&g, i) else {
                self.velocity_mps[i] = T::default();
                continue;
            };
            let v = p.keep * (self.velocity_mps[i] + p.pull * sum);
            self.velocity_mps[i] = v;
            self.height_m[i] += p.dt * v;
        }
    }
}
