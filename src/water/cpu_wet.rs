// SPDX-License-Identifier: MIT OR Apache-2.0
//! CPU twins of `wet` and `shallow`, as those of [`super::cpu`]: the same operations in the same order, in `f64` as the
//! reference or in `f32` to be compared with the GPU bit for bit. Whole-grid passes, to be read beside the GLSL.

use super::{
    cpu::Real,
    depth::{Columns, DepthModel, Tier, WALL_M},
    LAND_M,
};
use std::ops::Div;

/// [`super::DepthParams`] in the twin's precision.
#[derive(Clone, Copy, Debug)]
struct Numbers<T> {
    width: usize,
    height: usize,
    reach: T,
    pull: T,
    keep: T,
    rain: T,
    thin: T,
    fastest: T,
    has_advection: bool,
}

/// One column as its neighbours see it.
#[derive(Clone, Copy, Debug)]
struct Seen<T> {
    bed: T,
    surface: T,
    depth: T,
}

/// Twin of `glsl/water/wet.comp` and of `glsl/water/shallow.comp`.
#[derive(Clone, Debug)]
pub struct Depths<T> {
    /// Ground (m), [`WALL_M`] for a wall.
    pub bed_m: Vec<T>,
    /// Water less that at rest (m), [`LAND_M`] for a wall.
    pub rise_m: Vec<T>,
    /// Through the east faces: flow (m^2/s) or velocity (m/s).
    pub east: Vec<T>,
    /// Through the south faces.
    pub south: Vec<T>,
    /// `rise_m` a step before.
    before_m: Vec<T>,
    tier: Tier,
    numbers: Numbers<T>,
}

/// GLSL's `max`: the first of equals.
fn max<T: Real>(a: T, b: T) -> T {
    if a < b {
        b
    } else {
        a
    }
}

impl<T: Real + Div<Output = T>> Depths<T> {
    /// A basin as [`super::DepthState::upload`] sets it.
    pub fn new(tier: Tier, model: &DepthModel, columns: &Columns) -> Self {
        let of = |numbers: &[f32]| numbers.iter().map(|&n| T::of(f64::from(n))).collect::<Vec<T>>();
        let walled = columns.bed_m.iter().zip(&columns.rise_m);
        let bed: Vec<f32> = walled.map(|(&bed, &rise)| if rise == LAND_M { WALL_M } else { bed }).collect();
        let numbers = Numbers {
            width: model.cells.x as usize,
            height: model.cells.y as usize,
            reach: T::of(model.dt_s / model.cell_m),
            pull: T::of(model.gravity_mps2 * model.dt_s / model.cell_m),
            keep: T::of((-model.damping_per_s * model.dt_s).exp()),
            rain: T::default(),
            thin: T::of(model.thin_m),
            fastest: T::of(model.cell_m / model.dt_s),
            has_advection: true,
        };
        Self {
            bed_m: of(&bed),
            rise_m: of(&columns.rise_m),
            east: of(&columns.east),
            south: of(&columns.south),
            before_m: of(&columns.rise_m),
            tier,
            numbers,
        }
    }

    /// As [`super::Shallow::without_advection`].
    pub fn without_advection(mut self) -> Self {
        self.numbers.has_advection = false;
        self
    }

    /// Depth of a column, a debt as below zero (m); walls have none.
    pub fn depth_m(&self, column: usize) -> T {
        let (bed, rise) = (self.bed_m[column], self.rise_m[column]);
        if rise == T::of(f64::from(LAND_M)) {
            T::default()
        } else {
            max(-bed, T::default()) + rise
        }
    }

    /// One step.
    pub fn step(&mut self) {
        self.step_with(self.numbers);
    }

    /// One step with half the pull: see [`super::DepthParams::first_from_rest`].
    pub fn first_step_from_rest(&mut self) {
        self.step_with(Numbers { pull: T::of(0.5) * self.numbers.pull, ..self.numbers });
    }

    /// One step with rain (m).
    pub fn step_in_rain(&mut self, rain_m: f32) {
        self.step_with(Numbers { rain: T::of(f64::from(rain_m)), ..self.numbers });
    }

    fn step_with(&mut self, p: Numbers<T>) {
        match self.tier {
            Tier::Wet => {
                let flows = self.faces(&p, &self.rise_m, |stored, a, b| pipe(&p, stored, a, b));
                (self.east, self.south) = self.limit_and_move(&p, flows);
            }
            Tier::Shallow => {
                (self.east, self.south) = self.new_speeds(&p);
                let flows = self.faces(&p, &self.rise_m, carried);
                self.limit_and_move(&p, flows);
            }
        }
    }

