// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twin of `glsl/particles/{colliding,collide_look,colliding_flight,collide_sweep,collide_seed}.glsl`, without `may_enter`: what
//! that leaves out is never met. Whether it flies freely is asked of boxes alone, as `near` bits have it: whom slabs let by meets
//! nothing, which a test asks of [`Law::passes`].

pub use super::cpu_near::{met_in, near, slab};
use super::{
    colliding::{Colliding, Method},
    cpu_near::{bit, cell_of_met, dotted, extent_of, gap, gap_of_slab, met_at},
    Particle,
};
use crate::{
    cells::{Extent, Plane},
    impact::{Impact, NO_MESH},
    random,
};
use glam::{IVec3, UVec3, Vec3};

const NEVER_S: f32 = 3.0e38;
const MOST_PIECES: f32 = 4096.0;
const RIM: f32 = 1.0e-3;
const BEYOND: f32 = 0.126;
const MOST_IMPACTS: u32 = 8;
const MOST_LEGS: u32 = 16;
const SAME: f32 = 0.9999;
const SAME_SQ_M2PS2: f32 = 1.0e-8;

/// The scene on the host.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// A bit a cell.
    pub occupied: &'a [u32],
    /// Two a cell.
    pub planes: &'a [Plane],
    /// Of [`near`].
    pub near: &'a [u32],
}

/// Twin of the law: numbers, method, scene, and whom it moves when.
#[derive(Clone, Copy, Debug)]
pub struct Law<'a> {
    /// Numbers.
    pub law: &'a Colliding,
    /// How.
    pub method: Method,
    /// Where.
    pub scene: Scene<'a>,
    /// `law_tick()`.
    pub tick: u32,
    /// `law_step_s()`.
    pub step_s: f32,
}

#[derive(Clone, Copy)]
struct Met {
    number: usize,
    is_back: bool,
}

#[derive(Clone, Copy)]
struct Hit {
    after_s: f32,
    distance_m: f32,
    met: Option<Met>,
}

/// Where a plane is felt: in a cell, an extent.
struct Window {
    centre_m: Vec3,
    extent: Extent,
}

/// A box of cells, the corner nearest to its middle, and where feet on planes can be (cells).
#[derive(Clone, Copy)]
struct Cells {
    first: IVec3,
    last: IVec3,
    corner: IVec3,
    low: Vec3,
    high: Vec3,
}

/// A parabola, and when in the step it begins.
#[derive(Clone, Copy)]
struct Leg {
    at_m: Vec3,
    velocity_mps: Vec3,
    pull_mps2: Vec3,
    elapsed_s: f32,
    left_s: f32,
}

fn moved(at: Vec3, velocity: Vec3, pull: Vec3, after: f32) -> Vec3 {
    at + (velocity * after + pull * (0.5 * after * after))
}

fn fall_s(c: f32, w: f32, a: f32) -> f32 {
    let square = w * w - 2.0 * a * c;
    if w < 0.0 {
        if c <= 0.0 {
            return 0.0;
        }
        if square < 0.0 {
            return NEVER_S;
        }
        return 2.0 * c / (square.sqrt() - w);
    }
    if a < 0.0 {
        (w + square.max(0.0).sqrt()) / -a
    } else {
        NEVER_S
    }
}

fn rounding(w: f32, a: f32, after: f32, rise: f32) -> f32 {
    let square = w * w + 2.0 * a * rise;
    let speed = w + a * after;
    if speed < 0.0 && square > 0.0 {
        -square.sqrt() - speed
    } else {
        0.0
    }
}

/// Cells of a box in the order of `occupied_in_block` and `to_next_block`: of two at once the first that is met counts.
fn in_blocks(first: IVec3, last: IVec3) -> impl Iterator<Item = IVec3> {
    const BLOCK: IVec3 = IVec3::new(8, 2, 2);
    let blocks = (last - first + BLOCK) / BLOCK;
    let block = move |i: i32| {
        first + BLOCK * IVec3::new(i % blocks.x, i / blocks.x % blocks.y, i / blocks.x / blocks.y)
    };
    let cells = |block: IVec3| (0..32).map(move |i| block + IVec3::new(i % 8, i / 8 % 2, i / 16));
    (0..blocks.element_product())
        .flat_map(move |i| cells(block(i)))
        .filter(move |cell| cell.cmple(last).all())
}

