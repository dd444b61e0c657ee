// SPDX-License-Identifier: MIT OR Apache-2.0
//! Lists of particles against what needs no list.

use super::{SEED, STREAM};
use crate::common::{gpu, TestGpu};
use glam::Vec3;
use whitecap::{
    ballistic::{
        cpu,
        stored::{Counter, Particle},
        Builtin, Effect, GroundGrid, Moment, StoredEffect, StreamedEffect,
    },
    gpu::Access,
    shaders,
};

fn fire(gpu: &TestGpu, effect: &Effect, capacity: u32) -> StoredEffect {
    StoredEffect::new(gpu, c"ballistic.fire_emit", shaders::BALLISTIC_FIRE_EMIT_COMP, effect, capacity)
        .unwrap()
}

fn frames(gpu: &TestGpu, stored: &mut StoredEffect, frames: std::ops::Range<u64>, fps: u32) -> u32 {
    let mut born = 0;
    gpu.once(|rec| {
        for frame in frames {
            born += stored.record(rec, Moment::of_frame(frame, fps), SEED, STREAM);
            rec.barrier(StoredEffect::EXIT, StoredEffect::ENTRY);
            rec.barrier(StoredEffect::EXIT, Access::IndirectRead);
        }
    })
    .unwrap();
    born
}

/// What the list must hold, oldest first: birth and age of each that lives, from the clock.
fn want(effect: &Effect, now: Moment) -> Vec<(cpu::Birth, f64)> {
    let params = effect.params(now, SEED, STREAM, &GroundGrid::FLAT, u32::MAX);
    let of = |i| {
        let (who, back) = cpu::who(&params, i);
        let emitter = cpu::emitter_at(&params, cpu::age_of(&params, back));
        (cpu::birth(Builtin::Fire, &params, who, emitter), effect.emission().age_s(now, who.serial))
    };
    (0..params.births).map(of).collect()
}

fn compare(list: &[Particle], want: &[(cpu::Birth, f64)], allowed_s: f64, what: &str) {
    // Sums of ages may keep one that is over, or end one early, by what they are off.
    assert!(list.len().abs_diff(want.len()) <= 1, "{what}: {} particles, not {}", list.len(), want.len());
    let skip = |n: usize, other: usize| n.saturating_sub(other);
    let (list, want) = (&list[skip(list.len(), want.len())..], &want[skip(want.len(), list.len())..]);
    for (i, (got, (birth, age_s))) in list.iter().zip(want).enumerate() {
        let [x, y, z, age] = got.at_age;
        assert!((f64::from(age) - age_s).abs() <= allowed_s, "{what} {i}: age {age}, not {age_s}");
        let [u, v, w, _] = got.velocity;
        let apart =
            (Vec3::new(x, y, z) - birth.at_m).length() + (Vec3::new(u, v, w) - birth.velocity_mps).length();
        assert!(apart < 2e-5, "{what} {i}: {got:?}, not {birth:?}");
    }
}

#[test]
fn a_list_holds_what_lives_at_any_frame_rate() {
    let gpu = gpu();
    let effect = Builtin::Fire.effect();
    for fps in [24, 60, 240, 500] {
        let mut stored = fire(&gpu, &effect, 1000);
        let last = 2 * u64::from(fps) + 5;
        let born = frames(&gpu, &mut stored, 0..last + 1, fps);
        let (list, counter) = stored.download(&gpu).unwrap();
        let now = Moment::of_frame(last, fps);
        let all = effect.emission().births_by(now) + 1;
        assert_eq!(u64::from(born), all, "{fps} fps");
        assert_eq!(counter.dropped, 0);
        // Ages are sums over a life of frames, each rounded to 2^-24 of up to a second.
        compare(&list, &want(&effect, now), f64::from(fps) * 6e-8, &format!("{fps} fps"));
        assert_eq!(counter.draw, [6 * counter.count, 1, 0, 0]);
    }
}