    /// The column at `(x, y)`, a wall beyond the grid: `depth_of` and `surface_of` of `glsl/water/depth.glsl`.
    fn seen(&self, p: &Numbers<T>, rise_m: &[T], x: isize, y: isize) -> Seen<T> {
        let zero = T::default();
        let wall = T::of(f64::from(WALL_M));
        let Some(i) = index(p, x, y) else { return Seen { bed: wall, surface: wall, depth: zero } };
        let (bed, rise) = (self.bed_m[i], rise_m[i]);
        let still = max(-bed, zero);
        Seen { bed, surface: max(bed, zero) + max(rise, -still), depth: max(still + rise, zero) }
    }

    /// `f` of what is stored in each face and of the two columns beside it: east faces, then south faces.
    fn faces(&self, p: &Numbers<T>, rise_m: &[T], f: impl Fn(T, Seen<T>, Seen<T>) -> T) -> (Vec<T>, Vec<T>) {
        let mut flows = (self.east.clone(), self.south.clone());
        for i in 0..self.rise_m.len() {
            let (x, y) = ((i % p.width) as isize, (i / p.width) as isize);
            let here = self.seen(p, rise_m, x, y);
            flows.0[i] = f(self.east[i], here, self.seen(p, rise_m, x + 1, y));
            flows.1[i] = f(self.south[i], here, self.seen(p, rise_m, x, y + 1));
        }
        flows
    }

    /// `glsl/water/donor.glsl`: moves the water, and says what the flows were limited to.
    fn limit_and_move(&mut self, p: &Numbers<T>, flows: (Vec<T>, Vec<T>)) -> (Vec<T>, Vec<T>) {
        let (zero, one) = (T::default(), T::of(1.0));
        let count = self.rise_m.len();
        let place = |i: usize| ((i % p.width) as isize, (i / p.width) as isize);
        let at = |numbers: &[T], x: isize, y: isize| index(p, x, y).map_or(zero, |i| numbers[i]);
        let rise = |x: isize, y: isize| index(p, x, y).map_or(T::of(f64::from(LAND_M)), |i| self.rise_m[i]);
        let moved = |flows: &[T], dx: isize, dy: isize| -> Vec<T> {
            let other = |i: usize| rise(place(i).0 + dx, place(i).1 + dy);
            (0..count).map(|i| in_whole_units(p.reach * flows[i], self.rise_m[i], other(i))).collect()
        };
        let (east, south) = (moved(&flows.0, 1, 0), moved(&flows.1, 0, 1));
        let share = |i: usize| {
            let (x, y) = place(i);
            let (w, n) = (at(&east, x - 1, y), at(&south, x, y - 1));
            let out = (max(east[i], zero) + max(-w, zero)) + (max(south[i], zero) + max(-n, zero));
            let most = T::of(1.0 - 1.0 / 1_048_576.0) * self.seen(p, &self.rise_m, x, y).depth;
            if out > most {
                most / out
            } else {
                one
            }
        };
        let shares: Vec<T> = (0..count).map(share).collect();
        let limited = |numbers: &[T], dx: isize, dy: isize| -> Vec<T> {
            let donor = |i: usize, flow: T| {
                let donor = if flow > zero { Some(i) } else { index(p, place(i).0 + dx, place(i).1 + dy) };
                donor.map_or(one, |donor| shares[donor])
            };
            numbers.iter().enumerate().map(|(i, &flow)| flow * donor(i, flow)).collect()
        };
        let (east, south) = (limited(&east, 1, 0), limited(&south, 0, 1));
        self.before_m.clone_from(&self.rise_m);
        for i in 0..count {
            let (x, y) = place(i);
            let gain = (at(&east, x - 1, y) - east[i]) + (at(&south, x, y - 1) - south[i]);
            self.rise_m[i] = (self.rise_m[i] + gain) + p.rain;
        }
        (limited(&flows.0, 1, 0), limited(&flows.1, 0, 1))
    }

