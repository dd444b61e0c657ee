// SPDX-License-Identifier: MIT OR Apache-2.0
//! Effects that impacts throw: the ring against its twin, whatever the order of impacts, and particles against theirs.

use super::{hills, ulps, SEED, STREAM};
use crate::common::{gpu, TestGpu};
use glam::{vec3, DVec3, Vec3};
use std::mem::{offset_of, size_of};
use whitecap::{
    ballistic::{
        cpu::{self, Struck},
        cpu_kindled::Kept,
        kindled::{KindleParams, KindledVertices, Kindling, KindlingInfo, Ring, Strike},
        Builtin, Effect, Ground, GroundGrid, Moment, Params, Vertex,
    },
    gpu::{compiler, glsl::Stage, reflect::reflect, Access},
    impact::{Count, Impact, Stream, NO_MESH},
    random, shaders,
};

const CAPACITY: u32 = 4096;

/// A stream, and who takes births from it.
struct Bench<'a> {
    gpu: &'a TestGpu,
    stream: Stream,
    kindling: Kindling,
}

fn bench<'a>(gpu: &'a TestGpu, info: &KindlingInfo) -> Bench<'a> {
    let stream = Stream::new(gpu, CAPACITY).unwrap();
    let kindling = Kindling::new(gpu, &stream, info).unwrap();
    Bench { gpu, stream, kindling }
}

impl Bench<'_> {
    /// A step that ends at `now`, as those who collide would have left it.
    fn step(&self, impacts: &[Impact], now: Moment) {
        let mut all = impacts.to_vec();
        all.resize(CAPACITY as usize, Impact { impulse_mps: 1e9, ..Impact::default() });
        self.gpu.upload_to(self.stream.impacts(), &all).unwrap();
        let count = Count { appended: impacts.len() as u32, ..self.stream.counts().unwrap() };
        self.gpu.upload_to(self.stream.count(), &[count]).unwrap();
        self.gpu
            .once(|rec| {
                self.stream.record_begin(rec);
                self.stream.record_end(rec);
                self.kindling.record(rec, now);
            })
            .unwrap();
    }

    /// Who lives at `now`, and a vertex each.
    fn look(&self, vertices: &KindledVertices, params: &Params, now: Moment) -> Vec<Vertex> {
        self.gpu
            .once(|rec| {
                rec.fill(vertices.buffer(), 0x7777_7777);
                rec.barrier(Access::FillWrite, Access::ComputeWrite);
                self.kindling.record_living(rec, now);
                vertices.record(rec, params);
            })
            .unwrap();
        let ring = self.kindling.counts().unwrap();
        let all: Vec<Vertex> = self.gpu.download(vertices.buffer()).unwrap();
        let count = (ring.living * params.burst) as usize;
        assert_eq!((ring.quad_vertices, ring.points), (6 * count as u32, count as u32));
        let untouched = |vertex: &&Vertex| bytemuck::bytes_of(*vertex).iter().all(|byte| *byte == 0x77);
        assert_eq!(all[count..].iter().filter(untouched).count(), all.len() - count);
        all[..count].to_vec()
    }

    fn same_as(&self, kept: &Kept) {
        let (ring, strikes) = self.kindling.download().unwrap();
        assert_eq!(kept.strikes, strikes);
        let counts = (ring.births(), ring.overwritten(), ring.lost());
        assert_eq!(counts, (kept.births, kept.overwritten, kept.lost));
    }
}

fn unit(i: u32, of: u32) -> f32 {
    random::units(random::bits(9, of, i, 0))[0]
}

/// Number `i` of step `step`, of three sources and five meshes, some of them no mesh.
fn impact(step: u32, i: u32) -> Impact {
    let n = step * 1000 + i;
    let mesh = (6.0 * unit(n, 4)) as u32;
    Impact {
        at_m: vec3(unit(n, 0), unit(n, 1), unit(n, 2)),
        order: i,
        normal: random::direction_of([unit(n, 5), unit(n, 6)]),
        impulse_mps: 4.0 * unit(n, 3),
        velocity_mps: 9.0 * random::direction_of([unit(n, 7), unit(n, 8)]),
        mesh: if mesh == 5 { NO_MESH } else { mesh },
        source: (4.0 * unit(n, 9)) as u32,
        ..Impact::default()
    }
}

