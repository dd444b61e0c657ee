// SPDX-License-Identifier: MIT OR Apache-2.0
//! Event-driven molecular dynamics: the exact motion of a few hundred hard disks, from collision to collision (Alder and
//! Wainwright, "Studies in Molecular Dynamics. I", 1959). Without gravity; nothing may overlap at the start.

use super::model::{Borders, Disk, Model};

/// What happens to a disk next: another disk, a wall across an axis, or that it looks ahead again.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Event {
    Pair(usize),
    Wall(usize),
    Nothing,
}

/// A box of disks that is exact.
pub struct Exact {
    model: Model,
    /// As they are now.
    pub disks: Vec<Disk>,
    next: Vec<(f64, Event)>,
    now_s: f64,
    /// Sum of impulse times distance of the centres.
    pub virial: f64,
    /// Sum of the impulses of walls.
    pub wall: f64,
    /// Of pairs.
    pub collisions: u64,
}

impl Exact {
    /// A box at its start.
    pub fn new(model: Model, disks: &[Disk]) -> Self {
        let next = vec![(0.0, Event::Nothing); disks.len()];
        let mut made =
            Self { model, disks: disks.to_vec(), next, now_s: 0.0, virial: 0.0, wall: 0.0, collisions: 0 };
        (0..disks.len()).for_each(|i| made.predict(i));
        made
    }

    /// Forgets what was measured.
    pub fn reset(&mut self) {
        (self.virial, self.wall, self.collisions) = (0.0, 0.0, 0);
    }

    /// Lets `time_s` pass.
    pub fn run(&mut self, time_s: f64) {
        let end = self.now_s + time_s;
        loop {
            let (i, &(when, event)) = self
                .next
                .iter()
                .enumerate()
                .min_by(|a, b| a.1 .0.total_cmp(&b.1 .0))
                .expect("at least one disk");
            if when > end {
                self.drift(end);
                return;
            }
            self.drift(when);
            match event {
                Event::Pair(k) => self.collide(i, k),
                Event::Wall(axis) => self.bounce(i, axis),
                Event::Nothing => self.predict(i),
            }
        }
    }

    fn drift(&mut self, to_s: f64) {
        let dt = to_s - self.now_s;
        for disk in &mut self.disks {
            disk.at_m += disk.velocity_mps * dt;
            if self.model.borders == Borders::Periodic {
                for axis in 0..self.model.space.dimensions() as usize {
                    let size = self.model.size_m[axis];
                    disk.at_m[axis] -= size * (disk.at_m[axis] / size).floor();
                }
            }
        }
        self.now_s = to_s;
    }

    /// Finds the next event of disk `i`. Its partner may know of an earlier one: the first of all is taken.
    fn predict(&mut self, i: usize) {
        let me = self.disks[i];
        // Looked at again before a relative way of a quarter of the box: beyond it another image may be nearer.
        let mut best = (f64::INFINITY, Event::Nothing);
        let narrowest = self.model.size_m.to_array()[..self.model.space.dimensions() as usize]
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        if self.model.borders == Borders::Periodic {
            let fastest = self.disks.iter().map(|disk| disk.velocity_mps.length()).fold(0.0, f64::max);
            best.0 = self.now_s + 0.1 * narrowest / fastest.max(1e-300);
        } else {
            for axis in 0..self.model.space.dimensions() as usize {
                let (x, v) = (me.at_m[axis], me.velocity_mps[axis]);
                let room = if v > 0.0 { self.model.size_m[axis] - me.radius_m - x } else { me.radius_m - x };
                if v != 0.0 && self.now_s + (room / v).max(0.0) < best.0 {
                    best = (self.now_s + (room / v).max(0.0), Event::Wall(axis));
                }
            }
        }
        for (k, other) in self.disks.iter().enumerate().filter(|&(k, _)| k != i) {
            let d = self.model.way(me.at_m, other.at_m);
            let u = other.velocity_mps - me.velocity_mps;
            let (b, reach) = (d.dot(u), me.radius_m + other.radius_m);
            if b >= 0.0 {
                continue;
            }
            let (a, c) = (u.length_squared(), d.length_squared() - reach * reach);
            let disc = b * b - a * c;
            if disc < 0.0 {
                continue;
            }
            let when = self.now_s + (c / (disc.sqrt() - b)).max(0.0);
            if when < best.0 {
                best = (when, Event::Pair(k));
            }
        }
        self.next[i] = best;
    }

    fn collide(&mut self, i: usize, k: usize) {
        let (a, b) = (self.disks[i], self.disks[k]);
        let n = self.model.way(a.at_m, b.at_m).normalize();
        let (m, other) = (self.model.space.mass(a.radius_m), self.model.space.mass(b.radius_m));
        let impulse = 2.0 * n.dot(b.velocity_mps - a.velocity_mps) * (m * other / (m + other));
        self.disks[i].velocity_mps += n * (impulse / m);
        self.disks[k].velocity_mps -= n * (impulse / other);
        self.virial += impulse.abs() * (a.radius_m + b.radius_m);
        self.collisions += 1;
        self.after(&[i, k]);
    }

    fn bounce(&mut self, i: usize, axis: usize) {
        let disk = &mut self.disks[i];
        self.wall += 2.0 * self.model.space.mass(disk.radius_m) * disk.velocity_mps[axis].abs();
        disk.velocity_mps[axis] = -disk.velocity_mps[axis];
        self.after(&[i]);
    }

    /// Looks ahead for those that changed, and for those that were to meet them.
    fn after(&mut self, changed: &[usize]) {
        for k in 0..self.disks.len() {
            let was_to_meet = matches!(self.next[k].1, Event::Pair(other) if changed.contains(&other));
            if was_to_meet || changed.contains(&k) {
                self.predict(k);
            }
        }
    }
}
