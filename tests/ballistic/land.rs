// SPDX-License-Identifier: MIT OR Apache-2.0
//! What lands, as impacts: the kernel against its twin, the twin against f64, and steps against other steps.

use super::{hills, SEED, STREAM};
use crate::common::{gpu, TestGpu};
use glam::{DVec3, Vec3};
use whitecap::{
    ballistic::{cpu, land::landings, Builtin, Effect, Ground, GroundGrid, Land, Landing, Moment},
    impact::{Impact, Stream, NO_MESH},
};

const SOURCE: u32 = 7;

/// Rain and snow, in air and in none, from emitters that stand, move and circle.
fn effects() -> Vec<(Builtin, Effect)> {
    let rain = Effect { rate_per_s: 100.0, ..Builtin::Rain.effect() };
    let snow = Effect { rate_per_s: 150.0, ..Builtin::Snow.effect() };
    let mut thick = Effect { drag_per_s: 0.2, ..rain.clone() };
    thick.emitter.velocity_mps = Vec3::new(3.0, 0.0, -1.0);
    let mut round = Effect { burst: 3, ..snow.clone() };
    (round.emitter.circle_m, round.emitter.turns_per_s) = (12.0, 0.3);
    vec![(Builtin::Rain, rain), (Builtin::Snow, snow), (Builtin::Rain, thick), (Builtin::Snow, round)]
}

fn landing(effect: &Effect) -> Landing {
    Landing { effect: effect.clone(), source: SOURCE }
}

/// Hills that are dry, and hills in water.
fn grounds() -> [(GroundGrid, Vec<f32>); 2] {
    let (grid, heights) = hills();
    [(GroundGrid { water_m: f32::NEG_INFINITY, ..grid }, heights.clone()), (grid, heights)]
}

/// Impacts of a step by the twin.
fn twin(
    (builtin, effect): (Builtin, &Effect),
    (grid, heights): &(GroundGrid, Vec<f32>),
    after: Option<Moment>,
    by: Moment,
) -> Vec<Impact> {
    let landing = landing(effect);
    let p = landing.params(SEED, STREAM, grid);
    landing.parts(after, by).flat_map(|part| landings(builtin, &p, &Ground(heights), &part)).collect()
}

/// The same on the GPU, step by step.
fn on_gpu(
    gpu: &TestGpu,
    (builtin, effect): (Builtin, &Effect),
    (grid, heights): &(GroundGrid, Vec<f32>),
    steps: &[(Option<Moment>, Moment)],
) -> Vec<Vec<Impact>> {
    let stream = Stream::new(gpu, 1 << 14).unwrap();
    let ground = gpu.upload("test.ground_m", heights).unwrap();
    let spv = (c"ballistic.land", builtin.landing().unwrap());
    let land = Land::new(gpu, spv, landing(effect), (SEED, STREAM), (&ground, grid), &stream).unwrap();
    let step = |&(after, by): &(Option<Moment>, Moment)| {
        gpu.once(|rec| {
            stream.record_begin(rec);
            land.record(rec, after, by);
            stream.record_end(rec);
        })
        .unwrap();
        let (impacts, counts) = stream.download().unwrap();
        assert_eq!(counts.dropped(), 0);
        impacts
    };
    steps.iter().map(step).collect()
}

/// Steps of a rate from one second to another.
fn steps(fps: u32, from_s: u64, to_s: u64) -> Vec<(Option<Moment>, Moment)> {
    let per_s = u64::from(fps);
    let of = |frame| (frame > 0).then(|| Moment::of_frame(frame, fps));
    (from_s * per_s..to_s * per_s).map(|frame| (of(frame), Moment::of_frame(frame + 1, fps))).collect()
}

