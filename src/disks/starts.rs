// SPDX-License-Identifier: MIT OR Apache-2.0
//! Named starts, for tests, benches and scenes.

use super::model::{Borders, Disk, Model, Response, Space};
use crate::random::{bits, cos_sin_of_turn, units};
use glam::{dvec3, DVec3, Vec2};

/// A box and what is in it.
#[derive(Clone, Debug)]
pub struct Start {
    /// How it is stepped.
    pub model: Model,
    /// In the order of their ids.
    pub disks: Vec<Disk>,
}

/// A velocity of components that are normal, of variance 1 (Box and Muller, 1958).
pub fn thermal(space: Space, seed: u32, i: u32) -> DVec3 {
    let pair = |purpose| {
        let [u, v, ..] = units(bits(seed, 1, i, purpose));
        let way: Vec2 = cos_sin_of_turn(v);
        way.as_dvec2() * (-2.0 * (1.0 - f64::from(u)).ln()).sqrt()
    };
    let (xy, z) = (pair(0), pair(1));
    dvec3(xy.x, xy.y, if space == Space::Flat { 0.0 } else { z.x })
}

/// `count` equal disks that fill `packing` of a periodic box, on a lattice, with thermal velocities of root mean square 1
/// m/s and no momentum; radius 1 m.
pub fn fluid(space: Space, count: u32, packing: f64, seed: u32) -> Start {
    let room = space.measure(1.0) * f64::from(count) / packing;
    // Flat: rows that are shifted by half, near a hexagon; solid: face-centred cubic.
    let (size_m, places) = match space {
        Space::Flat => {
            let rows = ((f64::from(count) * 2.0 / 3.0_f64.sqrt()).sqrt() / 2.0).round().max(1.0) * 2.0;
            let columns = (f64::from(count) / rows).ceil();
            let step = (room / (rows * columns) * 2.0 / 3.0_f64.sqrt()).sqrt();
            let size = dvec3(columns * step, room / (columns * step), 1.0);
            let place = move |i: u32| {
                let (x, y) = ((f64::from(i) % columns), (f64::from(i) / columns).floor());
                dvec3((x + 0.25 + 0.5 * (y % 2.0)) / columns * size.x, (y + 0.5) / rows * size.y, 0.0)
            };
            (size, (0..count).map(place).collect::<Vec<_>>())
        }
        Space::Solid => {
            let n = (f64::from(count) / 4.0).cbrt().ceil();
            let size = DVec3::splat(room.cbrt());
            let place = move |i: u32| {
                let (cell, k) = (f64::from(i / 4), i % 4);
                let corner = dvec3(cell % n, (cell / n).floor() % n, (cell / n / n).floor());
                let shift =
                    [dvec3(0., 0., 0.), dvec3(0.5, 0.5, 0.), dvec3(0.5, 0., 0.5), dvec3(0., 0.5, 0.5)];
                (corner + shift[k as usize] + 0.25) / n * size
            };
            (size, (0..count).map(place).collect::<Vec<_>>())
        }
    };
    let mut velocities: Vec<DVec3> = (0..count).map(|i| thermal(space, seed, i)).collect();
    let mean = velocities.iter().sum::<DVec3>() / f64::from(count);
    velocities.iter_mut().for_each(|v| *v -= mean);
    let square = velocities.iter().map(|v| v.length_squared()).sum::<f64>() / f64::from(count);
    let scale = 1.0 / square.sqrt().max(1e-12);
    let disk = |(&at_m, v): (&DVec3, &DVec3)| Disk { at_m, velocity_mps: *v * scale, radius_m: 1.0 };
    Start {
        model: Model {
            space,
            size_m,
            borders: Borders::Periodic,
            gravity_mps2: DVec3::ZERO,
            response: Response::Matching { rounds: 3, rewinds: true },
            dt_s: 0.1,
        },
        disks: places.iter().zip(&velocities).map(disk).collect(),
    }
}

/// The tutorial's start: radii of half to all of `0.7 / sqrt(n)`, places and velocities at random, in a box of 2 m by 2 m.
/// In [`Space::Solid`] as dense, with the same share of a cell.
pub fn seed(space: Space, count: u32, borders: Borders, seed: u32) -> Start {
    let share = f64::from(count).powf(1.0 / f64::from(space.dimensions()));
    let widest = (0.7 / share).min(0.05);
    let disk = |i: u32| {
        let [x, y, z, r] = units(bits(seed, 0, i, 0)).map(f64::from);
        let [vx, vy, vz, _] = units(bits(seed, 0, i, 1)).map(|u| 10.0 * f64::from(u) - 5.0);
        let radius_m = widest * (0.5 + 0.5 * r);
        let flat = if space == Space::Flat { 0.0 } else { 1.0 };
        let inside = |u: f64| radius_m + u * (2.0 - 2.0 * radius_m);
        Disk {
            at_m: dvec3(inside(x), inside(y), flat * inside(z)),
            velocity_mps: dvec3(vx, vy, flat * vz) * widest,
            radius_m,
        }
    };
    Start {
        model: Model {
            space,
            size_m: DVec3::splat(2.0),
            borders,
            gravity_mps2: DVec3::ZERO,
            response: Response::Matching { rounds: 3, rewinds: true },
            dt_s: 1.0 / 60.0,
        },
        disks: (0..count).map(disk).collect(),
    }
}
