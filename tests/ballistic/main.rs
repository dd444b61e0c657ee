// SPDX-License-Identifier: MIT OR Apache-2.0
//! Closed-form effects: kernels against their twins, positions against f64, births against the clock.
#![allow(missing_docs)]

#[path = "../common/mod.rs"]
mod common;
mod kindled;
mod land;
mod pictures;
mod stored;
mod time;

use common::{gpu, TestGpu};
use glam::{uvec2, vec2, DVec3, Vec3};
use whitecap::{
    ballistic::{cpu, Builtin, Effect, Ground, GroundGrid, LandParams, Moment, Params, Vertex},
    shaders,
};

const SEED: u32 = 20;
const STREAM: u32 = 3;

/// Hills between 0 and 4 m, and water that stands at 1 m.
fn hills() -> (GroundGrid, Vec<f32>) {
    let cells = uvec2(33, 17);
    let height = |i: u32| {
        let (x, z) = ((i % 33) as f32, (i / 33) as f32);
        2.0 + 1.2 * (0.5 * x).sin() + 0.8 * (0.7 * z).cos()
    };
    let grid = GroundGrid { size_m: vec2(80.0, 75.0), cells, water_m: 1.0 };
    (grid, (0..cells.element_product()).map(height).collect())
}

fn ground_of(effect: &Effect) -> Option<(GroundGrid, Vec<f32>)> {
    effect.has_ground.then(hills)
}

/// Live particles of an effect at a moment, from the GPU.
fn materialised(gpu: &TestGpu, builtin: Builtin, effect: &Effect, now: Moment) -> (Params, Vec<Vertex>) {
    let ground = ground_of(effect);
    let buffer = ground.as_ref().map(|(_, heights)| gpu.upload("test.ground_m", heights).unwrap());
    let grid = ground.map_or(GroundGrid::FLAT, |(grid, _)| grid);
    let kernel = builtin.materialise(gpu).unwrap();
    let vertices = kernel.vertices(effect.most_particles() as u32, buffer.as_ref()).unwrap();
    let mut counts = Default::default();
    gpu.once(|rec| counts = vertices.record(rec, effect, now, SEED, STREAM, &grid)).unwrap();
    assert_eq!(counts.dropped, 0);
    let params = effect.params(now, SEED, STREAM, &grid, effect.most_particles() as u32);
    (params, vertices.download(gpu, counts.written).unwrap())
}

/// Times that are early, odd, late, and a day and more after the start.
const TIMES_S: [f64; 6] = [0.0, 0.37, 2.914_159, 11.3, 86_400.123_4, 7e6];

#[test]
fn every_effect_is_its_twin_to_the_bit() {
    let gpu = gpu();
    for builtin in Builtin::ALL {
        let mut effect = builtin.effect();
        if builtin == Builtin::Smoke {
            // A chimney that moves, and circles.
            effect.emitter.velocity_mps = Vec3::new(3.0, 0.0, -1.0);
            (effect.emitter.circle_m, effect.emitter.turns_per_s) = (2.5, 0.3);
        }
        let heights = ground_of(&effect).map(|(_, heights)| heights);
        let ground = heights.as_deref().map(Ground);
        for time_s in TIMES_S {
            let (params, got) = materialised(&gpu, builtin, &effect, Moment::from_s(time_s));
            assert_eq!(got.len() as u32, params.births * params.burst);
            let (mut seen, mut worst) = (0, 0.0f64);
            for (i, vertex) in got.iter().enumerate() {
                let want = cpu::flight(builtin, &params, ground.as_ref(), i as u32);
                let at_m = want.map_or(Vec3::ZERO, |flight| flight.at_m);
                seen += u32::from(want.is_some());
                if gpu.is_exact() {
                    let bits = |v: [f32; 3]| v.map(f32::to_bits);
                    // Zero has a sign that no one sees.
                    let plain = |v: [f32; 3]| bits(v.map(|x| x + 0.0));
                    assert_eq!(plain(vertex.at_m), plain(at_m.to_array()), "{builtin:?} {i} at {time_s} s");
                }
                let apart = (Vec3::from(vertex.at_m) - at_m).length() / at_m.length().max(1.0);
                worst = worst.max(f64::from(apart));
                let age = want.map_or(1.0, |flight| flight.share);
                let byte = f32::from(vertex.look[3]) / 255.0;
                assert!((byte - age.min(1.0)).abs() < 2.0 / 255.0, "{builtin:?} {i}: age {byte}, {age}");
            }
            // Directions and drag are products of a few steps, each rounded: where a device fuses what is not `precise`, a
            // few 2^-24 of the way.
            assert!(worst < 1e-6, "{builtin:?} at {time_s} s: {worst:e}");
            assert!(seen > 0 || builtin == Builtin::Fireworks, "{builtin:?}: none seen at {time_s} s");
        }
    }
}

