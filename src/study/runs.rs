// SPDX-License-Identifier: MIT OR Apache-2.0
//! What hard cases, benches and studies share: a basin of either model, run by name, and the time that a step takes.

use super::{must_be_numbers, Result};
use crate::{
    gpu::{Access, Clock, Gpu, Recorder, Submitter},
    water::{
        cpu, cpu_fourth, cpu_pipes, starts::Start, Book, BookState, Counts, Disturb, DisturbParams,
        Disturbance, Fourth, FourthState, Fused, FusedState, FusedTuning, Halves, HalvesState, Invalid,
        Model, Params, Pipes, PipesState, PipesTuning, Tuning, Walls, Waves, WavesState, LAND_M,
    },
};
use glam::UVec2;
use std::time::Instant;

/// A water kernel and its options, as results name them: `book`, or `waves/w0.25` with `/land` or `/coast` if it looks for
/// land, everywhere or in a few places, and
/// `/fused` if it takes several steps a dispatch and `/f16` if it stores halves, or `waves/fourth`, with `/land` too, or
/// `pipes` with the options of `waves/w0.25` but `/f16`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme {
    /// The kernel is `water.book`, else `water.waves` or `water.fourth`.
    pub is_book: bool,
    /// The kernel is `water.fourth`.
    pub is_fourth: bool,
    /// Weight of a diagonal pipe.
    pub diagonal: f64,
    /// The kernel is built to look for land.
    pub has_land: bool,
    /// The kernel is `water.fused` or `water.pipes_fused`.
    pub is_fused: bool,
    /// The kernel is `water.pipes` or `water.pipes_fused`.
    pub is_pipes: bool,
    /// The kernel is `water.waves_f16` or `water.fused_f16`.
    pub is_f16: bool,
}

impl Scheme {
    /// The scheme that a variant names; options that are no part of a scheme are passed over.
    ///
    /// # Panics
    /// If it names none: variants are written in tables of this crate.
    pub fn named(variant: &str) -> Self {
        let kernel = variant.split('/').next().unwrap_or_default();
        let has = |wanted: &str| variant.split('/').any(|option| option == wanted);
        let (is_book, is_pipes, is_fourth) = (kernel == "book", kernel == "pipes", has("fourth"));
        let weight = variant.split('/').find_map(|option| option.strip_prefix('w')?.parse().ok());
        let weight = weight.or(is_book.then_some(1.0)).or(is_fourth.then_some(0.25));
        let diagonal = weight.unwrap_or_else(|| panic!("`{variant}` names no scheme"));
        let (has_land, is_fused, is_f16) = (has("land") || has("coast"), has("fused"), has("f16"));
        Self { is_book, is_fourth, diagonal, has_land, is_fused, is_pipes, is_f16 }
    }

    /// Read once and written once by a dispatch, for each column.
    pub fn bytes_a_column(self) -> f64 {
        match (self.is_book, self.is_pipes, self.diagonal > 0.0) {
            (false, false, _) if self.is_f16 => 8.0,
            (false, false, _) => 16.0,
            (false, true, false) => 24.0,
            _ => 40.0,
        }
    }

    /// Courant number of the longest stable step of `model`.
    pub fn courant_limit(self, model: &Model) -> f64 {
        if self.is_fourth {
            model.fourth_order_limit()
        } else {
            model.courant_limit()
        }
    }

    /// # Errors
    /// The first parameter of `model` that the scheme does not take.
    pub fn check(self, model: &Model) -> std::result::Result<(), Invalid> {
        if self.is_fourth {
            model.check_fourth_order()
        } else {
            model.check()
        }
    }

    /// `model` with the stencil and the walls of the scheme.
    pub fn model(self, model: Model) -> Model {
        let walls = if self.is_book { Walls::Dropped } else { Walls::Folded };
        Model { diagonal: self.diagonal, walls, ..model }
    }
}

/// The constants of the book at 60 frames a second, in cells and seconds: `sqrt(0.3 * 60)` cells a second, and 0.9995 of
/// the flow kept a frame.
pub fn book_constants(cells: UVec2) -> Model {
    Model {
        cells,
        cell_m: 1.0,
        speed_mps: 18f64.sqrt(),
        damping_per_s: -60.0 * 0.9995f64.ln(),
        diagonal: 1.0,
        walls: Walls::Dropped,
        dt_s: 1.0 / 60.0,
    }
}

/// How each kernel cuts up the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tunings {
    /// Of `water.waves`, `water.fourth` and `water.pipes`.
    pub waves: Tuning,
    /// Of `water.fused`.
    pub fused: FusedTuning,
    /// Of `water.pipes_fused`.
    pub pipes: FusedTuning,
    /// Of `wet` and `shallow`; `None` is what each likes.
    pub depth: Option<Tuning>,
}

