// SPDX-License-Identifier: MIT OR Apache-2.0
//! The pool: births, ends, order, counts.

use crate::common::{gpu, TestGpu};
use glam::{vec3, Vec3};
use whitecap::{
    particles::{
        compile_law, cpu, Compaction, Drag, Emitter, Law, Layout, Options, Particle, Particles, Pool,
        PoolInfo, Snapshot, Step, Thrown, Tuning, TICKS_PER_S,
    },
    random,
};

const DRAG: Drag = Drag { pull_mps2: vec3(0.3, -9.81, 0.1), drag_per_s: 0.7 };
const TUNING: Tuning = Tuning { group: 64, items: 4, gathers: true };
const DT_S: f64 = 1.0 / 60.0;

fn emitters() -> Vec<Emitter> {
    let one = Emitter {
        at_m: vec3(-50.0, 10.0, 0.5),
        velocity_mps: vec3(1.0, 0.0, -2.0),
        speed_mps: 5.0,
        rate_per_s: 7013.7,
        thrown: Thrown::Singly,
    };
    let other = Emitter { rate_per_s: 3300.0, thrown: Thrown::Corners, at_m: Vec3::ZERO, ..one };
    vec![one, other, Emitter { rate_per_s: 0.0, ..one }]
}

fn info(emitters: &[Emitter], capacity: u32, life_s: f64) -> PoolInfo<'_> {
    PoolInfo { capacity, life_s, seed: 7, start: 0, emitters, law: bytemuck::bytes_of(&DRAG) }
}

fn options(compaction: Compaction) -> Options {
    Options { compaction, layout: Layout::Planes, tuning: TUNING }
}

fn pool(gpu: &TestGpu, options: Options, info: &PoolInfo<'_>) -> Pool {
    Particles::new(gpu, &Drag::LAW, options).unwrap().pool(info).unwrap()
}

fn twin(info: &PoolInfo<'_>) -> cpu::Pool {
    cpu::Pool::new(info)
}

fn law(it: &mut Particle, dt_s: f32) -> bool {
    cpu::drag(&DRAG, it, dt_s)
}

fn run(gpu: &TestGpu, pool: &mut Pool, steps: impl Iterator<Item = Step>) {
    gpu.once(|rec| {
        for step in steps {
            pool.record(rec, &step);
            rec.barrier(Particles::EXIT, Particles::ENTRY);
        }
    })
    .unwrap();
}

fn steps(range: std::ops::Range<u64>) -> impl Iterator<Item = Step> {
    range.map(|i| Step::nth(i, DT_S))
}

fn assert_same(gpu: &TestGpu, got: &[Particle], want: &[Particle]) {
    assert_eq!(got.len(), want.len());
    for (i, (a, b)) in got.iter().zip(want).enumerate() {
        assert_eq!(a.born, b.born, "{i}: {a:?} {b:?}");
        if gpu.is_exact() {
            assert!(bytemuck::bytes_of(a) == bytemuck::bytes_of(b), "{i}: {a:?} {b:?}");
        }
        assert!((a.at_m - b.at_m).length() < 1e-4 && (a.velocity_mps - b.velocity_mps).length() < 1e-4);
    }
}

fn tally(pool: &Pool) -> cpu::Tally {
    let counts = pool.counts().unwrap();
    cpu::Tally {
        born: counts.born,
        dropped: counts.dropped,
        aged: counts.aged,
        ended: counts.ended,
        spoiled: counts.spoiled,
    }
}

#[test]
fn a_stable_pool_is_its_twin_slot_by_slot() {
    let gpu = gpu();
    for (group, items, gathers) in [
        (64, 4, true),
        (64, 4, false),
        (32, 1, true),
        (32, 8, true),
        (128, 2, true),
        (128, 4, true),
        (256, 4, true),
    ] {
        let emitters = emitters();
        let info = info(&emitters, 2500, 0.3);
        let tuning = Tuning { group, items, gathers };
        let mut pool = pool(&gpu, Options { tuning, ..options(Compaction::Stable) }, &info);
        let mut twin = twin(&info);
        for part in 0..6 {
            run(&gpu, &mut pool, steps(7 * part..7 * part + 7));
            steps(7 * part..7 * part + 7).for_each(|step| twin.step(&step, &law));
            let (slots, state) = pool.download().unwrap();
            assert_eq!(tally(&pool), twin.tally, "{tuning:?}");
            assert_eq!((state.slots, state.now), (twin.slots.len() as u32, twin.now));
            assert_same(&gpu, &slots, &twin.slots);
        }
        assert!(twin.tally.dropped > 100 && twin.tally.aged > 1000, "{:?}", twin.tally);
    }
}