    /// `glsl/water/shallow.comp`.
    fn new_speeds(&self, p: &Numbers<T>) -> (Vec<T>, Vec<T>) {
        let zero = T::default();
        let half = T::of(0.5);
        let (q, r) = self.faces(p, &self.before_m, carried);
        let at = |numbers: &[T], x: isize, y: isize| index(p, x, y).map_or(zero, |i| numbers[i]);
        let mut speeds = (self.east.clone(), self.south.clone());
        for i in 0..self.rise_m.len() {
            let (x, y) = ((i % p.width) as isize, (i / p.width) as isize);
            let here = self.seen(p, &self.rise_m, x, y);
            let (u, v) = (&self.east, &self.south);
            let sides = [
                half * (at(&q, x - 1, y) + at(&q, x, y)),
                half * (at(&q, x, y) + at(&q, x + 1, y)),
                half * (at(&r, x, y - 1) + at(&r, x + 1, y - 1)),
                half * (at(&r, x, y) + at(&r, x + 1, y)),
            ];
            let round = [at(u, x - 1, y), at(u, x + 1, y), at(u, x, y - 1), at(u, x, y + 1)];
            speeds.0[i] = advance(p, u[i], round, sides, here, self.seen(p, &self.rise_m, x + 1, y));
            let sides = [
                half * (at(&r, x, y - 1) + at(&r, x, y)),
                half * (at(&r, x, y) + at(&r, x, y + 1)),
                half * (at(&q, x - 1, y) + at(&q, x - 1, y + 1)),
                half * (at(&q, x, y) + at(&q, x, y + 1)),
            ];
            let round = [at(v, x, y - 1), at(v, x, y + 1), at(v, x - 1, y), at(v, x + 1, y)];
            speeds.1[i] = advance(p, v[i], round, sides, here, self.seen(p, &self.rise_m, x, y + 1));
        }
        speeds
    }
}

/// Where `(x, y)` is stored, if it is in the grid.
fn index<T>(p: &Numbers<T>, x: isize, y: isize) -> Option<usize> {
    let is_in = x >= 0 && y >= 0 && x < p.width as isize && y < p.height as isize;
    is_in.then(|| y as usize * p.width + x as usize)
}

/// `in_whole_units` of `glsl/water/donor.glsl`.
fn in_whole_units<T: Real>(moved: T, rise_a: T, rise_b: T) -> T {
    let size = max(max(rise_a, -rise_a), max(rise_b, -rise_b));
    (moved + size) - size
}

/// `slope_of` of `glsl/water/depth.glsl`.
fn slope_of<T: Real>(a: Seen<T>, b: Seen<T>) -> T {
    let slope = a.surface - b.surface;
    let rounding = T::of(1.5 / 8_388_608.0) * max(a.surface, b.surface);
    let is_exact = max(a.bed, b.bed) <= T::default();
    if is_exact || max(slope, -slope) > rounding {
        slope
    } else {
        T::default()
    }
}

/// `flow_through` of `glsl/water/wet.comp`.
fn pipe<T: Real>(p: &Numbers<T>, stored: T, a: Seen<T>, b: Seen<T>) -> T {
    let head = max(a.surface, b.surface) - max(a.bed, b.bed);
    if head > p.thin {
        p.keep * (stored + (p.pull * head) * slope_of(a, b))
    } else {
        T::default()
    }
}

/// `carried` of `glsl/water/shallow.comp`.
fn carried<T: Real>(velocity: T, a: Seen<T>, b: Seen<T>) -> T {
    let upstream = if velocity > T::default() { a.surface } else { b.surface };
    velocity * max(upstream - max(a.bed, b.bed), T::default())
}

/// `advance` of `glsl/water/shallow.comp`.
fn advance<T: Real + Div<Output = T>>(
    p: &Numbers<T>,
    here: T,
    round: [T; 4],
    flows: [T; 4],
    a: Seen<T>,
    b: Seen<T>,
) -> T {
    let zero = T::default();
    let head = max(a.surface, b.surface) - max(a.bed, b.bed);
    if head <= p.thin {
        return zero;
    }
    let brings = [max(flows[0], zero), max(-flows[1], zero), max(flows[2], zero), max(-flows[3], zero)];
    let brought = (brings[0] * (here - round[0]) + brings[1] * (here - round[1]))
        + (brings[2] * (here - round[2]) + brings[3] * (here - round[3]));
    let brought = if p.has_advection { brought } else { zero };
    let mean = T::of(0.5) * (a.depth + b.depth);
    let over = max(mean, p.reach * ((brings[0] + brings[1]) + (brings[2] + brings[3])));
    let velocity = p.keep * ((here - p.reach * brought / over) + p.pull * slope_of(a, b));
    let capped = if velocity > p.fastest { p.fastest } else { velocity };
    max(capped, -p.fastest)
}
