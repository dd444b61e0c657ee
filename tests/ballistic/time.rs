// SPDX-License-Identifier: MIT OR Apache-2.0
//! Births and the clock: no frame rate and no hour changes what is born.

use super::{materialised, SEED, STREAM};
use crate::common::gpu;
use glam::{DVec3, Vec3};
use std::collections::HashSet;
use whitecap::ballistic::{cpu, Builtin, Emission, GroundGrid, Moment, Params};

const DAY_S: u64 = 86_400;

#[test]
fn frames_of_any_length_bear_the_same_number_a_second() {
    for (rate, nominal) in [(200.0, 200), (500.0, 500), (2500.0, 2500), (0.8, 1), (1234.567, 1235)] {
        let emission = Emission::new(rate, 1.0).unwrap();
        for fps in [24, 30, 59, 60, 144, 199, 200, 240, 500, 1000] {
            for start_s in [0, 1, 17, 3600, DAY_S, 30 * DAY_S] {
                let mut born = 0;
                for frame in start_s * u64::from(fps)..(start_s + 1) * u64::from(fps) {
                    let frames = [frame, frame + 1].map(|frame| Moment::of_frame(frame, fps));
                    let range = emission.born(Some(frames[0]), frames[1]);
                    for serial in range.clone() {
                        let age_s = emission.age_s(frames[1], serial);
                        assert!((0.0..=1.0 / f64::from(fps) + 1e-9).contains(&age_s), "{age_s}");
                    }
                    born += range.end - range.start;
                }
                assert!(born.abs_diff(nominal) <= 1, "{rate} per s at {fps} fps after {start_s} s: {born}");
            }
        }
    }
}

#[test]
fn the_live_range_is_what_lives() {
    for (rate, life) in [(200.0, 1.0), (2500.0, 3.0), (0.8, 3.6), (777.7, 0.013), (3.0, 0.1)] {
        let emission = Emission::new(rate, life).unwrap();
        for time_s in [0.0, 1e-9, 0.005, 0.9999, 1.0, 2.5, 3.0, 86_400.0, 86_400.7, 1e7] {
            let now = Moment::from_s(time_s);
            let live = emission.live(now);
            assert!(live.births <= emission.most(), "{live:?} of {}", emission.most());
            let oldest = live.newest + 1 - live.births;
            assert!(emission.age_s(now, live.newest) >= 0.0 && emission.age_s(now, live.newest + 1) < 0.0);
            if live.births > 0 {
                assert!(emission.age_s(now, oldest) < life + 1e-9);
            }
            if oldest > 0 {
                assert!(emission.age_s(now, oldest - 1) >= life - 1e-9);
            }
        }
    }
    assert_eq!(Emission::new(f64::NAN, 1.0), None);
    assert_eq!(Emission::new(1.0, f64::NAN), None);
    assert_eq!(Emission::new(0.0, 1.0), None);
    assert_eq!(Emission::new(1.0, 0.0), None);
    assert_eq!(Emission::new(1e9, 1.0), None);
}

#[test]
fn ages_are_those_of_f64_however_many_there_are() {
    for (rate, life) in [(200.0, 1.0), (2500.0, 3.0), (67_108_864.0, 1.0), (1e7 / 3.0, 16.0)] {
        let mut effect = Builtin::Fire.effect();
        (effect.rate_per_s, effect.life_s) = (rate, life);
        for time_s in [0.7, 20.3, 86_401.37, 1e7] {
            let now = Moment::from_s(time_s);
            let params = effect.params(now, SEED, STREAM, &GroundGrid::FLAT, u32::MAX);
            let live = effect.emission().live(now);
            for k in 0..997u64 {
                let back = k * (live.births - 1) / 996;
                let age = cpu::age_of(&params, back as u32);
                let want = effect.emission().age_s(now, live.newest - back);
                let apart = (f64::from(age.high) + f64::from(age.low) - want).abs();
                // All is exact but what the interval's last 14 bits bring, 2^-9 of it at most: four roundings of 2^-24.
                assert!(
                    apart <= 2f64.powi(-31) * want.max(1e-9),
                    "{rate} per s at {time_s} s, {back} back: {apart:e} of {want}"
                );
            }
        }
    }
}

