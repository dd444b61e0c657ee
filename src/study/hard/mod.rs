// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hard cases: set-ups that the simple method gets wrong, each a number against a limit. A case is an entry of a table
//! and a function of a few lines.

pub mod ballistic;
pub mod black_hole;
pub mod disks;
pub mod particles;
pub mod system;
pub mod volume;
pub mod water;

use super::{
    shapes::{finite, HardCase, HardCases},
    Error, OnProgress, Progress, Result,
};
use crate::gpu::Gpu;
use std::{cell::RefCell, collections::HashMap};

/// What a case runs on.
pub struct Context<'a> {
    /// The device.
    pub gpu: &'a Gpu,
    /// What rows have measured that others ask for too.
    shared: RefCell<HashMap<(&'static str, String), Vec<f64>>>,
}

impl<'a> Context<'a> {
    /// Nothing has run.
    pub fn new(gpu: &'a Gpu) -> Self {
        Self { gpu, shared: RefCell::default() }
    }

    /// The numbers of a run that several cases look at, each from its own side: run once for each variant.
    ///
    /// # Errors
    /// That of `run`.
    pub fn shared(
        &self,
        name: &'static str,
        variant: &str,
        run: impl FnOnce() -> Result<Vec<f64>>,
    ) -> Result<Vec<f64>> {
        let key = (name, variant.to_owned());
        if let Some(numbers) = self.shared.borrow().get(&key) {
            return Ok(numbers.clone());
        }
        let numbers = run()?;
        self.shared.borrow_mut().insert(key, numbers.clone());
        Ok(numbers)
    }
}

/// One quantity against its limit.
pub struct Case {
    /// Stable identifier. Cases that hold several quantities against limits share theirs.
    pub id: &'static str,
    /// One line for people.
    pub title: &'static str,
    /// What runs, one row each.
    pub variants: &'static [&'static str],
    /// Of what is measured and its limit.
    pub unit: &'static str,
    /// Largest absolute value that passes.
    pub limit: f64,
    /// Measures a variant.
    pub run: fn(&Context<'_>, &str) -> Result<Outcome>,
}

/// What a case found.
pub struct Outcome {
    measured: f64,
    holds: bool,
    seed: Option<f64>,
    note: Option<String>,
}

impl Outcome {
    /// A quantity, in the unit of the case.
    pub fn of(measured: f64) -> Self {
        Self { measured, holds: true, seed: None, note: None }
    }

    /// The same quantity of the simple method.
    pub fn seed(self, seed: f64) -> Self {
        Self { seed: finite(seed), ..self }
    }

    /// What else must hold.
    pub fn only_if(self, holds: bool) -> Self {
        Self { holds: self.holds && holds, ..self }
    }

    /// What a reader must know.
    pub fn note(self, note: impl Into<String>) -> Self {
        Self { note: Some(note.into()), ..self }
    }
}

impl Case {
    /// Whether `measured` is within the limit.
    pub fn allows(&self, measured: f64) -> bool {
        measured.abs() <= self.limit
    }

    fn row(&self, context: &Context<'_>, variant: &str) -> Result<HardCase> {
        let outcome = (self.run)(context, variant)?;
        Ok(HardCase {
            id: self.id.into(),
            title: self.title.into(),
            variant: variant.into(),
            measured: finite(outcome.measured),
            limit: self.limit,
            unit: self.unit.into(),
            pass: outcome.holds && self.allows(outcome.measured),
            seed_measured: outcome.seed,
            note: outcome.note,
        })
    }

    /// How well a filter finds the case: not at all, by its words, by the start of its identifier, by all of it.
    fn fit(&self, filter: &str) -> u8 {
        let (filter, id) = (filter.to_lowercase(), self.id.to_lowercase());
        let in_words = || self.title.to_lowercase().contains(&filter);
        let in_variants = || self.variants.iter().any(|variant| variant.contains(filter.as_str()));
        match () {
            () if id == filter => 3,
            () if id.starts_with(&filter) => 2,
            () => u8::from(in_words() || in_variants()),
        }
    }
}

/// Every case, in the order of the tables.
pub fn cases() -> impl Iterator<Item = &'static Case> {
    [
        water::CASES,
        water::DEPTH_CASES,
        particles::CASES,
        black_hole::CASES,
        ballistic::CASES,
        disks::CASES,
        volume::CASES,
        system::CASES,
    ]
    .into_iter()
    .flatten()
}

/// The cases whose identifier is one of `filters`; for a filter that is none, those whose identifier starts with it; if
/// none does, those whose title or variants contain it. All if there are no filters.
///
/// # Errors
/// [`Error::NoSuch`] if a filter finds nothing.
pub fn select(filters: &[String]) -> Result<Vec<&'static Case>> {
    let mut taken: Vec<bool> = cases().map(|_| filters.is_empty()).collect();
    for filter in filters {
        let best = cases().map(|case| case.fit(filter)).max().unwrap_or(0);
        taken
            .iter_mut()
            .zip(cases())
            .for_each(|(taken, case)| *taken |= best > 0 && case.fit(filter) == best);
        if best == 0 {
            let mut have: Vec<String> = cases().map(|case| case.id.into()).collect();
            have.dedup();
            return Err(Error::NoSuch { what: "hard case", wanted: filter.clone(), have });
        }
    }
    Ok(cases().zip(taken).filter_map(|(case, taken)| taken.then_some(case)).collect())
}

/// Runs the cases that [`select`] finds.
///
/// # Errors
/// [`Error::NoSuch`], or the device's. A case that does not hold is a result, no error.
pub fn run(gpu: &Gpu, filters: &[String], progress: OnProgress<'_>) -> Result<HardCases> {
    let chosen = select(filters)?;
    let of = chosen.iter().map(|case| case.variants.len()).sum();
    let mut rows = Vec::new();
    let context = Context::new(gpu);
    for case in chosen {
        for variant in case.variants {
            progress(Progress { done: rows.len(), of, now: &format!("{} {variant}", case.id) });
            rows.push(case.row(&context, variant)?);
        }
    }
    Ok(HardCases {
        device: gpu.name().into(),
        driver: gpu.adapter().driver.clone(),
        clock: gpu.clock()?.name().into(),
        edited: gpu.edited_shaders(),
        cases: rows,
    })
}
