// SPDX-License-Identifier: MIT OR Apache-2.0
//! CPU twin of the `pipes` rung, as those in [`cpu`](super::cpu).

use super::{
    cpu::{neighbour, Numbers, Real},
    Model, LAND_M,
};

/// Twin of `glsl/water/pipes.comp`.
#[derive(Clone, Debug)]
pub struct Pipes<T> {
    /// (m above rest), [`LAND_M`] for land.
    pub height_m: Vec<T>,
    /// From the right, lower right, below, lower left (m/s).
    pub flow_mps: Vec<[T; 4]>,
    numbers: Numbers<T>,
}

/// Where the pipe `k` of a column leads.
const PIPES: [(isize, isize); 4] = [(1, 0), (1, 1), (0, 1), (-1, 1)];

impl<T: Real> Pipes<T> {
    /// A basin at rest with the surface `height_m`.
    pub fn at_rest(model: &Model, height_m: &[f32]) -> Self {
        Self {
            height_m: height_m.iter().map(|&h| T::of(f64::from(h))).collect(),
            flow_mps: vec![[T::default(); 4]; height_m.len()],
            numbers: Numbers::new(model),
        }
    }

    /// As a driver rounds that has a fused multiply-add; others multiply, round, add, round.
    pub fn fused(mut self) -> Self {
        self.numbers.is_fused = true;
        self
    }

    /// One step with half the pull: see [`super::Params::first_from_rest`].
    pub fn first_step_from_rest(&mut self) {
        self.flows(self.numbers.first_from_rest());
        self.heights();
    }

    /// One step.
    pub fn step(&mut self) {
        self.flows(self.numbers);
        self.heights();
    }

    /// How fast each column rises: what flows in (m/s).
    pub fn rise_mps(&self) -> Vec<T> {
        let p = &self.numbers;
        (0..self.height_m.len()).map(|i| self.inflow(i % p.width, i / p.width)).collect()
    }

    fn flows(&mut self, p: Numbers<T>) {
        let land = T::of(f64::from(LAND_M));
        for (i, flow) in self.flow_mps.iter_mut().enumerate() {
            let (x, y) = (i % p.width, i / p.width);
            let at = |dx, dy| neighbour(&p, &self.height_m, land, x, y, dx, dy);
            for (flow, to) in flow.iter_mut().zip(PIPES) {
                // Land is so deep that the slope to it is finite and no pull of it is anything.
                let pull = p.pull * weight(&p, land, at, to);
                *flow = p.keep * p.fma(pull, at(to.0, to.1) - at(0, 0), *flow);
            }
        }
    }

    /// Gain less loss, in the order of the kernel.
    fn inflow(&self, x: usize, y: usize) -> T {
        let p = &self.numbers;
        let flow = |dx: isize, dy: isize, k: usize| {
            let from = x.checked_add_signed(dx).zip(y.checked_add_signed(dy));
            from.filter(|&(x, _)| x < p.width)
                .map_or(T::default(), |(x, y)| self.flow_mps[y * p.width + x][k])
        };
        let [right, lower_right, below, lower_left] = self.flow_mps[y * p.width + x];
        let gain = (right + lower_right) + (below + lower_left);
        let loss = (flow(-1, 0, 0) + flow(-1, -1, 1)) + (flow(0, -1, 2) + flow(1, -1, 3));
        gain - loss
    }

    fn heights(&mut self) {
        let rises = self.rise_mps();
        for (h, rise) in self.height_m.iter_mut().zip(rises) {
            *h = self.numbers.fma(self.numbers.dt, rise, *h);
        }
    }
}

/// Weight of the pipe from `(0, 0)` to `to`, 0 if there is none. What lies beyond the grid is land.
fn weight<T: Real>(p: &Numbers<T>, land: T, at: impl Fn(isize, isize) -> T, (dx, dy): (isize, isize)) -> T {
    let is_wet = |x, y| at(x, y) != land;
    if !is_wet(0, 0) || !is_wet(dx, dy) {
        return T::default();
    }
    if dx != 0 && dy != 0 {
        return if is_wet(dx, 0) || is_wet(0, dy) { p.diagonal } else { T::default() };
    }
    // A wall lies along the pipe where both columns beside it are land: it folds two half diagonals onto the pipe.
    let (nx, ny) = (dy, dx);
    let is_wall = |side: isize| !is_wet(side * nx, side * ny) && !is_wet(dx + side * nx, dy + side * ny);
    let walls = u8::from(is_wall(-1)) + u8::from(is_wall(1));
    T::of(1.0) + T::of(f64::from(if p.folded { walls } else { 0 })) * p.diagonal
}
