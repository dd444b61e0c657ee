// SPDX-License-Identifier: MIT OR Apache-2.0
//! Bodies that move through the water: their twin, and their volume.

use crate::{
    common::{distance, gpu, TestGpu},
    to_f32, wet, ODD, TUNING,
};
use glam::{dvec3, DVec3, UVec2};
use whitecap::{
    gpu::Access,
    water::{
        bodies::{Path, Pose, Shape},
        cpu_bodies, oracle,
        starts::{self, Start},
        Bodies, Body, BodyParams, Waves,
    },
};

/// Across the middle, round in circles, down and up, partly outside, and turned; in a basin of 38.5 x 22.5 m.
fn fleet() -> Vec<Body> {
    let sphere = |radius: f64, path| Body { shape: Shape::Sphere(radius), path, yaw_rad: 0.0 };
    let hull = |half, yaw_rad, path| Body { shape: Shape::Box(half), path, yaw_rad };
    vec![
        sphere(2.2, Path::Keys(vec![(0.0, dvec3(6.0, 0.5, 7.0)), (1.0, dvec3(30.0, -0.5, 15.0))])),
        sphere(1.5, Path::Swing { at_m: dvec3(15.3, 1.0, 4.0), by_m: dvec3(0.0, 2.5, 0.0), period_s: 1.0 }),
        hull(
            dvec3(3.0, 0.6, 1.0),
            0.0,
            Path::Circle { centre_m: dvec3(20.0, 0.2, 11.0), radius_m: 6.0, period_s: 3.0, start_rad: 1.0 },
        ),
        hull(
            dvec3(4.0, 1.0, 1.3),
            0.7,
            Path::Keys(vec![(0.0, dvec3(-5.0, 0.1, 3.0)), (2.0, dvec3(12.0, 0.1, 21.0))]),
        ),
    ]
}

fn poses(fleet: &[Body], times: &[f64]) -> Vec<Pose> {
    times.iter().flat_map(|&t| fleet.iter().map(move |body| body.pose(t, DVec3::ZERO))).collect()
}

/// Moves a fleet through water at rest that does not step: heights, and poses with their draughts.
fn sail(gpu: &TestGpu, start: &Start, fleet: &[Body], times: &[f64]) -> (Vec<f32>, Vec<Pose>) {
    let cells = start.model.cells;
    let state = Waves::new(gpu, TUNING, true).unwrap().state(cells).unwrap();
    state.upload(gpu, &start.height_m, &vec![0.0; start.height_m.len()]).unwrap();
    let params = BodyParams::new(&state.surface(), cells, start.model.cell_m, fleet.len() as u32);
    let steps = times.len() as u32 - 1;
    let mut list = Bodies::new(gpu).unwrap().list(state.surfaces(), params, steps).unwrap();
    let staging = list.staging(poses(fleet, times)).unwrap();
    gpu.once(|rec| {
        rec.copy(&staging, list.poses());
        rec.barrier(Access::CopyWrite, Bodies::ENTRY);
        list.record_draughts(rec, &state.surface());
        for step in 0..steps {
            rec.barrier(Bodies::EXIT, Bodies::ENTRY);
            list.record(rec, &state.surface(), step);
        }
    })
    .unwrap();
    (state.download(gpu).unwrap().0, gpu.download(list.poses()).unwrap())
}