#[test]
fn landings_are_those_of_the_twin() {
    let gpu = gpu();
    for (builtin, effect) in &effects() {
        for ground in &grounds() {
            // Early, odd, and a day after the start.
            for steps in [steps(24, 0, 3), steps(60, 11, 12), steps(10, 86_400, 86_401)] {
                let of = (*builtin, effect);
                let got = on_gpu(&gpu, of, ground, &steps);
                let want: Vec<_> = steps.iter().map(|&(after, by)| twin(of, ground, after, by)).collect();
                assert!(want.iter().map(Vec::len).sum::<usize>() > 50 || steps[0].0.is_none());
                for (got, want) in got.iter().zip(&want) {
                    let orders = |all: &[Impact]| all.iter().map(|it| it.order).collect::<Vec<_>>();
                    if gpu.is_exact() {
                        assert_eq!(orders(got), orders(want));
                    }
                    for got in got {
                        // A device that fuses may put one into the step before or after.
                        let Some(want) = want.iter().find(|it| it.order == got.order) else { continue };
                        assert_eq!((got.triangle, got.mesh, got.source), (0, NO_MESH, SOURCE));
                        let apart = [got.at_m - want.at_m, got.normal - want.normal];
                        let apart = apart.map(|it| it.abs().max_element()).into_iter().fold(0.0, f32::max);
                        let speed = (got.velocity_mps - want.velocity_mps).abs().max_element();
                        let all = apart.max(speed).max((got.impulse_mps - want.impulse_mps).abs());
                        assert!(all <= if gpu.is_exact() { 0.0 } else { 1e-3 }, "{got:?} {want:?}");
                        assert!((got.normal.length() - 1.0).abs() < 1e-6 && got.normal.y > 0.0, "{got:?}");
                        assert!(got.impulse_mps > 0.0, "{got:?}");
                    }
                }
            }
        }
    }
}

/// All that can be seen of an impact but its order, which counts from the begin of the step.
fn bits(impacts: &[Impact]) -> Vec<[u32; 10]> {
    let of = |it: &Impact| {
        let ([a, b, c], [d, e, f], [g, h, i]) =
            (it.at_m.to_array(), it.normal.to_array(), it.velocity_mps.to_array());
        [a, b, c, d, e, f, g, h, i, it.impulse_mps].map(f32::to_bits)
    };
    let mut all: Vec<_> = impacts.iter().map(of).collect();
    all.sort_unstable();
    all
}

#[test]
fn each_lands_once_and_in_the_same_place_whatever_the_steps() {
    let gpu = gpu();
    for (builtin, effect) in &effects() {
        for ground in &grounds() {
            // A second in which it falls; the start, for one step has no begin there.
            for (from_s, to_s) in [(0, 4), (20, 21)] {
                let whole = twin(
                    (*builtin, effect),
                    ground,
                    (from_s > 0).then(|| Moment::of_frame(from_s, 1)),
                    Moment::of_frame(to_s, 1),
                );
                assert!(whole.len() > 100 || *builtin == Builtin::Snow && from_s == 0, "{}", whole.len());
                for fps in [24, 60, 240] {
                    let parts: Vec<Impact> = match fps {
                        24 => on_gpu(&gpu, (*builtin, effect), ground, &steps(fps, from_s, to_s)).concat(),
                        _ => {
                            let one = |(after, by)| twin((*builtin, effect), ground, after, by);
                            steps(fps, from_s, to_s).into_iter().flat_map(one).collect()
                        }
                    };
                    assert_eq!(parts.len(), whole.len(), "{builtin:?} at {fps} fps");
                    if fps != 24 || gpu.is_exact() {
                        assert!(bits(&parts) == bits(&whole), "{builtin:?} at {fps} fps");
                    }
                }
            }
        }
    }
}

