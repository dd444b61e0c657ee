// SPDX-License-Identifier: MIT OR Apache-2.0
//! Extended position based dynamics: what its velocity pass is worth. That kernels are their twins is in `main.rs`.

use crate::{common::gpu, run, twin};
use glam::{dvec3, DVec3};
use whitecap::disks::{oracle, starts, starts::Start, Borders, Disk, Model, Response, Space};

const BOUNCES: Response = Response::Xpbd { bounces: true };
const PLAIN: Response = Response::Xpbd { bounces: false };

/// The tutorial's density and way in a step.
fn gas(response: Response, substeps: u32) -> Start {
    let mut start = starts::fluid(Space::Flat, 500, 0.2245, 6);
    start.model.response = response;
    start.model.dt_s = 0.09 / f64::from(substeps);
    start
}

fn energy_left(response: Response, substeps: u32) -> f64 {
    let start = gas(response, substeps);
    let disks = twin(&start, 600 * substeps).disks(); // ten seconds
    let (momentum, lengths) = oracle::momentum(&start.model, &disks);
    assert!(momentum.length() < 1e-12 * lengths, "every push is of a pair");
    oracle::energy(&start.model, &disks) / oracle::energy(&start.model, &start.disks)
}

#[test]
fn without_its_velocity_pass_it_is_inelastic_and_with_it_shorter_steps_lose_less() {
    let plain = energy_left(PLAIN, 1);
    let left = [1, 4].map(|substeps| energy_left(BOUNCES, substeps));
    println!("plain {plain:.3}, with the pass {left:.3?}");
    assert!(plain < 0.1, "{plain}");
    assert!(left[0] > 0.8 && left[0] < left[1] && left[1] < 1.0, "{left:?}");
}

#[test]
fn a_pair_bounces_with_its_velocity_pass_and_sticks_without() {
    let gpu = gpu();
    let disk = |x: f64, vx: f64, radius_m: f64| Disk {
        at_m: dvec3(x, 0.5, 0.0),
        velocity_mps: dvec3(vx, 0.0, 0.0),
        radius_m,
    };
    let model = Model {
        space: Space::Flat,
        size_m: DVec3::splat(2.0),
        borders: Borders::Walls,
        gravity_mps2: DVec3::ZERO,
        response: BOUNCES,
        dt_s: 0.01,
    };
    let start = Start { model, disks: vec![disk(0.5, 1.0, 0.1), disk(0.85, 0.0, 0.2)] };
    let after = |response| {
        let start = Start { model: Model { response, ..model }, ..start.clone() };
        run(&gpu, &start, 20).iter().map(|disk| disk.velocity_mps.x).collect::<Vec<f64>>()
    };
    // Masses of 1 and 4.
    let elastic = after(BOUNCES);
    assert!((elastic[0] + 0.6).abs() < 1e-5 && (elastic[1] - 0.4).abs() < 1e-5, "{elastic:?}");
    let plain = after(PLAIN);
    let energy = 0.01 * plain[0].powi(2) + 0.04 * plain[1].powi(2);
    // A place of 0.5 m rounded to 6e-8 m, over a step of 0.01 s, is a speed to 6e-6 m/s: measured 3e-6.
    let momentum = 0.01 * plain[0] + 0.04 * plain[1];
    assert!(energy < 0.005 && (momentum - 0.01).abs() < 0.05 * 6e-6, "{plain:?}");
}
