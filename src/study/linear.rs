// SPDX-License-Identifier: MIT OR Apache-2.0
//! Linear water: stencil, step and storage against the exact solution. A hill spreads in a closed basin for as long as a
//! wave needs to cross it and come back.

use super::{
    runs::{self, Basin, Effort, Scheme, Timing},
    shapes::{finite, Headline, Parts, Point, StudyResult},
    Found, OnProgress, Progress, Result,
};
use crate::{
    gpu::Gpu,
    run::RunError,
    scene::Scene,
    water::{
        cpu, cpu_fourth,
        oracle::{relative_l2, Exact},
        starts::{self, Start},
        Model,
    },
};
use glam::UVec2;

/// As results name it.
pub const NAME: &str = "water linear";
/// What the error is.
pub const METRIC: &str = "relative L2 of the heights at 2 L / c";

/// Flows stored (`book`, `pipes`), or summed into a velocity (`waves`), in halves (`f16`) or not, one step a dispatch or
/// several (`fused`); by the
/// weight of a diagonal pipe: none, isotropic, by its length alone, as wide as the others.
const VARIANTS: [&str; 19] = [
    "book",
    "waves/w0",
    "waves/w0.25",
    "waves/w0.7071",
    "waves/w1",
    "waves/fourth",
    "waves/fused/w0",
    "waves/fused/w0.25",
    "waves/fused/w0.7071",
    "waves/fused/w1",
    "waves/f16/w0",
    "waves/f16/w0.25",
    "waves/fused/f16/w0.25",
    "pipes/w0",
    "pipes/w0.25",
    "pipes/w0.7071",
    "pipes/w1",
    "pipes/fused/w0",
    "pipes/fused/w0.25",
];
/// Of a study that is to be quick.
const QUICK: [&str; 9] = [
    "book",
    "waves/w0",
    "waves/w0.25",
    "waves/w0.7071",
    "waves/w1",
    "waves/fourth",
    "waves/fused/w0.25",
    "waves/f16/w0.25",
    "pipes/w0.25",
];
/// The listings, leak and all, in their twin: the error is its own, the cost that of `book`, which reads and writes the
/// same.
const PRINTED: &str = "book as printed";
/// The book's own step at 60 frames a second (columns a step).
const BOOK_COURANT: f64 = 0.0707;
/// The longest step asked of all.
const LONGEST_COURANT: f64 = 0.99;
/// Of the basin (m); with waves of 1 m/s, so that they cross it in 10 s. Cost per simulated second is in these units.
const BASIN_M: f64 = 10.0;
/// Of the answer.
const TOLERANCES: [f64; 3] = [0.1, 0.01, 0.001];
/// Of the hill, of the basin's width.
const SIGMA: f32 = 0.05;
/// Half waves in the basin: of the hill, the shorter ones hold `exp(-(pi 80 / 20)^2 / 2) = 5e-35`.
const MODES: u32 = 80;

/// What runs.
struct Extent {
    variants: &'static [&'static str],
    sizes: &'static [u32],
    /// Of the book alone, which is far from 1 % on the others.
    seed_sizes: &'static [u32],
    /// Largest that the twin of the listings runs on.
    printed: u32,
    /// Whose errors are taken apart.
    parts: &'static [u32],
    effort: Effort,
}

impl Extent {
    fn new(gpu: &Gpu, quick: bool) -> Self {
        let full = Effort { budget_s: 2.0, ..Effort::full(gpu) };
        let (variants, seed_sizes) = (&VARIANTS[..], &[][..]);
        match (quick, gpu.adapter().is_software()) {
            (true, _) => Self {
                variants: &QUICK,
                sizes: &[64, 128],
                seed_sizes,
                printed: 64,
                parts: &[128],
                effort: Effort { run_ms: 5.0, ..full },
            },
            (false, true) => {
                let sizes = &[64, 128, 256];
                Self { variants, sizes, seed_sizes, printed: 128, parts: &[128, 256], effort: full }
            }
            (false, false) => Self {
                variants,
                sizes: &[64, 128, 256, 512, 1024],
                seed_sizes: &[2048, 4096],
                printed: 256,
                parts: &[128, 256],
                effort: full,
            },
        }
    }
}

fn model(scheme: Scheme, cells: u32) -> Model {
    let basin = runs::book_constants(UVec2::splat(cells));
    let cell_m = BASIN_M / f64::from(cells);
    scheme.model(Model { cell_m, speed_mps: 1.0, damping_per_s: 0.0, ..basin })
}

