// SPDX-License-Identifier: MIT OR Apache-2.0
//! A basin of any of the flat models, on the GPU and in f64.

use super::{time, Effort, Scheme, Timing, Tunings};
use crate::{
    gpu::{Access, Gpu, Recorder, Submitter},
    study::{must_be_numbers, Result},
    water::{
        book::Column, cpu, cpu_fourth, cpu_pipes, starts::Start, Book, BookState, Counts, Disturb,
        DisturbParams, Disturbance, Fourth, FourthState, Fused, FusedState, Halves, HalvesState, Model,
        Params, Pipes, PipesState, PipesTuning, Waves, WavesState,
    },
};

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

    /// All of the state, in bits: what a step leaves as it was, every other step does too.
    ///
    /// # Errors
    /// The device's.
    pub fn words(&self) -> Result<Vec<u32>> {
        let (height, others) = match &self.state {
            State::Book(state) => flows(&state.download(&self.gpu)?),
            State::Pipes(state) => flows(&state.download(&self.gpu)?),
            State::Waves(state) => state.download(&self.gpu)?,
            State::Fused(state) => state.download(&self.gpu)?,
            State::Fourth(state) => state.download(&self.gpu)?,
            State::Halves(state) => state.download(&self.gpu)?,
        };
        Ok(height.into_iter().chain(others).map(f32::to_bits).collect())
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

/// Heights, and the flows of all columns.
fn flows(columns: &[Column]) -> (Vec<f32>, Vec<f32>) {
    let height = columns.iter().map(|column| column.height_m).collect();
    (height, columns.iter().flat_map(|column| column.flow_mps).collect())
}

/// Heights of the f64 twin after `steps` steps from rest; land is at [`LAND_M`](crate::water::LAND_M).
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
