// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of each kernel variant against the rate at which the device copies memory. What computes something else
//! than its twin is not timed.

pub mod ballistic;
pub mod black_hole;
mod colliding;
pub mod disks;
pub mod draw;
mod kindled;
pub mod paint;
pub mod particles;
pub mod prims;
pub mod ripples;
pub mod volume;
pub mod water;

use super::{
    runs::{self, Effort, Timing},
    shapes::{Bench, BenchResult, Skipped},
    Error, OnProgress, Progress, Result,
};
use crate::{
    gpu::{Access, Buffer, Gpu, Kernel, KernelInfo, Residence},
    shaders,
};

/// What to run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Sizes, in the unit of each suite (edges of grids, numbers of particles); those that suit the device if `None`.
    pub sizes: Option<Vec<u32>>,
    /// For each row (s); 3 if `None`.
    pub budget_s: Option<f64>,
}

/// The variants of a simulation, and how they are timed.
pub struct Suite {
    /// As results name it.
    pub sim: &'static str,
    /// As results name them.
    pub variants: &'static [&'static str],
    /// Sizes to run when none are asked for.
    pub sizes: &'static [u32],
    /// Beyond it, a software driver takes minutes.
    pub largest_on_cpu: u32,
    /// A size, for people.
    pub label: fn(u32) -> String,
    /// Times a variant at a size, once it is seen to compute what its twin does.
    pub run: fn(&Gpu, &str, u32, Effort) -> Result<Measured>,
}

/// What a suite found.
pub struct Measured {
    /// Of one run.
    pub timing: Timing,
    /// Items of one run.
    pub items: f64,
    /// What an item is.
    pub unit: &'static str,
    /// Memory traffic that an item needs at the least (bytes).
    pub bytes_per_item: f64,
}

/// Every simulation's.
const SUITES: &[Suite] = &[
    water::SUITE,
    particles::SUITE,
    black_hole::SUITE,
    ballistic::SUITE,
    draw::SUITE,
    disks::SUITE,
    volume::SUITE,
    paint::SUITE,
    colliding::SUITE,
    ripples::SUITE,
    prims::SUITE,
];

/// Sim, variant.
const SYSTEM: [(&str, &str); 3] =
    [("system", "copy/kernel"), ("system", "copy/command"), ("system", "empty")];

/// Every row there is: sim and variant.
pub fn rows() -> impl Iterator<Item = (&'static str, &'static str)> {
    let of = |suite: &'static Suite| suite.variants.iter().map(move |variant| (suite.sim, *variant));
    SYSTEM.into_iter().chain(SUITES.iter().flat_map(of))
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
    // Runs so short that the budget has room for some.
    let (budget_s, full) = (options.budget_s.unwrap_or(3.0), Effort::full(gpu));
    let effort = Effort { budget_s, run_ms: full.run_ms.min(200.0 * budget_s), ..full };
    let (mut runs, mut left_out) = (Vec::new(), Vec::new());
    for suite in SUITES {
        for variant in suite.variants.iter().filter(|variant| is_named(names, (suite.sim, variant))) {
            for &size in options.sizes.as_deref().unwrap_or(suite.sizes) {
                let is_left =
                    options.sizes.is_none() && gpu.adapter().is_software() && size > suite.largest_on_cpu;
                if is_left { &mut left_out } else { &mut runs }.push((suite, *variant, size));
            }
        }
    }
    let (mut done, of) = (0, 2 + runs.len());
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

    let skip = |suite: &Suite, variant: &str, size: u32, reason: String| Skipped {
        variant: variant.into(),
        size: (suite.label)(size),
        reason,
    };
    let mut skipped = Vec::new();
    for (suite, variant, size) in runs {
        now(&format!("{}/{variant}, {}", suite.sim, (suite.label)(size)));
        match (suite.run)(gpu, variant, size, effort) {
            Ok(measured) => {
                let what = Row { sim: suite.sim, variant, size: (suite.label)(size), unit: measured.unit };
                let mut row =
                    what.timed(measured.timing, measured.items, measured.bytes_per_item, copy_bytes_per_s);
                if suite.sim == water::SUITE.sim {
                    row.ms_per_sim_second = Some(row.median_ms / water::step_s(variant, size));
                }
                results.push(row);
            }
            Err(error) => skipped.push(skip(suite, variant, size, reason_to_skip(error)?)),
        }
    }
    let why = "a software driver: run when asked for by size";
    skipped.extend(
        left_out.into_iter().map(|(suite, variant, size)| skip(suite, variant, size, why.to_string())),
    );
    Ok(Bench {
        device: gpu.name().into(),
        driver: gpu.adapter().driver.clone(),
        clock: gpu.clock()?.name().into(),
        edited: gpu.edited_shaders(),
        copy_bytes_per_s,
        results,
        skipped,
    })
}

/// What the device cannot hold, or a grid too small for a variant, is left out; anything else is an error.
fn reason_to_skip(error: Error) -> Result<String> {
    match error {
        Error::Water(crate::water::Error::Gpu(error))
        | Error::Particles(crate::particles::Error::Gpu(error))
        | Error::Disks(crate::disks::Error::Gpu(error))
        | Error::Paint(crate::paint::Error::Gpu(error))
        | Error::Gpu(error)
            if does_not_fit(&error) || matches!(error, crate::gpu::Error::Interface { .. }) =>
        {
            Ok(error.to_string())
        }
        Error::Particles(crate::particles::Error::Invalid(invalid)) => Ok(invalid.to_string()),
        Error::Water(crate::water::Error::Invalid(invalid)) => Ok(invalid.to_string()),
        error @ Error::Lacks { .. } => Ok(error.to_string()),
        error => Err(error),
    }
}

fn does_not_fit(error: &crate::gpu::Error) -> bool {
    matches!(
        error,
        crate::gpu::Error::Limit { .. } | crate::gpu::Error::Memory { .. } | crate::gpu::Error::Lacks { .. }
    ) || error.is_out_of_memory()
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
            ms_per_sim_second: None,
            runs: timing.runs,
            min_ms: Some(timing.min_ms),
            p95_ms: Some(timing.p95_ms),
        }
    }
}

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct CopyParams {
    count: u32,
}

pub(super) fn copy_kernel(gpu: &Gpu) -> Result<Kernel> {
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
