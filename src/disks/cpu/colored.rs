// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twins of the passes that go through the colours of cells: `glsl/disks/{colors,sweep,xpbd_*}.glsl`.

use super::{Contact, Disks, Space};
use glam::{DVec3, IVec3};

impl Disks {
    /// Twin of `glsl/disks/colors.glsl`: large disks are of no colour, and come first.
    pub(super) fn in_colors(&mut self, settle: impl FnMut(&mut Self, usize, usize)) {
        self.in_colors_from(|disks, i| disks.disks[i].at_m, settle);
    }

    /// With large disks looked for at `place`; the others are where they were sorted.
    fn in_colors_from(
        &mut self,
        place: impl Fn(&Self, usize) -> DVec3,
        mut settle: impl FnMut(&mut Self, usize, usize),
    ) {
        for i in 0..self.large() {
            let mut near = Vec::new();
            self.visit_from(i, place(self, i), |k| near.push(k));
            near.into_iter().for_each(|k| settle(self, i, k));
        }
        let cells = self.grid.cells.as_ivec3();
        let colors = if self.model.space == Space::Flat { 9 } else { 27 };
        for color in 0..colors {
            let of = IVec3::new(color % 3, color / 3 % 3, color / 9);
            for z in (of.z..cells.z).step_by(3) {
                for y in (of.y..cells.y).step_by(3) {
                    for x in (of.x..cells.x).step_by(3) {
                        let cell = IVec3::new(x, y, z);
                        let c = self.index(cell);
                        for i in self.start[c]..self.start[c + 1] {
                            let mut near = Vec::new();
                            self.visit_cells(i, cell, |k| near.push(k));
                            near.into_iter().for_each(|k| settle(self, i, k));
                        }
                    }
                }
            }
        }
    }

    /// One contact of `glsl/disks/sweep.glsl`: an impulse if they come nearer, then out of the overlap.
    pub(super) fn settle(&mut self, i: usize, k: usize) {
        let (n, far) = self.way(i, k);
        if far >= self.reach(i, k) {
            return;
        }
        if n.dot(self.disks[k].velocity_mps - self.disks[i].velocity_mps) < 0.0 {
            self.strike(i, k, &Contact { ago_s: 0.0, normal: n });
        }
        self.put_apart(i, k, n, far);
    }

    fn reach(&self, i: usize, k: usize) -> f64 {
        self.disks[i].radius_m + self.disks[k].radius_m
    }

    fn put_apart(&mut self, i: usize, k: usize, n: DVec3, far: f64) {
        let (m, other) = (self.mass(i), self.mass(k));
        let apart = n * ((self.reach(i, k) - far) / (m + other));
        self.disks[i].at_m -= apart * other;
        self.disks[k].at_m += apart * m;
    }

    /// Positions, velocities from where they led, and the velocity pass.
    pub(super) fn xpbd(&mut self, bounces: bool) {
        let before = self.disks.clone();
        self.in_colors(Self::xpbd_part);
        self.xpbd_derive(&before);
        if bounces {
            self.in_colors_from(|_, i| before[i].at_m, |disks, i, k| disks.xpbd_bounce(&before, i, k));
        }
    }

    /// One contact of `glsl/disks/xpbd_part.glsl`.
    fn xpbd_part(&mut self, i: usize, k: usize) {
        let (n, far) = self.way(i, k);
        let reach = self.reach(i, k);
        if far >= reach {
            return;
        }
        self.put_apart(i, k, n, far);
        let (m, other) = (self.mass(i), self.mass(k));
        self.virial[self.id[i] as usize] += m * other / (m + other) * (reach - far) / self.model.dt_s * reach;
        self.collisions += 1;
        for disk in [i, k] {
            self.hit[self.id[disk] as usize] = self.step;
        }
    }

    /// Twin of `glsl/disks/xpbd_derive.glsl`.
    fn xpbd_derive(&mut self, before: &[super::Disk]) {
        for (disk, before) in self.disks.iter_mut().zip(before) {
            disk.velocity_mps += self.model.way(before.at_m, disk.at_m) / self.model.dt_s;
        }
    }

    /// One contact of `glsl/disks/xpbd_bounce.glsl`.
    fn xpbd_bounce(&mut self, before: &[super::Disk], i: usize, k: usize) {
        let (n, far) = self.axis(i, k, self.model.way(before[i].at_m, before[k].at_m));
        let reach = self.reach(i, k);
        if far >= reach {
            return;
        }
        let (m, other) = (self.mass(i), self.mass(k));
        let closing = n.dot(before[k].velocity_mps - before[i].velocity_mps);
        let now = n.dot(self.disks[k].velocity_mps - self.disks[i].velocity_mps);
        let given = ((-closing).max(0.0) - now) * (m * other / (m + other));
        self.disks[i].velocity_mps -= n * (given / m);
        self.disks[k].velocity_mps += n * (given / other);
        self.virial[self.id[i] as usize] += given * reach;
    }
}