/// The same second in f64: births by whole numbers, falls to the end. Where an end of the second is not nearer than a
/// microsecond to a landing, the number is the same.
#[test]
fn landings_are_those_of_f64() {
    for (builtin, effect) in &effects() {
        for ground @ (grid, heights) in &grounds() {
            let (from, to) = (Moment::of_frame(30, 1), Moment::of_frame(31, 1));
            let p = landing(effect).params(SEED, STREAM, grid);
            let emission = effect.emission();
            let (mut want, mut near) = (Vec::<DVec3>::new(), 0);
            for serial in emission.ending(Some(from), to) {
                let born_s = serial as f64 * emission.interval_s();
                let emitter = &effect.emitter;
                let at = emitter.at_m.as_dvec3() + emitter.velocity_mps.as_dvec3() * born_s;
                let turn = std::f64::consts::TAU * emitter.turns_per_s * born_s;
                let at = at + f64::from(emitter.circle_m) * DVec3::new(turn.cos(), 0.0, turn.sin());
                for member in 0..effect.burst {
                    let who = cpu::Who { serial, member };
                    let start = cpu::birth_f64(*builtin, &p, who, at);
                    let flown_s = Ground(heights).hit_f64(&p, &start);
                    let landed_s = born_s + flown_s;
                    let edges = [from.as_s(), to.as_s()].map(|edge| (landed_s - edge).abs());
                    near +=
                        usize::from(edges[0].min(edges[1]) < 1e-5 || (flown_s - effect.life_s).abs() < 1e-5);
                    if flown_s < effect.life_s && landed_s > from.as_s() && landed_s <= to.as_s() {
                        let pull = effect.acceleration_mps2.as_dvec3();
                        let drag = f64::from(effect.drag_per_s);
                        want.push(cpu::position_f64(start.at_m, start.velocity_mps, pull, flown_s, drag));
                    }
                }
            }
            let got = twin((*builtin, effect), ground, Some(from), to);
            assert!(want.len() > 100, "{}", want.len());
            assert!(
                got.len().abs_diff(want.len()) <= near,
                "{builtin:?}: {} and {}, {near}",
                got.len(),
                want.len()
            );
            if near > 0 || *builtin == Builtin::Snow {
                continue; // which sways: it lands beside where it flew
            }
            let worst = got.iter().zip(&want).map(|(got, want)| (got.at_m.as_dvec3() - want).length());
            let worst = worst.fold(0.0, f64::max);
            println!("{builtin:?}: {} of them, {worst:e} m", want.len());
            // Some ulp of the emitter's place, which is up to 90 m away.
            assert!(worst < 1e-4, "{builtin:?}: {worst} m");
        }
    }
}

/// A step that ends when a drop lands has it, and the next one has not.
#[test]
fn a_step_has_its_end_and_not_its_begin() {
    let (builtin, effect) = effects().swap_remove(0);
    let ground = &grounds()[1];
    let (from, to) = (Moment::of_frame(50, 1), Moment::of_frame(51, 1));
    let all = twin((builtin, &effect), ground, Some(from), to).len();
    // Halved and halved again round one landing, until no tick is between.
    let (mut low, mut high) = (from.ticks, to.ticks);
    let by = |ticks| twin((builtin, &effect), ground, Some(from), Moment { ticks }).len();
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if by(middle) * 2 < all {
            low = middle;
        } else {
            high = middle;
        }
    }
    assert!(by(high) > by(low), "{low} {high}");
    for ticks in low - 3..high + 3 {
        let cut = Moment { ticks };
        let after = twin((builtin, &effect), ground, Some(cut), to).len();
        assert_eq!(by(ticks) + after, all, "cut at {ticks}");
    }
}

#[test]
fn what_finds_no_room_is_dropped_and_counted() {
    let gpu = gpu();
    let (grid, heights) = hills();
    let effect = Builtin::Rain.effect();
    let stream = Stream::new(&gpu, 100).unwrap();
    let ground = gpu.upload("test.ground_m", &heights).unwrap();
    let spv = (c"ballistic.land", Builtin::Rain.landing().unwrap());
    let land = Land::new(&gpu, spv, landing(&effect), (SEED, STREAM), (&ground, &grid), &stream).unwrap();
    let (after, by) = (Moment::of_frame(10, 1), Moment::of_frame(11, 1));
    gpu.once(|rec| {
        stream.record_begin(rec);
        land.record(rec, Some(after), by);
        stream.record_end(rec);
    })
    .unwrap();
    let counts = stream.counts().unwrap();
    let all = twin((Builtin::Rain, &effect), &(grid, heights), Some(after), by).len() as u64;
    assert!(all > 2000, "{all}");
    assert_eq!((counts.stored(), counts.count), (100, 100));
    assert!(counts.dropped().abs_diff(all - 100) <= if gpu.is_exact() { 0 } else { 2 }, "{counts:?}");
}

/// Ground above where it begins is nothing to fall on: what is born in a hill lands nowhere.
#[test]
fn what_begins_in_the_ground_lands_nowhere() {
    let gpu = gpu();
    let effect = Effect { rate_per_s: 100.0, ..Builtin::Rain.effect() };
    let (grid, heights) = hills();
    let high: Vec<f32> = heights.iter().map(|height| height + 500.0).collect();
    for ground in [(grid, high), (GroundGrid { water_m: 500.0, ..grid }, heights)] {
        let steps = steps(60, 1, 3);
        assert!(steps
            .iter()
            .all(|&(after, by)| twin((Builtin::Rain, &effect), &ground, after, by).is_empty()));
        assert!(on_gpu(&gpu, (Builtin::Rain, &effect), &ground, &steps).iter().all(Vec::is_empty));
    }
}