/// Order is the scheduler's there: as sets.
fn sorted(mut particles: Vec<Particle>) -> Vec<Particle> {
    particles.sort_by_key(|it| (it.born, it.velocity_mps.to_array().map(f32::to_bits)));
    particles
}

#[test]
fn every_compaction_and_layout_keeps_the_same_particles() {
    let gpu = gpu();
    let emitters = emitters();
    let info = info(&emitters, 2560, 0.3);
    let mut twin = twin(&info);
    steps(0..40).for_each(|step| twin.step(&step, &law));
    let want = sorted(twin.living());
    use Compaction::{Atomic, Group, InPlace, Ring, Stable, Subgroup};
    for compaction in [Stable, Group, Subgroup, Atomic, InPlace, Ring] {
        for layout in [Layout::Planes, Layout::Records] {
            let mut pool = pool(&gpu, Options { layout, ..options(compaction) }, &info);
            run(&gpu, &mut pool, steps(0..40));
            // A ring frees whole tiles only, so that more births find no room: its survivors are some of the twin's.
            if compaction == Ring {
                let got = sorted(pool.living().unwrap());
                assert!(got.len() > want.len() / 2 && tally(&pool).born < twin.tally.born);
                continue;
            }
            assert_eq!(tally(&pool), twin.tally, "{compaction:?} {layout:?}");
            assert_same(&gpu, &sorted(pool.living().unwrap()), &want);
        }
    }
}

/// Room for all: a ring is then its twin, and whoever is overtaken by the beginning has ended.
#[test]
fn a_ring_with_room_loses_nobody() {
    let gpu = gpu();
    let emitters = emitters();
    let info = info(&emitters, 5120, 0.3);
    let (mut pool, mut twin) = (pool(&gpu, options(Compaction::Ring), &info), twin(&info));
    run(&gpu, &mut pool, steps(0..90)); // three rounds
    steps(0..90).for_each(|step| twin.step(&step, &law));
    assert_eq!(tally(&pool), twin.tally);
    assert_eq!(twin.tally.dropped, 0);
    assert_same(&gpu, &sorted(pool.living().unwrap()), &sorted(twin.living()));
}

/// Positions in full, velocities to half a unit of 11 bits, births to 2^-6 s: after 18 steps each of which rounds the
/// velocity of up to 8 m/s by at most 2^-9 m/s, positions differ by less than 18 * 18 / 2 * DT * 2^-9 = 5.3 mm.
#[test]
fn packed_particles_are_as_far_off_as_their_rounding() {
    let gpu = gpu();
    let emitters = &emitters()[..1];
    let info = info(emitters, 4000, 0.5);
    let mut pool = pool(&gpu, Options { layout: Layout::Packed, ..options(Compaction::Stable) }, &info);
    let mut twin = twin(&info);
    run(&gpu, &mut pool, steps(0..18));
    steps(0..18).for_each(|step| twin.step(&step, &law));
    let (got, want) = (pool.living().unwrap(), twin.living());
    assert_eq!(got.len(), want.len());
    let apart = |(a, b): (&Particle, &Particle)| (a.at_m - b.at_m).length();
    let worst = got.iter().zip(&want).map(apart).fold(0.0, f32::max);
    assert!((1e-6..5.3e-3).contains(&worst), "{worst}");
    assert!(got.iter().zip(&want).all(|(a, b)| b.born.wrapping_sub(a.born) < 1024));
}

