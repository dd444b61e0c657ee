// SPDX-License-Identifier: MIT OR Apache-2.0
//! Water that stays where it is, and waves that do not grow.

use crate::{
    study::{
        hard::{Context, Outcome},
        runs::{book_constants, larger, rms, Basin, Scheme},
        Result,
    },
    water::{cpu, oracle, starts, Model},
};
use glam::UVec2;
use std::sync::LazyLock;

/// What the listings do to a lake of 64 x 64 columns in 3600 frames.
static PRINTED_LOSS: LazyLock<f64> = LazyLock::new(|| {
    let cells = UVec2::splat(64);
    let flat = vec![1.0; 64 * 64];
    let mut seed = cpu::BookAsPrinted::at_rest(cells, &flat);
    (0..3600).for_each(|_| seed.frame(1.0 / 60.0));
    seed.height_m.iter().sum::<f64>() / oracle::volume(&flat) - 1.0
});

pub fn flat_lake(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    const STEPS: u32 = 100_000;
    const PART: u32 = 2000;
    let scheme = Scheme::named(variant);
    let start = starts::flat(scheme.model(book_constants(UVec2::splat(64))), 1.0);
    let mut basin = Basin::new(context.gpu, scheme, &start)?;
    let (mut taken, mut is_fixed) = (0, false);
    // What a step leaves as it was to the bit, every other step does too. A GPU takes them all the same: it may have races.
    while taken < STEPS && !(is_fixed && context.gpu.adapter().is_software()) {
        basin.steps(PART - 1)?;
        let before = basin.words()?;
        basin.steps(1)?;
        taken += PART;
        is_fixed = basin.words()? == before;
    }
    let height = basin.heights()?;
    let worst = height.iter().map(|h| f64::from(h - 1.0).abs()).fold(0.0, larger);
    let ulp = worst / f64::from(f32::EPSILON);
    Ok(Outcome::of(oracle::volume(&height) / oracle::volume(&start.height_m) - 1.0)
        .seed(*PRINTED_LOSS)
        .only_if(ulp <= 2.0 && height.iter().all(|h| h.is_finite()))
        .note(format!(
            "{ulp} ulp from flat after {taken} steps{}; the listings as printed after 3600 frames of 1/60 s",
            if is_fixed { ", and a step changes no bit, so no other will" } else { "" }
        )))
}

pub fn longest_step(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    const STEPS: u32 = 4000;
    const LOOKS: u32 = 10;
    let scheme = Scheme::named(variant);
    let model = scheme.model(Model { damping_per_s: 0.0, ..book_constants(UVec2::splat(64)) });
    let below = model.with_courant(0.99 * model.courant_limit());
    let above = model.with_courant(1.01 * model.courant_limit());
    let start = starts::noise(below);
    let mut basin = Basin::new(context.gpu, scheme, &start)?;
    // With the first half step every wave swings as cos(n turn): the rms can never exceed that of the start.
    basin.first_step()?;
    let mut worst = 0.0;
    for _ in 0..LOOKS {
        basin.steps(STEPS / LOOKS)?;
        worst = larger(worst, rms(&basin.heights()?) / rms(&start.height_m));
    }
    let refused = above.check().err();
    Ok(Outcome::of(worst.powf(1.0 / f64::from(STEPS)))
        .seed(growth_in_twin(&starts::noise(above)))
        .only_if(worst.is_finite() && refused.is_some() && below.check().is_ok())
        .note(format!(
            "rms {worst:.3} of the start's at most; above: {}",
            refused.map_or("not refused".into(), |why| why.to_string())
        )))
}

/// Growth per step once the fastest wave has outgrown the others.
fn growth_in_twin(start: &starts::Start) -> f64 {
    let mut twin = cpu::Waves::<f64>::at_rest(&start.model, &start.height_m);
    (0..100).for_each(|_| twin.step());
    let early = rms(&twin.height_m);
    (0..100).for_each(|_| twin.step());
    (rms(&twin.height_m) / early).powf(0.01)
}

pub fn averaged_flow(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    const STEPS: u32 = 3600;
    let scheme = Scheme::named(variant);
    let start = starts::noise(scheme.model(book_constants(UVec2::splat(32))));
    let mut basin = Basin::new(context.gpu, scheme, &start)?;
    basin.first_step()?;
    basin.steps(STEPS - 1)?;
    let mut twin = cpu::Book::<f64>::at_rest(&start.model, &start.height_m);
    (0..STEPS).for_each(|_| twin.step_averaged());
    let highest = twin.height_m.iter().fold(0.0, |most, h| f64::max(most, h.abs()));
    let of_start = |now: f64| now / rms(&start.height_m);
    // Must blow up, or the twin averages something else: from 1e-3 m to more than 1e3 m.
    Ok(Outcome::of(of_start(rms(&basin.heights()?)))
        .seed(of_start(rms(&twin.height_m)))
        .only_if(highest > 1e3)
        .note(format!("averaged: from 1e-3 m to {highest:.1e} m")))
}

pub fn checkerboard(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let scheme = Scheme::named(variant);
    let cells = UVec2::splat(64);
    let model = scheme.model(Model { damping_per_s: 0.0, ..book_constants(cells) });
    let model = model.with_courant(0.9 * model.courant_limit());
    let board: Vec<f64> = (0..cells.element_product())
        .map(|i| if (i + i / cells.x).is_multiple_of(2) { 1.0 } else { -1.0 })
        .collect();
    let height_m: Vec<f32> = board.iter().map(|&sign| 0.1 * sign as f32).collect();
    let start = starts::Start { name: "checkerboard", model, height_m };
    let mut basin = Basin::new(context.gpu, scheme, &start)?;
    basin.first_step()?;
    let share = |height: &[f32]| oracle::amplitude(height, &board).abs() / 0.1;
    let mut largest = share(&basin.heights()?);
    // Steps in odd strides, to meet the swing at every phase.
    for _ in 0..100 {
        basin.steps(37)?;
        largest = larger(largest, share(&basin.heights()?));
    }
    Ok(Outcome::of(largest).note("after 1 to 3701 steps without damping"))
}
