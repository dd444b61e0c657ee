// SPDX-License-Identifier: MIT OR Apache-2.0
//! Impacts that ripple a water: the kernel against its twin, the host out of the way, and what a drop moves.

use super::{common::gpu, to_f32, wet, TUNING};
use crate::common::TestGpu;
use glam::{uvec2, vec2, vec3, UVec2, Vec3};
use whitecap::{
    gpu::Access,
    impact::{Count, Impact, Stream},
    random,
    water::{
        cpu_splash, splash::Hit, starts, Counts, Disturb, DisturbParams, Disturbance, Splash, SplashCounts,
        SplashParams, Splashing, Waves, WavesState, LAND_M,
    },
};

const CELLS: UVec2 = uvec2(96, 80);
const CELL_M: f64 = 0.25;
const DEPTH_M: f64 = 2.0;
const HIT: Hit = Hit { radius_m: 1.0, volume_m3: 1e-3, volume: true, momentum_in_m: Some(DEPTH_M) };

struct Pool {
    state: WavesState,
    stream: Stream,
    splashing: Splashing,
    params: SplashParams,
    disturb: DisturbParams,
}

/// Flat water with an island, and a stream of up to `capacity` impacts into it.
fn pool(gpu: &TestGpu, hit: &Hit, capacity: u32, has_land: bool) -> (Pool, Vec<f32>) {
    let start = starts::hump(starts::model(CELLS, 0.25));
    let state = Waves::new(gpu, TUNING, has_land).unwrap().state(start.model.cells).unwrap();
    let is_land = |i: u32| has_land && (20..40).contains(&(i % CELLS.x)) && (10..50).contains(&(i / CELLS.x));
    let heights: Vec<f32> =
        (0..CELLS.element_product()).map(|i| if is_land(i) { LAND_M } else { 0.0 }).collect();
    state.upload(gpu, &heights, &vec![0.0; heights.len()]).unwrap();
    let surface = state.surface();
    let disturb = DisturbParams {
        cells: CELLS,
        pitch: surface.pitch,
        stride: 1,
        cell_m: CELL_M as f32,
        limit_m: 10.0,
        has_velocity: 1,
    };
    let corner_m = vec2(-12.0, -10.0);
    let params = SplashParams::new(&surface, CELL_M, corner_m, hit);
    let stream = Stream::new(gpu, capacity).unwrap();
    let list = Disturb::new(gpu).unwrap();
    let list = list.list_of(state.surfaces(), state.velocities(), params.items * capacity).unwrap();
    let splashing = Splash::new(gpu).unwrap().bind(&stream, state.surfaces(), list, params.items).unwrap();
    (Pool { state, stream, splashing, params, disturb }, heights)
}

impl Pool {
    /// A step of these impacts, which lie as they are given.
    fn step(&self, gpu: &TestGpu, impacts: &[Impact]) {
        let mut all = impacts.to_vec();
        all.resize(self.stream.capacity() as usize, Impact::default());
        gpu.upload_to(self.stream.impacts(), &all).unwrap();
        let count = Count { appended: impacts.len() as u32, ..self.stream.counts().unwrap() };
        gpu.upload_to(self.stream.count(), &[count]).unwrap();
        gpu.once(|rec| {
            self.stream.record_begin(rec);
            self.stream.record_end(rec);
            rec.barrier(Stream::EXIT, Splash::ENTRY);
            rec.barrier(Stream::EXIT, Access::IndirectRead);
            self.splashing.record(rec, &self.state.surface(), &self.params, &self.disturb);
        })
        .unwrap();
    }

    fn surface(&self, gpu: &TestGpu) -> (Vec<f32>, Vec<f32>) {
        self.state.download(gpu).unwrap()
    }
}

/// Places all over the grid and round it, in an order that is not that of the numbers.
fn impacts(count: u32) -> Vec<Impact> {
    let of = |i: u32| {
        let [x, z, speed, _] = random::units(random::bits(5, 0, i, 0));
        Impact {
            at_m: vec3(30.0 * x - 15.0, 0.0, 24.0 * z - 12.0),
            order: 8 * (i.wrapping_mul(7919) % count),
            normal: Vec3::Y,
            impulse_mps: 5.0 + 10.0 * speed,
            ..Impact::default()
        }
    };
    (0..count).map(of).collect()
}

