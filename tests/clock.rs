// SPDX-License-Identifier: MIT OR Apache-2.0
//! The clock loses nothing, invents nothing, and says what it drops.
#![allow(missing_docs)]

use whitecap::clock::{Advance, FixedStep};

const DAY_S: u64 = 86_400;

/// Uniform in 0 to 1 (Steele and others, "Fast splittable pseudorandom number generators", 2014).
fn uniform(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

#[test]
fn a_day_has_as_many_steps_as_seconds_times_their_rate_at_every_frame_rate() {
    for frames_per_s in [20, 24, 30, 60, 75, 90, 120, 144, 240, 500, 1000] {
        for steps_per_s in [60, 120, 144] {
            let mut clock = FixedStep::new(1.0 / steps_per_s as f64, u32::MAX);
            let frame_s = 1.0 / frames_per_s as f64;
            let steps: u64 =
                (0..DAY_S / 24 * frames_per_s).map(|_| u64::from(clock.advance(frame_s).steps)).sum();
            assert_eq!(
                steps,
                DAY_S / 24 * steps_per_s,
                "{frames_per_s} frames, {steps_per_s} steps a second"
            );
            assert_eq!((clock.steps(), clock.lost_s(), clock.refused()), (steps, 0.0, 0));
        }
    }
    for frames_per_s in [60, 144] {
        let mut clock = FixedStep::new(1.0 / 60.0, 8);
        let frame_s = 1.0 / frames_per_s as f64;
        (0..DAY_S * frames_per_s).for_each(|_| _ = clock.advance(frame_s));
        assert_eq!(clock.steps(), 60 * DAY_S, "a whole day at {frames_per_s} frames a second");
        assert!((clock.simulated_s() - DAY_S as f64).abs() < 1e-10);
    }
}

#[test]
fn a_running_total_in_f32_drifts_where_the_clock_does_not() {
    let (mut total, mut clock) = (0.0f32, FixedStep::new(1.0 / 60.0, 8));
    for _ in 0..3600 * 60 {
        total += 1.0 / 60.0;
        clock.advance(1.0 / 60.0);
    }
    assert!((total - 3600.0).abs() > 1.0, "{total} s after an hour");
    assert!((clock.simulated_s() - 3600.0).abs() < 1e-11);
}

#[test]
fn frames_are_simulated_lost_or_pending_to_the_last_bit() {
    let mut state = 1;
    for cap in [1, 3, 8, u32::MAX] {
        let mut clock = FixedStep::new(0.25, cap);
        // Multiples of 2^-20 s: their sum is exact in f64 too.
        let frames: Vec<f64> =
            (0..10_000).map(|_| (uniform(&mut state) * 3e6).floor() / (1 << 20) as f64).collect();
        let mut lost = 0.0;
        for frame in &frames {
            let Advance { steps, lost_s } = clock.advance(*frame);
            assert!(steps <= cap);
            lost += lost_s;
            assert!((0.0..=1.0).contains(&clock.fraction()));
        }
        assert_eq!(lost, clock.lost_s());
        assert_eq!(clock.simulated_s() + clock.lost_s() + clock.pending_s(), frames.iter().sum::<f64>());
        assert_eq!(lost == 0.0, cap >= 12, "cap {cap}: lost {lost} s");
    }
}

#[test]
fn a_hitch_beyond_the_cap_is_reported_and_one_within_is_caught_up() {
    let dt_s = 1.0 / 60.0;
    let run = |cap: u32| {
        let mut clock = FixedStep::new(dt_s, cap);
        (0..90).for_each(|_| _ = clock.advance(dt_s));
        let hitch = clock.advance(0.5);
        (0..90).for_each(|_| _ = clock.advance(dt_s));
        (hitch, clock.steps(), clock.lost_s())
    };
    assert_eq!(run(8), (Advance { steps: 8, lost_s: 22.0 * dt_s }, 188, 22.0 * dt_s));
    assert_eq!(run(u32::MAX), (Advance { steps: 30, lost_s: 0.0 }, 210, 0.0));
}

#[test]
fn jitter_changes_when_steps_are_taken_but_not_how_many() {
    let dt_s = 1.0 / 60.0;
    let (mut state, mut clock, mut sum) = (7, FixedStep::new(dt_s, u32::MAX), 0.0);
    let mut counts = [0u32; 4];
    for _ in 0..100_000 {
        let frame = dt_s * (0.5 + uniform(&mut state));
        sum += frame;
        counts[clock.advance(frame).steps as usize] += 1;
        assert!((clock.simulated_s() + clock.pending_s() - sum).abs() < 1e-7);
    }
    assert!(counts[0] > 1000 && counts[2] > 1000, "{counts:?}: no jitter");
    assert_eq!(counts[3], 0);
}

#[test]
fn what_is_no_time_is_counted_and_changes_nothing() {
    let mut clock = FixedStep::new(0.01, 8);
    clock.advance(0.015);
    let before = clock.clone();
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e-9, 1e300] {
        assert_eq!(clock.advance(bad), Advance::default());
    }
    assert_eq!(clock.refused(), 5);
    assert_eq!((clock.steps(), clock.pending_s()), (before.steps(), before.pending_s()));
    assert_eq!(clock.advance(0.0), Advance::default());
    assert_eq!(clock.advance(-0.0), Advance::default());
    assert_eq!(clock.refused(), 5);
}

#[test]
fn the_fraction_lies_between_two_steps() {
    let mut clock = FixedStep::new(0.5, 8);
    for (frame, fraction) in [(0.125, 0.25), (0.25, 0.75), (0.125, 0.0), (1.25, 0.5)] {
        clock.advance(frame);
        assert_eq!(clock.fraction(), fraction);
    }
}

#[test]
#[should_panic(expected = "a step of NaN s")]
fn a_step_that_is_no_number_is_a_mistake() {
    FixedStep::new(f64::NAN, 1);
}
