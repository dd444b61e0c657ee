// SPDX-License-Identifier: MIT OR Apache-2.0
//! f64 twin of the kernels, pass by pass and in the same order: what `glsl/disks` says, to be read beside it.

mod colored;

use super::model::{Borders, Disk, Grid, Model, Response, Space, Stir};
use glam::{DVec3, IVec3};

/// No contact: `NONE` in `glsl/disks/disks.glsl`.
pub const NONE: u32 = u32::MAX;
/// Several contacts.
pub const MANY: u32 = u32::MAX - 1;
/// To be looked at in the next round.
pub const AWAKE: u32 = u32::MAX - 2;

/// Twin of a box of disks.
#[derive(Clone)]
pub struct Disks {
    model: Model,
    grid: Grid,
    disks: Vec<Disk>,
    id: Vec<u32>,
    partner: Vec<u32>,
    start: Vec<usize>,
    stirred_mps: f64,
    step: u32,
    /// By id: the step of the last hit, 0 for none.
    pub hit: Vec<u32>,
    /// By id: impulse times distance of the centres, of its pairs.
    pub virial: Vec<f64>,
    /// By id: impulse from walls.
    pub wall: Vec<f64>,
    /// Collisions of pairs so far.
    pub collisions: u64,
}

/// What two disks that overlap at the end of a step did in it.
struct Contact {
    /// How long before the end they met (s).
    ago_s: f64,
    /// From the first to the second, unit.
    normal: DVec3,
}

impl Disks {
    /// A box at its start.
    pub fn new(model: Model, disks: &[Disk]) -> Self {
        let grid = Grid::of(&model, disks.iter().map(|disk| disk.radius_m));
        let count = disks.len();
        let mut order: Vec<u32> = (0..count as u32).collect();
        order.sort_by_key(|&i| disks[i as usize].radius_m <= grid.small_m); // large ones first
        Self {
            stirred_mps: model.stirred_mps(disks),
            model,
            grid,
            disks: order.iter().map(|&i| disks[i as usize]).collect(),
            id: order,
            partner: vec![NONE; count],
            start: vec![grid.large as usize; grid.count() + 1], // the first step sorts
            step: 0,
            hit: vec![0; count],
            virial: vec![0.0; count],
            wall: vec![0.0; count],
            collisions: 0,
        }
    }

    /// The disks, in the order in which they were given.
    pub fn disks(&self) -> Vec<Disk> {
        let mut by_id = self.disks.clone();
        self.id.iter().zip(&self.disks).for_each(|(&id, disk)| by_id[id as usize] = *disk);
        by_id
    }

    /// One step.
    pub fn step(&mut self) {
        self.step_stirred(None);
    }

    /// One step in which a point pushes.
    pub fn step_stirred(&mut self, stir: Option<&Stir>) {
        self.step += 1;
        self.travel(stir);
        self.sort();
        match self.model.response {
            Response::Seed => self.contacts(),
            Response::GaussSeidel => self.in_colors(Self::settle),
            Response::Xpbd { bounces } => self.xpbd(bounces),
            Response::Matching { rounds, .. } => {
                for round in 0..rounds {
                    self.propose(round == 0);
                    self.collide();
                }
            }
        }
    }

    fn large(&self) -> usize {
        self.grid.large as usize
    }

    /// Twin of `cell_of`.
    fn cell(&self, at: DVec3) -> IVec3 {
        let cells = self.grid.cells.as_dvec3();
        let c = (at * (cells / self.model.size_m)).floor().clamp(DVec3::ZERO, cells - 1.0).as_ivec3();
        if self.model.space == Space::Flat {
            c.with_z(0)
        } else {
            c
        }
    }

    fn index(&self, c: IVec3) -> usize {
        let cells = self.grid.cells.as_ivec3();
        ((c.z * cells.y + c.y) * cells.x + c.x) as usize
    }

    /// Stable counting sort of all but the large ones: `disks.slot`, `disks.gather`.
    fn sort(&mut self) {
        let large = self.large();
        let cell: Vec<usize> = self.disks.iter().map(|disk| self.index(self.cell(disk.at_m))).collect();
        let mut order: Vec<usize> = (0..self.disks.len()).collect();
        order[large..].sort_by_key(|&i| cell[i]);
        self.start = vec![0; self.grid.count() + 1];
        cell[large..].iter().for_each(|&c| self.start[c + 1] += 1);
        self.start[0] = large;
        for c in 1..self.start.len() {
            self.start[c] += self.start[c - 1];
        }
        self.disks = order.iter().map(|&i| self.disks[i]).collect();
        self.id = order.iter().map(|&i| self.id[i]).collect();
        self.partner.fill(NONE);
    }