#[test]
fn impacts_are_the_disturbances_of_the_twin_in_their_order() {
    let gpu = gpu();
    let kinds = [HIT, Hit { momentum_in_m: None, ..HIT }, Hit { volume: false, ..HIT }];
    for (hit, count) in kinds.iter().zip([997, 64, 1]).chain([(&HIT, 0), (&HIT, 257)]) {
        let (pool, heights) = pool(&gpu, hit, 1000, true);
        let mut all = impacts(count);
        if let [_, bad, ..] = &mut all[..] {
            bad.at_m.x = f32::NAN; // is nowhere
        }
        let (want, missed) =
            cpu_splash::splash(&SplashParams { pitch: CELLS.x, ..pool.params }, &heights, &all);
        assert!(count < 100 || missed > 20 && want.len() > 50, "{missed} missed, {} items", want.len());
        for turn in 1..=2u64 {
            pool.step(&gpu, &all);
            let mut got = pool.splashing.download().unwrap();
            got.iter_mut().for_each(|it| it.scale = 0.0); // what water.weigh has written
            assert_eq!(got, want);
            let taken = turn * want.len() as u64 / u64::from(pool.params.items);
            assert_eq!(pool.splashing.counts().unwrap(), SplashCounts::new(taken, turn * missed));
            all.reverse(); // they lie as they come
        }
        let counts = pool.splashing.list().counts().unwrap();
        assert_eq!((counts.applied, counts.rejected, counts.missed), (2 * want.len() as u32, 0, 0));
    }
}

#[test]
fn numbers_of_64_bits_carry() {
    let gpu = gpu();
    let (pool, _) = pool(&gpu, &HIT, 64, false);
    let before = SplashCounts::new(u64::from(u32::MAX), u64::from(u32::MAX) - 1);
    gpu.upload_to(pool.splashing.counters(), &[before]).unwrap();
    let mut all = impacts(8);
    all.iter_mut().for_each(|it| it.at_m = Vec3::ZERO);
    all[3].at_m.x = 100.0;
    pool.step(&gpu, &all);
    let counts = pool.splashing.counts().unwrap();
    assert_eq!((counts.taken(), counts.missed()), (u64::from(u32::MAX) + 7, u64::from(u32::MAX)));
}

/// The host is not in between, and it makes no difference: to the bit, one drop and many.
#[test]
fn the_surface_is_the_one_after_the_same_disturbances_from_the_host() {
    let gpu = gpu();
    for count in [1, 300] {
        let (with, heights) = pool(&gpu, &HIT, 400, true);
        let all: Vec<Impact> = match count {
            1 => vec![Impact { at_m: vec3(2.6, 0.0, 3.1), impulse_mps: 20.0, ..Impact::default() }],
            _ => impacts(count),
        };
        with.step(&gpu, &all);
        let (other, _) = pool(&gpu, &HIT, 400, true);
        let params = SplashParams { pitch: CELLS.x, ..other.params };
        let (items, _) = cpu_splash::splash(&params, &heights, &all);
        let list = Disturb::new(&gpu).unwrap();
        let list = list.list_of(other.state.surfaces(), other.state.velocities(), 800).unwrap();
        let (staging, left) = list.staging(&items).unwrap();
        assert_eq!(left, 0);
        gpu.once(|rec| {
            rec.copy(&staging, list.list());
            rec.barrier(Access::CopyWrite, Disturb::ENTRY);
            list.record(rec, &other.state.surface(), &other.disturb);
        })
        .unwrap();
        let (got, want) = (with.surface(&gpu), other.surface(&gpu));
        assert!(want.1.iter().any(|&speed| speed != 0.0) && want.0.iter().any(|&h| h > 0.0));
        assert!(got == want, "{count}");
        // A step in which nothing lands changes nothing, whatever the last one has left in the list.
        with.step(&gpu, &[]);
        assert!(with.surface(&gpu) == want, "{count}");
    }
}

