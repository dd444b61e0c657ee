// SPDX-License-Identifier: MIT OR Apache-2.0
//! The stable machine-readable output: hard cases, benchmarks and work-precision studies, and their text
//! forms.
//!
//! JSON has no NaN or infinity. A quantity that a failing run can make non-finite (`measured`, `error`) is an
//! `Option`, `None` and `null` standing for "not a finite number": fill it through [`finite`]. Every other
//! number must be finite, and serialising one that is not is an error that names the value, never a silent
//! `null`.

use std::fmt::Write;

use serde::{Deserialize, Serialize, Serializer};

/// `Some(x)` when `x` is a finite number: how a measurement that may have blown up enters an `Option<f64>`
/// field.
pub fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn number<S: Serializer>(x: &f64, to: S) -> Result<S::Ok, S::Error> {
    if x.is_finite() {
        to.serialize_f64(*x)
    } else {
        Err(serde::ser::Error::custom(format_args!("{x} is not a finite number")))
    }
}

fn number_or_null<S: Serializer>(x: &Option<f64>, to: S) -> Result<S::Ok, S::Error> {
    match x {
        Some(x) => number(x, to),
        None => to.serialize_none(),
    }
}

/// The hard cases of every simulation, as measured on one device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HardCases {
    /// The device's name.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
    /// What is known of the clocks during the measurement.
    pub clock: String,
    /// Shaders that were not the binary's ([`Gpu::edited_shaders`](crate::gpu::Gpu::edited_shaders)).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub edited: Vec<String>,
    /// One entry for each case and variant.
    pub cases: Vec<HardCase>,
}

/// One hard case: a measured quantity against its limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HardCase {
    /// Stable identifier.
    pub id: String,
    /// One line for people.
    pub title: String,
    /// The variant of the simulation that ran.
    pub variant: String,
    /// The quantity (`unit`), or `None` when the run made it non-finite.
    #[serde(serialize_with = "number_or_null")]
    pub measured: Option<f64>,
    /// What it is held against (`unit`).
    #[serde(serialize_with = "number")]
    pub limit: f64,
    /// The unit of `measured` and `limit`.
    pub unit: String,
    /// Whether the case holds; never when `measured` is `None`.
    pub pass: bool,
    /// The same quantity for the simple variant that the others started from (`unit`).
    #[serde(default, skip_serializing_if = "Option::is_none", serialize_with = "number_or_null")]
    pub seed_measured: Option<f64>,
    /// What a reader must know to judge the number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// Throughputs on one device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bench {
    /// The device's name.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
    /// What is known of the clocks during the measurement.
    pub clock: String,
    /// Shaders that were not the binary's ([`Gpu::edited_shaders`](crate::gpu::Gpu::edited_shaders)).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub edited: Vec<String>,
    /// Bytes read plus bytes written by a plain device copy (bytes per second).
    #[serde(serialize_with = "number")]
    pub copy_bytes_per_s: f64,
    /// One entry for each variant and size that ran.
    pub results: Vec<BenchResult>,
    /// What did not run, and why.
    pub skipped: Vec<Skipped>,
}

/// The throughput of one variant at one size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BenchResult {
    /// The simulation.
    pub sim: String,
    /// Its variant.
    pub variant: String,
    /// Its size, such as `4096x4096`.
    pub size: String,
    /// `unit`s processed (per second).
    #[serde(serialize_with = "number")]
    pub items_per_s: f64,
    /// What one item is, such as `cell` or `particle`.
    pub unit: String,
    /// Memory traffic that one item needs at the least (bytes).
    #[serde(serialize_with = "number")]
    pub bytes_per_item: f64,
    /// `items_per_s * bytes_per_item` as a fraction of the copy's rate.
    #[serde(serialize_with = "number")]
    pub fraction_of_copy: f64,
    /// Median time of one run (ms).
    #[serde(serialize_with = "number")]
    pub median_ms: f64,
    /// Median time of the runs that a simulated second takes (ms), dispatches included; where a run has a length.
    #[serde(default, skip_serializing_if = "Option::is_none", serialize_with = "number_or_null")]
    pub ms_per_sim_second: Option<f64>,
    /// How many runs were timed.
    pub runs: u32,
    /// The fastest run (ms).
    #[serde(default, skip_serializing_if = "Option::is_none", serialize_with = "number_or_null")]
    pub min_ms: Option<f64>,
    /// The 95th percentile of the runs (ms).
    #[serde(default, skip_serializing_if = "Option::is_none", serialize_with = "number_or_null")]
    pub p95_ms: Option<f64>,
}