/// Distance in units of the last place of the length.
fn ulps(got: [f32; 3], want: DVec3) -> f64 {
    let apart = (Vec3::from(got).as_dvec3() - want).length();
    let length = want.length() as f32;
    apart / f64::from(f32::from_bits(length.to_bits() + 1) - length)
}

/// f64 of the same birth: age from whole numbers, position from the formula.
fn position_f64(builtin: Builtin, effect: &Effect, params: &Params, now: Moment, i: u32) -> Option<DVec3> {
    let (who, back) = cpu::who(params, i);
    let emitter = cpu::emitter_at(params, cpu::age_of(params, back));
    let start = cpu::birth(builtin, params, who, emitter);
    let age_s = effect.emission().age_s(now, who.serial) - f64::from(start.delay_s);
    let pull = effect.acceleration_mps2.as_dvec3();
    let drag = f64::from(effect.drag_per_s);
    (age_s >= 0.0)
        .then(|| cpu::position_f64(start.at_m.as_dvec3(), start.velocity_mps.as_dvec3(), pull, age_s, drag))
}

#[test]
fn positions_are_right_to_four_ulp_whatever_cancels_and_however_late_it_is() {
    let gpu = gpu();
    // The emitter in the origin, so that velocity and acceleration cancel in the length itself.
    for builtin in [Builtin::Fire, Builtin::Rain] {
        let mut effect = builtin.effect();
        effect.has_ground = false;
        effect.emitter.at_m = Vec3::ZERO;
        for time_s in TIMES_S {
            let now = Moment::from_s(time_s);
            let params = effect.params(now, SEED, STREAM, &GroundGrid::FLAT, u32::MAX);
            let mut worst = 0.0f64;
            for i in 0..params.births * params.burst {
                let want = position_f64(builtin, &effect, &params, now, i).unwrap();
                let got = cpu::flight(builtin, &params, None, i).unwrap().at_m;
                worst = worst.max(ulps(got.to_array(), want));
            }
            println!("{builtin:?} at {time_s} s: {worst:.2} ulp");
            assert!(worst <= 4.0, "{builtin:?} at {time_s} s: {worst} ulp");
        }
    }
    // The GPU, where there is no ground to end on.
    let effect = Effect { has_ground: false, ..Builtin::Fire.effect() };
    for time_s in TIMES_S {
        let now = Moment::from_s(time_s);
        let (params, got) = materialised(&gpu, Builtin::Fire, &effect, now);
        for (i, vertex) in got.iter().enumerate() {
            let want = position_f64(Builtin::Fire, &effect, &params, now, i as u32).unwrap();
            let apart = ulps(vertex.at_m, want);
            assert!(apart <= 4.0, "particle {i} at {time_s} s: {apart} ulp");
        }
    }
}

/// The birth in f32 is that in f64 to rounding: some ten roundings of 2^-24 each of speeds and ways up to 30.
#[test]
fn births_are_those_in_f64_to_rounding() {
    let (mut speed, mut way) = (0.0f64, 0.0f64);
    for builtin in Builtin::ALL {
        let effect = builtin.effect();
        let now = Moment::from_s(100.0);
        let params = effect.params(now, SEED, STREAM, &GroundGrid::FLAT, u32::MAX);
        for i in 0..params.births * params.burst {
            let (who, _) = cpu::who(&params, i);
            let at = effect.emitter.at_m;
            let got = cpu::birth(builtin, &params, who, at);
            let want = cpu::birth_f64(builtin, &params, who, at.as_dvec3());
            speed = speed.max((got.velocity_mps.as_dvec3() - want.velocity_mps).length());
            way = way.max((got.at_m.as_dvec3() - want.at_m).length());
            assert!((f64::from(got.delay_s) - want.delay_s).abs() < 2.4e-7);
        }
    }
    println!("{speed:e} m/s, {way:e} m");
    assert!(speed < 10.0 * 6e-8 * 30.0 && way < 10.0 * 6e-8 * 30.0, "{speed:e} m/s, {way:e} m");
}