    /// Twin of `glsl/disks/neighbours.glsl`: calls `meet` with every disk that may touch disk `i`.
    fn visit(&self, i: usize, meet: impl FnMut(usize)) {
        self.visit_from(i, self.disks[i].at_m, meet);
    }

    /// [`Disks::visit`], with disk `i` at `at`.
    fn visit_from(&self, i: usize, at: DVec3, mut meet: impl FnMut(usize)) {
        (0..self.large()).filter(|&k| k != i).for_each(&mut meet);
        self.visit_cells(i, self.cell(at), meet);
    }

    fn visit_cells(&self, i: usize, c: IVec3, mut meet: impl FnMut(usize)) {
        let cells = self.grid.cells.as_ivec3();
        let edge = self.model.size_m / self.grid.cells.as_dvec3();
        let reach = if i < self.large() {
            ((self.disks[i].radius_m + self.grid.small_m) / edge).ceil().as_ivec3()
        } else {
            IVec3::ONE
        };
        let along = |axis: usize| -> Vec<i32> {
            let (c, k, n) = (c[axis], reach[axis], cells[axis]);
            match self.model.borders {
                _ if axis == 2 && self.model.space == Space::Flat => vec![0],
                Borders::Walls => ((c - k).max(0)..=(c + k).min(n - 1)).collect(),
                Borders::Periodic if 2 * k + 1 >= n => (0..n).collect(),
                Borders::Periodic => (c - k..=c + k).map(|c| c.rem_euclid(n)).collect(),
            }
        };
        let (xs, ys, zs) = (along(0), along(1), along(2));
        for &z in &zs {
            for &y in &ys {
                for &x in &xs {
                    let c = self.index(IVec3::new(x, y, z));
                    (self.start[c]..self.start[c + 1]).filter(|&k| k != i).for_each(&mut meet);
                }
            }
        }
    }

    /// Unit vector from disk `i` to disk `k`, and how far they are apart; where they coincide, an axis of their ids.
    fn way(&self, i: usize, k: usize) -> (DVec3, f64) {
        self.axis(i, k, self.model.way(self.disks[i].at_m, self.disks[k].at_m))
    }

    /// The same of `d`, the way from one to the other.
    fn axis(&self, i: usize, k: usize, d: DVec3) -> (DVec3, f64) {
        let far = d.length();
        if far > 1e-6 * (self.disks[i].radius_m + self.disks[k].radius_m) {
            return (d / far, far);
        }
        let (a, b) = (self.id[i].min(self.id[k]), self.id[i].max(self.id[k]));
        let units = crate::random::units(crate::random::bits(a, b, 0, 0));
        let axis = match self.model.space {
            Space::Flat => crate::random::cos_sin_of_turn(units[0]).extend(0.0),
            Space::Solid => crate::random::direction_of([units[0], units[1]]),
        };
        (if self.id[i] == a { axis.as_dvec3() } else { -axis.as_dvec3() }, 0.0)
    }

    fn mass(&self, i: usize) -> f64 {
        self.model.space.mass(self.disks[i].radius_m)
    }

    /// Twin of `glsl/disks/travel.glsl`: what is left to do of the last step, then a step forward.
    fn travel(&mut self, stir: Option<&Stir>) {
        let mut next = self.disks.clone();
        for (i, next) in next.iter_mut().enumerate() {
            match self.model.response {
                Response::Seed => self.answer(i, next),
                Response::GaussSeidel | Response::Xpbd { .. } => {}
                Response::Matching { .. } => self.part(i, next),
            }
            let dt = self.model.dt_s;
            if let Some(stir) = stir {
                let middle = if self.model.space == Space::Flat { stir.at_m.with_z(0.0) } else { stir.at_m };
                let from = self.model.way(middle, next.at_m);
                let far = from.length();
                if far < stir.radius_m && far > 0.0 {
                    let most = self.stirred_mps.max(next.velocity_mps.length());
                    next.velocity_mps += from * (stir.push_mps2 * dt * (1.0 / far - 1.0 / stir.radius_m));
                    next.velocity_mps *= (most / next.velocity_mps.length()).min(1.0);
                }
            }
            next.at_m += next.velocity_mps * dt + self.model.gravity_mps2 * (0.5 * dt * dt);
            next.velocity_mps += self.model.gravity_mps2 * dt;
            let id = self.id[i] as usize;
            self.wall[id] += self.model.space.mass(next.radius_m) * meet_borders(&self.model, next);
        }
        self.disks = next;
    }

