// SPDX-License-Identifier: MIT OR Apache-2.0
//! Disks: speed against the error of the pressure, and boxes for hard cases and benches.

use super::{
    runs::{larger, time, Effort, Timing},
    shapes::{finite, Point, StudyResult},
    OnProgress, Progress, Result,
};
use crate::{
    disks::{
        edmd::Exact, oracle, starts, starts::Start, Borders, Disk, Grid, List, ListState, Model, Response,
        Sorted, SortedState, Space,
    },
    gpu::{Gpu, Recorder, Submitter},
};

/// As results name it.
pub const NAME: &str = "disks";
/// What the error is.
pub const METRIC: &str = "pressure, relative to Henderson's";

/// How a box is stepped, by the name in results: `list/seed`, `sorted/matching3`, `sorted/matching3/no-toi/3d`,
/// `sorted/xpbd`, `sorted/xpbd/no-bounce`.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// The tutorial's lists instead of sorted cells.
    pub is_list: bool,
    /// What contacts do.
    pub response: Response,
    /// Disks or spheres.
    pub space: Space,
}

impl Variant {
    /// # Panics
    /// If the name is none.
    pub fn named(name: &str) -> Self {
        let has = |part: &str| name.split('/').any(|it| it == part);
        let rounds = name.split('/').find_map(|part| part.strip_prefix("matching"));
        let response = match rounds {
            Some(rounds) => {
                Response::Matching { rounds: rounds.parse().expect("rounds"), rewinds: !has("no-toi") }
            }
            None if has("gauss-seidel") => Response::GaussSeidel,
            None if has("xpbd") => Response::Xpbd { bounces: !has("no-bounce") },
            None => {
                assert!(has("seed"), "no variant `{name}`");
                Response::Seed
            }
        };
        let space = if has("3d") { Space::Solid } else { Space::Flat };
        Self { is_list: has("list"), response, space }
    }
}

enum State {
    List(ListState),
    Sorted(SortedState),
}

/// A box on the GPU.
pub struct Gas {
    gpu: Gpu,
    kernels: Option<Sorted>,
    submitter: Submitter,
    state: State,
    substeps: u32,
}

/// Steps in a submission of a thousand disks, so that no driver thinks it hangs.
const BATCH: u32 = 400;

impl State {
    fn record(&mut self, rec: &mut Recorder<'_>) {
        match self {
            Self::List(state) => state.record(rec),
            Self::Sorted(state) => state.record(rec),
        }
        rec.barrier(Sorted::EXIT, Sorted::ENTRY);
    }
}

impl Gas {
    /// A box at its start, each step of which is cut into `substeps`.
    ///
    /// # Errors
    /// Bad input, or the device's.
    pub fn new(gpu: &Gpu, variant: &Variant, model: &Model, disks: &[Disk], substeps: u32) -> Result<Self> {
        Self::measuring(gpu, variant, model, disks, substeps, false)
    }

    /// [`Gas::new`], with impulses summed or not.
    ///
    /// # Errors
    /// Bad input, or the device's.
    pub fn measuring(
        gpu: &Gpu,
        variant: &Variant,
        model: &Model,
        disks: &[Disk],
        substeps: u32,
        measures: bool,
    ) -> Result<Self> {
        let model = Model { response: variant.response, space: variant.space, ..model.cut(substeps) };
        let (state, kernels) = if variant.is_list {
            (State::List(List::new(gpu)?.state(&model, disks)?), None)
        } else {
            let grid = Grid::of(&model, disks.iter().map(|disk| disk.radius_m));
            let kernels = Sorted::new(gpu, &model, grid.large > 0, measures)?;
            (State::Sorted(kernels.state(&model, disks)?), Some(kernels))
        };
        Ok(Self { gpu: gpu.clone(), submitter: Submitter::new(gpu, 0)?, kernels, state, substeps })
    }

    /// Puts other disks in another box, of the same kind.
    ///
    /// # Errors
    /// Bad input, or the device's.
    pub fn refill(&mut self, model: &Model, disks: &[Disk]) -> Result<()> {
        let model = model.cut(self.substeps);
        self.state = match &self.kernels {
            Some(kernels) => State::Sorted(kernels.state(&model, disks)?),
            None => State::List(List::new(&self.gpu)?.state(&model, disks)?),
        };
        Ok(())
    }

