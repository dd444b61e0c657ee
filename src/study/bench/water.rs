// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of water, and its tunings.

use super::{Measured, Suite};
use crate::{
    gpu::Gpu,
    study::{
        depths::{self, DepthBasin},
        hard::water::{from_twin, ROUNDING},
        must_be_within,
        runs::{Basin, Effort, Scheme, Timing, Tunings},
        Error, OnProgress, Progress, Result,
    },
    water::{starts, FusedTuning, Model, Tier, Tuning},
};
use glam::{uvec2, UVec2};

/// Its rows.
pub const SUITE: Suite = Suite {
    sim: "water",
    variants: &VARIANTS,
    sizes: &[256, 512, 1024, 2048, 4096, 8192],
    largest_on_cpu: 2048,
    label: |size| format!("{size}x{size}"),
    run: |gpu, variant, size, effort| {
        let tunings = Tunings::for_grid(gpu, UVec2::splat(size));
        let timing = step(gpu, variant, size, tunings, effort)?;
        let bytes_per_item = bytes_per_cell(variant, tunings);
        Ok(Measured { timing, items: f64::from(size).powi(2), unit: "cell", bytes_per_item })
    },
};

const VARIANTS: [&str; 21] = [
    "book",
    "waves/w0",
    "waves/w0.25",
    "waves/w1",
    "waves/w0.25/land",
    "waves/f16/w0.25",
    "waves/fourth",
    "waves/fourth/land",
    "waves/fused/w0.25",
    "waves/fused/w1",
    "waves/fused/f16/w0.25",
    "waves/fused/w0.25/land",
    "waves/fused/w0.25/coast",
    "pipes/w0",
    "pipes/w0.25",
    "pipes/fused/w0",
    "pipes/fused/w0.25",
    "pipes/fused/w0.25/land",
    "pipes/fused/w0.25/coast",
    "wet",
    "shallow",
];

/// What a cell needs at the least in a step (bytes): its state read once and written once, and its ground read. That of
/// `shallow` is rise, rise before and two velocities.
fn bytes_per_cell(variant: &str, tunings: Tunings) -> f64 {
    match depths::tier_of(variant) {
        Some(Tier::Wet) => 28.0,
        Some(Tier::Shallow) => 36.0,
        None => {
            let scheme = Scheme::named(variant);
            scheme.bytes_a_column() / f64::from(tunings.steps(scheme))
        }
    }
}

/// Simulated time of a step (s) on the grids of the linear study: waves of 1 m/s in a basin of 10 m, 0.95 of the longest
/// step. Of `wet` and `shallow` it is the fastest wave, and current, that goes 1 m/s.
pub fn step_s(variant: &str, size: u32) -> f64 {
    let courant = match depths::tier_of(variant) {
        Some(tier) => tier.courant_limit(),
        None => {
            let scheme = Scheme::named(variant);
            scheme.courant_limit(&scheme.model(starts::model(UVec2::splat(size), scheme.diagonal)))
        }
    };
    0.95 * courant * 10.0 / f64::from(size)
}

/// As [`ROUNDING`], with u = 2^-11 and one rounding each of the height, 16 * 2.3 u, and of the velocity,
/// 2.5 u * (1 + 2 + .. + 16): 0.18 if all errors had one sign. A tenth of it: 0.0023 is measured.
const ROUNDING_TO_HALVES: f64 = 37.7 / (1 << 11) as f64;

/// Time of a step, once the variant, cut up as it will be, is seen to be its twin on a grid that nothing divides. Noise,
/// undamped: zeros would cost a GPU less power, and waves that die become denormal numbers, which cost a CPU more time.
fn step(gpu: &Gpu, variant: &str, size: u32, tunings: Tunings, effort: Effort) -> Result<Timing> {
    if let Some(tier) = depths::tier_of(variant) {
        let cells = UVec2::splat(size);
        let tuning = tunings.depth.unwrap_or_else(|| tier.tuning(gpu, cells));
        let apart = depths::from_twin(gpu, tier, tuning, uvec2(77, 45))?;
        must_be_within(variant, apart, depths::ROUNDING)?;
        let model = depths::bench_model(tier, cells);
        return DepthBasin::tuned(gpu, tier, &model, &depths::landscape(cells), tuning)?.time(effort);
    }
    let scheme = Scheme::named(variant);
    let allowed = if scheme.is_f16 { ROUNDING_TO_HALVES } else { ROUNDING };
    must_be_within(variant, from_twin(gpu, scheme, tunings, uvec2(77, 45))?, allowed)?;
    let model = scheme.model(starts::model(UVec2::splat(size), scheme.diagonal));
    scheme.check(&model).map_err(crate::water::Error::from)?;
    let model = Model { damping_per_s: 0.0, ..model };
    let start = match scheme.has_land {
        true if variant.ends_with("coast") => starts::coast(model),
        true => starts::islands(model),
        false => starts::noise(model),
    };
    Basin::tuned(gpu, scheme, &start, tunings)?.time(effort)
}

