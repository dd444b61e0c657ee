// SPDX-License-Identifier: MIT OR Apache-2.0
//! Non-linear water: which model gets dam breaks and moving shores right, and at what cost. Linear pipes, pipes over
//! ground and shallow water on the same exact solutions, on finer and finer grids.

use super::{
    depths::DepthBasin,
    runs::{Basin, Effort, Scheme, Timing},
    shapes::{finite, Point, StudyResult},
    Found, OnProgress, Progress, Result,
};
use crate::{
    gpu::Gpu,
    water::{
        dam::{steps_to, Bowl, DamBreak, Swing, GRAVITY_MPS2},
        starts::{self, Start},
        Columns, DepthModel, Model, Tier,
    },
};
use glam::{uvec2, UVec2};

/// As results name it.
pub const NAME: &str = "water non-linear";
/// What the error is: of a dam break, of a bowl.
pub const METRIC: &str = "L1 of the depths";

const VARIANTS: [(&str, Option<Tier>); 3] =
    [("waves/w0", None), ("wet", Some(Tier::Wet)), ("shallow", Some(Tier::Shallow))];

/// A problem with an exact solution.
#[derive(Clone, Copy)]
enum Problem {
    Dam(DamBreak),
    Bowl(Bowl),
}

impl Problem {
    fn time_s(self) -> f64 {
        match self {
            Self::Dam(_) => DamBreak::TIME_S,
            Self::Bowl(bowl) => 5.0 * bowl.period_s(),
        }
    }

    fn model(self, tier: Tier, cells: u32) -> DepthModel {
        match self {
            Self::Dam(dam) => dam.model(tier, cells),
            Self::Bowl(bowl) => bowl.model(tier, cells, self.time_s()),
        }
    }

    fn columns(self, tier: Tier, model: &DepthModel) -> Columns {
        match self {
            Self::Dam(dam) => dam.columns(model.cells),
            Self::Bowl(bowl) => bowl.columns(tier, model),
        }
    }

    fn distance(self, model: &DepthModel, depths_m: &[f64]) -> f64 {
        match self {
            Self::Dam(dam) => dam.distance(depths_m),
            Self::Bowl(bowl) => bowl.distance(model, depths_m, self.time_s()),
        }
    }

    /// Depth that linear waves take for the whole basin (m).
    fn even_depth_m(self) -> f64 {
        match self {
            Self::Dam(dam) => 0.5 * (dam.high_m + dam.low_m),
            Self::Bowl(bowl) => bowl.depth_m,
        }
    }
}

/// Runs it: one study a problem.
///
/// # Errors
/// The device's.
pub fn study(gpu: &Gpu, quick: bool, progress: OnProgress<'_>) -> Result<Found> {
    let problems = [
        ("non-linear, Stoker", Problem::Dam(DamBreak::new(1.0, 0.1))),
        ("non-linear, Ritter", Problem::Dam(DamBreak::new(1.0, 0.0))),
        ("non-linear, Thacker", Problem::Bowl(Bowl::new(Swing::Tilting))),
    ];
    let sizes: &[u32] = if quick { &[100, 200] } else { &[100, 200, 400, 800] };
    let (mut done, of) = (0, problems.len() * sizes.len() * VARIANTS.len());
    let mut results = Vec::new();
    for (name, problem) in problems {
        let mut points = Vec::new();
        for &size in sizes {
            for (variant, tier) in VARIANTS {
                progress(Progress { done, of, now: &format!("{name}: {variant}, {size} columns") });
                done += 1;
                let (dt_s, error, step) = match tier {
                    Some(tier) => over_ground(gpu, problem, tier, size)?,
                    None => linear(gpu, problem, size)?,
                };
                points.push(Point {
                    variant: variant.into(),
                    step: dt_s,
                    size,
                    error: finite(error),
                    metric: METRIC.into(),
                    ms_per_sim_second: step.median_ms / dt_s,
                    ns_per_item: 1e6 * step.median_ms / f64::from(size).powi(2),
                    pareto: false,
                });
            }
        }
        let mut result = StudyResult {
            sim: "water".into(),
            study: name.into(),
            reference:
                "exact solution of the shallow-water equations along one row; cost of as many rows as columns"
                    .into(),
            points,
            cheapest: Vec::new(),
        };
        result.mark_pareto();
        result.cheapest = result.cheapest_for(&[0.1, 0.03, 0.01], "waves");
        results.push(result);
    }
    Ok(Found { studies: results, ..Found::default() })
}

