// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of each kernel variant against the rate at which the device copies memory. What computes something else
//! than its twin is not timed.

use super::{
    depths::{self, DepthBasin},
    hard::water::{from_twin, ROUNDING},
    runs::{self, Basin, Effort, Scheme, Timing, Tunings},
    shapes::{Bench, BenchResult, Skipped},
    Error, OnProgress, Progress, Result,
};
use crate::{
    gpu::{Access, Buffer, Gpu, Kernel, KernelInfo, Residence},
    shaders,
    water::{starts, FusedTuning, Model, Tier, Tuning},
};
use glam::{uvec2, UVec2};

/// What to run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Edges of the grids (cells); those that suit the device if `None`.
    pub sizes: Option<Vec<u32>>,
    /// For each row (s); 3 if `None`.
    pub budget_s: Option<f64>,
}

const SIZES: [u32; 5] = [512, 1024, 2048, 4096, 8192];
/// Beyond it, a software driver takes minutes (cells).
const LARGEST_ON_CPU: u32 = 2048;
/// Sim, variant.
const SYSTEM: [(&str, &str); 3] =
    [("system", "copy/kernel"), ("system", "copy/command"), ("system", "empty")];
const WATER: [&str; 17] = [
    "book",
    "waves/w0",
    "waves/w0.25",
    "waves/w1",
    "waves/w0.25/land",
    "waves/fourth",
    "waves/fourth/land",
    "waves/fused/w0.25",
    "waves/fused/w1",
    "waves/fused/w0.25/land",
    "pipes/w0",
    "pipes/w0.25",
    "pipes/fused/w0",
    "pipes/fused/w0.25",
    "pipes/fused/w0.25/land",
    "wet",
    "shallow",
];

/// Every row there is: sim and variant.
pub fn rows() -> impl Iterator<Item = (&'static str, &'static str)> {
    SYSTEM.into_iter().chain(WATER.map(|variant| ("water", variant)))
}

/// Whether a name begins the variant, or the variant with its sim.
fn is_named(names: &[String], (sim, variant): (&str, &str)) -> bool {
    let begins = |name: &String| {
        variant.starts_with(name.as_str()) || format!("{sim}/{variant}").starts_with(name.as_str())
    };
    names.is_empty() || names.iter().any(begins)
}

/// Runs the rows that `names` name, all if there are none. The copy is always measured: it is what the rest is held
/// against.
///
/// # Errors
/// [`Error::NoSuch`] for a name that is none, [`Error::Wrong`] for a kernel that is not its twin, or the device's. A size
/// that the device cannot hold is no error: it is in `skipped`.
pub fn bench(gpu: &Gpu, names: &[String], options: &Options, progress: OnProgress<'_>) -> Result<Bench> {
    if let Some(wanted) = names.iter().find(|name| !rows().any(|row| is_named(&[(*name).clone()], row))) {
        let have = rows().map(|(sim, variant)| format!("{sim}/{variant}")).collect();
        return Err(Error::NoSuch { what: "bench", wanted: wanted.clone(), have });
    }
    let effort = Effort { budget_s: options.budget_s.unwrap_or(3.0), ..Effort::full(gpu) };
    let variants: Vec<_> = WATER.into_iter().filter(|variant| is_named(names, ("water", variant))).collect();
    let (sizes, left_out) = sizes(gpu, options);
    let (mut done, of) = (0, 2 + variants.len() * sizes.len());
    let mut now = |what: &str| {
        progress(Progress { done, of, now: what });
        done += 1;
    };

    now("system/copy");
    let mut results = copies(gpu, effort)?;
    let copy_bytes_per_s = results.iter().map(|row| row.items_per_s * row.bytes_per_item).fold(0.0, f64::max);
    for row in &mut results {
        row.fraction_of_copy = row.items_per_s * row.bytes_per_item / copy_bytes_per_s;
    }
    now("system/empty");
    results.push(empty(gpu, effort)?);
    results.retain(|row| is_named(names, (&row.sim, &row.variant)));

    let mut skipped = Vec::new();
    for variant in variants {
        for &size in &sizes {
            now(&format!("water/{variant}, {size} x {size}"));
            let tunings = Tunings::for_grid(gpu, UVec2::splat(size));
            match water(gpu, variant, size, tunings, effort) {
                Ok(timing) => {
                    let bytes = bytes_per_cell(variant, tunings);
                    let items = f64::from(size).powi(2);
                    let what = Row { sim: "water", variant, size: square(size), unit: "cell" };
                    results.push(what.timed(timing, items, bytes, copy_bytes_per_s));
                }
                Err(Error::Water(crate::water::Error::Gpu(error))) | Err(Error::Gpu(error))
                    if does_not_fit(&error) =>
                {
                    skipped.push(Skipped {
                        variant: variant.into(),
                        size: square(size),
                        reason: error.to_string(),
                    });
                }
                Err(Error::Water(crate::water::Error::Invalid(invalid))) => skipped.push(Skipped {
                    variant: variant.into(),
                    size: square(size),
                    reason: invalid.to_string(),
                }),
                Err(error) => return Err(error),
            }
        }
        skipped.extend(left_out.iter().map(|&size| Skipped {
            variant: variant.into(),
            size: square(size),
            reason: "a software driver: run when asked for by size".into(),
        }));
    }
    Ok(Bench {
        device: gpu.name().into(),
        driver: gpu.adapter().driver.clone(),
        clock: gpu.clock()?.name().into(),
        copy_bytes_per_s,
        results,
        skipped,
    })
}