    /// The tutorial's: push out of every overlap by 0.51 of it, and exchange speeds if the contact is the only one of both.
    fn answer(&mut self, i: usize, next: &mut Disk) {
        if self.partner[i] == NONE {
            return;
        }
        let me = self.disks[i];
        let mut push = DVec3::ZERO;
        self.visit(i, |k| {
            let d = self.model.way(me.at_m, self.disks[k].at_m);
            let (far, reach) = (d.length(), me.radius_m + self.disks[k].radius_m);
            if far < reach {
                push -= d / far * (0.51 * (reach - far));
            }
        });
        next.at_m += push;
        let k = self.partner[i] as usize;
        if self.partner[i] == MANY {
            next.velocity_mps = -me.velocity_mps;
        } else if self.partner[k] as usize == i {
            let n = self.model.way(me.at_m, self.disks[k].at_m).normalize();
            let (m, other) = (self.mass(i), self.mass(k));
            let closing = n.dot(self.disks[k].velocity_mps - me.velocity_mps);
            next.velocity_mps += n * (2.0 * other / (m + other) * closing);
        }
    }

    /// Parts disks that still overlap, the lighter one more, by a radius at most. More than 6 (12) cannot touch one of
    /// their size: who has more flees by a radius.
    fn part(&self, i: usize, next: &mut Disk) {
        if self.partner[i] == NONE {
            return;
        }
        let (mut push, mut contacts) = (DVec3::ZERO, 0);
        self.visit(i, |k| {
            let (n, far) = self.way(i, k);
            let reach = self.disks[i].radius_m + self.disks[k].radius_m;
            if far < reach {
                let (m, other) = (self.mass(i), self.mass(k));
                push -= n * (RELAX * other / (m + other) * (reach - far));
                contacts += 1;
            }
        });
        let far = push.length();
        let crowd = if self.model.space == Space::Flat { 6 } else { 12 };
        if far > next.radius_m || (contacts > crowd && i >= self.large() && far > 0.0) {
            push *= next.radius_m / far;
        }
        next.at_m += push;
    }

    /// Twin of `glsl/disks/contacts.glsl`.
    fn contacts(&mut self) {
        for i in 0..self.disks.len() {
            let mut partner = NONE;
            self.visit(i, |k| {
                let far = self.model.way(self.disks[i].at_m, self.disks[k].at_m).length();
                if far < self.disks[i].radius_m + self.disks[k].radius_m {
                    partner = if partner == NONE { k as u32 } else { MANY };
                }
            });
            self.partner[i] = partner;
            if partner != NONE {
                self.hit[self.id[i] as usize] = self.step;
            }
        }
    }

    /// Twin of `contact` in `glsl/disks/contact.glsl`: whether disks that overlap have to collide, and where they met.
    fn contact(&self, i: usize, k: usize, rewinds: bool) -> Option<Contact> {
        let d = self.model.way(self.disks[i].at_m, self.disks[k].at_m);
        let reach = self.disks[i].radius_m + self.disks[k].radius_m;
        let c = d.length_squared() - reach * reach;
        if c >= 0.0 {
            return None;
        }
        let u = self.disks[k].velocity_mps - self.disks[i].velocity_mps;
        let (a, b) = (u.length_squared(), d.dot(u));
        if rewinds {
            let s = (b * b - a * c).sqrt();
            // The time since they met: the root of |d - u t| = reach that does not cancel.
            let ago_s = if b > 0.0 { (b + s) / a } else { -c / (s - b) };
            if ago_s <= self.model.dt_s {
                return Some(Contact { ago_s, normal: (d - u * ago_s) / reach });
            }
        }
        // They overlapped before this step: now, if they come nearer still.
        let (normal, _) = self.way(i, k);
        (normal.dot(u) < 0.0).then_some(Contact { ago_s: 0.0, normal })
    }

    fn rewinds(&self) -> bool {
        matches!(self.model.response, Response::Matching { rewinds: true, .. })
    }

    /// Twin of `glsl/disks/propose.glsl`: the earliest contact; of several at once, the one of the lowest id.
    fn propose(&mut self, is_first: bool) {
        let mut offers = self.partner.clone();
        for (i, offer) in offers.iter_mut().enumerate() {
            if !is_first && self.partner[i] == NONE {
                continue;
            }
            let (mut best, mut earliest, mut lowest) = (NONE, -1.0, NONE);
            self.visit(i, |k| {
                if let Some(contact) = self.contact(i, k, self.rewinds()) {
                    if contact.ago_s > earliest || (contact.ago_s == earliest && self.id[k] < lowest) {
                        (best, earliest, lowest) = (k as u32, contact.ago_s, self.id[k]);
                    }
                }
            });
            *offer = best;
            if best == NONE && self.overlaps(i) {
                *offer = AWAKE; // nothing to collide with, but to be parted
            }
        }
        self.partner = offers;
    }

    fn overlaps(&self, i: usize) -> bool {
        let mut any = false;
        self.visit(i, |k| any |= self.way(i, k).1 < self.disks[i].radius_m + self.disks[k].radius_m);
        any
    }