/// Shorter than a bench's: there are many points.
fn effort(gpu: &Gpu) -> Effort {
    Effort { budget_s: 0.5, ..Effort::full(gpu) }
}

/// `columns` of one row, in each of `rows`.
fn repeated(row: &Columns, rows: u32) -> Columns {
    let all = |numbers: &[f32]| numbers.repeat(rows as usize);
    Columns { bed_m: all(&row.bed_m), rise_m: all(&row.rise_m), east: all(&row.east), south: all(&row.south) }
}

/// Step (s), error, and the time of a step on a square grid.
fn over_ground(gpu: &Gpu, problem: Problem, tier: Tier, size: u32) -> Result<(f64, f64, Timing)> {
    let model = problem.model(tier, size);
    let start = problem.columns(tier, &model);
    let mut basin = DepthBasin::new(gpu, tier, &model, &start)?;
    let steps = steps_to(&model, problem.time_s());
    // Velocities of a start that moves are those of half a step before; flows of pipes start at rest.
    if tier == Tier::Wet || matches!(problem, Problem::Dam(_)) {
        basin.first_step()?;
    } else {
        basin.steps(1)?;
    }
    basin.steps(steps - 1)?;
    let error = problem.distance(&model, &basin.columns()?.depths_m());
    let square = DepthModel { cells: UVec2::splat(size), ..model };
    let timing = DepthBasin::new(gpu, tier, &square, &repeated(&start, size))?.time(effort(gpu))?;
    Ok((model.dt_s, error, timing))
}

/// The same of linear waves over even depth, which know the surface alone.
fn linear(gpu: &Gpu, problem: Problem, size: u32) -> Result<(f64, f64, Timing)> {
    let like = problem.model(Tier::Wet, size);
    let start = problem.columns(Tier::Wet, &like);
    let scheme = Scheme::named("waves/w0");
    let model = scheme.model(Model {
        cells: uvec2(size, 1),
        cell_m: like.cell_m,
        speed_mps: (GRAVITY_MPS2 * problem.even_depth_m()).sqrt(),
        damping_per_s: 0.0,
        ..starts::model(like.cells, 0.0)
    });
    let steps = (problem.time_s() / model.longest_stable_s()).ceil();
    let model = Model { dt_s: problem.time_s() / steps, ..model };
    let surface = |(depth, surface): (f64, f64)| if depth > 0.0 { surface as f32 } else { 0.0 };
    let height_m: Vec<f32> = start.depths_m().into_iter().zip(start.surfaces_m()).map(surface).collect();
    let mut basin = Basin::new(gpu, scheme, &Start { name: "row", model, height_m: height_m.clone() })?;
    basin.first_step()?;
    basin.steps(steps as u32 - 1)?;
    let depth = |(height, &bed): (&f32, &f32)| f64::from((height - bed).max(0.0));
    let depths: Vec<f64> = basin.heights()?.iter().zip(&start.bed_m).map(depth).collect();
    let square = Model { cells: UVec2::splat(size), ..model };
    let square = Start { name: "rows", model: square, height_m: height_m.repeat(size as usize) };
    let timing = Basin::new(gpu, scheme, &square)?.time(effort(gpu))?;
    Ok((model.dt_s, problem.distance(&like, &depths), timing))
}