/// What a cell needs at the least in a step (bytes): its state read once and written once, and its ground read. The two
/// passes of `shallow` read 20 and 16, and write 8 and 4.
fn bytes_per_cell(variant: &str, tunings: Tunings) -> f64 {
    match depths::tier_of(variant) {
        Some(Tier::Wet) => 28.0,
        Some(Tier::Shallow) => 48.0,
        None => {
            let scheme = Scheme::named(variant);
            scheme.bytes_a_column() / f64::from(tunings.steps(scheme))
        }
    }
}

fn square(size: u32) -> String {
    format!("{size}x{size}")
}

/// Sizes to run, and those that only run when asked for.
fn sizes(gpu: &Gpu, options: &Options) -> (Vec<u32>, Vec<u32>) {
    let wanted = options.sizes.clone().unwrap_or_else(|| SIZES.to_vec());
    let quick =
        |size: &u32| options.sizes.is_some() || !gpu.adapter().is_software() || *size <= LARGEST_ON_CPU;
    wanted.into_iter().partition(quick)
}

fn does_not_fit(error: &crate::gpu::Error) -> bool {
    matches!(error, crate::gpu::Error::Limit { .. } | crate::gpu::Error::Memory { .. })
        || error.is_out_of_memory()
}

struct Row<'a> {
    sim: &'a str,
    variant: &'a str,
    size: String,
    unit: &'a str,
}

impl Row<'_> {
    fn timed(self, timing: Timing, items: f64, bytes_per_item: f64, copy_bytes_per_s: f64) -> BenchResult {
        let items_per_s = items / (1e-3 * timing.median_ms);
        BenchResult {
            sim: self.sim.into(),
            variant: self.variant.into(),
            size: self.size,
            items_per_s,
            unit: self.unit.into(),
            bytes_per_item,
            fraction_of_copy: items_per_s * bytes_per_item / copy_bytes_per_s,
            median_ms: timing.median_ms,
            runs: timing.runs,
            min_ms: Some(timing.min_ms),
            p95_ms: Some(timing.p95_ms),
        }
    }
}

/// Time of a step, once the variant, cut up as it will be, is seen to be its twin on a grid that nothing divides. Noise,
/// undamped: zeros would cost a GPU less power, and waves that die become denormal numbers, which cost a CPU more time.
fn water(gpu: &Gpu, variant: &str, size: u32, tunings: Tunings, effort: Effort) -> Result<Timing> {
    if let Some(tier) = depths::tier_of(variant) {
        let cells = UVec2::splat(size);
        let tuning = tunings.depth.unwrap_or_else(|| tier.tuning(gpu, cells));
        let apart = depths::from_twin(gpu, tier, tuning, uvec2(77, 45))?;
        if apart > depths::ROUNDING {
            return Err(Error::Wrong { variant: variant.into(), apart, allowed: depths::ROUNDING });
        }
        let model = depths::bench_model(tier, cells);
        return DepthBasin::tuned(gpu, tier, &model, &depths::landscape(cells), tuning)?.time(effort);
    }
    let scheme = Scheme::named(variant);
    let apart = from_twin(gpu, scheme, tunings, uvec2(77, 45))?;
    if apart > ROUNDING {
        return Err(Error::Wrong { variant: variant.into(), apart, allowed: ROUNDING });
    }
    let model = scheme.model(starts::model(UVec2::splat(size), scheme.diagonal));
    scheme.check(&model).map_err(crate::water::Error::from)?;
    let model = Model { damping_per_s: 0.0, ..model };
    let start = if scheme.has_land { starts::islands(model) } else { starts::noise(model) };
    Basin::tuned(gpu, scheme, &start, tunings)?.time(effort)
}

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct CopyParams {
    count: u32,
}