    /// Steps, and waits for them.
    ///
    /// # Errors
    /// The device's.
    pub fn steps(&mut self, count: u32) -> Result<()> {
        let mut left = count * self.substeps;
        while left > 0 {
            let batch = left.min(BATCH);
            self.submitter.run(|rec| (0..batch).for_each(|_| self.state.record(rec)))?;
            left -= batch;
        }
        Ok(())
    }

    /// The disks, in the order in which they were given.
    ///
    /// # Errors
    /// The device's.
    pub fn disks(&self) -> Result<Vec<Disk>> {
        Ok(match &self.state {
            State::List(state) => state.disks(&self.gpu)?,
            State::Sorted(state) => state.disks(&self.gpu)?,
        })
    }

    /// The state as it lies in memory.
    ///
    /// # Errors
    /// The device's.
    pub fn words(&self) -> Result<Vec<u32>> {
        Ok(match &self.state {
            State::List(state) => self.gpu.download(state.records())?,
            State::Sorted(state) => state.words(&self.gpu)?,
        })
    }

    /// Since the start: impulse times distance of pairs, impulse of walls. Zeros of a list, which does not measure.
    ///
    /// # Errors
    /// The device's.
    pub fn impulses(&self) -> Result<[f64; 2]> {
        let State::Sorted(state) = &self.state else { return Ok([0.0; 2]) };
        let each = state.impulses(&self.gpu)?;
        Ok([0, 1].map(|k| each.iter().map(|it| f64::from(it[k])).sum()))
    }

    /// What [`Gas::impulses`] gain in each part of a run, of so many steps.
    ///
    /// # Errors
    /// The device's.
    fn gains(&mut self, which: usize, steps: u32) -> Result<[f64; PARTS as usize]> {
        let (mut gains, mut before) = ([0.0; PARTS as usize], self.impulses()?[which]);
        for gain in &mut gains {
            self.steps(steps)?;
            let now = self.impulses()?[which];
            *gain = now - before;
            before = now;
        }
        Ok(gains)
    }

    /// The time that a step takes, with all its substeps.
    ///
    /// # Errors
    /// The device's.
    pub fn time(&mut self, effort: Effort) -> Result<Timing> {
        let (state, substeps) = (&mut self.state, self.substeps);
        time(&self.gpu, effort, |rec| (0..substeps).for_each(|_| state.record(rec)))
    }
}

/// Share of disks that are farther from where they should be than `radii` of the smallest radius; those that are nowhere
/// count.
pub fn strays(model: &Model, got: &[Disk], want: &[Disk], radii: f64) -> f64 {
    let far = radii * want.iter().map(|disk| disk.radius_m).fold(f64::INFINITY, f64::min);
    let is_near = |(a, b): &(&Disk, &Disk)| model.way(a.at_m, b.at_m).length() <= far;
    1.0 - got.iter().zip(want).filter(is_near).count() as f64 / want.len() as f64
}

/// Largest overlap, of the sum of the radii; not a number if a disk is nowhere, which overlaps nobody.
pub fn overlap(model: &Model, disks: &[Disk]) -> f64 {
    match disks.iter().all(|disk| disk.at_m.is_finite()) {
        true => oracle::overlap(model, disks),
        false => f64::NAN,
    }
}

/// Parts of a run that are told apart: how they differ says how far the whole can be believed.
const PARTS: u32 = 8;

/// Mean, and its standard error.
fn mean(parts: &[f64; PARTS as usize]) -> (f64, f64) {
    let n = f64::from(PARTS);
    let mean = parts.iter().sum::<f64>() / n;
    let square = parts.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, (square / n).sqrt())
}

/// A fluid in equilibrium, and how long to watch it.
#[derive(Clone, Copy, Debug)]
pub struct Watch {
    /// How many.
    pub disks: u32,
    /// Share of the box.
    pub packing: f64,
    /// Root mean square way in a step, in radii.
    pub way: f64,
    /// Collisions of a disk before, and while it is measured.
    pub collisions: [f64; 2],
}

/// What was seen.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// `P V / (N k T)`, of Henderson's, less 1.
    pub pressure: f64,
    /// Standard error of that.
    pub doubt: f64,
    /// Momentum, of the sum of its lengths.
    pub momentum: f64,
    /// Energy, of the start's, less 1.
    pub energy: f64,
    /// Largest overlap, of the sum of the radii.
    pub overlap: f64,
    /// Into how many each step was cut.
    pub substeps: u32,
}