/// Of the formulas themselves: no drag is the limit of little drag, and the f32 form is a few roundings from f64.
#[test]
fn drag_goes_to_none_without_cancellation() {
    let (p0, v0, a) = (Vec3::new(1.0, 2.0, -3.0), Vec3::new(4.0, 5.0, -1.0), Vec3::new(0.3, -9.8, 0.1));
    let (mut worst, mut low) = (0.0f64, 0.0f64);
    for drag in [1e-30f32, 1e-12, 1e-7, 1e-4, 0.01, 0.1, 0.4999, 0.5001, 1.0, 3.0, 20.0, 300.0] {
        for age in [1e-3f32, 0.1, 0.5, 0.999, 1.0, 2.5, 7.0] {
            let r = cpu::reach_of(cpu::Wide { high: age, low: 0.0 }, drag);
            let [v, acc, keep] = cpu::reach_f64(f64::from(age), f64::from(drag));
            for (got, want) in [(r.v.high, v), (r.a.high, acc)] {
                worst = worst.max((f64::from(got) / want - 1.0).abs());
            }
            low = low.max((f64::from(r.keep) - keep).abs());
            let got = cpu::position(p0, v0, a, &r).as_dvec3();
            let want = cpu::position_f64(p0.as_dvec3(), v0.as_dvec3(), a.as_dvec3(), age.into(), drag.into());
            let way = (v0 * r.v.high).length() + (a * r.a.high).length() + p0.length();
            assert!((got - want).length() < 5e-7 * f64::from(way), "drag {drag}, age {age}");
        }
    }
    println!("factors {worst:e}, keep {low:e}");
    assert!(worst < 2.5e-7 && low < 1.2e-7, "{worst:e} {low:e}");
    let none = cpu::position(p0, v0, a, &cpu::reach_of(cpu::Wide { high: 2.0, low: 0.0 }, 0.0));
    let little = cpu::position(p0, v0, a, &cpu::reach_of(cpu::Wide { high: 2.0, low: 0.0 }, 1e-30));
    assert!((none - little).length() < 1e-6);
}

#[test]
fn the_time_of_a_fall_is_right_where_it_grazes() {
    let (mut worst, mut naive) = (0.0f64, 0.0f64);
    for above in [1e-6f32, 1e-4, 1e-2, 0.3, 1.0, 20.0, 900.0] {
        for rise in [-80.0f32, -29.4, -3.0, -1e-3, 0.0, 1e-3, 2.0, 30.0] {
            for pull in [-9.8f32, -1.6, -1e-3] {
                let got = cpu::fall_time(above, rise, pull);
                let want = cpu::fall_time_f64(above.into(), rise.into(), pull.into());
                worst = worst.max((f64::from(got) / want - 1.0).abs());
                let root = (-rise - (rise * rise - 2.0 * pull * above).sqrt()) / pull;
                naive = naive.max((f64::from(root) / want - 1.0).abs());
            }
        }
    }
    assert!(worst < 3e-7, "{worst:e}");
    assert!(naive > 0.9, "the other root is not that bad: {naive}");
    assert_eq!(cpu::fall_time(-1.0, 5.0, -9.8), 0.0);
    assert_eq!(cpu::fall_time(1.0, 0.0, 0.0), 1e30);
    assert_eq!(cpu::fall_time(1.0, 1.0, 2.0), 1e30);
    assert_eq!(cpu::fall_time(1.0, -1.0, 2.0), 1e30);
    assert_eq!(cpu::fall_time(1.0, -4.0, 0.0), 0.25);
}

