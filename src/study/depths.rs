// SPDX-License-Identifier: MIT OR Apache-2.0
//! Basins of any depth for hard cases, benches and studies, as [`super::runs`] has them for waves.

use super::{
    must_be_numbers,
    runs::{larger, time, Effort, Timing},
    Result,
};
use crate::{
    gpu::{Gpu, Recorder, Submitter},
    water::{
        cpu_wet::Depths, Columns, DepthModel, DepthParams, DepthState, Shallow, Tier, Tuning, Wet, LAND_M,
    },
};
use glam::{dvec2, UVec2};

/// The tier that a variant names, as in `wet` or `shallow/stoker`; `None` if another model is meant.
pub fn tier_of(variant: &str) -> Option<Tier> {
    match variant.split('/').next() {
        Some("wet") => Some(Tier::Wet),
        Some("shallow") => Some(Tier::Shallow),
        _ => None,
    }
}

/// A basin on the GPU.
pub struct DepthBasin {
    gpu: Gpu,
    submitter: Submitter,
    state: DepthState,
    params: DepthParams,
}

/// Steps in a submission, so that no driver thinks it hangs.
const BATCH: u32 = 2000;

fn record(state: &mut DepthState, rec: &mut Recorder<'_>, params: &DepthParams) {
    state.record(rec, params);
    rec.barrier(DepthState::EXIT, DepthState::ENTRY);
}

impl DepthBasin {
    /// A basin that starts as `columns`.
    ///
    /// # Errors
    /// Bad input, or the device's.
    pub fn new(gpu: &Gpu, tier: Tier, model: &DepthModel, columns: &Columns) -> Result<Self> {
        Self::tuned(gpu, tier, model, columns, tier.tuning(gpu, model.cells))
    }

    /// A basin cut up by hand.
    ///
    /// # Errors
    /// Bad input, or the device's.
    pub fn tuned(
        gpu: &Gpu,
        tier: Tier,
        model: &DepthModel,
        columns: &Columns,
        tuning: Tuning,
    ) -> Result<Self> {
        model.check(tier).map_err(crate::water::Error::from)?;
        let state = match tier {
            Tier::Wet => Wet::new(gpu, tuning)?.state(model.cells)?,
            Tier::Shallow => Shallow::new(gpu, tuning)?.state(model.cells)?,
        };
        Self::of(gpu, state, model, columns)
    }

    /// A basin of [`Tier::Shallow`] without advection.
    ///
    /// # Errors
    /// Bad input, or the device's.
    pub fn without_advection(gpu: &Gpu, model: &DepthModel, columns: &Columns) -> Result<Self> {
        model.check(Tier::Shallow).map_err(crate::water::Error::from)?;
        let tuning = Tier::Shallow.tuning(gpu, model.cells);
        Self::of(gpu, Shallow::without_advection(gpu, tuning)?.state(model.cells)?, model, columns)
    }

    fn of(gpu: &Gpu, state: DepthState, model: &DepthModel, columns: &Columns) -> Result<Self> {
        state.upload(gpu, columns)?;
        let params = model.params(state.pitch());
        Ok(Self { gpu: gpu.clone(), submitter: Submitter::new(gpu, 0)?, state, params })
    }

    /// The first step from rest, with half the pull.
    ///
    /// # Errors
    /// The device's.
    pub fn first_step(&mut self) -> Result<()> {
        let params = self.params.first_from_rest();
        self.submitter.run(|rec| record(&mut self.state, rec, &params))?;
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
            self.submitter.run(|rec| (0..batch).for_each(|_| record(&mut self.state, rec, &self.params)))?;
            left -= batch;
        }
        Ok(())
    }

    /// Ground and water.
    ///
    /// # Errors
    /// The device's.
    pub fn columns(&self) -> Result<Columns> {
        Ok(self.state.columns(&self.gpu)?)
    }

    /// The time that a step takes.
    ///
    /// # Errors
    /// The device's.
    pub fn time(&mut self, effort: Effort) -> Result<Timing> {
        let (state, params) = (&mut self.state, &self.params);
        let timing = time(&self.gpu, effort, |rec| record(state, rec, params))?;
        must_be_numbers("water over ground", &self.columns()?.rise_m)?;
        Ok(timing)
    }
}

/// A model for twins and benches: half-metre columns, 0.9 of the longest step, undamped.
pub fn bench_model(tier: Tier, cells: UVec2) -> DepthModel {
    let model = DepthModel {
        cells,
        cell_m: 0.5,
        gravity_mps2: 9.81,
        deepest_m: 2.5,
        fastest_mps: 3.0,
        damping_per_s: 0.0,
        thin_m: 1e-5,
        dt_s: 1.0,
    };
    model.with_courant(tier, 0.9 * tier.courant_limit())
}

/// Hills that stand out of choppy water, and some walls.
pub fn landscape(cells: UVec2) -> Columns {
    let at = |i: usize| dvec2((i as u32 % cells.x) as f64, (i as u32 / cells.x) as f64);
    let count = cells.element_product() as usize;
    let bed: Vec<f64> =
        (0..count).map(|i| 1.4 * (0.031 * at(i).x).sin() * (0.023 * at(i).y + 1.0).cos() - 0.5).collect();
    let surface = |i: usize| 0.2 * (0.7 * at(i).x).sin() * (0.5 * at(i).y).cos();
    let mut columns = Columns::at_rest(&bed, surface);
    (0..count).filter(|i| count > 100 && i % 531 == 11).for_each(|i| columns.rise_m[i] = LAND_M);
    columns
}

/// Steps of [`from_twin`].
pub const STEPS: u32 = 16;
/// What rounding explains after them, of the largest rise, with u = 2^-24: a step rounds some 20 times between one state
/// and the next, each time by u of the largest number at most, and passes errors on whole, from rise to flow and back.
pub const ROUNDING: f64 = 2.0 * 20.0 * STEPS as f64 / (1 << 24) as f64;

/// How far rises are from the f64 twin, of the largest: at most [`ROUNDING`]. Land must stay land.
///
/// # Errors
/// The device's.
pub fn from_twin(gpu: &Gpu, tier: Tier, tuning: Tuning, cells: UVec2) -> Result<f64> {
    let (model, start) = (bench_model(tier, cells), landscape(cells));
    let mut basin = DepthBasin::tuned(gpu, tier, &model, &start, tuning)?;
    basin.steps(STEPS)?;
    let mut twin = Depths::<f64>::new(tier, &model, &start);
    (0..STEPS).for_each(|_| twin.step());
    let got = basin.columns()?.rise_m;
    if twin.rise_m.iter().filter(|h| **h != f64::from(LAND_M)).all(|h| *h == 0.0) {
        return Ok(got.iter().map(|h| f64::from(h.abs())).fold(0.0, larger));
    }
    Ok(super::runs::apart(&got, &twin.rise_m))
}