#[test]
fn runs_repeat_to_the_bit_and_go_on_from_a_snapshot() {
    let gpu = gpu();
    let emitters = emitters();
    let info = info(&emitters, 2500, 0.3);
    let fresh = || pool(&gpu, options(Compaction::Stable), &info);
    let (mut one, mut other, mut resumed) = (fresh(), fresh(), fresh());
    run(&gpu, &mut one, steps(0..50));
    run(&gpu, &mut other, steps(0..25));
    resumed.restore(&other.snapshot().unwrap()).unwrap();
    run(&gpu, &mut other, steps(25..50));
    run(&gpu, &mut resumed, steps(25..50));
    let [one, other, resumed] = [one, other, resumed].map(|it| it.snapshot().unwrap());
    // Slots that are out of use hold what earlier steps left there.
    let in_use = |it: &Snapshot| -> Vec<u32> {
        let (slots, stride) = (it.state[3] as usize, it.state[17] as usize);
        let planes = it.particles.chunks(stride).flat_map(|plane| &plane[..slots]);
        planes.chain(&it.state).chain(&it.births).copied().collect()
    };
    assert!(one.state[3] > 2000);
    assert!(in_use(&one) == in_use(&other), "two runs differ");
    assert!(in_use(&one) == in_use(&resumed), "a run that was resumed differs");
    // Control: another seed is another run.
    let mut third = pool(&gpu, options(Compaction::Stable), &PoolInfo { seed: 8, ..info });
    run(&gpu, &mut third, steps(0..50));
    assert!(in_use(&one) != in_use(&third.snapshot().unwrap()));
}

/// Frames from 15 to 1000 a second, even and uneven: as many births as the time holds periods, and all at their times.
#[test]
fn births_do_not_depend_on_the_steps() {
    let gpu = gpu();
    let still = Drag { pull_mps2: Vec3::ZERO, drag_per_s: 0.0 };
    let emitters = [Emitter { velocity_mps: Vec3::ZERO, rate_per_s: 480.7, ..emitters()[0] }];
    let run_at = |tick_of: &dyn Fn(u32) -> u32| {
        let info = PoolInfo { law: bytemuck::bytes_of(&still), ..info(&emitters, 1000, 10.0) };
        let mut pool = pool(&gpu, options(Compaction::Stable), &info);
        let ticks: Vec<u32> =
            (0..).map(tick_of).take_while(|&tick| tick < TICKS_PER_S).chain([TICKS_PER_S]).collect();
        run(&gpu, &mut pool, ticks.windows(2).map(|it| Step::between(it[0], it[1])));
        pool.living().unwrap()
    };
    let births = |all: &[Particle]| all.iter().map(|it| it.born).collect::<Vec<_>>();
    let period = f64::from(TICKS_PER_S) / 480.7;
    let exact: Vec<u32> = (1..=480).map(|n| (f64::from(n) * period).floor() as u32).collect();
    for hz in [15.0, 24.0, 60.0, 144.0, 1000.0] {
        let all = run_at(&|i| (f64::from(i) * f64::from(TICKS_PER_S) / hz) as u32);
        assert_eq!(births(&all), exact, "{hz} Hz");
        // As far from the emitter as they have had time for at 5 m/s: a rounding of numbers of 64 a step.
        for (it, n) in all.iter().zip(1..) {
            let far = 5.0 * (1.0 - f64::from(n) / 480.7);
            let apart = (it.at_m - vec3(-50.0, 10.0, 0.5)).as_dvec3().length() - far;
            assert!(apart.abs() < 4e-6 * hz.max(10.0), "{hz} Hz, {n}: {apart:e}");
        }
    }
    let jitter = |i: u32| if i == 0 { 0 } else { i * 1092 + random::bits(1, 2, i, 3)[0] % 1000 };
    assert_eq!(births(&run_at(&jitter)), exact);
    // Control: births by the frame, as the book has them, depend on it; the comparison sees that.
    let by_frame = |hz: u32| (1..=hz).map(|i| i * TICKS_PER_S / hz).collect::<Vec<_>>();
    assert_ne!(by_frame(60), by_frame(144));
    assert_ne!(by_frame(480), exact);
}