const GROUPS: [UVec2; 13] = [
    uvec2(32, 1),
    uvec2(32, 2),
    uvec2(32, 4),
    uvec2(32, 8),
    uvec2(64, 1),
    uvec2(64, 2),
    uvec2(64, 4),
    uvec2(128, 1),
    uvec2(128, 2),
    uvec2(256, 1),
    uvec2(16, 8),
    uvec2(16, 16),
    uvec2(8, 8),
];

/// Of `shallow`, which are one lane high.
const WALKS: [UVec2; 3] = [uvec2(32, 1), uvec2(64, 1), uvec2(128, 1)];

/// Cells per second of a variant with every tuning, on a grid of `size` by `size`, the fastest first. A tuning that the
/// device does not take is left out.
///
/// # Errors
/// [`Error::NoSuch`], or the device's.
pub fn sweep_tuning(
    gpu: &Gpu,
    variant: &str,
    size: u32,
    progress: OnProgress<'_>,
) -> Result<Vec<(Tuning, f64)>> {
    if !VARIANTS.contains(&variant) {
        let have = VARIANTS.map(String::from).to_vec();
        return Err(Error::NoSuch { what: "variant to tune", wanted: variant.into(), have });
    }
    let effort = Effort { run_ms: 10.0, fewest_runs: 9, budget_s: 0.5 };
    let (groups, rows): (&[UVec2], &[u32]) = match depths::tier_of(variant) {
        Some(Tier::Shallow) => (&WALKS, &[13, 29, 45, 61, 93, 125]),
        _ => (&GROUPS, &[1, 2, 4, 8, 16, 32]),
    };
    let mut rates = Vec::new();
    let tunings = groups.iter().flat_map(|&group| rows.iter().map(move |&rows| Tuning { group, rows }));
    for (done, tuning) in tunings.enumerate() {
        let Tuning { group, rows: walked } = tuning;
        let now = format!("{}x{}, {walked} rows", group.x, group.y);
        progress(Progress { done, of: groups.len() * rows.len(), now: &now });
        let tunings =
            Tunings { waves: tuning, depth: Some(tuning), ..Tunings::for_grid(gpu, UVec2::splat(size)) };
        match step(gpu, variant, size, tunings, effort) {
            Ok(timing) => rates.push((tuning, f64::from(size).powi(2) / (1e-3 * timing.median_ms))),
            Err(Error::Gpu(crate::gpu::Error::Interface { .. })) => {}
            Err(error) => return Err(error),
        }
    }
    rates.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(rates)
}

/// Workgroup and rows: tiles of 64 x 32 to 256 x 64.
const TILES: [(UVec2, u32); 20] = [
    (uvec2(16, 4), 8),
    (uvec2(16, 4), 16),
    (uvec2(16, 8), 4),
    (uvec2(16, 8), 8),
    (uvec2(16, 16), 4),
    (uvec2(32, 1), 24),
    (uvec2(32, 1), 31),
    (uvec2(32, 2), 16),
    (uvec2(32, 4), 8),
    (uvec2(32, 4), 12),
    (uvec2(32, 4), 16),
    (uvec2(32, 8), 4),
    (uvec2(32, 8), 6),
    (uvec2(32, 8), 8),
    (uvec2(32, 16), 2),
    (uvec2(32, 16), 3),
    (uvec2(32, 16), 4),
    (uvec2(64, 1), 24),
    (uvec2(64, 4), 8),
    (uvec2(64, 8), 4),
];

/// Cells times steps per second of `waves/fused/..` or `pipes/fused/..` with every tuning, as [`sweep_tuning`].
///
/// # Errors
/// The device's.
pub fn sweep_fused(
    gpu: &Gpu,
    variant: &str,
    size: u32,
    progress: OnProgress<'_>,
) -> Result<Vec<(FusedTuning, f64)>> {
    let effort = Effort { run_ms: 10.0, fewest_runs: 9, budget_s: 0.5 };
    let steps = [2, 4, 6, 8, 12];
    let mut rates = Vec::new();
    let tunings: Vec<_> = TILES
        .iter()
        .flat_map(|&(group, rows)| steps.map(|steps| (group, rows, steps)))
        .flat_map(|(group, rows, steps)| [1, 2].map(|buffers| FusedTuning { group, rows, steps, buffers }))
        .collect();
    for (done, &fused) in tunings.iter().enumerate() {
        let tile = fused.tile();
        let now = format!("{} x {}, {} rows, {} steps", tile.x, tile.y, fused.rows, fused.steps);
        progress(Progress { done, of: tunings.len(), now: &now });
        let tunings = Tunings { fused, pipes: fused, ..Tunings::for_grid(gpu, UVec2::splat(size)) };
        match step(gpu, variant, size, tunings, effort) {
            Ok(timing) => rates.push((fused, f64::from(size).powi(2) / (1e-3 * timing.median_ms))),
            Err(Error::Gpu(crate::gpu::Error::Interface { .. })) => {}
            Err(error) => return Err(error),
        }
    }
    rates.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(rates)
}