impl Tunings {
    /// What the device likes.
    pub fn for_grid(gpu: &Gpu, cells: UVec2) -> Self {
        Self {
            waves: Tuning::for_grid(gpu, cells),
            fused: FusedTuning::for_grid(gpu, cells),
            pipes: FusedTuning::for_pipes(gpu, cells),
            depth: None,
        }
    }

    /// Steps that a dispatch takes.
    pub fn steps(&self, scheme: Scheme) -> u32 {
        match (scheme.is_fused, scheme.is_pipes) {
            (false, _) => 1,
            (true, false) => self.fused.steps,
            (true, true) => self.pipes.steps,
        }
    }
}

enum State {
    Book(BookState),
    Waves(WavesState),
    Fused(FusedState),
    Fourth(FourthState),
    Pipes(PipesState),
    Halves(HalvesState),
}

impl State {
    /// Steps, of which the first may be the one from rest, with half the pull.
    fn record(&mut self, rec: &mut Recorder<'_>, model: &Model, is_first: bool, steps: u32) {
        let barrier = |rec: &mut Recorder<'_>| rec.barrier(Waves::EXIT, Waves::ENTRY);
        let each = |rec: &mut Recorder<'_>, step: &mut dyn FnMut(&mut Recorder<'_>)| {
            for i in 0..steps {
                if i > 0 {
                    barrier(rec);
                }
                step(rec);
            }
        };
        let from_rest = |params: Params| if is_first { params.first_from_rest() } else { params };
        match self {
            Self::Book(state) => {
                let params = from_rest(model.params(state.pitch()));
                each(rec, &mut |rec| state.record(rec, &params));
            }
            Self::Waves(state) => {
                let params = from_rest(model.params(state.pitch()));
                each(rec, &mut |rec| state.record(rec, &params));
            }
            Self::Fourth(state) => {
                let params = model.fourth_order_params(state.pitch());
                let params = if is_first { params.first_from_rest() } else { params };
                each(rec, &mut |rec| state.record(rec, &params));
            }
            Self::Fused(state) => state.record(rec, &from_rest(model.params(state.pitch())), steps),
            Self::Pipes(state) => state.record(rec, &from_rest(model.params(state.pitch())), steps),
            Self::Halves(state) => state.record(rec, &from_rest(model.params(state.pitch())), steps),
        }
        barrier(rec);
    }
}

/// A basin on the GPU, of any model.
pub struct Basin {
    gpu: Gpu,
    submitter: Submitter,
    model: Model,
    state: State,
    steps_a_dispatch: u32,
}

/// Steps in a submission, so that no driver thinks it hangs.
const BATCH: u32 = 2000;

impl Basin {
    /// A basin at rest.
    ///
    /// # Errors
    /// Bad input, or the device's.
    pub fn new(gpu: &Gpu, scheme: Scheme, start: &Start) -> Result<Self> {
        Self::tuned(gpu, scheme, start, Tunings::for_grid(gpu, start.model.cells))
    }

    /// A basin at rest, cut up by hand.
    ///
    /// # Errors
    /// Bad input, or the device's.
    pub fn tuned(gpu: &Gpu, scheme: Scheme, start: &Start, tunings: Tunings) -> Result<Self> {
        let cells = start.model.cells;
        let blocks = |fused| match scheme.is_fused {
            true => PipesTuning::Fused(fused),
            false => PipesTuning::OneStep(tunings.waves),
        };
        let state = if scheme.is_book {
            let state = Book::new(gpu)?.state(cells)?;
            state.upload(gpu, &start.height_m)?;
            State::Book(state)
        } else if scheme.is_f16 {
            let state = Halves::new(gpu, blocks(tunings.fused), start.model.walls)?.state(cells)?;
            state.upload(gpu, &start.height_m, &vec![0.0; start.height_m.len()])?;
            State::Halves(state)
        } else if scheme.is_pipes {
            let tuning = blocks(tunings.pipes);
            let kernel = Pipes::new(gpu, tuning, scheme.diagonal > 0.0, scheme.has_land)?;
            let state = kernel.state(cells)?;
            state.upload(gpu, &start.height_m)?;
            State::Pipes(state)
        } else if scheme.is_fused {
            let kernel = Fused::new(gpu, tunings.fused, start.model.walls, scheme.has_land)?;
            let state = kernel.state(cells)?;
            state.upload(gpu, &start.height_m, &vec![0.0; start.height_m.len()])?;
            State::Fused(state)
        } else if scheme.is_fourth {
            let state = Fourth::new(gpu, tunings.waves, scheme.has_land)?.state(cells)?;
            state.upload(gpu, &start.height_m, &vec![0.0; start.height_m.len()])?;
            State::Fourth(state)
        } else {
            let state = Waves::new(gpu, tunings.waves, scheme.has_land)?.state(cells)?;
            state.upload(gpu, &start.height_m, &vec![0.0; start.height_m.len()])?;
            State::Waves(state)
        };
        let submitter = Submitter::new(gpu, 0)?;
        let steps_a_dispatch = tunings.steps(scheme);
        Ok(Self { gpu: gpu.clone(), submitter, model: start.model, state, steps_a_dispatch })
    }