#[test]
fn a_flight_ends_on_the_ground_and_on_water() {
    let (grid, heights) = hills();
    let ground = Ground(&heights);
    for drag in [0.0, 0.5] {
        let effect = Effect { drag_per_s: drag, ..Builtin::Rain.effect() };
        let params = effect.params(Moment::from_s(10.0), SEED, STREAM, &grid, u32::MAX);
        let (mut wet, mut dry) = (0, 0);
        for i in 0..2000 {
            let (who, _) = cpu::who(&params, i);
            let start = cpu::birth(Builtin::Rain, &params, who, effect.emitter.at_m);
            let t = f64::from(ground.hit(&params, &start));
            let (p0, v0) = (start.at_m.as_dvec3(), start.velocity_mps.as_dvec3());
            let exact = cpu::BirthF64 { at_m: p0, velocity_mps: v0, delay_s: 0.0 };
            assert!((t / ground.hit_f64(&params, &exact) - 1.0).abs() < 2e-6, "drop {i}: {t}");
            let pull = effect.acceleration_mps2.as_dvec3();
            let at = |t: f64| cpu::position_f64(p0, v0, pull, t, f64::from(drag));
            let above = |t: f64| at(t).y - ground.height_f64(&params, glam::dvec2(at(t).x, at(t).z));
            // Heights are rounded to 2^-24 of 30 m, and rounds end at 1e-5 of the slope's power.
            assert!(above(t).abs() < 3e-5, "drop {i}: {} m above the ground", above(t));
            assert!(
                (0..200).all(|k| above(t * f64::from(k) / 200.0) > -1e-4),
                "drop {i} was under ground before"
            );
            let level = at(t).y;
            if (level - 1.0).abs() < 1e-4 {
                wet += 1
            } else {
                dry += 1
            }
        }
        assert!(wet > 50 && dry > 500, "{wet} on water, {dry} on land");
    }
}

/// Rain over hills: below the ground there is none, and what came down lies still and splashes.
#[test]
fn no_drop_falls_through_the_ground() {
    let gpu = gpu();
    let effect = Builtin::Rain.effect();
    let (params, got) = materialised(&gpu, Builtin::Rain, &effect, Moment::from_s(20.0));
    let (_, heights) = hills();
    let ground = Ground(&heights);
    let mut down = 0;
    for (i, vertex) in got.iter().enumerate() {
        let at = Vec3::from(vertex.at_m);
        let above = at.y - ground.height(&params, vec2(at.x, at.z));
        assert!(above > -1e-4, "drop {i}: {above} m");
        let flight = cpu::flight(Builtin::Rain, &params, Some(&ground), i as u32).unwrap();
        down += u32::from(flight.down_s >= 0.0);
    }
    assert!(down > 500, "{down} of {} came down", got.len());
}

#[test]
fn what_finds_no_room_is_counted_and_nothing_is_written_beyond() {
    let gpu = gpu();
    let effect = Builtin::Fire.effect();
    let kernel = Builtin::Fire.materialise(&gpu).unwrap();
    for (capacity, written, dropped) in [(1, 1, 199), (77, 77, 123), (200, 200, 0), (300, 200, 0)] {
        let vertices = kernel.vertices(capacity, None).unwrap();
        let mut counts = Default::default();
        gpu.once(|rec| {
            rec.fill(vertices.buffer(), 0x7777_7777);
            rec.barrier(whitecap::gpu::Access::FillWrite, whitecap::gpu::Access::ComputeWrite);
            counts = vertices.record(rec, &effect, Moment::from_s(9.0), SEED, STREAM, &GroundGrid::FLAT);
        })
        .unwrap();
        assert_eq!((counts.written, counts.dropped), (written, dropped));
        let all: Vec<u32> = gpu.download(vertices.buffer()).unwrap();
        let untouched = all.chunks(4).filter(|vertex| vertex.iter().all(|&word| word == 0x7777_7777)).count();
        assert_eq!(untouched as u32, capacity - written);
    }
}