fn shuffled(mut impacts: Vec<Impact>, by: u32) -> Vec<Impact> {
    impacts.sort_by_key(|it| random::bits(by, it.source, it.order, 1)[0]);
    impacts
}

fn info(most: u32, burst: u32, life_s: f64) -> KindlingInfo {
    let (sources, meshes) = (vec![400, 0, 900], Vec::new());
    KindlingInfo { most, burst, life_s, least_impulse_mps: 1.0, sources, meshes }
}

fn ring_of(effect: &Effect, most: u32) -> KindlingInfo {
    KindlingInfo { sources: vec![64], least_impulse_mps: 0.0, ..info(most, effect.burst, effect.life_s) }
}

const KINDLED: [(Builtin, &[u8]); 2] = [
    (Builtin::Sparks, shaders::BALLISTIC_SPARKS_KINDLED_COMP),
    (Builtin::Dust, shaders::BALLISTIC_DUST_KINDLED_COMP),
];

#[test]
fn one_impact_throws_the_particles_of_its_twin_and_no_others() {
    let gpu = gpu();
    for (builtin, spv) in KINDLED {
        let effect = Effect { burst: 37, ..builtin.effect() };
        let info = ring_of(&effect, 8);
        let bench = bench(&gpu, &info);
        let vertices = bench.kindling.vertices(c"ballistic.kindled", spv, None).unwrap();
        let params = effect.kindled_params(SEED, STREAM, &GroundGrid::FLAT, info.most);
        let mut kept = Kept::new(&info);
        // Late in the day, and against a ceiling as well.
        for (at_s, normal) in [(0.25, vec3(0.6, 0.0, 0.8)), (40_000.7, vec3(0.0, -1.0, 0.0))] {
            let struck = [Impact {
                at_m: vec3(-2.0, 1.5, 0.25),
                normal,
                impulse_mps: 30.0,
                velocity_mps: vec3(1.0, -2.0, 3.0) - 30.0 * normal,
                ..Impact::default()
            }];
            let born = Moment::from_s(at_s);
            bench.step(&struck, born);
            kept.step(&struck, born);
            bench.same_as(&kept);
            let life = Moment::from_s(effect.life_s).ticks;
            for age in [0, 1, 1 << 20, life / 3, life - 1, life, 3 * life] {
                let now = Moment { ticks: born.ticks + age };
                let got = bench.look(&vertices, &params, now);
                assert_eq!(got.len(), if age < life { 37 } else { 0 }, "{builtin:?}, {age} ticks old");
                for (i, vertex) in got.iter().enumerate() {
                    let flight = kept.flight(builtin, &params, None, now, i as u32).unwrap();
                    if gpu.is_exact() {
                        let plain = |v: [f32; 3]| v.map(|x| (x + 0.0).to_bits());
                        assert_eq!(plain(vertex.at_m), plain(flight.at_m.to_array()), "{builtin:?} {i}");
                    }
                    assert!((Vec3::from(vertex.at_m) - flight.at_m).length() < 3e-6, "{builtin:?} {i}");
                    // And in f64, from the same birth and from the ticks.
                    let (strike, who) = kept.who(&params, now, i as u32);
                    let Strike { at_m, normal, velocity_mps, impulse_mps, .. } = *strike;
                    let struck = Struck { at_m, normal, velocity_mps, impulse_mps };
                    let start = cpu::birth_of(builtin, &params, who, &struck);
                    let want = cpu::position_f64(
                        start.at_m.as_dvec3(),
                        start.velocity_mps.as_dvec3(),
                        effect.acceleration_mps2.as_dvec3(),
                        Moment { ticks: age }.as_s(),
                        effect.drag_per_s.into(),
                    );
                    assert!(ulps(flight.at_m.to_array(), want) <= 4.0, "{builtin:?} {i}, {age} ticks old");
                    assert!(start.velocity_mps.dot(strike.normal) > 0.0, "{builtin:?} {i} goes in");
                }
            }
        }
    }
}