/// Courant numbers up to the limit, and 0.95 of it.
fn courants(variant: &str, limit: f64, quick: bool) -> Vec<f64> {
    let slow = if variant == "book" { BOOK_COURANT } else { 0.07 };
    let mut all = vec![0.35, 0.7, 0.86, LONGEST_COURANT, 0.95 * limit];
    if variant.contains("fourth") {
        all.push(0.8);
    }
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
pub fn study(gpu: &Gpu, quick: bool, progress: OnProgress<'_>) -> Result<Found> {
    let extent = Extent::new(gpu, quick);
    let sizes = || extent.sizes.iter().chain(extent.seed_sizes).copied();
    let variants = |size| if extent.sizes.contains(&size) { extent.variants } else { &["book"][..] };
    let (mut done, of) = (0, sizes().map(|size| variants(size).len()).sum());
    let (mut points, mut parts) = (Vec::new(), Vec::new());
    for size in sizes() {
        let start = starts::gauss(model(Scheme::named("book"), size), SIGMA);
        let exact = Exact::smooth(start.model.cells, &start.height_m, MODES).after(2.0 * f64::from(size));
        for variant in variants(size) {
            progress(Progress { done, of, now: &format!("{variant}, {size} x {size}") });
            done += 1;
            let scheme = Scheme::named(variant);
            let model = model(scheme, size);
            let start = Start { model, ..start.clone() };
            let mut courants = courants(variant, scheme.courant_limit(&model), quick);
            if extent.seed_sizes.contains(&size) {
                courants.retain(|courant| [BOOK_COURANT, LONGEST_COURANT].contains(courant));
            }
            // Any stable step costs the same. One that is not would leave no numbers, which cost a GPU less.
            let longest = courants.last().copied().expect("each has a step");
            let timed = Start { model: model.with_courant(longest), ..start.clone() };
            let timing = Basin::new(gpu, scheme, &timed)?.time(extent.effort)?;
            for courant in courants {
                // A whole number of steps, none longer than asked for.
                let steps = (2.0 * f64::from(size) / courant).ceil() as u32;
                let model = model.with_courant(2.0 * f64::from(size) / f64::from(steps));
                let start = Start { model, ..start.clone() };
                let height_m = heights(gpu, scheme, &start, steps)?;
                points.push(point(variant, &model, relative_l2(&height_m, &exact), timing));
                let is_shortest = !quick && size == extent.parts[0] && courant <= BOOK_COURANT;
                if extent.parts.contains(&size) && !scheme.is_fused && (is_shortest || courant == longest) {
                    parts.push(parts_of(variant, &start, steps, &height_m, &exact));
                }
                if *variant == "book" && courant == BOOK_COURANT && size <= extent.printed {
                    let error = relative_l2(&printed(&start, steps), &exact);
                    points.push(point(PRINTED, &model, error, timing));
                }
            }
        }
    }
    let mut result = StudyResult {
        sim: "water".into(),
        study: "linear".into(),
        reference: "exact solution of the wave equation, by the cosine transform of the start".into(),
        points,
        cheapest: Vec::new(),
    };
    result.mark_pareto();
    result.cheapest = result.cheapest_for(&TOLERANCES, "book");
    let mut headlines = headlines(&result);
    headlines.push(choices(gpu, &result, extent.sizes)?);
    Ok(Found { studies: vec![result], headlines, parts })
}

/// Whether what scenes choose by rule keeps within the tolerance when it is run, and whether something cheaper would have:
/// the hill of this study as a scene, on each size and for each tolerance that the rules think can be kept there.
fn choices(gpu: &Gpu, result: &StudyResult, sizes: &[u32]) -> Result<Headline> {
    let (mut kept, mut all, mut cheaper, mut words) = (0, 0, 0, Vec::new());
    for &size in sizes {
        let start = starts::gauss(model(Scheme::named("book"), size), SIGMA);
        let exact = Exact::smooth(start.model.cells, &start.height_m, MODES).after(2.0 * f64::from(size));
        for tolerance in TOLERANCES {
            let scene = match Scene::parse(&scene_of(size, tolerance), "study", None, &[]) {
                Ok(scene) => scene,
                Err(error) if error.to_string().contains("tolerance") => continue, // none keeps within it here
                Err(error) => return Err(RunError::from(error).into()),
            };
            let verdict = scene.water[0].choice.taken();
            let scheme = Scheme::named(&verdict.name);
            let plan = scene.plan().map_err(RunError::from)?;
            let model = Model { dt_s: plan.waters[0].simulation.dt_s(), ..model(scheme, size) };
            let steps = (2.0 * BASIN_M / model.dt_s).round() as u32;
            let start = Start { model, ..start.clone() };
            let error = relative_l2(&heights(gpu, scheme, &start, steps)?, &exact);
            // Of the forms in which scenes run it, what the cheapest takes; and what any other takes here.
            let fused = verdict.name.replacen('/', "/fused/", 1);
            let of = |name: &str| result.points.iter().find(|p| p.variant == name && p.size == size);
            let ns = [verdict.name.as_str(), &fused].into_iter().filter_map(of).map(|p| p.ns_per_item);
            let cost = ns.fold(f64::INFINITY, f64::min) / model.dt_s;
            let is_cheaper = |p: &&Point| {
                let is_other = p.variant != verdict.name && p.variant != fused && !p.variant.contains("f16");
                let is_within = p.size == size && p.error.is_some_and(|error| error <= tolerance);
                is_other && is_within && p.ns_per_item / p.step < 0.9 * cost
            };
            let other = result.points.iter().find(is_cheaper);
            all += 1;
            kept += u32::from(error <= tolerance);
            cheaper += u32::from(other.is_some());
            words.push(format!(
                "{} % on {size}: {} expected {:.2} %, measured {:.2} %{}",
                100.0 * tolerance,
                verdict.name,
                100.0 * verdict.error(),
                100.0 * error,
                other.map_or(String::new(), |p| format!(" ({} is cheaper)", p.variant))
            ));
        }
    }
    Ok(Headline {
        sim: "water".into(),
        study: "linear".into(),
        what: format!("Choices by rule that keep within their tolerance, of {all}"),
        value: Some(f64::from(kept)),
        unit: "choices".into(),
        note: format!(
            "for {cheaper} of them another variant is more than 10 % cheaper and within it too; {}",
            words.join("; ")
        ),
    })
}

/// The study as a scene: so low that the model has no error.
fn scene_of(size: u32, tolerance: f64) -> String {
    format!(
        "output = {{ size = [16, 16], fps = 1, frames = 20 }}\n[[water]]\nname = 'hill'\ncells = [{size}, {size}]\n\
         size_m = [{BASIN_M}, {BASIN_M}]\ndepth_m = 1\ngravity_mps2 = 1\ndamping_per_s = 0\ntolerance = {tolerance}\n\
         start = {{ shape = 'hump', height_m = 1e-6, radius_m = {} }}\n",
        f64::from(SIGMA) * BASIN_M
    )
}

fn heights(gpu: &Gpu, scheme: Scheme, start: &Start, steps: u32) -> Result<Vec<f32>> {
    let mut basin = Basin::new(gpu, scheme, start)?;
    basin.first_step()?;
    basin.steps(steps - 1)?;
    basin.heights()
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

/// What the listings make of the start, with steps as long, but without their damping: the reference has none.
fn printed(start: &Start, steps: u32) -> Vec<f32> {
    let mut seed = cpu::BookAsPrinted::at_rest(start.model.cells, &start.height_m);
    seed.damping = 1.0;
    // `c dt / dx = sqrt(0.3 dt)` there, with waves as fast as the frames let them be.
    let frame_s = start.model.courant().powi(2) / 0.3;
    (0..steps).for_each(|_| seed.frame(frame_s));
    seed.height_m.into_iter().map(|h| h as f32).collect()
}

/// The same steps in f64. Whether flows are stored or summed is all the same there.
fn twin(scheme: Scheme, start: &Start, steps: u32) -> Vec<f64> {
    if scheme.is_book {
        let mut twin = cpu::Book::<f64>::at_rest(&start.model, &start.height_m);
        twin.first_step_from_rest();
        (1..steps).for_each(|_| twin.step());
        twin.height_m
    } else if scheme.is_fourth {
        let mut twin = cpu_fourth::Fourth::<f64>::at_rest(&start.model, &start.height_m);
        twin.first_step_from_rest();
        (1..steps).for_each(|_| twin.step());
        twin.height_m
    } else {
        let mut twin = cpu::Waves::<f64>::at_rest(&start.model, &start.height_m);
        twin.first_step_from_rest();
        (1..steps).for_each(|_| twin.step());
        twin.height_m
    }
}

/// The reference solves the equation that the schemes converge to: there is no error of the model.
fn parts_of(variant: &str, start: &Start, steps: u32, height_m: &[f32], exact: &[f64]) -> Parts {
    let norm = |of: &mut dyn Iterator<Item = f64>| of.map(|x| x * x).sum::<f64>().sqrt();
    let twin = twin(Scheme::named(variant), start, steps);
    let size = norm(&mut exact.iter().copied());
    let truncation = norm(&mut twin.iter().zip(exact).map(|(a, b)| a - b)) / size;
    let rounding = norm(&mut height_m.iter().zip(&twin).map(|(&a, b)| f64::from(a) - b)) / size;
    Parts {
        sim: "water".into(),
        study: "linear".into(),
        variant: variant.into(),
        step: start.model.dt_s,
        size: start.model.cells.x,
        truncation: finite(truncation),
        model: None,
        rounding: finite(rounding),
    }
}

/// Size, error and cost of the book at one Courant number, the smallest grid first.
fn of_book(result: &StudyResult, courant: f64) -> Vec<(f64, f64, f64)> {
    let its = |p: &&Point| {
        p.variant == "book" && (p.step * f64::from(p.size) / BASIN_M / courant - 1.0).abs() < 0.01
    };
    let numbers = |p: &Point| Some((f64::from(p.size), p.error?, p.ms_per_sim_second));
    let mut all: Vec<_> = result.points.iter().filter(its).filter_map(numbers).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// Cost at which the error comes down to `tolerance`, of sizes with their error and cost, on a line through two of them in
/// logarithms; and how it was found: those on either side of it, the last two when all are too coarse, or the first when none
/// is.
pub fn cost_of(tolerance: f64, all: &[(f64, f64, f64)]) -> Option<(f64, String)> {
    let &(size, error, ms) = all.first()?;
    if error <= tolerance {
        let how = format!("at most: {size} columns, the fewest that ran, come to {:.2} %", 100.0 * error);
        return Some((ms, how));
    }
    let pair = all.windows(2).find(|pair| pair[1].1 <= tolerance).or(all.windows(2).last())?;
    let [(size_a, error_a, ms_a), (size_b, error_b, ms_b)] = pair else { return None };
    let between = (size_b / size_a).ln();
    let order = (error_a / error_b).ln() / between;
    if !order.is_finite() || order < 0.1 {
        return None;
    }
    let size = size_b * (error_b / tolerance).powf(1.0 / order);
    let ms = ms_b * (size / size_b).powf((ms_b / ms_a).ln() / between);
    let how = match *error_b <= tolerance {
        true => format!("interpolated between {size_a} and {size_b} columns"),
        false => format!(
            "EXTRAPOLATED: {:.2} % is the best that it reaches, on {size_b} columns; by its order of {order:.2} between \
             {size_a} and {size_b} it takes {size:.0}",
            100.0 * error_b
        ),
    };
    Some((ms, how))
}

fn headlines(result: &StudyResult) -> Vec<Headline> {
    const TOLERANCE: f64 = 0.01;
    let headline = |what: &str, value: Option<f64>, unit: &str, note: String| Headline {
        sim: "water".into(),
        study: "linear".into(),
        what: what.into(),
        value: value.and_then(finite),
        unit: unit.into(),
        note,
    };
    let within = |p: &&Point| p.error.is_some_and(|error| error <= TOLERANCE);
    let cheapest = result
        .points
        .iter()
        .filter(within)
        .min_by(|a, b| a.ms_per_sim_second.total_cmp(&b.ms_per_sim_second));
    let note = cheapest.map_or("nothing that ran is this accurate".into(), |p| {
        let error = 100.0 * p.error.unwrap_or(f64::NAN);
        format!("{}, {} columns along each side, steps of {:.4} s: {error:.2} %", p.variant, p.size, p.step)
    });
    let ms = cheapest.map(|p| p.ms_per_sim_second);
    let mut all = vec![headline("Cheapest way to an error of 1 %", ms, "ms per simulated second", note)];
    for (courant, whose) in
        [(BOOK_COURANT, "its own step at 60 frames a second"), (LONGEST_COURANT, "the longest step")]
    {
        let seed = cost_of(TOLERANCE, &of_book(result, courant));
        let ratio = seed.as_ref().zip(ms).map(|((seed, _), ms)| seed / ms);
        let note = seed.map_or("too few sizes to tell".into(), |(ms, how)| {
            format!("the book's: {ms:.3e} ms per simulated second, {how}")
        });
        let what = format!("Time to an error of 1 %, the book's scheme with {whose} over the cheapest");
        all.push(headline(&what, ratio, "times", note));
    }
    all
}