#[test]
fn births_spread_within_their_step() {
    let gpu = gpu();
    let still = Drag { pull_mps2: Vec3::ZERO, drag_per_s: 0.0 };
    // Thrown by a moving emitter against its motion, they would stay where they are born: 1000 a second at 10 m/s.
    let emitters = [Emitter {
        speed_mps: 10.0,
        velocity_mps: Vec3::ZERO,
        rate_per_s: 1000.0,
        at_m: Vec3::ZERO,
        ..emitters()[0]
    }];
    let info = PoolInfo { law: bytemuck::bytes_of(&still), ..info(&emitters, 1000, 10.0) };
    let mut pool = pool(&gpu, options(Compaction::Stable), &info);
    run(&gpu, &mut pool, std::iter::once(Step::between(0, TICKS_PER_S / 20 + 1))); // 50 ms: 50 births
    let living = pool.living().unwrap();
    assert_eq!(living.len(), 50);
    for (n, it) in living.iter().enumerate() {
        // 10 mm apart, to 1 %.
        let want = 10.0 * (3277.0 / 65536.0 - (n as f32 + 1.0) * 1e-3);
        assert!((it.at_m.length() - want).abs() < 1e-4, "{n}: {} {want}", it.at_m.length());
    }
}

#[test]
fn directions_are_even_and_corners_are_cubes() {
    let gpu = gpu();
    let still = Drag { pull_mps2: Vec3::ZERO, drag_per_s: 0.0 };
    for thrown in [Thrown::Singly, Thrown::Corners] {
        let emitters = [Emitter { velocity_mps: Vec3::ZERO, rate_per_s: 32768.0, thrown, ..emitters()[0] }];
        let info = PoolInfo { law: bytemuck::bytes_of(&still), ..info(&emitters, 40_000, 100.0) };
        let mut pool = pool(&gpu, options(Compaction::Stable), &info);
        run(&gpu, &mut pool, (0..20).map(|i| Step::between(i * 3277, (i + 1) * 3277)));
        let velocities: Vec<Vec3> = pool.living().unwrap().iter().map(|it| it.velocity_mps).collect();
        assert!(velocities.len() >= 32_760, "{}", velocities.len());
        assert!(velocities.iter().all(|v| (v.length() - 5.0).abs() < 5e-6));
        if thrown == Thrown::Corners {
            let chunks = velocities.chunks_exact(8);
            assert!(chunks.clone().all(|eight| eight.iter().sum::<Vec3>().length() < 2e-5));
            assert!(chunks.clone().all(|eight| (eight[0].dot(eight[1]) - 25.0 / 3.0).abs() < 1e-4));
        }
        // Heights on a sphere are uniform along every axis: chi-square of 31 degrees below its 99.9 % point (61.1). Eight
        // corners of a cube are one draw, so theirs counts eight times: its mean is 8 times larger at the most.
        for axis in [Vec3::X, Vec3::Y, Vec3::Z, vec3(1.0, 1.0, 1.0).normalize()] {
            let mut bins = [0u32; 32];
            velocities.iter().for_each(|v| bins[((v.dot(axis) / 5.0 + 1.0) * 15.999) as usize] += 1);
            let even = velocities.len() as f64 / 32.0;
            let chi: f64 = bins.iter().map(|&n| (f64::from(n) - even).powi(2) / even).sum();
            let limit = if thrown == Thrown::Singly { 61.1 } else { 8.0 * 61.1 };
            assert!(chi < limit, "{thrown:?} {axis}: {chi}");
        }
    }
}

#[test]
fn lives_end_on_their_tick() {
    let gpu = gpu();
    // 0.3 s are 18 steps of 1/60 s but for a rounding; 0.25 s end within a step.
    for life_s in [0.3, 0.25, 0.2 + 1.0 / 65536.0] {
        let emitters = emitters();
        let info = info(&emitters, 6000, life_s);
        let mut pool = pool(&gpu, options(Compaction::Stable), &info);
        for part in 0..12 {
            run(&gpu, &mut pool, steps(5 * part..5 * part + 5));
            // Births up to now, less births up to a life ago: exact integers.
            let ticks = u64::from(pool.now());
            let life = u64::from(pool.life_ticks());
            let thrown_by = |tick: u64| -> u64 {
                let of = |it: &Emitter| match it.period() {
                    0 => 0,
                    // Whole ticks: born = floor(n period), so n period < tick + 1.
                    period => u64::from(it.batch()) * (((tick + 1) << 32).saturating_sub(1) / period),
                };
                emitters.iter().map(of).sum()
            };
            let by_now: u64 = emitters
                .iter()
                .map(|it| match it.period() {
                    0 => 0,
                    period => u64::from(it.batch()) * ((ticks << 32) / period),
                })
                .sum();
            let gone = if ticks >= life { thrown_by(ticks - life) } else { 0 };
            let counts = pool.counts().unwrap();
            assert_eq!((counts.born, counts.aged), (by_now, gone), "{life_s} s, tick {ticks}");
            assert_eq!(pool.living().unwrap().len() as u64, counts.alive());
        }
    }
}