/// A benchmark that did not run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skipped {
    /// The variant.
    pub variant: String,
    /// The size.
    pub size: String,
    /// Why it did not run.
    pub reason: String,
}

/// Work-precision studies on one device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Study {
    /// The device's name.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
    /// What is known of the clocks during the measurement.
    pub clock: String,
    /// Shaders that were not the binary's ([`Gpu::edited_shaders`](crate::gpu::Gpu::edited_shaders)).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub edited: Vec<String>,
    /// The studies.
    pub studies: Vec<StudyResult>,
    /// What they found, in a line each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub headlines: Vec<Headline>,
    /// Where the error comes from, for some of the points.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<Parts>,
}

/// A finding in one number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Headline {
    /// The simulation.
    pub sim: String,
    /// The studies that it is of.
    pub study: String,
    /// What the number is.
    pub what: String,
    /// The number (`unit`), or `None` when nothing that ran gives it.
    #[serde(serialize_with = "number_or_null")]
    pub value: Option<f64>,
    /// Its unit.
    pub unit: String,
    /// From which points, and what is not measured in it.
    pub note: String,
}

/// The error of a point in its parts, each in the metric of the study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Parts {
    /// The simulation.
    pub sim: String,
    /// The study.
    pub study: String,
    /// The variant.
    pub variant: String,
    /// Time step (s).
    #[serde(serialize_with = "number")]
    pub step: f64,
    /// Cells along one side, or the number of particles.
    pub size: u32,
    /// The scheme in f64, from what it converges to.
    #[serde(serialize_with = "number_or_null")]
    pub truncation: Option<f64>,
    /// What it converges to, from the exact solution; `None` if that is the same by theory.
    #[serde(serialize_with = "number_or_null")]
    pub model: Option<f64>,
    /// The device, from the scheme in f64.
    #[serde(serialize_with = "number_or_null")]
    pub rounding: Option<f64>,
}

/// One study: the error and the cost of each variant at each step and size. All points share one metric.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudyResult {
    /// The simulation.
    pub sim: String,
    /// What was studied.
    pub study: String,
    /// What the errors are relative to.
    pub reference: String,
    /// The measurements.
    pub points: Vec<Point>,
    /// The answer: what to run for a given tolerance.
    pub cheapest: Vec<Cheapest>,
}

/// The error and the cost of one variant at one step and size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Point {
    /// The variant.
    pub variant: String,
    /// Time step (s).
    #[serde(serialize_with = "number")]
    pub step: f64,
    /// Cells along one side, or the number of particles.
    pub size: u32,
    /// Distance from the reference (`metric`), or `None` when the run made it non-finite.
    #[serde(serialize_with = "number_or_null")]
    pub error: Option<f64>,
    /// How `error` is measured.
    pub metric: String,
    /// Device time for one simulated second (ms).
    #[serde(serialize_with = "number")]
    pub ms_per_sim_second: f64,
    /// Device time for one item of one step (ns).
    #[serde(serialize_with = "number")]
    pub ns_per_item: f64,
    /// Whether no other point is at least as accurate and as cheap, and better in one of the two.
    pub pareto: bool,
}

/// The cheapest point that meets a tolerance; all but the tolerance are `None` when no point does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cheapest {
    /// The largest error allowed (the study's metric).
    #[serde(serialize_with = "number")]
    pub tolerance: f64,
    /// The variant to run.
    pub variant: Option<String>,
    /// Its device time for one simulated second (ms).
    #[serde(serialize_with = "number_or_null")]
    pub ms_per_sim_second: Option<f64>,
    /// How many times cheaper than the cheapest seed point that meets it; `None` when no seed point does.
    #[serde(serialize_with = "number_or_null")]
    pub speedup_over_seed: Option<f64>,
}