/// Snow thrown up over hills, by a shader that is compiled now, as that of a scene is.
#[test]
fn what_impacts_throw_ends_on_the_ground_as_by_the_twin() {
    let gpu = gpu();
    let effect = Effect { burst: 9, ..Builtin::Snow.effect() };
    let info = ring_of(&effect, 64);
    let bench = bench(&gpu, &info);
    let (grid, heights) = hills();
    let text = Builtin::Snow.file().1;
    let source = format!(
        "#version 460\n#extension GL_GOOGLE_include_directive : require\n#define KINDLED_BINDING 1\n\
         #define GROUND_BINDING 3\n#include \"ballistic/effect.glsl\"\n{text}\n\
         #include \"ballistic/materialise.glsl\"\n"
    );
    let words = compiler().unwrap().compile(&source, "snow.glsl", Stage::Compute).unwrap();
    let spv: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let buffer = gpu.upload("test.ground_m", &heights).unwrap();
    let vertices = bench.kindling.vertices(c"ballistic.snow_kindled", &spv, Some(&buffer)).unwrap();
    let params = effect.kindled_params(SEED, STREAM, &grid, info.most);
    let mut kept = Kept::new(&info);
    let hits: Vec<_> = (0..20).map(|i| Impact { source: 0, at_m: 6.0 * Vec3::Y, ..impact(1, i) }).collect();
    bench.step(&hits, Moment::from_s(1.0));
    kept.step(&hits, Moment::from_s(1.0));
    for at_s in [1.5, 5.0, 9.0] {
        let now = Moment::from_s(at_s);
        let got = bench.look(&vertices, &params, now);
        assert_eq!(got.len(), 180);
        let mut down = 0;
        for (i, vertex) in got.iter().enumerate() {
            let ground = Ground(&heights);
            let want = kept.flight(Builtin::Snow, &params, Some(&ground), now, i as u32).unwrap();
            down += u32::from(want.down_s >= 0.0);
            let apart = (Vec3::from(vertex.at_m) - want.at_m).length();
            assert!(apart <= if gpu.is_exact() { 0.0 } else { 3e-5 }, "{i} at {at_s} s: {apart}");
        }
        assert_eq!((down > 0, down == 180), (at_s > 4.0, at_s > 8.0), "{down} are down at {at_s} s");
    }
}

#[test]
fn serial_numbers_do_not_go_by_the_order_in_which_impacts_lie() {
    let gpu = gpu();
    for meshes in [Vec::new(), vec![false, true, true, false, true]] {
        let info = KindlingInfo { meshes, ..info(500, 2, 0.3) };
        let (mut kept, mut states) = (Kept::new(&info), Vec::new());
        for by in 0..3 {
            let bench = bench(&gpu, &info);
            for step in 0..24 {
                // None, few, many, and more than the ring holds.
                let count = [0, 3, 130, 999][step as usize % 4];
                let now = Moment::from_s(f64::from(step) / 30.0);
                let impacts = shuffled((0..count).map(|i| impact(step, i)).collect(), by);
                bench.step(&impacts, now);
                if by == 0 {
                    kept.step(&impacts, now);
                    bench.same_as(&kept);
                }
            }
            states.push(bench.kindling.state().unwrap());
        }
        let counts = (kept.births, kept.overwritten, kept.lost);
        assert!(kept.births > 500 && kept.lost > 0, "{counts:?}");
        assert_eq!(kept.overwritten > 0, info.meshes.is_empty(), "{counts:?}");
        assert!(states[1] == states[0] && states[2] == states[0], "rings differ");
    }
}

