// SPDX-License-Identifier: MIT OR Apache-2.0
//! How long the device takes.

use crate::{
    gpu::{Clock, Gpu, Recorder, Submitter},
    study::Result,
};
use std::time::Instant;

/// How long to time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Shortest run: one submission of as many repetitions as it takes (ms).
    pub run_ms: f64,
    /// Fewest runs, if the budget allows.
    pub fewest_runs: u32,
    /// No run begins later than this after the first, but for the first three (s).
    pub budget_s: f64,
}

impl Effort {
    /// What a bench takes on this device.
    pub fn full(gpu: &Gpu) -> Self {
        Self { run_ms: 20.0, fewest_runs: if gpu.adapter().is_software() { 9 } else { 50 }, budget_s: 3.0 }
    }
}

/// Time of one repetition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// (ms).
    pub median_ms: f64,
    /// (ms).
    pub min_ms: f64,
    /// 95th percentile (ms).
    pub p95_ms: f64,
    /// How many runs were timed.
    pub runs: u32,
}

/// A GPU that idled, as while a start is computed, takes this long to raise its clocks again (s): without it an H100 was
/// seen at 0.3 of its rate.
const WARM_UP_S: f64 = 0.5;

/// Times what `record` records, barriers included: many repetitions a submission, by the clock that can be believed.
///
/// # Errors
/// The device's.
pub fn time(gpu: &Gpu, effort: Effort, mut record: impl FnMut(&mut Recorder<'_>)) -> Result<Timing> {
    // One span around all: the spans inside find no room and are not timed. A fence would count recording as well, so
    // there the submission as a whole is timed.
    let is_gpu = gpu.clock()? == Clock::Gpu;
    let mut submitter = Submitter::new(gpu, usize::from(is_gpu))?;
    let mut run = |repeats: u32| -> Result<f64> {
        let times = submitter.run(|rec| {
            rec.span(c"bench", |rec| (0..repeats).for_each(|_| record(rec)));
        })?;
        Ok(if is_gpu { times.of(c"bench") } else { times.wall_ms })
    };
    run(1)?; // first touch
             // Whatever the budget: a short run of slow clocks would be believed.
    let (begun, warm_up_s) = (Instant::now(), if gpu.adapter().is_software() { 0.0 } else { WARM_UP_S });
    let mut repeats = 1;
    let mut ms = run(repeats)?;
    while (ms < effort.run_ms || begun.elapsed().as_secs_f64() < warm_up_s) && repeats < 1 << 16 {
        // Toward the goal in bounded leaps: a first measurement may be far off.
        let leap = (1.1 * effort.run_ms / ms.max(1e-3)).clamp(1.0, 16.0);
        repeats = (f64::from(repeats) * leap).ceil() as u32;
        ms = run(repeats)?;
    }
    let begun = Instant::now();
    let mut each = Vec::new();
    while each.len() < 3
        || (each.len() < effort.fewest_runs as usize && begun.elapsed().as_secs_f64() < effort.budget_s)
    {
        each.push(run(repeats)? / f64::from(repeats));
    }
    each.sort_by(f64::total_cmp);
    let at = |share: f64| each[((each.len() - 1) as f64 * share).round() as usize];
    Ok(Timing { median_ms: at(0.5), min_ms: each[0], p95_ms: at(0.95), runs: each.len() as u32 })
}