impl StudyResult {
    /// Marks the points that no other point beats in error and cost together. Equal points are marked alike.
    pub fn mark_pareto(&mut self) {
        let cost: Vec<Option<(f64, f64)>> =
            self.points.iter().map(|p| p.error.map(|error| (error, p.ms_per_sim_second))).collect();
        for (point, mine) in self.points.iter_mut().zip(&cost) {
            point.pareto =
                mine.is_some_and(|a| !cost.iter().flatten().any(|b| b.0 <= a.0 && b.1 <= a.1 && *b != a));
        }
    }

    /// For each tolerance, the cheapest point within it, against the cheapest one within it among the
    /// variants whose name starts with `seed_variant_prefix`.
    pub fn cheapest_for(&self, tolerances: &[f64], seed_variant_prefix: &str) -> Vec<Cheapest> {
        let cheapest = |tolerance: f64, prefix: &str| {
            self.points
                .iter()
                .filter(|p| p.variant.starts_with(prefix) && p.error.is_some_and(|e| e <= tolerance))
                .min_by(|a, b| a.ms_per_sim_second.total_cmp(&b.ms_per_sim_second))
        };
        tolerances
            .iter()
            .map(|&tolerance| {
                let best = cheapest(tolerance, "");
                let seed = cheapest(tolerance, seed_variant_prefix);
                Cheapest {
                    tolerance,
                    variant: best.map(|p| p.variant.clone()),
                    ms_per_sim_second: best.map(|p| p.ms_per_sim_second),
                    speedup_over_seed: best
                        .zip(seed)
                        .and_then(|(best, seed)| finite(seed.ms_per_sim_second / best.ms_per_sim_second)),
                }
            })
            .collect()
    }
}

impl Study {
    /// All points as CSV: quoted as in RFC 4180, lines ended by LF, an error that is not a number left empty.
    pub fn to_csv(&self) -> String {
        let mut csv = String::from(
            "sim,study,reference,variant,step,size,error,metric,ms_per_sim_second,ns_per_item,pareto\n",
        );
        for study in &self.studies {
            let [sim, name, reference] = [&study.sim, &study.study, &study.reference].map(|s| quoted(s));
            for p in &study.points {
                let (variant, metric) = (quoted(&p.variant), quoted(&p.metric));
                let error = p.error.map(|e| format!("{e:?}")).unwrap_or_default();
                let Point { step, size, ms_per_sim_second: ms, ns_per_item: ns, pareto, .. } = p;
                let start = format!("{sim},{name},{reference},{variant},{step:?},{size}");
                writeln!(csv, "{start},{error},{metric},{ms:?},{ns:?},{pareto}")
                    .expect("writing to a String cannot fail");
            }
        }
        csv
    }
}

fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

/// A plain-text table with aligned columns under a rule. A column of numbers (a `%`, `x` or `×` may follow,
/// `-` and blanks are neutral) is aligned to the right, any other to the left.
pub fn table(headers: &[&str], rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).chain([headers.len()]).max().unwrap_or(0);
    let cell = |row: usize, column: usize| -> &str { rows[row].get(column).map_or("", String::as_str) };
    let layout: Vec<(usize, bool)> = (0..columns)
        .map(|column| {
            let header = headers.get(column).map_or(0, |h| h.chars().count());
            let width = (0..rows.len()).map(|row| cell(row, column).chars().count()).fold(header, usize::max);
            let words = (0..rows.len()).map(|row| cell(row, column)).filter(|c| !matches!(*c, "" | "-"));
            let numeric = |word: &str| word.trim_end_matches(['%', 'x', '×', ' ']).parse::<f64>().is_ok();
            (width, words.clone().next().is_some() && words.clone().all(numeric))
        })
        .collect();
    let line = |cell: &dyn Fn(usize) -> String| {
        let cells: Vec<String> = layout
            .iter()
            .enumerate()
            .map(|(column, &(width, right))| {
                let text = cell(column);
                if right {
                    format!("{text:>width$}")
                } else {
                    format!("{text:<width$}")
                }
            })
            .collect();
        format!("{}\n", cells.join("  ").trim_end())
    };
    let mut text = line(&|column| headers.get(column).copied().unwrap_or_default().to_owned());
    text += &line(&|column| "-".repeat(layout[column].0));
    for row in 0..rows.len() {
        text += &line(&|column| cell(row, column).to_owned());
    }
    text
}