#[test]
fn mistakes_in_an_effect_file_are_named_with_line_and_excerpt() {
    let error = |text: &str| Effect::parse("my/glow.glsl", text).unwrap_err().to_string();
    let head = "// mine\n/* effect\nrate_per_s = 10\n";
    assert_eq!(
        error(&format!("{head}lief_s = 2\n*/\n")),
        "my/glow.glsl:4: no key `lief_s`; there are rate_per_s, burst, life_s, acceleration_mps2, drag_per_s, \
         emitter_m, emitter_mps, circle_m, circle_turns_per_s, exposure_s, size, blend, ground\n    4 | lief_s = 2"
    );
    for (line, what) in [
        ("life_s = -1", "`life_s` = -1: a number from 0.001 to 86400 is allowed"),
        ("life_s = NaN", "`life_s` = NaN: a number from 0.001 to 86400 is allowed"),
        ("life_s = 1 2", "`life_s` = 1 2: a number from"),
        ("life_s 2", "`life_s 2` is not `key = value`"),
        ("emitter_m = 1 2", "`emitter_m` = 1 2: three numbers"),
        ("emitter_m = 1 2 inf", "three numbers up to a million"),
        ("rate_per_s = 3", "`rate_per_s` is given twice"),
        ("blend = mix", "`blend` = mix: `add` and `over` are allowed"),
        ("burst = 2.5", "`burst` = 2.5: a whole number"),
    ] {
        let text = error(&format!("{head}{line}\n*/\n"));
        assert!(
            text.starts_with("my/glow.glsl:4: ") && text.contains(what) && text.ends_with(line),
            "{text}"
        );
    }
    assert!(error("void f() {}\n").contains("no comment that begins with `/* effect`"));
    assert!(error("/* effect\nrate_per_s = 1\n").contains("has no line `*/`"));
    assert!(error(&format!("{head}*/")).contains("my/glow.glsl:2: `life_s` is missing"));
    let many = error("/* effect\nrate_per_s = 1e8\nburst = 1000\nlife_s = 9\n*/");
    assert!(many.contains("900000000000 particles live at once"), "{many}");
    let good =
        Effect::parse("a/b.glsl", &format!("{head}life_s = 2 # two\n\nemitter_m = 1 2 3\n*/\n")).unwrap();
    assert_eq!((good.name.as_str(), good.life_s, good.emitter.at_m), ("b", 2.0, Vec3::new(1.0, 2.0, 3.0)));
}

#[test]
fn every_effect_that_comes_with_the_crate_is_one_file() {
    for builtin in Builtin::ALL {
        let effect = builtin.effect();
        assert_eq!((effect.name.as_str(), Builtin::named(&effect.name)), (builtin.name(), Some(builtin)));
    }
    assert_eq!(Builtin::named("ice"), None);
    let fire = Builtin::Fire.effect();
    assert_eq!((fire.rate_per_s, fire.life_s, fire.most_particles()), (200.0, 1.0, 200));
    let rain = Builtin::Rain.effect();
    assert_eq!(
        (rain.rate_per_s * f64::from(rain.burst), rain.life_s, rain.most_particles()),
        (2500.0, 3.0, 7500)
    );
}

#[test]
fn the_struct_of_an_effect_is_laid_out_as_the_shaders_declare() {
    use std::mem::{offset_of, size_of};
    for (name, spv) in shaders::ALL.iter().filter(|(name, _)| name.starts_with("ballistic.")) {
        let interface = whitecap::gpu::reflect::reflect(spv, &[256; 8]).unwrap();
        let Some(glsl) = interface.structs.get("Effect") else { continue };
        let fields: Vec<_> = glsl.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
        macro_rules! offsets { ($($field:ident),* $(,)?) => { [$((stringify!($field), offset_of!(Params, $field))),*] } }
        let want = offsets![
            acceleration,
            emitter_m,
            emitter_mps,
            turns_per_s,
            lives_per_s,
            interval_s,
            interval_low_s,
            since_s,
            since_low_s,
            seed,
            stream,
            newest,
            newest_high,
            births,
            burst,
            ground_size_m,
            ground_cells,
            water_m,
            exposure_s,
            size,
            capacity,
        ];
        assert_eq!(fields, want, "{name}");
        assert_eq!((glsl.bytes, size_of::<Params>()), (128, 128), "{name}");
        let Some(glsl) = interface.structs.get("Landing") else { continue };
        let fields: Vec<_> = glsl.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
        macro_rules! landing { ($($field:ident),* $(,)?) => { [$((stringify!($field), offset_of!(LandParams, $field))),*] } }
        let want = landing![
            emitter_m, from_s, to_s, turn, epoch, epoch_high, first, particles, before, source, reserved
        ];
        assert_eq!(fields, want, "{name}");
        assert_eq!((glsl.bytes, size_of::<LandParams>()), (64, 64), "{name}");
    }
}
