// SPDX-License-Identifier: MIT OR Apache-2.0
//! CPU twins: each does what the kernel of the same name does, column by column, in the same order of operations, in
//! `f64` as the reference, or in `f32` to be compared with the GPU bit for bit. Written to be read beside the GLSL.

use super::{Model, Walls, LAND_M};
use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// `f32` or `f64`.
pub trait Real:
    Copy
    + PartialEq
    + PartialOrd
    + Default
    + Add<Output = Self>
    + AddAssign
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
{
    /// `self * a + b`, rounded once.
    fn fused(self, a: Self, b: Self) -> Self;
    /// Nearest value.
    fn of(value: f64) -> Self;
}

impl Real for f32 {
    fn fused(self, a: Self, b: Self) -> Self {
        self.mul_add(a, b)
    }
    fn of(value: f64) -> Self {
        value as f32
    }
}

impl Real for f64 {
    fn fused(self, a: Self, b: Self) -> Self {
        self.mul_add(a, b)
    }
    fn of(value: f64) -> Self {
        value
    }
}

/// [`super::Params`] in the twin's precision: rounded as the GPU has them in `f32`, exact in `f64`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Numbers<T> {
    pub width: usize,
    pub height: usize,
    pub dt: T,
    pub pull: T,
    pub keep: T,
    pub diagonal: T,
    pub folded: bool,
    /// Land is in the basin: the kernel is built to look for it.
    pub has_land: bool,
    /// `fma` is rounded once. GLSL leaves it to the driver.
    pub is_fused: bool,
}

impl<T: Real> Numbers<T> {
    pub fn new(model: &Model) -> Self {
        let w = model.diagonal;
        Self {
            width: model.cells.x as usize,
            height: model.cells.y as usize,
            dt: T::of(model.dt_s),
            pull: T::of(model.pull()),
            keep: T::of((-model.damping_per_s * model.dt_s).exp()),
            diagonal: T::of(w),
            folded: model.walls == Walls::Folded,
            has_land: false,
            is_fused: false,
        }
    }

    /// `a * b + c`, as the driver does it.
    pub fn fma(&self, a: T, b: T, c: T) -> T {
        if self.is_fused {
            a.fused(b, c)
        } else {
            a * b + c
        }
    }

    /// See [`super::Params::first_from_rest`].
    pub fn first_from_rest(self) -> Self {
        Self { pull: T::of(0.5) * self.pull, ..self }
    }
}

/// Twin of `glsl/water/waves_pass.glsl`.
#[derive(Clone, Debug)]
pub struct Waves<T> {
    /// (m above rest), [`LAND_M`] for land.
    pub height_m: Vec<T>,
    /// (m/s).
    pub velocity_mps: Vec<T>,
    numbers: Numbers<T>,
}

impl<T: Real> Waves<T> {
    /// A basin at rest with the surface `height_m`.
    pub fn at_rest(model: &Model, height_m: &[f32]) -> Self {
        Self {
            height_m: height_m.iter().map(|&h| T::of(f64::from(h))).collect(),
            velocity_mps: vec![T::default(); height_m.len()],
            numbers: Numbers { has_land: height_m.contains(&LAND_M), ..Numbers::new(model) },
        }
    }

    /// As a driver rounds that has a fused multiply-add; others multiply, round, add, round.
    pub fn fused(mut self) -> Self {
        self.numbers.is_fused = true;
        self
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
        let old = self.height_m.clone();
        for y in 0..p.height {
            for x in 0..p.width {
                let i = y * p.width + x;
                let Some(sum) = laplacian(&p, &old, x, y) else {
                    self.velocity_mps[i] = T::default();
                    continue;
                };
                let v = p.keep * p.fma(p.pull, sum, self.velocity_mps[i]);
                self.velocity_mps[i] = v;
                self.height_m[i] = p.fma(p.dt, v, old[i]);
            }
        }
    }
}

/// The stencil's sum at `(x, y)`; `None` on land.
fn laplacian<T: Real>(p: &Numbers<T>, old: &[T], x: usize, y: usize) -> Option<T> {
    let land = T::of(f64::from(LAND_M));
    let centre = old[y * p.width + x];
    let at = |dx: isize, dy: isize| neighbour(p, old, land, x, y, dx, dy);
    let is_beside_land = || (-1..=1).any(|dy| (-1..=1).any(|dx| at(dx, dy) == land));
    match () {
        () if centre == land => None,
        () if p.has_land && is_beside_land() => Some(pulls_beside_land(p, land, centre, at)),
        () => Some(bends(p, old, x, y)),
    }
}

/// The stencil's sum at `(x, y)` as pulls, land near or not; `None` on land.
pub(super) fn pulls<T: Real>(p: &Numbers<T>, old: &[T], x: usize, y: usize) -> Option<T> {
    let land = T::of(f64::from(LAND_M));
    let centre = old[y * p.width + x];
    let at = |dx: isize, dy: isize| neighbour(p, old, land, x, y, dx, dy);
    (centre != land).then(|| pulls_beside_land(p, land, centre, at))
}