/// Impacts of a second in steps of 1/240 s, seen at three rates of pictures.
#[test]
fn nothing_is_lost_or_double_at_any_rate_of_pictures() {
    let gpu = gpu();
    let effect = Effect { burst: 3, life_s: 0.3, ..Builtin::Dust.effect() };
    let info = KindlingInfo { sources: vec![900; 4], ..ring_of(&effect, 1 << 12) };
    let params = effect.kindled_params(SEED, STREAM, &GroundGrid::FLAT, info.most);
    let end_of = |step: u32| Moment::of_frame(u64::from(step), 240);
    let of_step = |step: u32| (0..step % 11).map(move |i| impact(step, i)).collect::<Vec<_>>();
    let mut seen: Vec<Vec<Vec<Vertex>>> = Vec::new();
    for rate in [24, 60, 240] {
        let bench = bench(&gpu, &info);
        let vertices = bench.kindling.vertices(c"ballistic.kindled", KINDLED[1].1, None).unwrap();
        let mut twelfths = Vec::new();
        for step in 1..=240 {
            bench.step(&of_step(step), end_of(step));
            if step % (240 / rate) > 0 {
                continue;
            }
            let got = bench.look(&vertices, &params, end_of(step));
            let life = Moment::from_s(effect.life_s).ticks;
            let lives = |born: &u32| end_of(step).ticks - end_of(*born).ticks < life;
            let alive: u32 = (1..=step).filter(lives).map(|born| born % 11).sum();
            assert_eq!(got.len() as u32, 3 * alive, "{rate} pictures a second, step {step}");
            if step % 20 == 0 {
                twelfths.push(got);
            }
        }
        let births = bench.kindling.counts().unwrap();
        assert_eq!(births.births(), (1..=240).map(|step| step % 11).sum::<u64>());
        assert_eq!((births.overwritten(), births.lost()), (0, 0));
        seen.push(twelfths);
    }
    assert!(seen[0].iter().all(|picture| picture.len() > 100));
    assert!(seen[1] == seen[0] && seen[2] == seen[0], "pictures of one moment differ");
}

#[test]
fn what_lived_when_it_was_overwritten_is_counted() {
    let gpu = gpu();
    // Two steps of 30 into 50 slots: 10 are lost while they live, or none where the first are over.
    for (later_s, overwritten, living) in [(0.5, 10, 50), (1.0, 0, 30), (2.0, 0, 30)] {
        let info = KindlingInfo { sources: vec![900; 4], least_impulse_mps: 0.0, ..info(50, 1, 1.0) };
        let bench = bench(&gpu, &info);
        for (step, at_s) in [(0, 1.0), (1, 1.0 + later_s)] {
            bench.step(&(0..30).map(|i| impact(step, i)).collect::<Vec<_>>(), Moment::from_s(at_s));
        }
        bench.gpu.once(|rec| bench.kindling.record_living(rec, Moment::from_s(1.0 + later_s))).unwrap();
        let ring = bench.kindling.counts().unwrap();
        assert_eq!((ring.births(), ring.overwritten(), ring.living), (60, overwritten, living));
        // One step of more than the ring holds: the newest stay.
        let all: Vec<_> = (0..120).map(|i| impact(2, i)).collect();
        bench.step(&shuffled(all.clone(), 4), Moment::from_s(9.0));
        let (ring, strikes) = bench.kindling.download().unwrap();
        assert_eq!((ring.births(), ring.overwritten()), (180, overwritten + 70));
        // By source, then by order.
        let mut places: Vec<_> = all.iter().map(|it| (it.source, it.order, it.at_m)).collect();
        places.sort_by_key(|it| (it.0, it.1));
        let want: Vec<_> = places[70..].iter().map(|it| it.2).collect();
        assert_eq!(strikes.iter().map(|it| it.at_m).collect::<Vec<_>>(), want);
    }
}

#[test]
fn without_impacts_there_is_nothing_and_a_step_without_time_changes_no_age() {
    let gpu = gpu();
    let effect = Builtin::Sparks.effect();
    let info = ring_of(&effect, 64);
    let bench = bench(&gpu, &info);
    let vertices = bench.kindling.vertices(c"ballistic.kindled", KINDLED[0].1, None).unwrap();
    let params = effect.kindled_params(SEED, STREAM, &GroundGrid::FLAT, info.most);
    let start = Moment::default();
    assert!(bench.look(&vertices, &params, start).is_empty());
    bench.step(&[], start);
    // Too soft, of nobody, and of no number.
    let soft = |impulse_mps, source| Impact { impulse_mps, source, ..Impact::default() };
    bench.step(&[soft(-0.1, 0), soft(9.0, 1), soft(f32::NAN, 0)], start);
    let ring = bench.kindling.counts().unwrap();
    assert_eq!((ring.births(), ring.lost(), ring.slot, ring.step_births), (0, 0, 0, 0));
    assert!(bench.look(&vertices, &params, Moment::from_s(1.0)).is_empty());
    let ring = bench.kindling.counts().unwrap();
    assert_eq!((ring.quad_vertices, ring.groups_x, ring.splat_x), (0, 0, 0));
    // Two steps at one moment: all are there, at the places of their impacts, and again so.
    let now = Moment::from_s(2.0);
    let hit =
        |order| Impact { at_m: vec3(order as f32, 0.0, 1.0), order, normal: Vec3::Y, ..Impact::default() };
    bench.step(&[hit(0), hit(1)], now);
    bench.step(&[hit(2)], now);
    let first = bench.look(&vertices, &params, now);
    let places: Vec<_> = first.iter().map(|it| it.at_m).collect();
    assert_eq!(places, [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]]);
    assert_eq!(bench.look(&vertices, &params, now), first);
    // Before their births they are not seen.
    let before = bench.look(&vertices, &params, Moment::from_s(1.9));
    assert!(before.iter().all(|it| it.at_m == [0.0; 3] && it.look[..3] == [0; 3]), "{before:?}");
}