    /// The first step from rest, with half the pull: see [`Params::first_from_rest`].
    ///
    /// # Errors
    /// The device's.
    pub fn first_step(&mut self) -> Result<()> {
        self.submitter.run(|rec| self.state.record(rec, &self.model, true, 1))?;
        Ok(())
    }

    /// Steps, and waits for them.
    ///
    /// # Errors
    /// The device's.
    pub fn steps(&mut self, count: u32) -> Result<()> {
        let mut left = count;
        while left > 0 {
            let batch = left.min(BATCH);
            self.submitter.run(|rec| self.state.record(rec, &self.model, false, batch))?;
            left -= batch;
        }
        Ok(())
    }

    /// Heights (m above rest).
    ///
    /// # Errors
    /// The device's.
    pub fn heights(&self) -> Result<Vec<f32>> {
        Ok(self.surface()?.0)
    }

    /// Heights (m above rest) and how fast they rise (m/s), half a step before.
    ///
    /// # Errors
    /// The device's.
    pub fn surface(&self) -> Result<(Vec<f32>, Vec<f32>)> {
        let state = match &self.state {
            State::Waves(state) => return Ok(state.download(&self.gpu)?),
            State::Fused(state) => return Ok(state.download(&self.gpu)?),
            State::Fourth(state) => return Ok(state.download(&self.gpu)?),
            State::Halves(state) => return Ok(state.download(&self.gpu)?),
            State::Book(state) => state.download(&self.gpu)?,
            State::Pipes(state) => state.download(&self.gpu)?,
        };
        let (w, h) = (self.model.cells.x as usize, self.model.cells.y as usize);
        let flow = |x: usize, y: usize, dx: isize, dy: isize, k: usize| {
            let from = x.checked_add_signed(dx).zip(y.checked_add_signed(dy));
            from.filter(|&(x, _)| x < w).map_or(0.0, |(x, y)| state[y * w + x].flow_mps[k])
        };
        let rise = |x: usize, y: usize| {
            let gain: f32 = state[y * w + x].flow_mps.iter().sum();
            gain - (flow(x, y, -1, 0, 0)
                + flow(x, y, -1, -1, 1)
                + flow(x, y, 0, -1, 2)
                + flow(x, y, 1, -1, 3))
        };
        let velocity = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(|(x, y)| rise(x, y)).collect();
        Ok((state.iter().map(|column| column.height_m).collect(), velocity))
    }

    /// Sets heights (m above rest), at rest.
    ///
    /// # Errors
    /// Bad input, or the device's.
    pub fn upload(&mut self, height_m: &[f32]) -> Result<()> {
        let at_rest = vec![0.0; height_m.len()];
        match &self.state {
            State::Book(state) => state.upload(&self.gpu, height_m)?,
            State::Pipes(state) => state.upload(&self.gpu, height_m)?,
            State::Waves(state) => state.upload(&self.gpu, height_m, &at_rest)?,
            State::Fourth(state) => state.upload(&self.gpu, height_m, &at_rest)?,
            State::Fused(state) => state.upload(&self.gpu, height_m, &at_rest)?,
            State::Halves(state) => state.upload(&self.gpu, height_m, &at_rest)?,
        }
        Ok(())
    }

