// SPDX-License-Identifier: MIT OR Apache-2.0
//! `[[disks]]`: boxes of disks or spheres that collide.

use super::{
    parse::{
        Rule::{Finite, Within},
        Table,
    },
    schema::{LENGTH, PLACE},
    PlannedBuffer, Scene,
};
use crate::{
    disks::{starts::Start, Borders, Disk, Grid, Model, Response, Space},
    random::{bits, units},
};
use glam::{vec3, DVec3, Vec3};
use serde::Serialize;

/// A box of disks.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DisksScene {
    /// Name; default `disks`.
    pub name: String,
    /// `flat`: disks, seen from above in a picture that the box fills, the default; `solid`: spheres in the world.
    pub space: Space,
    /// How many, 1..=2^24.
    pub count: u32,
    /// The box along x, y and z (m); z is 1 and not used if it is flat. Spheres stand round the y axis, on y = 0.
    pub size_m: [f64; 3],
    /// `walls` (default) or `periodic`.
    pub borders: Borders,
    /// (m/s²), default 0.
    pub gravity_mps2: [f64; 3],
    /// `matching` (default), `gauss_seidel` or `seed`.
    pub response: Response,
    /// Least and largest radius (m); default the tutorial's, 0.175 and 0.35 of the room of one.
    pub radius_m: [f64; 2],
    /// Largest velocity along an axis at the start (m/s), default five of the largest radius a second.
    pub speed_mps: f64,
    /// Where in the box they start, lowest corner (m), default the box.
    pub from_m: [f64; 3],
    /// Highest corner (m).
    pub to_m: [f64; 3],
    /// Time step (s), default 1/60; cut into substeps where disks are fast or crowded.
    pub dt_s: f64,
    /// Disks of their own, in front of the others.
    pub heavy: Vec<Heavy>,
}

/// A disk of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Heavy {
    /// Centre, from the lowest corner of the box (m).
    pub at_m: [f64; 3],
    /// (m).
    pub radius_m: f64,
    /// (m/s), default 0.
    pub velocity_mps: [f64; 3],
}

pub(super) fn disks(root: &mut Table<'_>) -> Vec<DisksScene> {
    root.tables("disks").into_iter().map(one).collect()
}

fn one(mut table: Table<'_>) -> DisksScene {
    let name = table.text("name", "a text", |name| !name.is_empty()).unwrap_or("disks").to_owned();
    let space = table.choice("space", &[("flat", Space::Flat), ("solid", Space::Solid)]);
    let space = space.unwrap_or(Space::Flat);
    let count: u32 = table.number("count", Within(1.0, 16_777_216.0));
    let size_m = match space {
        Space::Flat => {
            let [x, y]: [f64; 2] = table.number("size_m", LENGTH);
            [x, y, 1.0]
        }
        Space::Solid => table.number("size_m", LENGTH),
    };
    let borders = [("walls", Borders::Walls), ("periodic", Borders::Periodic)];
    let borders = table.choice("borders", &borders).unwrap_or(Borders::Walls);
    let rounds = table.maybe("rounds", Within(1.0, 64.0)).unwrap_or(3);
    let matching = Response::Matching { rounds, rewinds: true };
    let words = [("matching", matching), ("gauss_seidel", Response::GaussSeidel), ("seed", Response::Seed)];
    let from_m = table.maybe("from_m", PLACE).unwrap_or([0.0; 3]);
    let to_m = table.maybe("to_m", PLACE).unwrap_or(size_m);
    let dimensions = space.dimensions() as usize;
    if (0..dimensions).any(|k| from_m[k] < 0.0 || to_m[k] > size_m[k] || from_m[k] >= to_m[k]) {
        table.conflict(
            "to_m",
            "and from_m: the part of the box that they span has to be within it, and not empty",
        );
    }
    let room: f64 = (0..dimensions).map(|k| (to_m[k] - from_m[k]).max(0.0)).product();
    let widest = 0.35 * (room / f64::from(count.max(1))).powf(1.0 / dimensions as f64);
    let radius_m = table.maybe("radius_m", LENGTH).unwrap_or([0.5 * widest, widest]);
    if radius_m[0] > radius_m[1] {
        table.conflict("radius_m", "has the largest first; the least comes first");
    }
    let heavy = table.tables("heavy").into_iter().map(|mut table| {
        let heavy = Heavy {
            at_m: table.number("at_m", PLACE),
            radius_m: table.number("radius_m", LENGTH),
            velocity_mps: table.maybe("velocity_mps", Finite).unwrap_or([0.0; 3]),
        };
        table.finish();
        heavy
    });
    let heavy = heavy.collect();
    let made = DisksScene {
        name,
        space,
        count,
        size_m,
        borders,
        gravity_mps2: table.maybe("gravity_mps2", Finite).unwrap_or([0.0; 3]),
        response: table.choice("response", &words).unwrap_or(matching),
        radius_m,
        speed_mps: table.maybe("speed_mps", Within(0.0, 1e6)).unwrap_or(5.0 * radius_m[1]),
        from_m,
        to_m,
        dt_s: table.maybe("dt_s", Within(1e-6, 10.0)).unwrap_or(1.0 / 60.0),
        heavy,
    };
    table.finish();
    made
}