    /// Twin of `glsl/disks/collide.glsl`: pairs that agree collide, and wake whom they now overlap.
    fn collide(&mut self) {
        let pairs: Vec<(usize, usize)> = (0..self.disks.len())
            .map(|i| (i, self.partner[i] as usize))
            .filter(|&(i, k)| self.partner[i] < AWAKE && i < k && self.partner[k] as usize == i)
            .collect();
        for &(i, k) in &pairs {
            let contact = self.contact(i, k, self.rewinds()).expect("both saw it");
            self.strike(i, k, &contact);
        }
        for (i, k) in pairs {
            for disk in [i, k] {
                let mut met = Vec::new();
                self.visit(disk, |other| {
                    let reach = self.disks[disk].radius_m + self.disks[other].radius_m;
                    if self.partner[other] == NONE && self.way(disk, other).1 < reach {
                        met.push(other);
                    }
                });
                met.into_iter().for_each(|other| self.partner[other] = AWAKE);
            }
        }
    }

    /// Twin of `strike` in `glsl/disks/contact.glsl`: rewind, exact impulse of two elastic bodies, replay.
    fn strike(&mut self, i: usize, k: usize, contact: &Contact) {
        let (m, other) = (self.mass(i), self.mass(k));
        let n = contact.normal;
        let closing = n.dot(self.disks[k].velocity_mps - self.disks[i].velocity_mps);
        let impulse = 2.0 * closing * (m * other / (m + other));
        let (mine, its) = (n * (impulse / m), n * (-impulse / other));
        self.disks[i].velocity_mps += mine;
        self.disks[i].at_m += mine * contact.ago_s;
        self.disks[k].velocity_mps += its;
        self.disks[k].at_m += its * contact.ago_s;
        let reach = self.disks[i].radius_m + self.disks[k].radius_m;
        self.virial[self.id[i] as usize] += impulse.abs() * reach;
        self.collisions += 1;
        for disk in [i, k] {
            self.hit[self.id[disk] as usize] = self.step;
        }
    }
}

/// Part of an overlap that a step takes away. All pairs at once push too far, from 2/3 on in a dense layer, from 1/2 on in
/// dense spheres (the Laplacian of their contacts has eigenvalues up to 3 and 4).
const RELAX: f64 = 0.5;

/// Twin of `between_walls` in `glsl/disks/walls.glsl`, or goes round; returns the change of speed at walls (m/s).
fn meet_borders(model: &Model, disk: &mut Disk) -> f64 {
    let mut change = 0.0;
    for axis in 0..model.space.dimensions() as usize {
        let size = model.size_m[axis];
        let (at, velocity) = (&mut disk.at_m[axis], &mut disk.velocity_mps[axis]);
        if model.borders == Borders::Periodic {
            *at -= size * (*at / size).floor();
            continue;
        }
        let (low, high) = (disk.radius_m, size - disk.radius_m);
        if *at < low {
            let bounced = bounce(*at - low, *velocity, model.gravity_mps2[axis]);
            *at = (low + bounced.inside_m).min(high);
            *velocity = bounced.speed_mps;
            change += bounced.change_mps;
        } else if *at > high {
            let bounced = bounce(high - *at, -*velocity, -model.gravity_mps2[axis]);
            *at = (high - bounced.inside_m).max(low);
            *velocity = -bounced.speed_mps;
            change += bounced.change_mps;
        }
    }
    change
}

/// What a wall did.
struct Bounced {
    /// How far from it (m).
    inside_m: f64,
    /// Inwards (m/s).
    speed_mps: f64,
    /// Of speed, at the wall (m/s).
    change_mps: f64,
}

/// Twin of `bounce` in `glsl/disks/walls.glsl`.
fn bounce(y: f64, v: f64, pull: f64) -> Bounced {
    if pull == 0.0 {
        return Bounced { inside_m: -y, speed_mps: v.abs(), change_mps: 2.0 * (-v).max(0.0) };
    }
    let speed = (v * v - 2.0 * pull * y).max(0.0).sqrt();
    let (mut since_s, mut change) = (0.0, (speed - v).max(0.0));
    if v < 0.0 && speed > 0.0 {
        since_s = -2.0 * y / (speed - v);
        change = 2.0 * speed;
        if pull < 0.0 {
            let turn_s = -2.0 * speed / pull;
            let turns = (since_s / turn_s).floor();
            since_s = (since_s - turns * turn_s).clamp(0.0, turn_s);
            change += turns * change;
        }
    }
    Bounced {
        inside_m: ((speed + 0.5 * pull * since_s) * since_s).max(0.0),
        speed_mps: speed + pull * since_s,
        change_mps: change,
    }
}