/// Watches the pressure, from pairs, in a box that repeats. `substeps`: those that the model asks for if `None`.
///
/// # Errors
/// The device's.
pub fn watch(gpu: &Gpu, variant: &Variant, what: Watch, substeps: Option<u32>) -> Result<Seen> {
    let start = starts::fluid(variant.space, what.disks, what.packing, 3);
    let model = Model { dt_s: what.way, response: variant.response, ..start.model };
    let substeps = substeps.unwrap_or_else(|| model.substeps(&start.disks));
    let a_step = model.collisions_a_step(&start.disks);
    let steps = what.collisions.map(|n| (n / a_step).ceil().max(2.0) as u32);
    let mut gas = Gas::measuring(gpu, variant, &model, &start.disks, substeps, true)?;
    gas.steps(steps[0])?;
    let in_part = steps[1].div_ceil(PARTS);
    let before = oracle::energy(&model, &gas.disks()?);
    let parts = gas.gains(0, in_part)?;
    let disks = gas.disks()?;
    let energy = 0.5 * (before + oracle::energy(&model, &disks)); // some responses lose it
    let z = |virial| oracle::pressure_of_virial(energy, virial, f64::from(in_part) * model.dt_s);
    let henderson = oracle::pressure(variant.space, what.packing);
    let (pressure, doubt) = mean(&parts.map(|virial| z(virial) / henderson - 1.0));
    let (momentum, lengths) = oracle::momentum(&model, &disks);
    Ok(Seen {
        pressure,
        doubt,
        momentum: momentum.length() / lengths,
        energy: oracle::energy(&model, &disks) / oracle::energy(&model, &start.disks) - 1.0,
        overlap: overlap(&model, &disks),
        substeps,
    })
}

/// Pressure of the tutorial's response on walls, of exact motion in the same box, less 1, and its standard error: reversed
/// velocities are no impulse of a pair. `way`: root mean square of a step (radii); of a disk, exact motion takes so many
/// `collisions`, and the response four times as many.
///
/// # Errors
/// The device's.
pub fn seed_pressure(gpu: &Gpu, packing: f64, way: f64, collisions: f64) -> Result<(f64, f64)> {
    let start = between_walls(starts::fluid(Space::Flat, 256, packing, 7));
    let a_second = Model { dt_s: 1.0, ..start.model }.collisions_a_step(&start.disks);
    let [warm_s, long_s] = [20.0, collisions].map(|n| (n / a_second).max(10.0));
    let mut exact = Exact::new(start.model, &start.disks);
    exact.run(warm_s);
    let part_s = long_s / f64::from(PARTS);
    let (want, of_want) = mean(&[(); PARTS as usize].map(|()| {
        exact.reset();
        exact.run(part_s);
        exact.wall / part_s
    }));
    let variant = Variant::named("sorted/seed");
    let model = Model { dt_s: way, response: variant.response, ..start.model };
    let mut gas = Gas::measuring(gpu, &variant, &model, &start.disks, 1, true)?;
    gas.steps((warm_s / way) as u32)?;
    let steps = (4.0 * part_s / way) as u32;
    let (got, of_got) = mean(&gas.gains(1, steps)?.map(|wall| wall / (way * f64::from(steps))));
    let ratio = got / want;
    Ok((ratio - 1.0, ratio * (of_got / got).hypot(of_want / want)))
}

/// A box whose lattice leaves room at the walls.
fn between_walls(mut start: Start) -> Start {
    start.model.borders = Borders::Walls;
    for disk in &mut start.disks {
        let share = disk.at_m / start.model.size_m;
        disk.at_m = (share * (start.model.size_m - 2.02) + 1.01).with_z(0.0);
    }
    start
}

const VARIANTS: [&str; 9] = [
    "sorted/seed",
    "sorted/gauss-seidel",
    "sorted/matching1",
    "sorted/matching3",
    "sorted/matching8",
    "sorted/matching1/no-toi",
    "sorted/matching3/no-toi",
    "sorted/xpbd",
    "sorted/xpbd/no-bounce",
];
/// (1/s).
const RATES: [f64; 4] = [15.0, 30.0, 60.0, 240.0];
/// Way in a step of 1/15 s (radii).
const WAY: f64 = 0.5;