#[test]
fn a_first_frame_late_in_the_day_has_all_that_live_and_a_long_one_loses_nobody() {
    let gpu = gpu();
    let mut effect = Builtin::Fire.effect();
    (effect.rate_per_s, effect.life_s) = (777.0, 1.3);
    let mut stored = fire(&gpu, &effect, 5000);
    let first = 86_400 * 60;
    frames(&gpu, &mut stored, first..first + 1, 60);
    let (list, _) = stored.download(&gpu).unwrap();
    compare(&list, &want(&effect, Moment::of_frame(first, 60)), 1e-7, "first");
    // Ten seconds at once: all that lived are over, and those that live were born on the way.
    let later = first + 600;
    frames(&gpu, &mut stored, later..later + 1, 60);
    let (list, counter) = stored.download(&gpu).unwrap();
    compare(&list, &want(&effect, Moment::of_frame(later, 60)), 1e-7, "later");
    assert_eq!(counter.dropped, 0);
}

/// The book's effect dies when its list is full, as the emitter is the last in it.
#[test]
fn an_effect_that_was_crowded_out_recovers_and_the_lost_are_counted() {
    let gpu = gpu();
    let effect = Builtin::Fire.effect();
    let mut stored = fire(&gpu, &effect, 10);
    let born = frames(&gpu, &mut stored, 0..301, 60);
    let (list, counter) = stored.download(&gpu).unwrap();
    assert_eq!((list.len(), counter.count), (10, 10));
    // Whoever was born lives, is over, or was counted as lost: ten lists' worth at the most came and went in five lives.
    let over = born - counter.dropped - counter.count;
    assert!((40..=60).contains(&over), "{over} of {born} lived to their end, {} were lost", counter.dropped);
}

#[test]
fn an_empty_list_stays_empty_and_ends_well() {
    let gpu = gpu();
    let mut effect = Builtin::Fire.effect();
    (effect.rate_per_s, effect.life_s) = (0.01, 0.5);
    let mut stored = fire(&gpu, &effect, 4);
    frames(&gpu, &mut stored, 100..160, 60);
    let (list, counter) = stored.download(&gpu).unwrap();
    assert_eq!(list, []);
    assert_eq!(counter, Counter { groups: [0, 0, 1], draw: [0, 1, 0, 0], ..Counter::default() });
}

#[test]
fn transform_feedback_writes_the_same_list() {
    let gpu = gpu();
    if !gpu.has_transform_feedback() {
        eprintln!("SKIP: {} has no transform feedback", gpu.name());
        return;
    }
    let effect = Builtin::Fire.effect();
    let vertex = shaders::BALLISTIC_FIRE_STREAM_VERT;
    for fps in [24, 60, 240] {
        let mut streamed = StreamedEffect::new(&gpu, c"ballistic.stream", vertex, &effect, 1000).unwrap();
        let last = 2 * u64::from(fps) + 5;
        let mut born = 0;
        gpu.once(|rec| {
            for frame in 0..last + 1 {
                born += streamed.record(rec, Moment::of_frame(frame, fps), SEED, STREAM);
                rec.barrier(StreamedEffect::EXIT, StreamedEffect::ENTRY);
            }
        })
        .unwrap();
        let now = Moment::of_frame(last, fps);
        assert_eq!(u64::from(born), effect.emission().births_by(now) + 1, "{fps} fps");
        let list = streamed.download(&gpu).unwrap();
        compare(&list, &want(&effect, now), f64::from(fps) * 6e-8, &format!("{fps} fps"));
    }
    // A list that is too short loses what is over, and recovers: the emitter is not in it.
    let mut small = StreamedEffect::new(&gpu, c"ballistic.stream", vertex, &effect, 10).unwrap();
    gpu.once(|rec| {
        for frame in 0..301 {
            small.record(rec, Moment::of_frame(frame, 60), SEED, STREAM);
            rec.barrier(StreamedEffect::EXIT, StreamedEffect::ENTRY);
        }
    })
    .unwrap();
    let list = small.download(&gpu).unwrap();
    assert_eq!(list.len(), 10);
    assert!(list.iter().all(|particle| (0.0..1.0).contains(&particle.at_age[3])), "{list:?}");
}
