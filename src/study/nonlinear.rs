// SPDX-License-Identifier: MIT OR Apache-2.0
//! Non-linear water: which model gets dam breaks and moving shores right, and at what cost. Linear pipes, pipes over
//! ground, face velocities and shallow water on the same exact solutions, on finer and finer grids.

use super::{
    depths::DepthBasin,
    runs::{Basin, Effort, Scheme, Timing},
    shapes::{finite, Headline, Parts, Point, StudyResult},
    Found, OnProgress, Progress, Result,
};
use crate::{
    gpu::Gpu,
    water::{
        cpu,
        cpu_wet::Depths,
        dam::{steps_to, Bowl, DamBreak, Swing, GRAVITY_MPS2},
        starts::{self, Start},
        Columns, DepthModel, Model, Tier,
    },
};
use glam::UVec2;

/// As results name it.
pub const NAME: &str = "water non-linear";
/// What the error is: of a dam break, of a bowl.
pub const METRIC: &str = "L1 of the depths";

/// How much of the shallow-water equations is in a variant.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Waves over even depth.
    Linear,
    /// Pipes as deep as the water.
    Wet,
    /// Face velocities that carry the depth of upstream.
    FaceVelocity,
    /// The whole equations.
    Shallow,
}

impl Kind {
    /// That it starts and steps as.
    fn tier(self) -> Tier {
        match self {
            Self::Linear | Self::Wet => Tier::Wet,
            Self::FaceVelocity | Self::Shallow => Tier::Shallow,
        }
    }
}