/// Runs it: one study a packing. The unit of length is a radius, and disks move 7.5 of them a second.
///
/// # Errors
/// The device's.
pub fn study(gpu: &Gpu, quick: bool, progress: OnProgress<'_>) -> Result<Vec<StudyResult>> {
    let packings: &[f64] = if quick { &[0.2245] } else { &[0.1, 0.2245, 0.4, 0.5, 0.65] };
    // A GPU takes no longer for more disks than these.
    let (disks, of_walls) = match (quick, gpu.adapter().is_software()) {
        (true, _) => (1600, 80.0),
        (false, true) => (1600, 320.0),
        (false, false) => (6400, 640.0),
    };
    let (mut done, of) = (0, packings.len() * VARIANTS.len() * RATES.len());
    let mut results = Vec::new();
    for &packing in packings {
        let mut points = Vec::new();
        let (mut drifts, mut doubts) = (Vec::new(), [0.0f64; 2]);
        for name in VARIANTS {
            for rate in RATES {
                progress(Progress { done, of, now: &format!("{name}, {rate} Hz, packing {packing}") });
                done += 1;
                let variant = Variant::named(name);
                let speed = WAY * RATES[0]; // radii a second
                let [warm, long] = if quick { [10.0, 25.0] } else { [20.0, 80.0] };
                let what = Watch { disks, packing, way: speed / rate, collisions: [warm, long] };
                // As the step comes: what substeps would do is what a higher rate does.
                let mut seen = watch(gpu, &variant, what, Some(1))?;
                let is_seed = variant.response == Response::Seed;
                if is_seed {
                    (seen.pressure, seen.doubt) = seed_pressure(gpu, packing, what.way, of_walls)?;
                }
                let doubt = &mut doubts[usize::from(is_seed)];
                *doubt = larger(*doubt, seen.doubt);
                if rate == 60.0 {
                    let Seen { momentum, energy, overlap, .. } = seen;
                    drifts.push(format!("{name} {momentum:.0e}, energy {energy:+.0e}, overlap {overlap:.3}"));
                }
                let start = starts::fluid(variant.space, 100_000, packing, 3);
                let model = Model { dt_s: what.way, response: variant.response, ..start.model };
                let mut gas = Gas::new(gpu, &variant, &model, &start.disks, 1)?;
                gas.steps(20)?;
                let effort = Effort { budget_s: if quick { 0.1 } else { 0.4 }, ..Effort::full(gpu) };
                let ms = gas.time(effort)?.median_ms;
                points.push(Point {
                    variant: name.into(),
                    step: 1.0 / rate,
                    size: disks,
                    // No error is known better than the run tells: one that happens to be small is not.
                    error: finite(larger(seen.pressure.abs(), seen.doubt)),
                    metric: METRIC.into(),
                    ms_per_sim_second: ms * rate,
                    ns_per_item: 1e6 * ms / 1e5,
                    pareto: false,
                });
            }
        }
        let mut result = StudyResult {
            sim: "disks".into(),
            study: format!("packing {packing}"),
            reference: format!(
                "Henderson's equation of state, of the tutorial's response exact motion between the same walls; no error is \
                 given below its standard error, which is {:.1e} at the most, {:.1e} of the tutorial's; cost of 100 000 \
                 disks; momentum lost, of the sum of its lengths, and energy, of the start's, less 1, at 60 Hz: {}",
                doubts[0],
                doubts[1],
                drifts.join("; ")
            ),
            points,
            cheapest: Vec::new(),
        };
        result.mark_pareto();
        result.cheapest = result.cheapest_for(&[0.1, 0.01, 0.003], "sorted/seed");
        results.push(result);
    }
    Ok(results)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of 1 to 8: variance 6, of their mean 6 / 8.
    #[test]
    fn a_mean_has_the_standard_error_of_its_parts() {
        let (of, doubt) = mean(&std::array::from_fn(|i| 1.0 + i as f64));
        assert!(of == 4.5 && (doubt - 0.75f64.sqrt()).abs() < 1e-15, "{of} {doubt}");
        assert_eq!(mean(&[3.0; PARTS as usize]), (3.0, 0.0));
    }

    #[test]
    fn disks_that_are_nowhere_have_no_overlap() {
        let start = starts::fluid(Space::Flat, 16, 0.2, 1);
        assert!(overlap(&start.model, &start.disks) <= 0.0);
        let mut disks = start.disks;
        disks[3].at_m.y = f64::NAN;
        assert!(overlap(&start.model, &disks).is_nan());
    }
}