/// `pull_of` in `glsl/water/waves.glsl`: where there is no land, columns beyond the border are mirror images.
fn bends<T: Real>(p: &Numbers<T>, old: &[T], x: usize, y: usize) -> T {
    let rows = [y.saturating_sub(1), y, (y + 1).min(p.height - 1)];
    let columns = [x.saturating_sub(1), x, (x + 1).min(p.width - 1)];
    let [n, c, s] = rows.map(|y| columns.map(|x| old[y * p.width + x]));
    let bend = |[west, mid, east]: [T; 3]| (east - mid) - (mid - west);
    let drops = |at_wall: bool| !p.folded && at_wall;
    let above = if drops(y == 0) { T::default() } else { bend(n) };
    let below = if drops(y + 1 == p.height) { T::default() } else { bend(s) };
    let walls = f64::from(u8::from(drops(x == 0)) + u8::from(drops(x + 1 == p.width)));
    let upright = T::of(1.0) + T::of(2.0 - walls) * p.diagonal;
    let along = p.fma(p.diagonal, above + below, bend(c));
    p.fma(upright, (s[1] - c[1]) - (c[1] - n[1]), along)
}

/// `pull_beside_land` in `glsl/water/waves.glsl`: land and what lies beyond the border are shores alike.
fn pulls_beside_land<T: Real>(p: &Numbers<T>, land: T, centre: T, at: impl Fn(isize, isize) -> T) -> T {
    let [n, s, w, e] = [at(0, -1), at(0, 1), at(-1, 0), at(1, 0)];
    let side = |side: T| if side == land { T::default() } else { side - centre };
    let corner = |corner: T, row: T, column: T| corner_pull(p, land, corner, row, column, centre);
    let sides = (side(w) + side(e)) + (side(n) + side(s));
    let corners = (corner(at(-1, -1), n, w) + corner(at(1, -1), n, e))
        + (corner(at(-1, 1), s, w) + corner(at(1, 1), s, e));
    sides + p.diagonal * corners
}

/// The stencil's sum at every column, 0 on land: for the discrete energy.
pub fn laplacians(model: &Model, height_m: &[f64]) -> Vec<f64> {
    let has_land = height_m.contains(&f64::from(LAND_M));
    let p = Numbers::<f64> { has_land, ..Numbers::new(model) };
    (0..height_m.len()).map(|i| laplacian(&p, height_m, i % p.width, i / p.width).unwrap_or(0.0)).collect()
}

/// The column beside `(x, y)`, land beyond the grid.
pub(super) fn neighbour<T: Real>(
    p: &Numbers<T>,
    old: &[T],
    land: T,
    x: usize,
    y: usize,
    dx: isize,
    dy: isize,
) -> T {
    match (x.checked_add_signed(dx), y.checked_add_signed(dy)) {
        (Some(x), Some(y)) if x < p.width && y < p.height => old[y * p.width + x],
        _ => land,
    }
}

/// What the column in one corner adds: `corner_pull` in `glsl/water/waves.glsl`, border and shore alike.
fn corner_pull<T: Real>(p: &Numbers<T>, land: T, corner: T, row: T, column: T, centre: T) -> T {
    match (corner != land, row != land, column != land) {
        (true, false, false) => T::default(),
        (true, ..) => corner - centre,
        (false, true, false) if p.folded => row - centre,
        (false, false, true) if p.folded => column - centre,
        (false, ..) => T::default(),
    }
}

/// Twin of `glsl/water/book.comp`.
#[derive(Clone, Debug)]
pub struct Book<T> {
    /// (m above rest).
    pub height_m: Vec<T>,
    /// From the right, lower right, below, lower left (m/s).
    pub flow_mps: Vec<[T; 4]>,
    numbers: Numbers<T>,
}

/// Where the pipe `k` of a column leads.
const PIPES: [(isize, isize); 4] = [(1, 0), (1, 1), (0, 1), (-1, 1)];