/// A drop brings its volume, and its momentum moves water outwards and none in: the second moment of the rise is that of
/// H V v laplace(b), 4 H V v.
#[test]
fn a_drop_brings_its_volume_and_moves_as_much_water_as_its_momentum_does() {
    let gpu = gpu();
    let (pool, _) = pool(&gpu, &HIT, 4, false);
    let (at, speed_mps) = (vec2(0.4, -0.7), 9.0);
    let drop = Impact { at_m: vec3(at.x, 0.0, at.y), impulse_mps: speed_mps, ..Impact::default() };
    pool.step(&gpu, &[drop]);
    let (heights, speeds) = pool.surface(&gpu);
    let column_m2 = CELL_M * CELL_M;
    let volume: f64 = wet(&heights).iter().sum::<f64>() * column_m2;
    assert!((volume / HIT.volume_m3 - 1.0).abs() < 1e-5, "{volume} m3");
    let size: f64 = speeds.iter().map(|&it| f64::from(it).abs()).sum::<f64>() * column_m2;
    let flow: f64 = speeds.iter().map(|&it| f64::from(it)).sum::<f64>() * column_m2;
    assert!(flow.abs() < 1e-6 * size, "{flow} of {size} m3/s");
    let moment: f64 = (0..speeds.len() as u32)
        .map(|i| {
            let c =
                (uvec2(i % CELLS.x, i / CELLS.x).as_dvec2() + 0.5) * CELL_M + vec2(-12.0, -10.0).as_dvec2();
            f64::from(speeds[i as usize]) * (c - at.as_dvec2()).length_squared() * column_m2
        })
        .sum();
    let want = 4.0 * DEPTH_M * HIT.volume_m3 * f64::from(speed_mps);
    println!("moment {moment} m5/s, {want}");
    assert!((moment / want - 1.0).abs() < 1e-3, "{moment} and {want}");
    // It sinks under the drop and rises round it.
    let column = |x: f32, z: f32| {
        let c = ((vec2(x, z) + vec2(12.0, 10.0)) / CELL_M as f32).as_uvec2();
        speeds[(c.y * CELLS.x + c.x) as usize]
    };
    assert!(column(at.x, at.y) < 0.0 && column(at.x + 1.5, at.y) > 0.0);
    assert!(to_f32(&wet(&heights)).iter().all(|&h| h >= 0.0));
}

/// A drop that is too fast for the water is refused whole: half of it would bring water from nowhere.
#[test]
fn a_drop_that_is_absurd_is_refused_with_both_its_bells() {
    let gpu = gpu();
    let (pool, _) = pool(&gpu, &HIT, 4, false);
    let of =
        |speed_mps: f32| Impact { at_m: vec3(1.0, 0.0, 1.0), impulse_mps: speed_mps, ..Impact::default() };
    // The inner bell alone is beyond 10 m/s, as its push is 16/3 H V v / r^2 on pi r^2 / 3.
    let (fast, none) = (of(1500.0), of(f32::INFINITY));
    for (drop, applied, rejected) in [(fast, 0, 2), (none, 0, 4), (of(100.0), 2, 4)] {
        pool.step(&gpu, &[drop]);
        let counts = pool.splashing.list().counts().unwrap();
        assert_eq!((counts.applied, counts.rejected), (applied, rejected), "{drop:?}");
        let (_, speeds) = pool.surface(&gpu);
        assert_eq!(speeds.iter().any(|&it| it != 0.0), applied > 0, "{drop:?}");
        let items = pool.splashing.download().unwrap();
        let outer = f64::from(items[1].push_m3ps) * 3.0 / (4.0 * std::f64::consts::PI);
        assert!(drop != fast || outer < 10.0, "the outer one alone would not be refused: {outer} m/s");
    }
}

/// Bells know nothing of what lies between: by a shore a drop brings its volume, and moves nothing to the other side. Where no
/// land is in reach it pushes, and no water comes or goes by that.
#[test]
fn a_drop_by_the_shore_keeps_its_volume_and_pushes_nothing_through_it() {
    let gpu = gpu();
    // West of the island, whose first column is 20.
    for (column, pushes) in [(19.5, false), (20.0 - 2.0 * HIT.radius_m / CELL_M - 1.1, true)] {
        let (pool, _) = pool(&gpu, &HIT, 4, true);
        let x = (-12.0 + column * CELL_M) as f32;
        let drop = Impact { at_m: vec3(x, 0.0, -3.0), impulse_mps: 3.0, ..Impact::default() };
        pool.step(&gpu, &[drop]);
        let (heights, speeds) = pool.surface(&gpu);
        let sum = |all: &[f64]| all.iter().sum::<f64>() * CELL_M * CELL_M;
        let wide: Vec<f64> = speeds.iter().map(|&it| it.into()).collect();
        let size: f64 = wide.iter().map(|it| it.abs()).sum::<f64>() * CELL_M * CELL_M;
        assert!((sum(&wet(&heights)) / HIT.volume_m3 - 1.0).abs() < 1e-5);
        assert!((size > 0.0) == pushes && sum(&wide).abs() <= 1e-6 * size, "{column}: {size} moved");
        let counts: Counts = pool.splashing.list().counts().unwrap();
        assert_eq!((counts.applied, counts.missed), (2, 0));
        let all: Vec<Disturbance> = pool.splashing.download().unwrap();
        assert!(all[0].scale > 0.0 && all[1].radius_m == 2.0 * all[0].radius_m);
    }
}
