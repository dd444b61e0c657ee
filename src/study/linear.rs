// SPDX-License-Identifier: MIT OR Apache-2.0
//! Linear water: stencil and step against the exact solution. A hill spreads in a closed basin for as long as a wave
//! needs to cross it and come back.

use super::{
    runs::{self, Basin, Effort, Scheme, Timing},
    shapes::{finite, Point, StudyResult},
    OnProgress, Progress, Result,
};
use crate::{
    gpu::Gpu,
    water::{
        oracle::{relative_l2, Exact},
        starts, Model,
    },
};
use glam::UVec2;

/// As results name it.
pub const NAME: &str = "water linear";
/// What the error is.
pub const METRIC: &str = "relative L2 of the heights at 2 L / c";

const VARIANTS: [&str; 6] =
    ["book", "waves/w0", "waves/w0.25", "waves/w1", "waves/fourth", "waves/fused/w0.25"];
/// The book's own step at 60 frames a second (columns a step).
const BOOK_COURANT: f64 = 0.0707;
/// Of the basin (m); with waves of 1 m/s, so that they cross it in 10 s. Cost per simulated second is in these units.
const BASIN_M: f64 = 10.0;
/// Of the hill, of the basin's width.
const SIGMA: f32 = 0.05;

fn model(scheme: Scheme, cells: u32) -> Model {
    let basin = runs::book_constants(UVec2::splat(cells));
    let cell_m = BASIN_M / f64::from(cells);
    scheme.model(Model { cell_m, speed_mps: 1.0, damping_per_s: 0.0, ..basin })
}

/// Courant numbers up to the limit, and 0.95 of it.
fn courants(variant: &str, limit: f64, quick: bool) -> Vec<f64> {
    let slow = if variant == "book" { BOOK_COURANT } else { 0.07 };
    let mut all = vec![0.35, 0.7, 0.8, 0.86, 0.99, 0.95 * limit];
    if !quick || variant == "book" {
        all.push(slow);
    }
    all.retain(|courant| *courant <= limit);
    all.sort_by(f64::total_cmp);
    all
}

/// Runs it.
///
/// # Errors
/// The device's.
pub fn study(gpu: &Gpu, quick: bool, progress: OnProgress<'_>) -> Result<StudyResult> {
    let sizes: &[u32] = match (quick, gpu.adapter().is_software()) {
        (true, _) => &[64, 128],
        (false, true) => &[64, 128, 256],
        (false, false) => &[64, 128, 256, 512, 1024],
    };
    let mut result = StudyResult {
        sim: "water".into(),
        study: "linear".into(),
        reference: "exact solution of the wave equation, by the cosine transform of the start".into(),
        points: Vec::new(),
        cheapest: Vec::new(),
    };
    let (mut done, of) = (0, sizes.len() * VARIANTS.len());
    for &size in sizes {
        let start = starts::gauss(model(Scheme::named("book"), size), SIGMA);
        let exact = Exact::new(start.model.cells, &start.height_m).after(2.0 * f64::from(size));
        for variant in VARIANTS {
            progress(Progress { done, of, now: &format!("{variant}, {size} x {size}") });
            done += 1;
            let scheme = Scheme::named(variant);
            let model = model(scheme, size);
            let start = starts::Start { model, ..start.clone() };
            let timing =
                Basin::new(gpu, scheme, &start)?.time(Effort { budget_s: 2.0, ..Effort::full(gpu) })?;
            for courant in courants(variant, scheme.courant_limit(&model), quick) {
                // A whole number of steps, none longer than asked for.
                let steps = (2.0 * f64::from(size) / courant).ceil() as u32;
                let model = model.with_courant(2.0 * f64::from(size) / f64::from(steps));
                let error = error(gpu, scheme, &starts::Start { model, ..start.clone() }, steps, &exact)?;
                result.points.push(point(variant, &model, error, timing));
            }
        }
    }
    result.mark_pareto();
    result.cheapest = result.cheapest_for(&[0.1, 0.01, 0.001], "book");
    Ok(result)
}

fn error(gpu: &Gpu, scheme: Scheme, start: &starts::Start, steps: u32, exact: &[f64]) -> Result<f64> {
    let mut basin = Basin::new(gpu, scheme, start)?;
    basin.first_step()?;
    basin.steps(steps - 1)?;
    Ok(relative_l2(&basin.heights()?, exact))
}

fn point(variant: &str, model: &Model, error: f64, step: Timing) -> Point {
    Point {
        variant: variant.into(),
        step: model.dt_s,
        size: model.cells.x,
        error: finite(error),
        metric: METRIC.into(),
        ms_per_sim_second: step.median_ms / model.dt_s,
        ns_per_item: 1e6 * step.median_ms / model.cells.as_dvec2().element_product(),
        pareto: false,
    }
}