impl<T: Real> Book<T> {
    /// A basin at rest with the surface `height_m`.
    pub fn at_rest(model: &Model, height_m: &[f32]) -> Self {
        Self {
            height_m: height_m.iter().map(|&h| T::of(f64::from(h))).collect(),
            flow_mps: vec![[T::default(); 4]; height_m.len()],
            numbers: Numbers::new(model),
        }
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

    /// One step by equation 12.5 of the book, which averages the flows before and after: it grows without bound
    /// whatever the step, and is here so that a test can show it.
    pub fn step_averaged(&mut self) {
        let before = self.flow_mps.clone();
        self.flows(self.numbers);
        let after = self.flow_mps.clone();
        for (flow, before) in self.flow_mps.iter_mut().zip(before) {
            for k in 0..4 {
                flow[k] = T::of(0.5) * (flow[k] + before[k]);
            }
        }
        self.heights();
        self.flow_mps = after;
    }

    fn flows(&mut self, p: Numbers<T>) {
        for y in 0..p.height {
            for x in 0..p.width {
                let i = y * p.width + x;
                for (k, (dx, dy)) in PIPES.into_iter().enumerate() {
                    let pull = if k % 2 == 1 { p.diagonal * p.pull } else { p.pull };
                    let end = x.checked_add_signed(dx).zip(y.checked_add_signed(dy));
                    let end = end.filter(|&(x, y)| x < p.width && y < p.height);
                    self.flow_mps[i][k] = match end {
                        Some((x, y)) => {
                            let slope = self.height_m[y * p.width + x] - self.height_m[i];
                            p.keep * (self.flow_mps[i][k] + pull * slope)
                        }
                        None => T::default(),
                    };
                }
            }
        }
    }

    fn heights(&mut self) {
        let p = self.numbers;
        let flow = |x: usize, y: usize, dx: isize, dy: isize, k: usize| {
            let from = x.checked_add_signed(dx).zip(y.checked_add_signed(dy));
            from.filter(|&(x, _)| x < p.width)
                .map_or(T::default(), |(x, y)| self.flow_mps[y * p.width + x][k])
        };
        for y in 0..p.height {
            for x in 0..p.width {
                let own = self.flow_mps[y * p.width + x];
                let gain = (own[0] + own[1]) + (own[2] + own[3]);
                let loss = (flow(x, y, -1, 0, 0) + flow(x, y, -1, -1, 1))
                    + (flow(x, y, 0, -1, 2) + flow(x, y, 1, -1, 3));
                let i = y * p.width + x;
                self.height_m[i] += p.dt * (gain - loss);
            }
        }
    }
}

/// The listings of the book as they are printed (12.2 to 12.7, under the rules of Direct3D 11): the figure that the hard
/// cases show beside the kernels. `dt` is in the flow only; the threads round a tile make flow where there is no column
/// (the row above's last column is the left neighbour of the first, what lies before the buffer reads as zero); a frame
/// is a step.
#[derive(Clone, Debug)]
pub struct BookAsPrinted {
    width: isize,
    height: isize,
    /// (m above an empty column).
    pub height_m: Vec<f64>,
    /// Right, lower right, below, lower left.
    pub flow: Vec<[f64; 4]>,
    /// Of the flow, what a frame leaves: 0.9995 as printed.
    pub damping: f64,
}

impl BookAsPrinted {
    /// A basin at rest. The listings need a grid of whole tiles.
    ///
    /// # Panics
    /// If the grid is no multiple of 16.
    pub fn at_rest(cells: glam::UVec2, height_m: &[f32]) -> Self {
        assert!((cells % 16) == glam::UVec2::ZERO, "the listings need whole tiles, not {cells}");
        Self {
            width: cells.x as isize,
            height: cells.y as isize,
            height_m: height_m.iter().map(|&h| f64::from(h)).collect(),
            flow: vec![[0.0; 4]; height_m.len()],
            damping: 0.9995,
        }
    }

    /// One frame of `frame_s` (s).
    pub fn frame(&mut self, frame_s: f64) {
        const STEP: f64 = 0.05;
        const PIPE_AREA: f64 = 0.0001;
        const GRAVITY: f64 = 10.0;
        const PIPE_LENGTH: f64 = 0.2;
        const COLUMN_AREA: f64 = 0.05;
        let factor = frame_s.min(STEP) * PIPE_AREA * GRAVITY / (PIPE_LENGTH * COLUMN_AREA);

        let (w, h) = (self.width, self.height);
        let index = |x: isize, y: isize| usize::try_from(x + y * w).ok().filter(|&i| i < self.flow.len());
        let loaded =
            |x: isize, y: isize| index(x, y).map_or((0.0, [0.0; 4]), |i| (self.height_m[i], self.flow[i]));
        let new_flow = |x: isize, y: isize| {
            let (here, old) = loaded(x, y);
            let not_right = x < w - 1;
            let not_bottom = y < h - 1;
            let exists = [not_right, not_right && not_bottom, not_bottom, not_bottom && x > 0];
            let mut flow = [0.0; 4];
            for (k, (dx, dy)) in PIPES.into_iter().enumerate() {
                let slope = if exists[k] { loaded(x + dx, y + dy).0 - here } else { 0.0 };
                flow[k] = (slope * factor + old[k]) * self.damping;
            }
            flow
        };
        // Of the columns, and of the threads that stand round them on three sides.
        let wide = w + 2;
        let threads = (-1..h).flat_map(|y| (-1..=w).map(move |x| (x, y)));
        let new_flows: Vec<[f64; 4]> = threads.map(|(x, y)| new_flow(x, y)).collect();
        let made = |x: isize, y: isize| new_flows[((y + 1) * wide + x + 1) as usize];
        for y in 0..h {
            for x in 0..w {
                let i = (x + y * w) as usize;
                let own = made(x, y);
                let gain: f64 = own.iter().sum();
                let loss =
                    made(x - 1, y)[0] + made(x - 1, y - 1)[1] + made(x, y - 1)[2] + made(x + 1, y - 1)[3];
                self.height_m[i] += gain - loss;
                self.flow[i] = own;
            }
        }
    }
}