impl DisksScene {
    /// Of the box's lowest corner, in the world (m).
    pub fn origin_m(&self) -> Vec3 {
        vec3(-0.5 * self.size_m[0] as f32, 0.0, -0.5 * self.size_m[2] as f32)
    }

    /// The disks: on a lattice, each within its room at random; those on a heavy one are left out.
    pub fn start(&self, seed: u64) -> Start {
        let dimensions = self.space.dimensions() as usize;
        let (from, to) = (DVec3::from(self.from_m), DVec3::from(self.to_m));
        let span = (to - from).to_array();
        let room: f64 = span[..dimensions].iter().product::<f64>() / f64::from(self.count);
        let edge = room.powf(1.0 / dimensions as f64);
        // Enough cells along each axis, so that there is one a disk.
        let mut cells = [1u64; 3];
        for axis in 0..dimensions {
            cells[axis] = (span[axis] / edge).round().max(1.0) as u64;
        }
        let longest = (0..dimensions).max_by(|&a, &b| span[a].total_cmp(&span[b])).unwrap_or(0);
        while cells.iter().product::<u64>() < u64::from(self.count) {
            cells[longest] += 1;
        }
        let heavy = self.heavy.iter().map(|it| Disk {
            at_m: DVec3::from(it.at_m).with_z(if dimensions == 2 { 0.0 } else { it.at_m[2] }),
            velocity_mps: DVec3::from(it.velocity_mps),
            radius_m: it.radius_m,
        });
        let mut disks: Vec<Disk> = heavy.collect();
        let own = disks.len();
        let seed = seed as u32;
        for i in 0..self.count {
            let place = units(bits(seed, 0, i, 0)).map(f64::from);
            let speed = units(bits(seed, 0, i, 1)).map(|u| f64::from(u) * 2.0 - 1.0);
            let radius_m = self.radius_m[0] + place[3] * (self.radius_m[1] - self.radius_m[0]);
            // The cells that are left over are spread among the rest.
            let n = u64::from(i) * cells.iter().product::<u64>() / u64::from(self.count);
            let cell = [n % cells[0], n / cells[0] % cells[1], n / cells[0] / cells[1]];
            let (mut at, mut velocity) = (DVec3::ZERO, DVec3::ZERO);
            for axis in 0..dimensions {
                let wide = span[axis] / cells[axis] as f64;
                let play = (wide - 2.0 * radius_m).max(0.0);
                at[axis] = from[axis] + (cell[axis] as f64 + 0.5) * wide + (place[axis] - 0.5) * play;
                velocity[axis] = speed[axis] * self.speed_mps;
            }
            if disks[..own].iter().all(|it| it.at_m.distance(at) > it.radius_m + radius_m) {
                disks.push(Disk { at_m: at, velocity_mps: velocity, radius_m });
            }
        }
        let model = Model {
            space: self.space,
            size_m: DVec3::from(self.size_m),
            borders: self.borders,
            gravity_mps2: DVec3::from(self.gravity_mps2),
            response: self.response,
            dt_s: self.dt_s,
        };
        Start { model, disks }
    }

    pub(super) fn list_buffers(&self, seed: u64, list: &mut Vec<PlannedBuffer>) {
        let start = self.start(seed);
        let grid = Grid::of(&start.model, start.disks.iter().map(|disk| disk.radius_m));
        let count = start.disks.len() as u64;
        let cells = (grid.count() as u64 + 1).next_multiple_of(4096);
        let motion = if self.space == Space::Flat { 8 } else { 16 };
        let because = format!("disks.{}", self.name);
        for (name, bytes) in [
            ("place_m", 16 * count),
            ("motion", motion * count),
            ("new_place_m", 16 * count),
            ("new_motion", motion * count),
            ("key", 8 * count),
            ("count", 4 * cells),
            ("sums", cells / 1024),
            ("start", 4 * cells),
            ("slot", 4 * count),
            ("partner", 4 * count),
            ("wake", 4 * count),
            ("hit", 4 * count),
        ] {
            list.push(PlannedBuffer { name: format!("disks.{name}"), bytes, because: because.clone() });
        }
    }

    pub(super) fn list_passes(&self, scene: &Scene, list: &mut Vec<(String, f64)>) {
        let start = self.start(scene.seed);
        let substeps = f64::from(start.model.substeps(&start.disks));
        let often = substeps / (scene.output.fps * self.dt_s);
        let (respond, times) = match self.response {
            Response::Seed => ("disks.contacts", 1),
            Response::GaussSeidel => ("disks.sweep", if self.space == Space::Flat { 9 } else { 27 }),
            Response::Xpbd { .. } => {
                ("disks.xpbd_part, disks.xpbd_bounce", if self.space == Space::Flat { 9 } else { 27 })
            }
            Response::Matching { rounds, .. } => ("disks.propose, disks.collide", rounds),
        };
        for pass in ["disks.travel", "prims.reduce, prims.scan", "disks.slot", "disks.gather"] {
            list.push((pass.into(), often));
        }
        list.push((respond.into(), often * f64::from(times)));
    }
}