#[test]
fn serial_numbers_go_on_beyond_32_bits() {
    let gpu = gpu();
    let effect = Builtin::Sparks.effect();
    let info = ring_of(&effect, 16);
    let bench = bench(&gpu, &info);
    let vertices = bench.kindling.vertices(c"ballistic.kindled", KINDLED[0].1, None).unwrap();
    let params = effect.kindled_params(SEED, STREAM, &GroundGrid::FLAT, info.most);
    let late = Ring { next_low: u32::MAX - 2, overwritten_low: u32::MAX, ..bench.kindling.counts().unwrap() };
    bench.gpu.upload_to(bench.kindling.ring(), &[late]).unwrap();
    let mut kept = Kept::new(&info);
    kept.births = u64::from(u32::MAX - 2);
    let now = Moment::from_s(3.0);
    let hits: Vec<_> = (0..20).map(|order| Impact { order, normal: Vec3::X, ..Impact::default() }).collect();
    bench.step(&hits, now);
    kept.step(&hits, now);
    let ring = bench.kindling.counts().unwrap();
    assert_eq!((ring.births(), kept.births), ((1 << 32) + 17, (1 << 32) + 17));
    let later = Moment::from_s(3.5);
    let got = bench.look(&vertices, &params, later);
    assert_eq!(got.len(), 16);
    for (i, vertex) in got.iter().enumerate() {
        let (_, who) = kept.who(&params, later, i as u32);
        assert_eq!(who.serial, (1 << 32) + 1 + i as u64);
        let want = kept.flight(Builtin::Sparks, &params, None, later, i as u32).unwrap().at_m;
        assert!((Vec3::from(vertex.at_m) - want).length() < 3e-6, "{i}");
    }
}

#[test]
fn a_ring_goes_on_from_a_state_and_refuses_another() {
    let gpu = gpu();
    let info = KindlingInfo { sources: vec![900; 4], ..info(300, 1, 1.0) };
    let run = |bench: &Bench<'_>, steps: std::ops::Range<u32>| {
        for step in steps {
            let all: Vec<_> = (0..70).map(|i| impact(step, i)).collect();
            bench.step(&shuffled(all, 2), Moment::from_s(f64::from(step) / 20.0));
        }
    };
    let (whole, half, rest) = (bench(&gpu, &info), bench(&gpu, &info), bench(&gpu, &info));
    run(&whole, 0..12);
    run(&half, 0..5);
    assert!(rest.kindling.restore(&half.kindling.state().unwrap()).unwrap());
    run(&rest, 5..12);
    assert!(rest.kindling.state().unwrap() == whole.kindling.state().unwrap());
    let mut bad = half.kindling.state().unwrap();
    bad[2] = 300; // a slot that is none
    assert!(!rest.kindling.restore(&bad).unwrap());
    assert!(!rest.kindling.restore(&bad[1..]).unwrap());
    let other = bench(&gpu, &KindlingInfo { most: 301, ..info });
    assert!(!other.kindling.restore(&half.kindling.state().unwrap()).unwrap());
}