#[test]
fn bodies_do_what_their_twin_does_and_raise_exactly_their_volume() {
    let gpu = gpu();
    let (fleet, times) = (fleet(), [0.0, 0.1, 0.3, 0.8]);
    for start in [starts::hump(starts::model(ODD, 0.25)), starts::islands(starts::model(ODD, 0.25))] {
        let (height, got) = sail(&gpu, &start, &fleet, &times);
        let params = BodyParams {
            cells: ODD,
            origin: UVec2::ZERO,
            size: ODD,
            pitch: ODD.x,
            stride: 1,
            first: 0,
            count: 4,
            cell_m: start.model.cell_m as f32,
        };
        let (mut want, mut height_m) = (poses(&fleet, &times), start.height_m.clone());
        cpu_bodies::draught(&params, &start.height_m, &mut want);
        for step in 0..3 {
            cpu_bodies::body(
                &params,
                &mut height_m,
                &want[4 * step..4 * step + 4],
                &want[4 * step + 4..4 * step + 8],
            );
        }
        let rose =
            |h: &[f32]| -> Vec<f64> { wet(h).iter().zip(wet(&start.height_m)).map(|(a, b)| a - b).collect() };
        let d = distance(&to_f32(&rose(&height)), &rose(&height_m));
        assert!(d.relative_power < 1e-11, "{}: {d:?}", start.name);
        let displaced = |poses: &[Pose]| poses.iter().map(|pose| f64::from(pose.displaced_m3)).sum::<f64>();
        let gained = start.model.cell_m.powi(2) * (oracle::volume(&height) - oracle::volume(&start.height_m));
        let told = displaced(&got[12..]) - displaced(&got[..4]);
        println!("{}: {gained} m3 gained, {told} m3 displaced", start.name);
        assert!((gained - told).abs() < 1e-4);
        // Where all is water, that is the volume below the level.
        if start.name == "hump" {
            for (pose, body) in got.iter().zip(fleet.iter().cycle()).filter(|(pose, _)| pose.at_m.x > 5.0) {
                let submerged = body.shape.submerged_m3(pose.at_m.y.into());
                assert!(
                    (f64::from(pose.displaced_m3) - submerged).abs() < 1e-5 * submerged.max(1.0),
                    "{pose:?}"
                );
                assert!(pose.submerged_m3 == 0.0 || (pose.scale - 1.0).abs() < 0.1, "{pose:?}");
            }
        }
    }
}

#[test]
fn a_closed_passage_leaves_nothing_behind() {
    let gpu = gpu();
    let out = |place: DVec3| (0.0, place);
    let round = Path::Keys(vec![
        out(dvec3(-20.0, 0.0, 9.0)),
        (1.0, dvec3(15.0, -0.4, 11.0)),
        (2.0, dvec3(22.0, 0.3, 14.0)),
        (3.0, dvec3(60.0, 0.0, 3.0)),
    ]);
    let fleet = [Shape::Sphere(3.0), Shape::Box(dvec3(4.0, 1.0, 1.5))].map(|shape| Body {
        shape,
        path: round.clone(),
        yaw_rad: 0.3,
    });
    let times: Vec<f64> = (0..=150).map(|i| 0.02 * f64::from(i)).collect();
    for start in [starts::flat(starts::model(ODD, 0.25), 0.0), starts::islands(starts::model(ODD, 0.25))] {
        let (height, poses) = sail(&gpu, &start, &fleet, &times);
        let most = poses.iter().map(|pose| f64::from(pose.displaced_m3)).fold(0.0, f64::max);
        let left = start.model.cell_m.powi(2) * (oracle::volume(&height) - oracle::volume(&start.height_m));
        let worst =
            wet(&height).iter().zip(wet(&start.height_m)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        println!("{}: of {most} m3, {left:e} m3 are left, {worst:e} m at most", start.name);
        assert!(left.abs() < 1e-5 * most && worst < 1e-5);
    }
}

#[test]
fn paths_go_through_their_keys_and_circles_close() {
    let keys = Path::Keys(vec![(1.0, dvec3(0.0, 1.0, 2.0)), (3.0, dvec3(4.0, 1.0, 0.0))]);
    let places = [0.0, 1.0, 2.0, 3.0, 9.0].map(|t| keys.at(t).0);
    assert_eq!(places[..2], [dvec3(0.0, 1.0, 2.0); 2]);
    assert_eq!(places[2..], [dvec3(2.0, 1.0, 1.0), dvec3(4.0, 1.0, 0.0), dvec3(4.0, 1.0, 0.0)]);
    let circle = Path::Circle { centre_m: DVec3::Y, radius_m: 2.0, period_s: 4.0, start_rad: 0.0 };
    assert!(circle.at(1.0).0.distance(dvec3(0.0, 1.0, 2.0)) < 1e-12);
    assert_eq!(circle.at(0.0), circle.at(4e6));
    let swing = Path::Swing { at_m: DVec3::X, by_m: DVec3::Y, period_s: 2.0 };
    assert!(swing.at(0.5).0.distance(dvec3(1.0, 1.0, 0.0)) < 1e-12);
    assert_eq!(Shape::Sphere(1.0).submerged_m3(-1.0), 4.0 / 3.0 * std::f64::consts::PI);
    assert_eq!(Shape::Box(dvec3(1.0, 2.0, 3.0)).submerged_m3(1.0), 12.0);
    assert_eq!(Shape::Box(dvec3(1.0, 2.0, 3.0)).submerged_m3(-9.0), 48.0);
}