    /// Applies disturbances, none of which may lift a column by more than 10 m, and says what became of them.
    ///
    /// # Errors
    /// The device's.
    pub fn disturb(&mut self, items: &[Disturbance]) -> Result<Counts> {
        let (surfaces, surface, velocities) = match &self.state {
            State::Book(state) => (state.surfaces(), state.surface(), [None; 2]),
            State::Pipes(state) => (state.surfaces(), state.surface(), [None; 2]),
            State::Waves(state) => (state.surfaces(), state.surface(), state.velocities()),
            State::Fourth(state) => (state.surfaces(), state.surface(), state.velocities()),
            State::Fused(state) => (state.surfaces(), state.surface(), state.velocities()),
            State::Halves(state) => ([state.surface(); 2], state.surface(), [Some(state.velocity()); 2]),
        };
        let params = DisturbParams {
            cells: self.model.cells,
            pitch: surface.pitch,
            stride: surface.stride,
            cell_m: self.model.cell_m as f32,
            limit_m: 10.0,
            has_velocity: u32::from(velocities[0].is_some()),
        };
        let list = Disturb::new(&self.gpu)?.list_of(surfaces, velocities, items.len() as u32)?;
        let (staging, _) = list.staging(items)?;
        self.submitter.run(|rec| {
            rec.copy(&staging, list.list());
            rec.barrier(Access::CopyWrite, Disturb::ENTRY);
            if let State::Halves(state) = &self.state {
                state.unpack(rec);
                rec.barrier(Halves::EXIT, Disturb::ENTRY);
            }
            list.record(rec, &surface, &params);
            rec.barrier(Disturb::EXIT, Waves::ENTRY);
            if let State::Halves(state) = &self.state {
                state.pack(rec);
                rec.barrier(Halves::EXIT, Halves::ENTRY);
            }
        })?;
        Ok(list.counts()?)
    }

    /// The time that a step takes.
    ///
    /// # Errors
    /// The device's.
    pub fn time(&mut self, effort: Effort) -> Result<Timing> {
        let (gpu, state, model, steps) = (&self.gpu, &mut self.state, &self.model, self.steps_a_dispatch);
        let block = time(gpu, effort, |rec| state.record(rec, model, false, steps))?;
        must_be_numbers("water", &self.heights()?)?;
        let each = |ms: f64| ms / f64::from(steps);
        let (median_ms, min_ms, p95_ms) = (each(block.median_ms), each(block.min_ms), each(block.p95_ms));
        Ok(Timing { median_ms, min_ms, p95_ms, ..block })
    }
}

/// Heights of the f64 twin after `steps` steps from rest; land is at [`LAND_M`].
pub fn twin(scheme: Scheme, start: &Start, steps: u32) -> Vec<f64> {
    if scheme.is_book {
        let mut twin = cpu::Book::<f64>::at_rest(&start.model, &start.height_m);
        (0..steps).for_each(|_| twin.step());
        twin.height_m
    } else if scheme.is_pipes {
        let mut twin = cpu_pipes::Pipes::<f64>::at_rest(&start.model, &start.height_m);
        (0..steps).for_each(|_| twin.step());
        twin.height_m
    } else if scheme.is_fourth {
        let mut twin = cpu_fourth::Fourth::<f64>::at_rest(&start.model, &start.height_m);
        (0..steps).for_each(|_| twin.step());
        twin.height_m
    } else {
        let mut twin = cpu::Waves::<f64>::at_rest(&start.model, &start.height_m);
        (0..steps).for_each(|_| twin.step());
        twin.height_m
    }
}

/// Largest difference, of the largest height wanted. Land has to be land in both; what is no number is infinitely far.
pub fn apart(got: &[f32], want: &[f64]) -> f64 {
    let is_land = |h: f64| h == f64::from(LAND_M);
    let water = || got.iter().map(|&a| f64::from(a)).zip(want.iter().copied()).filter(|&(_, b)| !is_land(b));
    let moved = got.iter().zip(want).any(|(&a, &b)| is_land(f64::from(a)) != is_land(b));
    if got.len() != want.len() || moved || water().any(|(a, _)| !a.is_finite()) {
        return f64::INFINITY;
    }
    let apart = water().map(|(a, b)| (a - b).abs()).fold(0.0, larger);
    match water().map(|(_, b)| b.abs()).fold(0.0, larger) {
        0.0 => f64::INFINITY, // a comparison of nothing
        highest => apart / highest,
    }
}

/// The larger of two; what is no number is larger than all, where `f64::max` would lose it.
pub fn larger(a: f64, b: f64) -> f64 {
    if b <= a || a.is_nan() {
        a
    } else {
        b
    }
}

/// The one farther from zero; what is no number is farther than all.
pub fn farther(a: f64, b: f64) -> f64 {
    if b.abs() <= a.abs() || a.is_nan() {
        a
    } else {
        b
    }
}

/// Root of the mean square.
pub fn rms<T: Copy + Into<f64>>(numbers: &[T]) -> f64 {
    (numbers.iter().map(|&h| h.into().powi(2)).sum::<f64>() / numbers.len() as f64).sqrt()
}

/// Uniform numbers between 0 and 1 (Steele and others, "Fast Splittable Pseudorandom Number Generators", 2014).
pub struct Uniform(pub u64);

impl Iterator for Uniform {
    type Item = f64;
    fn next(&mut self) -> Option<f64> {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Some(((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64)
    }
}

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