impl Law<'_> {
    /// Twin of `advance`. Impacts are added to `impacts`.
    pub fn advance(&self, it: &mut Particle, dt_s: f32, slot: u32, impacts: &mut Vec<Impact>) -> bool {
        let law = self.law;
        if dt_s > 0.0 {
            match self.method {
                Method::OnePlane | Method::TwoPlanes => self.collide(it, dt_s, slot, impacts),
                _ => self.step_as_seed(it, dt_s, slot, impacts),
            }
        }
        let is_above = it.at_m.y >= law.floor_m;
        if law.respawns != 0 && !is_above {
            let [u, v, ..] = random::units(random::bits(law.seed, slot, self.tick, 0));
            it.at_m = law.emitter_m + random::direction_of([u, v]) * law.emitter_radius_m;
            it.velocity_mps = Vec3::ZERO;
            it.born = self.tick;
        }
        true
    }

    /// Twin of `flies_freely`, of a particle whose step is no longer than the law's.
    pub fn passes(&self, it: &Particle, dt_s: f32) -> bool {
        let (law, grid) = (self.law, &self.law.grid);
        let (step, per_m) = (self.step_s, 1.0 / grid.cell_m);
        let most_s = law.lead_s.max((step - law.lead_s).abs());
        let pad = ((law.radius_m + law.slack_m) + law.surface_mps * most_s) * per_m + 2.0 * RIM;
        let bulge = law.gravity_mps2.abs() * (0.125 * step * step * per_m);
        let half_way = 0.5 * (moved(it.at_m, it.velocity_mps, law.gravity_mps2, dt_s) - it.at_m);
        let place = ((it.at_m + half_way) - Vec3::from(grid.low_m)) * per_m;
        let reach = half_way.abs() * per_m + (pad + bulge);
        let cells = UVec3::from(grid.cells).as_ivec3();
        let corner = place.round().as_ivec3().clamp(IVec3::ZERO, cells - 1);
        let from_corner = place - corner.as_vec3();
        let farthest = (from_corner.abs() + reach).max_element();
        let i = grid.index(corner).expect("in the grid");
        let gap = gap_of_slab(self.scene.near, grid.count(), i);
        if gap > 1 && gap as f32 > farthest + BEYOND {
            return true;
        }
        if farthest + if gap == 0 { BEYOND } else { 0.0 } < 1.0 {
            let (n, [low, high]) = slab(self.scene.near, grid.count(), i);
            let middle = n.dot(from_corner);
            let along = n.dot(half_way).abs() * per_m + n.abs().dot(bulge) + pad * n.length();
            return middle - along > high || middle + along < low;
        }
        let reach = reach + BEYOND;
        (place + reach).cmplt(Vec3::ZERO).any() || (place - reach).cmpgt(cells.as_vec3()).any()
    }

    fn plane(&self, cell: usize, slot: usize) -> Plane {
        self.scene.planes[2 * cell + slot]
    }

    fn elapsed_at(&self, left: f32) -> f32 {
        (self.step_s - left) - self.law.lead_s
    }

    fn padding_m(&self, left: f32, elapsed: f32) -> f32 {
        let (law, most) = (self.law, elapsed.abs().max((elapsed + left).abs()));
        ((law.radius_m + law.slack_m) + BEYOND * law.grid.cell_m) + law.surface_mps * most
    }

    fn box_of(&self, from: Vec3, to: Vec3, pad: Vec3) -> Cells {
        let grid = &self.law.grid;
        let (counts, most) = (UVec3::from(grid.cells).as_ivec3(), UVec3::from(grid.cells).as_vec3());
        let [from, to] = [grid.place(from.min(to) - pad), grid.place(from.max(to) + pad)];
        let spare = BEYOND - 2.0 * RIM;
        let (low, high) = (from.clamp(Vec3::ZERO, most), to.clamp(Vec3::NEG_ONE, most));
        let middle = 0.5 * (low + high) + 0.5;
        Cells {
            first: low.floor().as_ivec3(),
            last: high.floor().as_ivec3().min(counts - 1),
            corner: middle.floor().as_ivec3().clamp(IVec3::ZERO, counts - 1),
            low: from + spare,
            high: to - spare,
        }
    }

    fn room_of(&self, it: &Cells) -> i32 {
        if it.first.cmpgt(it.last).any() {
            return 0;
        }
        let corner = self.law.grid.index(it.corner).expect("in the grid");
        gap(self.scene.near, corner) - (it.corner - it.first).max(it.last + 1 - it.corner).max_element()
    }

    fn flies_freely(&self, from: Vec3, to: Vec3, pull: Vec3, dt: f32) -> bool {
        let pad = Vec3::splat(self.padding_m(dt, self.elapsed_at(dt))) + pull.abs() * (0.125 * dt * dt);
        self.room_of(&self.box_of(from, to, pad)) >= 0
    }

    fn is_there(&self, foot: Vec3, window: &Window) -> bool {
        window.extent.has(foot, self.law.grid.cell_m)
    }

    fn meet(
        &self,
        leg: &Leg,
        (number, plane): (usize, &Plane),
        centre: Vec3,
        window: &Window,
        hit: &mut Hit,
        deep: Option<&mut Vec3>,
    ) {
        let (normal, u) = (Vec3::from(plane.normal), Vec3::from(plane.velocity_mps));
        let from_centre = leg.at_m - (centre + u * leg.elapsed_s);
        let along = dotted(normal, from_centre) + plane.distance_m;
        let n = if along < 0.0 { -normal } else { normal };
        let (d, radius, slack) = (along.abs(), self.law.radius_m, self.law.slack_m);
        let seen = leg.velocity_mps - u;
        let (w, a) = (dotted(n, seen), dotted(n, leg.pull_mps2));
        let from_window = leg.at_m - (window.centre_m + u * leg.elapsed_s);
        let shallow = radius - slack;
        if let Some(deep) = deep {
            let more = (radius - d) - dotted(*deep, n);
            if d < shallow && more > 0.0 && self.is_there(from_window - n * d, window) {
                *deep += n * more;
            }
        }
        let mut until = leg.left_s;
        if a > 0.0 && w < 0.0 {
            until = until.min(-w / a);
        }
        let after = |t: f32| d + (w * t + a * (0.5 * t * t));
        if after(until) >= if d < shallow { d - 0.1 * slack } else { shallow } {
            return;
        }
        for level in 0..3 {
            let mut time = fall_s(d - radius * (1.0 - 0.5 * level as f32), w, a);
            if time >= hit.after_s || time.is_nan() {
                return;
            }
            let mut then = after(time);
            let foot = (from_window + (seen * time + leg.pull_mps2 * (0.5 * time * time))) - n * then;
            if !self.is_there(foot, window) {
                continue;
            }
            if level == 2 {
                time = time.min(fall_s(d - slack.min(d), w, a));
                then = after(time);
            }
            *hit = Hit { after_s: time, distance_m: then, met: Some(Met { number, is_back: along < 0.0 }) };
            return;
        }
    }

    fn meet_cell(&self, leg: &Leg, cell: IVec3, cells: &Cells, hit: &mut Hit, mut deep: Option<&mut Vec3>) {
        let grid = &self.law.grid;
        let i = grid.index(cell).expect("in the grid");
        let met = match self.method {
            Method::TwoPlanes => met_at(self.scene.near, grid.count(), i),
            _ => 1,
        };
        // Twin of `met_in_box`.
        let centre = cell.as_vec3() + 0.5;
        let felt = Extent::of((cells.low - centre).as_dvec3(), (cells.high - centre).as_dvec3());
        for k in (0..14).filter(|k| met >> k & 1 != 0) {
            let stored = cell_of_met(cell, k);
            let number = 2 * grid.index(stored).expect("in the grid") + (k & 1);
            let plane = (number, &self.scene.planes[number]);
            let extent = match self.method {
                Method::TwoPlanes => extent_of(self.scene.near, grid.count(), i, k),
                _ => Extent((0..3).fold(0, |all, k| all | extent_of(self.scene.near, grid.count(), i, k).0)),
            };
            if Extent(extent.0 & felt.0).bounds().is_none() {
                continue;
            }
            let window = Window { centre_m: grid.centre_m(cell), extent };
            self.meet(leg, plane, grid.centre_m(stored), &window, hit, deep.as_deref_mut());
        }
    }

    fn first_hit(&self, leg: &Leg, mut deep: Option<&mut Vec3>) -> Hit {
        let (grid, left) = (&self.law.grid, leg.left_s);
        let mut hit = Hit { after_s: left, distance_m: 0.0, met: None };
        let fastest = leg.velocity_mps.abs() + leg.pull_mps2.abs() * left;
        let cells = fastest.max_element() * left / grid.cell_m;
        if cells >= NEVER_S || cells.is_nan() {
            return hit;
        }
        let pieces = cells.ceil().clamp(1.0, MOST_PIECES);
        let piece_s = left / pieces;
        let pad = Vec3::splat(self.padding_m(left, leg.elapsed_s))
            + leg.pull_mps2.abs() * (0.125 * piece_s * piece_s);
        let at = |after| moved(leg.at_m, leg.velocity_mps, leg.pull_mps2, after);
        let mut piece = 0.0;
        while piece < pieces && hit.after_s > piece_s * piece {
            let cells = self.box_of(at(piece_s * piece), at(piece_s * (piece + 1.0)), pad);
            let (Cells { first, last, .. }, room) = (cells, self.room_of(&cells));
            if room < 0 {
                let mut deep = deep.as_deref_mut().filter(|_| piece == 0.0);
                for cell in in_blocks(first, last) {
                    if grid.index(cell).is_some_and(|i| bit(self.scene.occupied, i)) {
                        self.meet_cell(leg, cell, &cells, &mut hit, deep.as_deref_mut());
                    }
                }
            }
            piece += 1.0 + room.max(0) as f32;
        }
        hit
    }

    fn surface(&self, met: Met) -> (Vec3, Vec3) {
        let plane = &self.scene.planes[met.number];
        let normal = Vec3::from(plane.normal);
        (if met.is_back { -normal } else { normal }, plane.velocity_mps.into())
    }

    fn hold(&self, held: &mut Vec<(Vec3, Vec3)>, (n, u): (Vec3, Vec3)) {
        let is_same = |&(m, w): &(Vec3, Vec3)| dotted(m, n) > SAME && dotted(w - u, w - u) <= SAME_SQ_M2PS2;
        if held.len() < 3 && !held.iter().any(is_same) {
            held.push((n, u));
        }
    }

    fn kept_of(&self, slide: f32, press: f32) -> f32 {
        let most = self.law.friction * press;
        if slide > most {
            (slide - most) / slide
        } else {
            0.0
        }
    }

    fn held_pull(&self, held: &[(Vec3, Vec3)], velocity: Vec3, left: f32) -> Vec3 {
        let gravity = self.law.gravity_mps2;
        let mut end = velocity + gravity * left;
        for _ in 0..if held.len() > 1 { 4 } else { 1 } {
            for &(n, u) in held {
                let (leaving, pressing) = (dotted(velocity - u, n), dotted(end - u, n));
                if pressing >= 0.0 || leaving > 0.01 * dotted(gravity, n).abs() * left {
                    continue;
                }
                let slide = end - u - n * pressing;
                end = u + slide * self.kept_of(dotted(slide, slide).sqrt(), -pressing);
            }
        }
        (end - velocity) / left
    }

    /// Twin of `collide`.
    fn collide(&self, it: &mut Particle, dt: f32, slot: u32, impacts: &mut Vec<Impact>) {
        let law = self.law;
        let gravity = law.gravity_mps2;
        let (mut at, mut velocity, mut pull, mut push) = (it.at_m, it.velocity_mps, gravity, Vec3::ZERO);
        let mut left = dt;
        if !self.flies_freely(at, moved(at, velocity, gravity, dt), gravity, dt) {
            let mut count = 0;
            let mut held: Vec<(Vec3, Vec3)> = Vec::with_capacity(3);
            let mut stops = false;
            for number in 0..MOST_LEGS {
                let mut deep = Vec3::ZERO;
                let elapsed_s = self.elapsed_at(left);
                let moving = velocity + push;
                let leg = Leg { at_m: at, velocity_mps: moving, pull_mps2: pull, elapsed_s, left_s: left };
                let hit = self.first_hit(&leg, (number == 0).then_some(&mut deep));
                if number == 0 && deep != Vec3::ZERO {
                    let (most, deepest) = (0.5 * law.radius_m, dotted(deep, deep).sqrt());
                    push = deep * ((most / deepest).min(1.0) / left);
                    continue;
                }
                let Some(met) = hit.met else { break };
                stops = number == MOST_LEGS - 1;
                let (n, u) = self.surface(met);
                let from = at;
                at = moved(at, moving, pull, hit.after_s);
                let rise = dotted(at - from, n) - dotted(u, n) * hit.after_s;
                velocity = (velocity + pull * hit.after_s)
                    + n * rounding(dotted(moving - u, n), dotted(pull, n), hit.after_s, rise);
                left = (left - hit.after_s).max(0.0);
                let pushing = dotted(push, n);
                if pushing < 0.0 {
                    push -= n * pushing;
                }
                let seen = velocity - u;
                let approach = dotted(seen, n);
                let mut is_slow = true;
                if approach < 0.0 {
                    let step = dotted(gravity, n).abs() * dt;
                    let rebound = -approach * law.restitution;
                    is_slow = rebound <= step * if law.restitution < 1.0 { 1.0 } else { 1.0e-3 };
                    let rests = is_slow && -approach <= 0.5 * step;
                    if !rests && count == MOST_IMPACTS {
                        stops = true;
                        break;
                    }
                    let press = -approach * if is_slow { 1.0 } else { 1.0 + law.restitution };
                    let slide = seen - n * approach;
                    let kept = self.kept_of(dotted(slide, slide).sqrt(), press);
                    velocity = u + slide * kept + n * (approach + press);
                    if !rests {
                        impacts.push(Impact {
                            at_m: at - n * hit.distance_m,
                            order: slot.wrapping_mul(8) + count,
                            normal: n,
                            impulse_mps: press,
                            velocity_mps: seen,
                            triangle: self.scene.planes[met.number].triangle,
                            mesh: NO_MESH,
                            source: self.source(slot),
                            ..Impact::default()
                        });
                        count += 1;
                    }
                }
                if is_slow {
                    self.hold(&mut held, (n, u));
                }
                if left == 0.0 {
                    stops = true;
                    break;
                }
                pull = if held.is_empty() { gravity } else { self.held_pull(&held, velocity, left) };
            }
            if stops {
                (it.at_m, it.velocity_mps) = (at, velocity);
                return;
            }
        }
        it.at_m = moved(at, velocity + push, pull, left);
        it.velocity_mps = velocity + pull * left;
    }

    fn source(&self, slot: u32) -> u32 {
        self.law.source + if self.law.sources > 1 { slot % self.law.sources } else { 0 }
    }

    /// Twin of `step_as_seed`.
    fn step_as_seed(&self, it: &mut Particle, dt: f32, slot: u32, impacts: &mut Vec<Impact>) {
        let mut parts = 1;
        if self.method == Method::Substeps {
            let velocity = it.velocity_mps;
            let cells = dotted(velocity, velocity).sqrt() * dt / self.law.grid.cell_m;
            parts = cells.ceil().clamp(1.0, 64.0) as u32;
        }
        let part_s = dt / parts as f32;
        for part in 0..parts {
            self.step_once_as_seed(it, part_s, slot, part.min(7), impacts);
        }
    }

    fn step_once_as_seed(&self, it: &mut Particle, dt: f32, slot: u32, part: u32, impacts: &mut Vec<Impact>) {
        let law = self.law;
        let cell = law.grid.cell_of(it.at_m);
        if let Some(i) = law.grid.index(cell).filter(|i| bit(self.scene.occupied, *i)) {
            let plane = self.plane(i, 0);
            let (n, u) = (Vec3::from(plane.normal), Vec3::from(plane.velocity_mps));
            let d = dotted(n, it.at_m - law.grid.centre_m(cell)) + plane.distance_m;
            let seen = it.velocity_mps - u;
            let speed = dotted(u, u).sqrt();
            if d < law.radius_m && (self.method == Method::Seed || dotted(seen, n) < 0.0) {
                let towards = if speed > 0.0 { (dotted(u, n) / speed).max(0.0) } else { 0.0 };
                let mirrored = it.velocity_mps - n * (2.0 * dotted(it.velocity_mps, n));
                let mixed = mirrored * (law.restitution * (1.0 - towards)) + u * towards;
                impacts.push(Impact {
                    at_m: it.at_m - n * d,
                    order: slot.wrapping_mul(8) + part,
                    normal: n,
                    impulse_mps: dotted(mixed - it.velocity_mps, n),
                    velocity_mps: seen,
                    triangle: plane.triangle,
                    mesh: NO_MESH,
                    source: self.source(slot),
                    ..Impact::default()
                });
                it.at_m += n * (law.radius_m - d);
                it.velocity_mps = mixed;
            }
        }
        it.at_m += it.velocity_mps * dt;
        it.velocity_mps += law.gravity_mps2 * dt;
    }
}