/// What frames add up to, and what is sought at once: positions at a moment do not know how it was reached.
#[test]
fn to_seek_is_to_play() {
    let gpu = gpu();
    let effect = Builtin::Sparks.effect();
    for (fps, time_s) in [(24, 5), (60, 7), (1000, 3)] {
        let end = Moment::of_frame(u64::from(fps) * time_s, fps);
        let (_, sought) = materialised(&gpu, Builtin::Sparks, &effect, end);
        // Played: every frame's newborn are taken note of, and flown in f64 from what they began with.
        let mut alive: Vec<(u64, cpu::Birth)> = Vec::new();
        let mut before = None;
        for frame in 0..=u64::from(fps) * time_s {
            let now = Moment::of_frame(frame, fps);
            let params = effect.params(now, SEED, STREAM, &GroundGrid::FLAT, u32::MAX);
            for serial in effect.emission().born(before, now) {
                let who = cpu::Who { serial, member: 0 };
                alive.push((serial, cpu::birth(Builtin::Sparks, &params, who, effect.emitter.at_m)));
            }
            alive.retain(|(serial, _)| effect.emission().age_s(now, *serial) < effect.life_s);
            before = Some(now);
        }
        assert_eq!(alive.len(), sought.len());
        for ((serial, birth), vertex) in alive.iter().zip(&sought) {
            let age_s = effect.emission().age_s(end, *serial);
            let (p, v, a) = (birth.at_m, birth.velocity_mps, effect.acceleration_mps2);
            let drag = f64::from(effect.drag_per_s);
            let want = cpu::position_f64(p.as_dvec3(), v.as_dvec3(), a.as_dvec3(), age_s, drag);
            let apart = (Vec3::from(vertex.at_m).as_dvec3() - want).length();
            assert!(apart <= 1e-6 * want.length().max(1.0), "particle {serial}: {apart:e} m");
        }
    }
}

fn fire_params(time_s: f64) -> Params {
    Builtin::Fire.effect().params(Moment::from_s(time_s), SEED, STREAM, &GroundGrid::FLAT, u32::MAX)
}

/// Directions of fire, before x and z are halved.
fn direction(params: &Params, serial: u64) -> Vec3 {
    let birth = cpu::birth(Builtin::Fire, params, cpu::Who { serial, member: 0 }, Vec3::ZERO);
    birth.velocity_mps / Vec3::new(2.0, 4.0, 2.0)
}

#[test]
fn no_direction_comes_twice_in_a_million_and_a_day_later_they_are_others() {
    let params = fire_params(1.0);
    let mut seen = HashSet::new();
    for serial in (0..500_000).chain(200 * DAY_S..200 * DAY_S + 500_000) {
        let way = direction(&params, serial);
        assert!(seen.insert(way.to_array().map(f32::to_bits)), "{serial} repeats {way}");
    }
}

#[test]
fn statistics_are_those_of_the_start_after_a_day() {
    let n = 200_000;
    let of = |first: u64| -> (DVec3, DVec3) {
        let params = fire_params(1.0);
        let ways = (first..first + n).map(|serial| direction(&params, serial).as_dvec3());
        let (sum, squares) =
            ways.fold((DVec3::ZERO, DVec3::ZERO), |(sum, squares), way| (sum + way, squares + way * way));
        (sum / n as f64, squares / n as f64)
    };
    for first in [0, 200 * DAY_S, 1 << 33] {
        let (mean, squares) = of(first);
        // Four standard errors of means of variance 1/3 and of squares of variance 4/45.
        assert!(mean.abs().max_element() < 4.0 / (3.0 * n as f64).sqrt(), "{mean}");
        assert!(
            (squares - 1.0 / 3.0).abs().max_element() < 4.0 * (4.0 / 45.0 / n as f64).sqrt(),
            "{squares}"
        );
    }
}

/// A fast emitter: sparks lie along its path as evenly as they are born, whatever the frames.
#[test]
fn births_of_a_fast_emitter_lie_evenly_on_its_path() {
    let gpu = gpu();
    let mut effect = Builtin::Fire.effect();
    effect.emitter.velocity_mps = Vec3::new(60.0, 0.0, 0.0);
    let now = Moment::of_frame(37, 20);
    let (params, got) = materialised(&gpu, Builtin::Fire, &effect, now);
    let start = |i: usize| {
        let (who, back) = cpu::who(&params, i as u32);
        let age = cpu::age_of(&params, back);
        let velocity = cpu::birth(Builtin::Fire, &params, who, Vec3::ZERO).velocity_mps;
        // Take off what it flew: what is left is where it was born.
        Vec3::from(got[i].at_m).as_dvec3().x - f64::from(velocity.x) * f64::from(age.high)
    };
    for i in 1..got.len() {
        let gap = start(i) - start(i - 1);
        assert!((gap / 0.3 - 1.0).abs() <= 0.01, "{i}: {gap} m, not 60 m/s x 5 ms");
    }
}