#[test]
fn ten_times_more_births_than_room_are_dropped_and_counted() {
    let gpu = gpu();
    for compaction in [Compaction::Stable, Compaction::Group, Compaction::Atomic, Compaction::InPlace] {
        for capacity in [1, 2, 31, 32, 33, 255, 256, 257, 1000] {
            let emitters = [Emitter { rate_per_s: 10.0 * f64::from(capacity) / 0.1, ..emitters()[0] }];
            let info = info(&emitters, capacity, 0.1);
            let (mut pool, mut twin) = (pool(&gpu, options(compaction), &info), twin(&info));
            run(&gpu, &mut pool, steps(0..30));
            steps(0..30).for_each(|step| twin.step(&step, &law));
            assert_eq!(tally(&pool), twin.tally, "{compaction:?}, {capacity}");
            assert!(twin.tally.dropped > 5 * twin.tally.born);
            // Free slots are a queue in a ring: where it begins is a place there, not a count of births, which would wrap.
            let state = pool.download().unwrap().1;
            assert!(state.free_first < 2 * capacity, "{compaction:?}, {capacity}: {}", state.free_first);
            let mut snapshot = pool.snapshot().unwrap();
            assert_eq!(snapshot.trespasses(capacity), 0, "{compaction:?}, {capacity}");
            // Control: one word too far is seen.
            snapshot.particles[capacity as usize] ^= 1;
            *snapshot.places.last_mut().unwrap() = 0;
            assert_eq!(snapshot.trespasses(capacity), 2);
            assert_eq!(pool.living().unwrap().len() as u32, capacity);
        }
    }
}

#[test]
fn what_is_no_number_is_counted_and_never_stored() {
    let gpu = gpu();
    let emitters = emitters();
    let huge = Drag { pull_mps2: vec3(0.0, f32::MAX, 0.0), drag_per_s: 0.0 };
    let info = PoolInfo { law: bytemuck::bytes_of(&huge), ..info(&emitters, 2500, 10.0) };
    let mut pool = pool(&gpu, options(Compaction::Stable), &info);
    let particle =
        |i: u32| Particle { at_m: Vec3::splat(i as f32), velocity_mps: vec3(0.0, 3e38, 0.0), born: 0 };
    pool.upload(&(0..100).map(particle).collect::<Vec<_>>()).unwrap();
    run(&gpu, &mut pool, (0..3).map(|i| Step::between(i * 60000, (i + 1) * 60000)));
    let counts = pool.counts().unwrap();
    assert!(counts.spoiled >= 100, "{counts:?}");
    assert_eq!(counts.ended, 0);
    let (slots, _) = pool.download().unwrap();
    assert!(slots.iter().all(|it| it.at_m.is_finite() && it.velocity_mps.is_finite()));
    assert_eq!(pool.living().unwrap().len() as u64, counts.alive());
}

#[test]
fn a_pool_uploaded_goes_on_as_its_twin() {
    let gpu = gpu();
    for count in [0, 1, 255, 256, 257, 2500] {
        let info = info(&[], 2500, 0.3);
        let (mut pool, mut twin) = (pool(&gpu, options(Compaction::Stable), &info), twin(&info));
        let particle = |i: u32| {
            let [a, b, c, d] = random::units(random::bits(3, 1, i, 0));
            Particle {
                at_m: vec3(a, b, c),
                velocity_mps: vec3(b, c, d),
                born: 0u32.wrapping_sub((d * 19000.0) as u32),
            }
        };
        let start: Vec<Particle> = (0..count).map(particle).collect();
        pool.upload(&start).unwrap();
        twin.tally.born = u64::from(count);
        twin.slots = start;
        run(&gpu, &mut pool, steps(0..9));
        steps(0..9).for_each(|step| twin.step(&step, &law));
        assert_eq!(tally(&pool), twin.tally);
        assert_same(&gpu, &pool.download().unwrap().0, &twin.slots);
    }
}