const LINEAR: &str = "waves/w0";
const SHALLOW: &str = "shallow";
const VARIANTS: [(&str, Kind); 4] = [
    (LINEAR, Kind::Linear),
    ("wet", Kind::Wet),
    ("shallow/no-advection", Kind::FaceVelocity),
    (SHALLOW, Kind::Shallow),
];

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

    /// Its grid is square; others are one row.
    fn is_round(self) -> bool {
        matches!(self, Self::Bowl(bowl) if bowl.swing != Swing::Tilting)
    }

    /// Of two solutions on one grid, in the metric of [`Problem::distance`].
    fn apart(self, a: &[f64], b: &[f64]) -> f64 {
        let apart: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
        match self {
            Self::Dam(dam) => apart * DamBreak::LENGTH_M / a.len() as f64 / (dam.high_m - dam.low_m),
            Self::Bowl(_) => apart / b.iter().sum::<f64>(), // no water is lost
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

/// What runs.
struct Extent {
    /// Columns of a problem of one row, and along each side of one that is round.
    sizes: &'static [u32],
    round_sizes: &'static [u32],
    /// Whose errors are taken apart.
    parts: &'static [u32],
    /// For what each model converges to.
    finest: u32,
    effort: Effort,
}

impl Extent {
    fn new(gpu: &Gpu, quick: bool) -> Self {
        // Shorter than a bench's: there are many points. A GPU takes its fewest runs in it all the same.
        let effort =
            Effort { budget_s: if gpu.adapter().is_software() { 0.5 } else { 2.0 }, ..Effort::full(gpu) };
        match quick {
            true => Self {
                sizes: &[100, 200],
                round_sizes: &[64],
                parts: &[100],
                finest: 800,
                effort: Effort { run_ms: 5.0, ..effort },
            },
            false => Self {
                sizes: &[100, 200, 400, 800],
                round_sizes: &[64, 128, 256],
                parts: &[100, 400],
                finest: 3200,
                effort,
            },
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
        ("non-linear, Thacker, round", Problem::Bowl(Bowl::new(Swing::Rising))),
    ];
    let extent = Extent::new(gpu, quick);
    let sizes = |problem: Problem| if problem.is_round() { extent.round_sizes } else { extent.sizes };
    let (mut done, of) = (0, problems.iter().map(|(_, it)| sizes(*it).len() * VARIANTS.len()).sum());
    let mut found = Found::default();
    for (name, problem) in problems {
        let mut points = Vec::new();
        for &size in sizes(problem) {
            for (variant, kind) in VARIANTS {
                progress(Progress { done, of, now: &format!("{name}: {variant}, {size} columns") });
                done += 1;
                let (model, depths) = run(gpu, problem, kind, size)?;
                let (dt_s, timing) = step_time(gpu, problem, kind, size, extent.effort)?;
                points.push(Point {
                    variant: variant.into(),
                    step: dt_s,
                    size,
                    error: finite(problem.distance(&model, &depths)),
                    metric: METRIC.into(),
                    ms_per_sim_second: timing.median_ms / dt_s,
                    ns_per_item: 1e6 * timing.median_ms / f64::from(size).powi(2),
                    pareto: false,
                });
            }
        }
        if !problem.is_round() {
            for (variant, kind) in VARIANTS {
                found.parts.extend(parts(gpu, name, problem, (variant, kind), &extent)?);
            }
        }
        let mut result = StudyResult {
            sim: "water".into(),
            study: name.into(),
            reference: match problem.is_round() {
                true => "exact solution of the shallow-water equations".into(),
                false => {
                    "exact solution of the shallow-water equations along one row; cost of as many rows as \
                          columns"
                        .into()
                }
            },
            points,
            cheapest: Vec::new(),
        };
        result.mark_pareto();
        result.cheapest = result.cheapest_for(&[0.1, 0.03, 0.01, 0.001], LINEAR);
        found.headlines.push(headline(&result));
        found.studies.push(result);
    }
    Ok(found)
}

/// The whole equations on the finest grid that ran, against the best that the seed's model did on any.
fn headline(result: &StudyResult) -> Headline {
    let of = |variant: &'static str| result.points.iter().filter(move |p| p.variant == variant);
    let finest = of(SHALLOW).max_by_key(|p| p.size);
    let errors: Vec<String> =
        of(LINEAR).map(|p| format!("{:.3} on {}", p.error.unwrap_or(f64::INFINITY), p.size)).collect();
    let size = finest.map_or(0, |p| p.size);
    Headline {
        sim: "water".into(),
        study: result.study.clone(),
        what: format!("{}: error of `{SHALLOW}` on {size} columns", result.study),
        value: finest.and_then(|p| p.error),
        unit: "(L1)".into(),
        note: format!("linear pipes, the seed's model: {}", errors.join(", ")),
    }
}

/// A row of water in even depth, as the linear variant starts (m above rest), and its step.
fn linear(problem: Problem, size: u32) -> (Start, DepthModel, Columns) {
    let like = problem.model(Tier::Wet, size);
    let start = problem.columns(Tier::Wet, &like);
    let model = Scheme::named(LINEAR).model(Model {
        cells: like.cells,
        cell_m: like.cell_m,
        speed_mps: (GRAVITY_MPS2 * problem.even_depth_m()).sqrt(),
        damping_per_s: 0.0,
        ..starts::model(like.cells, 0.0)
    });
    let steps = (problem.time_s() / model.longest_stable_s()).ceil();
    let model = Model { dt_s: problem.time_s() / steps, ..model };
    let surface = |(depth, surface): (f64, f64)| if depth > 0.0 { surface as f32 } else { 0.0 };
    let height_m = start.depths_m().into_iter().zip(start.surfaces_m()).map(surface).collect();
    (Start { name: "row", model, height_m }, like, start)
}

/// Depths (m) under a surface that knows no ground.
fn above_ground<T: Copy + Into<f64>>(height_m: &[T], ground: &Columns) -> Vec<f64> {
    let depth = |(&h, &bed): (&T, &f32)| h.into() - f64::from(bed);
    // Not by `max`, for which what is no number is dry.
    height_m.iter().zip(&ground.bed_m).map(depth).map(|h| if h < 0.0 { 0.0 } else { h }).collect()
}

/// Flows start at rest; velocities of a start that moves are those of half a step before.
fn starts_at_rest(problem: Problem, kind: Kind) -> bool {
    kind.tier() == Tier::Wet || matches!(problem, Problem::Dam(_))
}

/// Depths at the end (m), and the model over ground that they are of.
fn run(gpu: &Gpu, problem: Problem, kind: Kind, size: u32) -> Result<(DepthModel, Vec<f64>)> {
    if kind == Kind::Linear {
        let (start, like, ground) = linear(problem, size);
        let mut basin = Basin::new(gpu, Scheme::named(LINEAR), &start)?;
        basin.first_step()?;
        basin.steps((problem.time_s() / start.model.dt_s).round() as u32 - 1)?;
        return Ok((like, above_ground(&basin.heights()?, &ground)));
    }
    let model = problem.model(kind.tier(), size);
    let start = problem.columns(kind.tier(), &model);
    let mut basin = basin(gpu, kind, &model, &start)?;
    match starts_at_rest(problem, kind) {
        true => basin.first_step()?,
        false => basin.steps(1)?,
    }
    basin.steps(steps_to(&model, problem.time_s()) - 1)?;
    let depths = basin.columns()?.depths_m();
    Ok((model, depths))
}

fn basin(gpu: &Gpu, kind: Kind, model: &DepthModel, start: &Columns) -> Result<DepthBasin> {
    match kind {
        Kind::FaceVelocity => DepthBasin::without_advection(gpu, model, start),
        _ => DepthBasin::new(gpu, kind.tier(), model, start),
    }
}

/// [`run`] in f64.
fn twin(problem: Problem, kind: Kind, size: u32) -> Vec<f64> {
    if kind == Kind::Linear {
        let (start, _, ground) = linear(problem, size);
        let mut twin = cpu::Waves::<f64>::at_rest(&start.model, &start.height_m);
        twin.first_step_from_rest();
        (1..(problem.time_s() / start.model.dt_s).round() as u32).for_each(|_| twin.step());
        return above_ground(&twin.height_m, &ground);
    }
    let model = problem.model(kind.tier(), size);
    let twin = Depths::<f64>::new(kind.tier(), &model, &problem.columns(kind.tier(), &model));
    let mut twin = if kind == Kind::FaceVelocity { twin.without_advection() } else { twin };
    match starts_at_rest(problem, kind) {
        true => twin.first_step_from_rest(),
        false => twin.step(),
    }
    (1..steps_to(&model, problem.time_s())).for_each(|_| twin.step());
    (0..twin.rise_m.len()).map(|column| twin.depth_m(column)).collect()
}

/// Step (s), and the time that it takes on a square grid.
fn step_time(gpu: &Gpu, problem: Problem, kind: Kind, size: u32, effort: Effort) -> Result<(f64, Timing)> {
    let rows = if problem.is_round() { 1 } else { size as usize };
    let square = UVec2::splat(size);
    if kind == Kind::Linear {
        let (start, ..) = linear(problem, size);
        let model = Model { cells: square, ..start.model };
        let start = Start { name: "rows", model, height_m: start.height_m.repeat(rows) };
        return Ok((model.dt_s, Basin::new(gpu, Scheme::named(LINEAR), &start)?.time(effort)?));
    }
    let model = problem.model(kind.tier(), size);
    let row = problem.columns(kind.tier(), &model);
    let all = |numbers: &[f32]| numbers.repeat(rows);
    let start = Columns {
        bed_m: all(&row.bed_m),
        rise_m: all(&row.rise_m),
        east: all(&row.east),
        south: all(&row.south),
    };
    let model = DepthModel { cells: square, ..model };
    Ok((model.dt_s, basin(gpu, kind, &model, &start)?.time(effort)?))
}

/// Errors of a variant, taken apart with what it makes of the finest grid as what it converges to.
fn parts(
    gpu: &Gpu,
    study: &str,
    problem: Problem,
    (variant, kind): (&str, Kind),
    extent: &Extent,
) -> Result<Vec<Parts>> {
    let (finest_model, finest) = run(gpu, problem, kind, extent.finest)?;
    let model_error = problem.distance(&finest_model, &finest);
    let mut all = Vec::new();
    for &size in extent.parts {
        let (model, depths) = run(gpu, problem, kind, size)?;
        let twin = twin(problem, kind, size);
        let coarse: Vec<f64> = finest
            .chunks_exact((extent.finest / size) as usize)
            .map(|block| block.iter().sum::<f64>() / block.len() as f64)
            .collect();
        let step = if kind == Kind::Linear { linear(problem, size).0.model.dt_s } else { model.dt_s };
        all.push(Parts {
            sim: "water".into(),
            study: study.into(),
            variant: variant.into(),
            step,
            size,
            truncation: finite(problem.apart(&twin, &coarse)),
            model: finite(model_error),
            rounding: finite(problem.apart(&depths, &twin)),
        });
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn water_that_is_no_number_is_not_dry() {
        let ground = Columns::at_rest(&[-1.0, 0.5, -1.0], |_| 0.0);
        let depths = above_ground(&[0.25, 0.25, f64::NAN], &ground);
        assert_eq!(depths[..2], [1.25, 0.0]);
        assert!(depths[2].is_nan());
    }
}