#[test]
fn numbers_out_of_range_are_named_with_what_is_allowed() {
    let good = info(100, 4, 1.0);
    good.check().unwrap();
    let says = |info: KindlingInfo, what: &str| {
        let said = info.check().unwrap_err();
        assert!(said.contains(what), "{said}");
    };
    says(KindlingInfo { most: 0, ..good.clone() }, "most = 0: 1 to 67108864");
    says(KindlingInfo { burst: 1 << 28, ..good.clone() }, "most x burst = 100 x 268435456: 1 to 268435456");
    says(KindlingInfo { burst: 0, ..good.clone() }, "most x burst = 100 x 0");
    says(KindlingInfo { life_s: 0.0, ..good.clone() }, "life_s = 0");
    says(KindlingInfo { life_s: f64::NAN, ..good.clone() }, "life_s = NaN");
    says(KindlingInfo { least_impulse_mps: f32::NAN, ..good.clone() }, "least_impulse_mps = NaN: 0 or more");
    says(KindlingInfo { sources: vec![0, 0], ..good.clone() }, "0 orders of all sources");
    says(KindlingInfo { sources: vec![u32::MAX; 2], ..good }, "8589934590 orders of all sources");
}

#[test]
fn away_keeps_lengths_and_turns_up_into_the_normal() {
    for i in 0..2000 {
        let normal = match i {
            0 => Vec3::Y,
            1 => Vec3::NEG_Y,
            2 => vec3(1e-7, -1.0, 0.0),
            _ => random::direction_of([unit(i, 1), unit(i, 2)]),
        };
        let struck = Struck { normal, ..Struck::at_rest(Vec3::ZERO) };
        assert!((struck.away(Vec3::Y) - normal).length() < 1e-6);
        let v = 5.0 * random::direction_of([unit(i, 3), unit(i, 4)]);
        assert!((struck.away(v).length() - 5.0).abs() < 1e-5, "{normal} {v}");
        let off = struck.away(v).as_dvec3().dot(normal.as_dvec3());
        assert!((off - f64::from(v.y)).abs() < 1e-5, "{normal} {v}");
    }
    let v = DVec3::new(0.3, -0.2, 7.0).as_vec3();
    assert_eq!(Struck::at_rest(Vec3::ONE).away(v), v);
}

macro_rules! assert_layout {
    ($spv:expr, $glsl:literal == $rust:ident { $($field:ident),* $(,)? }) => {{
        let interface = reflect($spv, &[256, 2, 256]).unwrap();
        let glsl = interface.structs.get($glsl).unwrap_or_else(|| panic!("no struct `{}`", $glsl));
        let fields: Vec<_> = glsl.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
        assert_eq!(fields, [$((stringify!($field), offset_of!($rust, $field))),*], "fields of `{}`", $glsl);
        assert_eq!(glsl.bytes, size_of::<$rust>(), "size of `{}`", $glsl);
    }};
}

#[test]
fn what_crosses_to_the_gpu_is_laid_out_alike() {
    use shaders::*;
    for spv in [
        BALLISTIC_TURN_COMP,
        BALLISTIC_KINDLE_COMP,
        BALLISTIC_LIVING_COMP,
        BALLISTIC_SPARKS_KINDLED_COMP,
        BALLISTIC_DUST_KINDLED_VERT,
    ] {
        assert_layout!(
            spv,
            "Strike" == Strike { at_m, born_low, normal, born_high, velocity_mps, impulse_mps }
        );
        assert_layout!(
            spv,
            "Ring"
                == Ring {
                    next_low,
                    next_high,
                    slot,
                    step_births,
                    now_low,
                    now_high,
                    living,
                    lost,
                    overwritten_low,
                    overwritten_high,
                    twice,
                    quad_vertices,
                    quad_instances,
                    quad_first_vertex,
                    quad_first_instance,
                    points,
                    point_instances,
                    point_first_vertex,
                    point_first_instance,
                    groups_x,
                    groups_y,
                    groups_z,
                    splat_x,
                    splat_y,
                    splat_z,
                }
        );
    }
    for spv in [BALLISTIC_MARK_COMP, BALLISTIC_TURN_COMP, BALLISTIC_KINDLE_COMP, BALLISTIC_LIVING_COMP] {
        assert_layout!(
            spv,
            "KindleParams"
                == KindleParams {
                    capacity,
                    burst,
                    sources,
                    meshes,
                    least_impulse_mps,
                    total_at,
                    now_low,
                    now_high,
                    life_low,
                    life_high,
                }
        );
    }
}