#[test]
fn the_twin_of_drag_is_exact() {
    let start = (vec3(1.0, 2.0, 3.0), vec3(-4.0, 5.0, 6.0));
    for drag_per_s in [0.0, 1e-4, 0.1, 0.49, 0.51, 3.0, 40.0] {
        let law = Drag { drag_per_s, ..DRAG };
        for dt_s in [1e-4, 1.0 / 60.0, 0.2, 1.0] {
            let mut it = Particle { at_m: start.0, velocity_mps: start.1, born: 0 };
            cpu::drag(&law, &mut it, dt_s);
            let (at, velocity) =
                cpu::drag_exactly(&law, start.0.as_dvec3(), start.1.as_dvec3(), f64::from(dt_s));
            // Some roundings of numbers of up to 20.
            assert!((it.at_m.as_dvec3() - at).length() < 5e-6, "{law:?} {dt_s}: {} {at}", it.at_m);
            assert!((it.velocity_mps.as_dvec3() - velocity).length() < 5e-6, "{law:?} {dt_s}");
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_with_the_limit() {
    let gpu = gpu();
    let particles = Particles::new(&gpu, &Drag::LAW, options(Compaction::Stable)).unwrap();
    let most = gpu.limits().max_storage_buffer_range / 28 / 32 * 32 - 1;
    let emitters = emitters();
    let message = |info: PoolInfo<'_>| particles.pool(&info).map(drop).unwrap_err().to_string();
    let fair = info(&emitters, 1000, 1.0);
    assert!(
        message(PoolInfo { capacity: 0, ..fair }).contains(&format!("capacity = 0: allowed is 1 to {most}"))
    );
    assert!(message(PoolInfo { capacity: most + 1, ..fair }).contains(&format!("1 to {most}")));
    assert!(message(PoolInfo { life_s: 0.0, ..fair }).contains("life_s = 0"));
    assert!(message(PoolInfo { life_s: f64::NAN, ..fair }).contains("life_s = NaN"));
    assert!(message(PoolInfo { law: &[], ..fair }).contains("law = 0 bytes"));
    let fast = [Emitter { rate_per_s: 2e9, ..emitters[0] }];
    assert!(message(PoolInfo { emitters: &fast, ..fair }).contains("rate_per_s = 2000000000"));
    let lost = [Emitter { at_m: vec3(f32::NAN, 0.0, 0.0), ..emitters[0] }];
    assert!(message(PoolInfo { emitters: &lost, ..fair }).contains("at_m"));
    particles.pool(&PoolInfo { capacity: 1, ..fair }).unwrap();
}

/// Blocks of 256 tiles of 32 slots: some 25 000 particles fill three and a part, and grow into them and shrink again.
#[test]
fn a_pool_of_several_blocks_is_its_twin() {
    let gpu = gpu();
    let tuning = Tuning { group: 32, items: 1, gathers: true };
    let emitters = [Emitter { rate_per_s: 80_000.0, ..emitters()[0] }];
    let info = info(&emitters, 30_000, 0.3);
    let mut pool = pool(&gpu, Options { tuning, ..options(Compaction::Stable) }, &info);
    let mut twin = twin(&info);
    let on = twin.emitters.clone();
    for part in 0..8 {
        let range = 12 * part..12 * part + 12;
        if part == 3 {
            twin.emitters[0].period_low = 0;
            twin.emitters[0].period_high = 0;
        }
        if part == 5 {
            assert!(twin.tally.born > 45_000 && twin.living().is_empty());
            twin.emitters = on.clone();
        }
        if part == 3 || part == 5 {
            // Off, and once all are gone on again: nobody is counted who was there before.
            let words = [twin.emitters.clone(), twin.emitters.clone()].concat();
            gpu.upload_to(pool.emitters(), &words).unwrap();
        }
        run(&gpu, &mut pool, steps(range.clone()));
        steps(range).for_each(|step| twin.step(&step, &law));
        assert_eq!(tally(&pool), twin.tally);
        assert_same(&gpu, &pool.download().unwrap().0, &twin.slots);
    }
    assert!(twin.tally.born > 90_000 && twin.living().len() > 20_000);
}

const HOLE: &str =
    "layout(set = 0, binding = LAW_BINDING, std430) readonly buffer Law { vec4 hole; };  // (m), radius
bool advance(inout Particle it, float dt_s) {
    precise vec3 at = it.at_m + it.velocity_mps * dt_s;
    it.at_m = at;
    return distance(at, hole.xyz) > hole.w;
}
";

/// A user's own, from text: particles fly straight and end in a ball.
#[test]
fn a_law_compiled_at_run_time_ends_particles() {
    let gpu = gpu();
    let spv = compile_law(HOLE, "hole.glsl").unwrap();
    let own = Law {
        name: c"particles.hole",
        spv: &spv,
        subgroups: None,
        deferred: None,
        constants: &[],
        blocks: &[],
    };
    let emitters = [Emitter { at_m: Vec3::ZERO, velocity_mps: Vec3::ZERO, ..emitters()[0] }];
    // Everyone begins within the ball, and at 5 m/s is out of it after 0.1 s; nobody lasts so long.
    let hole = [0.0f32, 0.0, 0.0, 0.5];
    for compaction in [Compaction::Stable, Compaction::Group, Compaction::InPlace, Compaction::Ring] {
        let info = PoolInfo { law: bytemuck::bytes_of(&hole), ..info(&emitters, 2560, 10.0) };
        let mut pool = Particles::new(&gpu, &own, options(compaction)).unwrap().pool(&info).unwrap();
        run(&gpu, &mut pool, steps(0..40));
        let counts = pool.counts().unwrap();
        assert!(counts.ended > 4000 && counts.ended == counts.born, "{compaction:?} {counts:?}");
        assert_eq!(pool.living().unwrap().len(), 0);
        let (slots, _) = pool.download().unwrap();
        assert!(slots.iter().all(|it| it.velocity_mps.is_finite()));
    }
    let twin_law = |it: &mut Particle, dt_s: f32| {
        it.at_m += it.velocity_mps * dt_s;
        it.at_m.x.mul_add(it.at_m.x, it.at_m.y * it.at_m.y + it.at_m.z * it.at_m.z).sqrt() > 3.0
    };
    // A ball that lets some go: those born outside of it, of an emitter on its rim.
    let hole = [0.0f32, 0.0, 0.0, 3.0];
    let emitters = [Emitter { at_m: vec3(3.0, 0.0, 0.0), ..emitters[0] }];
    let info = PoolInfo { law: bytemuck::bytes_of(&hole), ..info(&emitters, 2560, 0.2) };
    let mut pool = Particles::new(&gpu, &own, options(Compaction::Stable)).unwrap().pool(&info).unwrap();
    let mut twin = twin(&info);
    run(&gpu, &mut pool, steps(0..40));
    steps(0..40).for_each(|step| twin.step(&step, &twin_law));
    let apart = tally(&pool).ended.abs_diff(twin.tally.ended);
    // Who grazes the rim is decided by a rounding.
    assert!(
        apart < 3 && twin.tally.ended > 1000 && twin.tally.aged > 1000,
        "{:?} {:?}",
        tally(&pool),
        twin.tally
    );
    let error =
        compile_law("bool advance(inout Particle it, float dt_s) {\n    return tru;\n}\n", "mine.glsl")
            .unwrap_err();
    assert!(error.log.contains("mine.glsl:2"), "{}", error.log);
}

#[test]
fn steps_without_a_barrier_are_seen() {
    let gpu = gpu();
    if !crate::common::validates() {
        println!("SKIP: no validation in this pass");
        return;
    }
    let emitters = emitters();
    let mut pool = pool(&gpu, options(Compaction::Stable), &info(&emitters, 1000, 1.0));
    gpu.once(|rec| {
        steps(0..2).for_each(|step| pool.record(rec, &step));
    })
    .unwrap();
    gpu.expect_message("SYNC-HAZARD-");
}