fn copy_kernel(gpu: &Gpu) -> Result<Kernel> {
    let info = KernelInfo {
        name: c"gpu.copy",
        spv: shaders::GPU_COPY_COMP,
        blocks: &["From", "To"],
        constants: &[],
    };
    Ok(Kernel::new::<CopyParams>(gpu, &info)?)
}

/// Both ways to copy, at sizes far beyond every cache. Words that differ: zeros may be compressed.
fn copies(gpu: &Gpu, effort: Effort) -> Result<Vec<BenchResult>> {
    const MIB: u64 = 1 << 20;
    let wanted = if gpu.adapter().is_software() { [64 * MIB, 128 * MIB] } else { [512 * MIB, 1024 * MIB] };
    let limits = gpu.limits();
    let groups = 16 * 256 * u64::from(limits.max_compute_work_group_count[0]);
    let most = groups.min(u64::from(limits.max_storage_buffer_range)) / MIB * MIB;
    let mut sizes = wanted.map(|bytes| bytes.min(most)).to_vec();
    sizes.dedup();
    let kernel = copy_kernel(gpu)?;
    let mut rows = Vec::new();
    for bytes in sizes {
        let buffers = Buffer::new(gpu, "bench.from", bytes, Residence::Device)
            .and_then(|from| Ok((from, Buffer::new(gpu, "bench.to", bytes, Residence::Device)?)));
        let (from, to) = match buffers {
            Err(error) if does_not_fit(&error) && !rows.is_empty() => break,
            other => other?,
        };
        let words: Vec<u32> = (0..bytes / 4).map(|i| (i as u32).wrapping_mul(0x9e37_79b9)).collect();
        gpu.upload_to(&from, &words)?;
        drop(words);
        let bound = kernel.bind(&[("From", (&from).into()), ("To", (&to).into())])?;
        let count = (bytes / 16) as u32;
        let by_kernel = runs::time(gpu, effort, |rec| {
            rec.dispatch(&bound, [count, 1, 1], &CopyParams { count });
            rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
        })?;
        let by_command = runs::time(gpu, effort, |rec| {
            rec.copy(&from, &to);
            rec.barrier(Access::CopyWrite, Access::CopyWrite);
        })?;
        for (variant, timing) in [("copy/kernel", by_kernel), ("copy/command", by_command)] {
            let what = Row { sim: "system", variant, size: format!("{}MiB", bytes / MIB), unit: "byte" };
            rows.push(what.timed(timing, bytes as f64, 2.0, f64::INFINITY)); // the fraction is known after the last
        }
    }
    Ok(rows)
}

/// A dispatch that does nothing, and its barrier.
fn empty(gpu: &Gpu, effort: Effort) -> Result<BenchResult> {
    let buffers = ["bench.from", "bench.to"].map(|name| Buffer::new(gpu, name, 4096, Residence::Device));
    let [from, to] = buffers;
    let (from, to) = (from?, to?);
    let bound = copy_kernel(gpu)?.bind(&[("From", (&from).into()), ("To", (&to).into())])?;
    let timing = runs::time(gpu, effort, |rec| {
        rec.dispatch(&bound, [1, 1, 1], &CopyParams { count: 0 });
        rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
    })?;
    let what = Row { sim: "system", variant: "empty", size: "1".into(), unit: "dispatch" };
    Ok(what.timed(timing, 1.0, 0.0, f64::INFINITY))
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
    if !WATER.contains(&variant) {
        let have = WATER.map(String::from).to_vec();
        return Err(Error::NoSuch { what: "variant to tune", wanted: variant.into(), have });
    }
    let effort = Effort { run_ms: 10.0, fewest_runs: 9, budget_s: 0.5 };
    let rows = [1, 2, 4, 8, 16, 32];
    let mut rates = Vec::new();
    let tunings = GROUPS.iter().flat_map(|&group| rows.map(|rows| Tuning { group, rows }));
    for (done, tuning) in tunings.enumerate() {
        let Tuning { group, rows: walked } = tuning;
        let now = format!("{}x{}, {walked} rows", group.x, group.y);
        progress(Progress { done, of: GROUPS.len() * rows.len(), now: &now });
        let tunings =
            Tunings { waves: tuning, depth: Some(tuning), ..Tunings::for_grid(gpu, UVec2::splat(size)) };
        match water(gpu, variant, size, tunings, effort) {
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
        match water(gpu, variant, size, tunings, effort) {
            Ok(timing) => rates.push((fused, f64::from(size).powi(2) / (1e-3 * timing.median_ms))),
            Err(Error::Gpu(crate::gpu::Error::Interface { .. })) => {}
            Err(error) => return Err(error),
        }
    }
    rates.sort_by(|a, b| b.1.total_cmp(&a.1));
    Ok(rates)
}
