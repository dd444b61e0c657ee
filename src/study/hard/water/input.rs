// SPDX-License-Identifier: MIT OR Apache-2.0
//! Sources that are no numbers.

use crate::{
    study::{
        hard::{Context, Outcome},
        runs::{book_constants, Basin, Scheme},
        Result,
    },
    water::{
        cpu,
        starts::{self, Start},
        Counts, Disturbance, Error,
    },
};
use glam::{vec2, UVec2};

const STEPS: u32 = 10;
const BAD: [f32; 4] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30];

pub fn absurd_sources(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let scheme = Scheme::named(variant);
    let start = starts::hump(scheme.model(book_constants(UVec2::splat(64))));
    let run = |spoil: &mut dyn FnMut(&mut Basin) -> Result<()>| -> Result<Vec<u32>> {
        let mut basin = Basin::new(context.gpu, scheme, &start)?;
        basin.steps(STEPS)?;
        spoil(&mut basin)?;
        basin.steps(STEPS)?;
        Ok(basin.heights()?.into_iter().map(f32::to_bits).collect())
    };
    let clean = run(&mut |_| Ok(()))?;
    let mut tally = (0, Counts::default(), 0);
    let spoiled = run(&mut |basin| {
        tally = spoil(basin, &start.height_m)?;
        Ok(())
    })?;
    let changed = clean.iter().zip(&spoiled).filter(|(a, b)| a != b).count();
    let (uploads_refused, counts, sources) = tally;
    let all = uploads_refused == BAD.len() && counts == Counts { rejected: sources, ..Default::default() };
    let finite = spoiled.iter().all(|bits| f32::from_bits(*bits).is_finite());
    Ok(Outcome::of(changed as f64).seed(spread_of_a_nan(&start)).only_if(all && finite).note(format!(
        "{uploads_refused} of {} starts refused, {} of {sources} disturbances counted as rejected; a NaN in one column \
         of the listings, {STEPS} frames later",
        BAD.len(),
        counts.rejected
    )))
}

/// Columns of the listings that are no number, some frames after one was.
fn spread_of_a_nan(start: &Start) -> f64 {
    let mut seed = cpu::BookAsPrinted::at_rest(start.model.cells, &start.height_m);
    seed.height_m[32 * 64 + 32] = f64::NAN;
    (0..STEPS).for_each(|_| seed.frame(1.0 / 60.0));
    seed.height_m.iter().filter(|h| !h.is_finite()).count() as f64
}

/// Starts refused, what became of the disturbances, and how many those were.
fn spoil(basin: &mut Basin, start: &[f32]) -> Result<(usize, Counts, u32)> {
    let mut refused = 0;
    for bad in BAD {
        let mut height = start.to_vec();
        height[100] = bad;
        refused +=
            usize::from(matches!(basin.upload(&height), Err(crate::study::Error::Water(Error::Invalid(_)))));
    }
    let good = Disturbance { at_m: vec2(32.0, 32.0), radius_m: 3.0, volume_m3: 1.0, ..Default::default() };
    let sources: Vec<Disturbance> = BAD
        .into_iter()
        .flat_map(|bad| {
            [
                Disturbance { volume_m3: bad, ..good },
                Disturbance { volume_m3: -bad, ..good },
                Disturbance { push_m3ps: bad, ..good },
            ]
        })
        .chain(BAD.into_iter().filter(|bad| !bad.is_finite()).flat_map(|bad| {
            [
                Disturbance { radius_m: bad, ..good },
                Disturbance { at_m: vec2(bad, 1.0), ..good },
                Disturbance { at_m: vec2(1.0, bad), ..good },
            ]
        }))
        .collect();
    Ok((refused, basin.disturb(&sources)?, sources.len() as u32))
}
