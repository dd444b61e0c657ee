// SPDX-License-Identifier: MIT OR Apache-2.0
//! What is known of hard disks and spheres: pressure, and what does not change.

use super::model::{Borders, Disk, Model, Space};
use glam::DVec3;

/// `P V / (N k T)` of disks (Henderson, "A simple equation of state for hard discs", Molecular Physics 30, 1975) and of
/// spheres (Carnahan and Starling, "Equation of State for Nonattracting Rigid Spheres", 1969) that fill `packing` of a box.
pub fn pressure(space: Space, packing: f64) -> f64 {
    match space {
        Space::Flat => (1.0 + packing.powi(2) / 8.0) / (1.0 - packing).powi(2),
        Space::Solid => (1.0 + packing + packing.powi(2) - packing.powi(3)) / (1.0 - packing).powi(3),
    }
}

/// Of disks of several radii: `(1 - x) / (1 - packing) + x Z`, with `x` the square of the mean radius over the mean square
/// (Jenkins and Mancini, "Balance laws and constitutive relations for plane flows of a dense, binary mixture", 1987).
pub fn mixture_pressure(packing: f64, disks: &[Disk]) -> f64 {
    let mean = |power| disks.iter().map(|disk| disk.radius_m.powi(power)).sum::<f64>() / disks.len() as f64;
    let x = mean(1).powi(2) / mean(2);
    (1.0 - x) / (1.0 - packing) + x * pressure(Space::Flat, packing)
}

/// Kinetic energy, and that of the height above the corner into which gravity pulls.
pub fn total_energy(model: &Model, disks: &[Disk]) -> f64 {
    if model.borders == Borders::Periodic {
        return energy(model, disks); // nothing is above anything
    }
    let pull = model.gravity_mps2;
    let corner = DVec3::select(pull.cmpgt(DVec3::ZERO), model.size_m, DVec3::ZERO);
    let height = |d: &Disk| model.space.mass(d.radius_m) * pull.dot(corner - d.at_m);
    energy(model, disks) + disks.iter().map(height).sum::<f64>()
}

/// Kinetic energy.
pub fn energy(model: &Model, disks: &[Disk]) -> f64 {
    disks.iter().map(|d| 0.5 * model.space.mass(d.radius_m) * d.velocity_mps.length_squared()).sum()
}

/// Momentum, and the sum of its lengths.
pub fn momentum(model: &Model, disks: &[Disk]) -> (DVec3, f64) {
    disks.iter().fold((DVec3::ZERO, 0.0), |(sum, lengths), d| {
        let p = model.space.mass(d.radius_m) * d.velocity_mps;
        (sum + p, lengths + p.length())
    })
}

/// `P V / (N k T)` from what pairs gave each other in `time_s`: `virial` is the sum of impulse times distance of the centres,
/// `energy` that of [`energy`] in the mean.
pub fn pressure_of_virial(energy: f64, virial: f64, time_s: f64) -> f64 {
    1.0 + virial / (2.0 * energy * time_s)
}

/// The largest overlap of a pair, of the sum of its radii; every pair is looked at.
pub fn overlap(model: &Model, disks: &[Disk]) -> f64 {
    let mut order: Vec<&Disk> = disks.iter().collect();
    order.sort_by(|a, b| a.at_m.x.total_cmp(&b.at_m.x));
    let widest = 2.0 * disks.iter().map(|disk| disk.radius_m).fold(0.0, f64::max);
    let mut most = 0.0_f64;
    for (i, a) in order.iter().enumerate() {
        // Along x in order, and once round.
        for b in order[i + 1..].iter().chain(&order[..i]) {
            let d = model.way(a.at_m, b.at_m);
            if d.x.abs() > widest {
                if model.borders == Borders::Walls || d.x > 0.0 {
                    break;
                }
                continue;
            }
            let reach = a.radius_m + b.radius_m;
            most = most.max(1.0 - d.length() / reach);
        }
    }
    most
}
