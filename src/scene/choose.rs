// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which rung steps a water: the cheapest that has what the scene asks for and is expected to keep within its tolerance.
//!
//! The expected error is that of the model, fitted to smooth humps of height `A` and half width `b` in water of depth `H`
//! after a way `X` (docs/water.md), and that of the grid: the phases of the scheme against those of the wave equation,
//! from the exact symbol of the stencil, over the spectrum of what is let go.

use super::{Body, BodyPath, BodyShape, Model, Start, Walls, WaterScene};
use crate::water::{self, oracle, Tier};
use glam::UVec2;
use serde::Serialize;
use std::{
    collections::BTreeSet,
    f64::consts::{FRAC_PI_4, PI},
};

/// A way to step a water.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Variant {
    /// The rung.
    pub model: Model,
    /// Of the error: 2 or 4.
    pub order: u32,
    /// Weight of the diagonal pipes.
    pub diagonal: f64,
}

/// What is expected of a variant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// Which.
    pub variant: Variant,
    /// Its name, as results have it.
    pub name: String,
    /// Relative error of the model.
    pub model_error: f64,
    /// Relative error of the grid.
    pub grid_error: f64,
    /// What a column and simulated second cost on an H100 (ns); `None` where that was not measured.
    pub ns_per_column_second: Option<f64>,
    /// What the scene asks for and this does not have; `None` if it has all.
    pub lacks: Option<String>,
}

/// Every variant, and the one that is taken.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Choice {
    /// The scene names its model.
    pub is_asked: bool,
    /// In the order of the rungs.
    pub verdicts: Vec<Verdict>,
    /// The one of them that is taken.
    pub chosen: usize,
}

/// What the scene says of the variant itself.
#[derive(Clone, Copy, Default)]
pub(super) struct Wishes {
    pub model: Option<Model>,
    pub order: Option<u32>,
    pub diagonal: Option<f64>,
    pub walls: Option<Walls>,
    pub foam: Option<bool>,
    pub has_terrain: bool,
}

/// A key, and what is wrong with its value.
pub(super) type Refusal = (&'static str, String);

/// A key that does not go with a variant: what that has instead, or not, and what the key goes with.
struct Lack {
    key: &'static str,
    why: &'static str,
    allowed: String,
}

impl Lack {
    fn refusal(&self, variant: &Variant) -> Refusal {
        let Self { key, why, allowed } = self;
        (key, format!("does not go with {}, which has {why}; allowed: {allowed}", variant.asked()))
    }
}

impl Variant {
    /// As results have it: `waves/w0.25`, `waves/fourth`, `shallow`.
    pub fn name(&self) -> String {
        match (self.model, self.order) {
            (Model::Waves, 4) => "waves/fourth".into(),
            (Model::Waves | Model::Pipes, _) => format!("{}/w{}", self.model.name(), self.diagonal),
            _ => self.model.name().into(),
        }
    }

    /// As a scene asks for it.
    fn asked(&self) -> String {
        let order = if self.order == 4 { " and order 4" } else { "" };
        format!("model {:?}{order}", self.model.name())
    }

    /// The tier, for the models that know the ground.
    pub fn tier(&self) -> Option<Tier> {
        match self.model {
            Model::Wet => Some(Tier::Wet),
            Model::Shallow => Some(Tier::Shallow),
            _ => None,
        }
    }
}

impl Verdict {
    /// Relative error, all together.
    pub fn error(&self) -> f64 {
        self.model_error + self.grid_error
    }
}

impl Choice {
    /// The variant that is taken.
    ///
    /// # Panics
    /// If nothing was chosen: a scene that was read has chosen.
    pub fn taken(&self) -> &Verdict {
        &self.verdicts[self.chosen]
    }

    /// Why, as the rest of a sentence.
    pub fn reason(&self, tolerance: Option<f64>) -> String {
        match (self.is_asked, tolerance) {
            (true, None) => "as the scene asks".into(),
            (true, Some(x)) => format!("the cheapest of the model asked for within {} %", percent(x)),
            (false, Some(x)) => {
                format!("the cheapest that has what the scene asks for within {} %", percent(x))
            }
            (false, None) => "the lowest rung that has what the scene asks for".into(),
        }
    }
}

/// Up to here the rules for the model's error are fitted; above it all that is known is that it is large.
pub const FITTED: f64 = 0.3;

/// An expected error in percent, as far as it is known.
pub fn percent_expected(share: f64) -> String {
    if share > FITTED {
        return format!("over {}", percent(FITTED));
    }
    percent(share)
}

/// A share in percent, to two figures.
pub fn percent(share: f64) -> String {
    let digits = (1 - (100.0 * share).abs().max(1e-12).log10().floor() as i32).clamp(0, 8) as usize;
    let text = format!("{:.digits$}", 100.0 * share);
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        text
    }
}

/// The variants of a scene that says no more of them than `wishes`, in the order of the rungs.
fn candidates(wishes: &Wishes) -> Vec<Variant> {
    let diagonals = wishes.diagonal.map_or(vec![0.25, 0.0, 1.0], |w| vec![w]);
    let second = |model| diagonals.iter().map(move |&diagonal| Variant { model, order: 2, diagonal });
    let mut all = vec![Variant { model: Model::Book, order: 2, diagonal: wishes.diagonal.unwrap_or(1.0) }];
    all.extend(second(Model::Waves));
    all.push(Variant { model: Model::Waves, order: 4, diagonal: 0.25 });
    all.extend(second(Model::Pipes));
    all.extend([Model::Wet, Model::Shallow].map(|model| Variant { model, order: 2, diagonal: 0.0 }));
    all
}

/// Sets model, order, stencil and what depends on them.
///
/// # Errors
/// Every key that does not go with the model asked for, or why no model will do.
pub(super) fn choose(
    water: &mut WaterScene,
    wishes: &Wishes,
    span_s: f64,
    fps: f64,
) -> Result<(), Vec<Refusal>> {
    let asked = wishes.model;
    let variants = candidates(wishes);
    let order = wishes.order.unwrap_or(2);
    if let Some(model) = asked {
        let variant = variants.iter().find(|v| v.model == model && v.order == order);
        let variant = variant.copied().unwrap_or(Variant { model, order, diagonal: 0.25 });
        let refused = lacks(&variant, water, wishes);
        if !refused.is_empty() {
            return Err(refused.iter().map(|lack| lack.refusal(&variant)).collect());
        }
    }
    let verdict = |variant: &Variant| {
        let step_s = step_s(water, variant, fps);
        let [model_error, grid_error] = expected_errors(water, variant, span_s, step_s);
        let mut lacks = lacks(variant, water, wishes);
        lacks.extend(features(variant, water, wishes));
        Verdict {
            variant: *variant,
            name: variant.name(),
            model_error,
            grid_error,
            ns_per_column_second: cost_ns(water, variant, wishes, fps, step_s).map(|ns| ns / step_s),
            lacks: lacks.first().map(|Lack { key, why, .. }| format!("{key}: {why}")),
        }
    };
    let verdicts: Vec<_> = variants.iter().map(verdict).collect();
    let able = |v: &Verdict| match asked {
        // What the scene asks for by name is taken as it is, also where another would be better.
        Some(model) => v.variant.model == model && lacks(&v.variant, water, wishes).is_empty(),
        None => v.variant.model != Model::Book && v.lacks.is_none() && v.ns_per_column_second.is_some(),
    };
    let able: Vec<usize> = (0..verdicts.len()).filter(|&i| able(&verdicts[i])).collect();
    let Some(&first) = able.first() else {
        let lacks =
            |v: &Verdict| v.lacks.as_ref().map(|lacks| format!("{:?} for {lacks}", v.variant.model.name()));
        let mut lacks: Vec<_> = verdicts.iter().skip(1).filter_map(lacks).collect();
        lacks.dedup();
        let why = format!("is left to be chosen, and none will do: not {}", lacks.join("; "));
        return Err(vec![("model", why)]);
    };
    let chosen = match water.tolerance {
        None => able.iter().copied().find(|&i| verdicts[i].variant.order == order).unwrap_or(first),
        Some(tolerance) => {
            let within = able.iter().copied().filter(|&i| verdicts[i].error() <= tolerance);
            let key = |i: &usize| {
                let verdict = &verdicts[*i];
                (verdict.ns_per_column_second.unwrap_or(f64::INFINITY), verdict.error())
            };
            let cheapest = within.min_by(|a, b| key(a).partial_cmp(&key(b)).expect("finite"));
            cheapest.ok_or_else(|| {
                let error = |i: &&usize| verdicts[**i].error();
                let best = able.iter().min_by(|a, b| error(a).total_cmp(&error(b))).expect("there is one");
                let best = &verdicts[*best];
                let why = format!(
                    "is {tolerance}; allowed: at least {:.2e}, which `{}` is expected to reach ({:.2e} of it the \
                     model's, which more columns do not change)",
                    best.error(),
                    best.name,
                    best.model_error
                );
                vec![("tolerance", why)]
            })?
        }
    };
    let taken = verdicts[chosen].variant;
    water.model = taken.model;
    water.order = taken.order;
    water.diagonal = taken.diagonal;
    water.walls = wishes.walls.unwrap_or(match taken.model {
        Model::Book => Walls::Dropped,
        _ => Walls::Folded,
    });
    water.foam = wishes.foam.unwrap_or(taken.model.has_ground());
    water.choice = Choice { is_asked: asked.is_some(), verdicts, chosen };
    Ok(())
}

/// Keys that do not go with a variant, whoever asks for it.
fn lacks(variant: &Variant, water: &WaterScene, wishes: &Wishes) -> Vec<Lack> {
    use Model::{Book, Pipes, Shallow, Waves, Wet};
    let mut list = Vec::new();
    let mut needs = |is_there: bool, key: &'static str, models: &[Model], why: &'static str| {
        if is_there && !models.contains(&variant.model) {
            let allowed: Vec<_> = models.iter().map(|model| format!("{:?}", model.name())).collect();
            list.push(Lack { key, why, allowed: allowed.join(", ") });
        }
    };
    let pushes = water.drops.iter().any(|drop| drop.push_m3ps != 0.0);
    let rain = water.rain.as_ref();
    needs(pushes, "drop", &[Waves], "no velocity of the surface to push");
    needs(
        rain.is_some_and(|rain| rain.push_m3ps != 0.0),
        "rain",
        &[Waves],
        "no velocity of the surface to push",
    );
    needs(
        rain.is_some_and(|rain| rain.mm_per_h != 0.0),
        "rain",
        &[Wet, Shallow],
        "no land for mm_per_h to fall on",
    );
    needs(water.borders.any_absorbs(), "borders", &[Waves], "no velocity of the surface to damp");
    needs(!water.barriers.is_empty(), "wall", &[Waves, Pipes, Wet, Shallow], "the whole grid as its basin");
    needs(
        !water.bodies.is_empty(),
        "body",
        &[Book, Waves, Pipes],
        "no level that stays, for bodies to float at",
    );
    needs(wishes.foam == Some(true), "foam", &[Pipes, Wet, Shallow], "no flows to show");
    needs(wishes.diagonal.is_some(), "diagonal", &[Book, Waves, Pipes], "no diagonal pipes");
    needs(wishes.walls == Some(Walls::Folded), "walls", &[Waves, Pipes], "no diagonal pipes to fold");
    needs(wishes.walls == Some(Walls::Dropped), "walls", &[Book, Waves, Pipes], "no diagonal pipes to drop");
    needs(wishes.order == Some(4), "order", &[Waves], "order 2");
    if variant.order == 4 {
        let mut fixed = |is_other: bool, key: &'static str, why: &'static str, allowed: &str| {
            if is_other {
                list.push(Lack { key, why, allowed: allowed.into() });
            }
        };
        fixed(wishes.diagonal.is_some_and(|w| w != 0.25), "diagonal", "one stencil", "0.25");
        fixed(wishes.walls == Some(Walls::Dropped), "walls", "walls that are mirrors", "\"folded\"");
        fixed(wishes.order == Some(2), "order", "order 4", "4");
    } else if variant.model == Waves && wishes.order == Some(4) {
        list.push(Lack { key: "order", why: "order 2", allowed: "2".into() });
    }
    list
}

/// Where a wave is higher than this share of the depth it breaks, and a block of it is a bore.
const BREAKING: f64 = 1.0 / 3.0;

/// What a scene has that a variant would get wrong, where the choice is ours.
fn features(variant: &Variant, water: &WaterScene, wishes: &Wishes) -> Vec<Lack> {
    let mut list = Vec::new();
    let mut wrong = |is_there: bool, key: &'static str, why: &'static str| {
        if is_there {
            list.push(Lack { key, why, allowed: String::new() });
        }
    };
    let has_ground = variant.model.has_ground();
    wrong(wishes.has_terrain && !has_ground, "terrain", "the bottom is not even, and shores move");
    wrong(!water.sources.is_empty() && !has_ground, "source", "levels rise, and a drain may fall dry");
    let is_rough = variant.model != Model::Shallow && breaks(water);
    wrong(
        water.tolerance.is_none() && is_rough,
        "start",
        "it breaks into a bore, which only advection carries",
    );
    list
}

fn breaks(water: &WaterScene) -> bool {
    waves_of(water).iter().any(|wave| wave.is_dam(water.depth_m))
}

/// Something that is let go: how high, how wide, of which wave numbers.
struct Wave {
    height_m: f64,
    half_width_m: f64,
    spectrum: Spectrum,
}

enum Spectrum {
    /// A Gaussian of this standard deviation (m).
    Gauss(f64),
    /// All waves of this number (rad/m).
    Ring(f64),
    /// A box of this half width (m).
    Edge(f64),
}

impl Wave {
    fn is_dam(&self, depth_m: f64) -> bool {
        matches!(self.spectrum, Spectrum::Edge(_)) && self.height_m > BREAKING * depth_m
    }

    fn gauss(height_m: f64, sigma_m: f64) -> Self {
        Self { height_m: height_m.abs(), half_width_m: 1.177 * sigma_m, spectrum: Spectrum::Gauss(sigma_m) }
    }

    /// The bell of a disturbance, `(1 - r^2)^2`, is half as high at 0.54 of its radius, as a Gaussian of 0.46 of it is.
    fn bell(height_m: f64, radius_m: f64) -> Self {
        Self::gauss(height_m, 0.46 * radius_m)
    }
}

/// The waves of a scene: its start and what disturbs it.
fn waves_of(water: &WaterScene) -> Vec<Wave> {
    let mut list = Vec::new();
    match water.start {
        Start::Flat => {}
        Start::Hump { height_m, radius_m, .. } => list.push(Wave::gauss(height_m.into(), radius_m.into())),
        Start::Sombrero { height_m, radius_m, .. } => {
            let (height_m, radius_m) = (f64::from(height_m).abs(), f64::from(radius_m));
            let spectrum = Spectrum::Ring(PI / radius_m);
            list.push(Wave { height_m, half_width_m: 0.6 * radius_m, spectrum });
        }
        Start::Mode { height_m, waves } => {
            let along = |axis: usize| PI * f64::from(waves[axis]) / f64::from(water.size_m[axis]);
            let k = along(0).hypot(along(1));
            if k > 0.0 {
                let height_m = f64::from(height_m).abs();
                list.push(Wave { height_m, half_width_m: 0.5 * PI / k, spectrum: Spectrum::Ring(k) });
            }
        }
        Start::Block { height_m, from_m, to_m } => {
            let half = |axis: usize| 0.5 * f64::from((to_m[axis] - from_m[axis]).abs());
            let half_width_m = half(0).min(half(1));
            let height_m = f64::from(height_m).abs();
            list.push(Wave { height_m, half_width_m, spectrum: Spectrum::Edge(half_width_m) });
        }
    }
    // A push lifts the surface until the wave has left the disc.
    let speed_mps = (water.gravity_mps2 * water.depth_m).sqrt();
    let bell = |radius_m: f32, volume_m3: f32, push_m3ps: f32| {
        let radius_m = f64::from(radius_m);
        let per_m3 = 3.0 / (PI * radius_m * radius_m);
        let pushed = f64::from(push_m3ps).abs() * 0.54 * radius_m / speed_mps;
        Wave::bell(per_m3 * f64::from(volume_m3).abs().max(pushed), radius_m)
    };
    list.extend(water.drops.iter().map(|drop| bell(drop.radius_m, drop.volume_m3, drop.push_m3ps)));
    let rain = water.rain.iter().filter(|rain| rain.drops_per_s > 0.0);
    list.extend(rain.map(|rain| bell(rain.radius_m, rain.volume_m3, rain.push_m3ps)));
    list.extend(water.bodies.iter().map(|body| wake(body, water)));
    list
}

/// What a body raises: its draught, over half its width.
fn wake(body: &Body, water: &WaterScene) -> Wave {
    let (half_m, height_m) = match body.shape {
        BodyShape::Sphere { radius_m } => (radius_m, radius_m),
        BodyShape::Box { half_m: [x, y, z] } => (x.min(z), y),
    };
    let y_m = match &body.path {
        BodyPath::Path(keys) => keys.first().map_or(0.0, |key| key[2]),
        BodyPath::Circle { centre_m, .. } => centre_m[1],
        BodyPath::Swing { at_m, by_m, .. } => at_m[1] - by_m[1].abs(),
    };
    let draught = (f64::from(water.level_m) - (y_m - height_m)).clamp(0.0, 2.0 * height_m);
    Wave::gauss(draught, half_m / 1.177)
}

/// Relative errors of model and grid at the end of `span_s`, for the wave that is worst in each.
fn expected_errors(water: &WaterScene, variant: &Variant, span_s: f64, step_s: f64) -> [f64; 2] {
    let speed_mps = (water.gravity_mps2 * water.depth_m).sqrt();
    let way_m = speed_mps * span_s;
    let courant = speed_mps * step_s / water.column_m();
    let longer = f64::from(water.cells[0].max(water.cells[1]));
    let worst = |error: &dyn Fn(&Wave) -> f64| waves_of(water).iter().map(error).fold(0.0, f64::max);
    [
        worst(&|wave| model_error(variant.model, wave, water.depth_m, way_m, longer)),
        worst(&|wave| match wave.is_dam(water.depth_m) {
            true => 0.0, // in the fit of the model's
            false => grid_error(variant, &wave.spectrum, courant, water.column_m(), way_m),
        }),
    ]
}

/// Fits of measured errors: smooth humps below a third of the depth, and dam breaks (L1; docs/water.md).
fn model_error(model: Model, wave: &Wave, depth_m: f64, way_m: f64, cells: f64) -> f64 {
    let share = wave.height_m / depth_m;
    let is_dam = wave.is_dam(depth_m);
    match model {
        Model::Book | Model::Waves | Model::Pipes if is_dam => 0.6,
        Model::Wet if is_dam => 0.75,
        Model::Shallow if is_dam => 0.1 * (100.0 / cells).powf(0.75),
        Model::Book | Model::Waves | Model::Pipes => 0.37 * share * way_m / wave.half_width_m,
        Model::Wet => 0.24 * share * way_m / wave.half_width_m,
        Model::Shallow => 0.062 * share,
    }
}

/// Relative L2 of the wave equation's solution against the scheme's after `way_m`, when every wave swings: `2 |sin|` of
/// half of what it is out of phase, over the spectrum.
fn grid_error(variant: &Variant, spectrum: &Spectrum, courant: f64, column_m: f64, way_m: f64) -> f64 {
    let steps = way_m / (courant * column_m);
    let power = |k: f64, angle: f64| {
        let k = k.clamp(1e-9, PI); // (rad/column); shorter waves are not on the grid
        let s = oracle::symbol([k * angle.cos(), k * angle.sin()], variant.diagonal);
        let s = if variant.order == 4 { s * (1.0 + (1.0 - courant * courant) * s / 12.0) } else { s };
        let turn = 2.0 * (0.5 * courant * s.max(0.0).sqrt()).min(1.0).asin();
        let late = steps * (turn - courant * k).abs();
        if late > PI {
            2.0
        } else {
            4.0 * (0.5 * late).sin().powi(2)
        }
    };
    const ANGLES: usize = 8;
    let round = |k: f64| {
        let angle = |i: usize| FRAC_PI_4 * (i as f64 + 0.5) / ANGLES as f64;
        (0..ANGLES).map(|i| power(k, angle(i))).sum::<f64>() / ANGLES as f64
    };
    /// Sums by wave numbers of one spectrum.
    fn mean(to: f64, weight: impl Fn(f64) -> f64, power: impl Fn(f64) -> f64) -> f64 {
        let points = (0..96).map(|i| to * (f64::from(i) + 0.5) / 96.0);
        let (sum, all) =
            points.fold((0.0, 0.0), |(sum, all), k| (sum + weight(k) * power(k), all + weight(k)));
        sum / all
    }
    match *spectrum {
        Spectrum::Gauss(sigma_m) => {
            let sigma = sigma_m / column_m;
            mean((5.0 / sigma).min(PI), |k| k * (-(k * sigma).powi(2)).exp(), round)
        }
        Spectrum::Ring(k) => round(k * column_m),
        Spectrum::Edge(half_m) => {
            let half = half_m / column_m;
            mean(PI, |k| ((k * half).sin() / (k * half)).powi(2), |k| power(k, 0.0))
        }
    }
    .sqrt()
}

/// The step of a variant (s): that of the scene, or the longest that divides a picture's time and is 5 % below the limit.
pub(super) fn step_s(water: &WaterScene, variant: &Variant, fps: f64) -> f64 {
    match variant.tier() {
        None => water.waves_model(variant, fps).dt_s,
        Some(tier) => water.depth_model(tier, fps).dt_s,
    }
}

/// A step of a column (ns): what an H100 80GB HBM3 with driver 580.159.04 measured (docs/results), at 4096 x 4096 but for
/// waves with land a step a dispatch, at 8192 x 8192. `None`: not measured. Fused kernels cost as their steps do, but a
/// dispatch no less than one of a step.
fn cost_ns(water: &WaterScene, variant: &Variant, wishes: &Wishes, fps: f64, step_s: f64) -> Option<f64> {
    let has_land = wishes.has_terrain || !water.barriers.is_empty();
    let shores = if wishes.has_terrain { 1.0 } else { shore_share(water) };
    // Between the rates of `coast`, of whose tiles a tenth are shores, and of `islands`, of whose tiles all are.
    let with_land = |coast: f64, islands: f64| {
        let share = ((shores - COAST) / (1.0 - COAST)).max(0.0);
        1.0 / ((1.0 - share) / coast + share / islands)
    };
    let steps = (1.0 / (fps * step_s)).max(1.0);
    // Rates in columns a ns: many steps a dispatch, and one.
    let fused = |many: f64, one: f64| {
        if water.acts_each_step() {
            1.0 / one
        } else {
            (1.0 / many).max(1.0 / (one * steps))
        }
    };
    Some(match (variant.model, variant.order, has_land) {
        (Model::Book, ..) => 1.0 / 50.4,
        (Model::Waves, 4, false) => 1.0 / 170.0,
        (Model::Waves, 4, true) => 1.0 / 58.8,
        (Model::Waves, _, false) => fused(877.0, 174.0),
        (Model::Waves, _, true) => fused(with_land(647.0, 163.0), 167.0),
        (Model::Pipes, _, true) if water.acts_each_step() => return None,
        (Model::Pipes, _, true) => 1.0 / with_land(188.0, 89.4),
        (Model::Pipes, ..) if variant.diagonal == 0.0 => fused(510.0, 118.0),
        (Model::Pipes, ..) => fused(308.0, 69.5),
        (Model::Wet, ..) => 1.0 / 86.3,
        (Model::Shallow, ..) => 1.0 / 52.9,
    })
}

/// Columns along a side of what a fused tile writes, and those beside it that it reads.
const TILE: u32 = 48;
const HALO: u32 = 8;
/// Share of the tiles of the bench's `coast` that are shores, as [`shore_share`] counts them.
const COAST: f64 = 0.1;

/// Share of tiles that have land or the border of the grid in reach: those cost several times what open water does.
fn shore_share(water: &WaterScene) -> f64 {
    let cells = UVec2::from(water.cells);
    let tiles = cells.map(|n| n.div_ceil(TILE));
    let reach = |from: UVec2, to: UVec2| {
        let from = from.saturating_sub(UVec2::splat(HALO)) / TILE;
        let to = ((to + HALO) / TILE).min(tiles - 1);
        (from.y..=to.y).flat_map(move |y| (from.x..=to.x).map(move |x| (x, y)))
    };
    let border = |(x, y): &(u32, u32)| *x == 0 || *y == 0 || *x + 1 == tiles.x || *y + 1 == tiles.y;
    let all = (0..tiles.y).flat_map(|y| (0..tiles.x).map(move |x| (x, y)));
    let mut shores: BTreeSet<_> = all.filter(border).collect();
    for [from, to] in water.walled_columns() {
        shores.extend(reach(from, to));
    }
    shores.len() as f64 / f64::from(tiles.element_product())
}

impl WaterScene {
    /// What steps it.
    pub fn variant(&self) -> Variant {
        Variant { model: self.model, order: self.order, diagonal: self.diagonal }
    }

    /// Whether anything acts between every two steps, so that several cannot be one dispatch.
    pub(super) fn acts_each_step(&self) -> bool {
        self.borders.any_absorbs() || !self.bodies.is_empty() || !self.sources.is_empty()
    }

    /// The model in the units of the kernels of flat water, with the step of `variant`.
    pub(super) fn waves_model(&self, variant: &Variant, fps: f64) -> water::Model {
        let model = water::Model {
            cells: self.cells.into(),
            cell_m: self.column_m(),
            speed_mps: (self.gravity_mps2 * self.depth_m).sqrt(),
            damping_per_s: self.damping_per_s,
            diagonal: variant.diagonal,
            walls: match self.walls {
                Walls::Folded => water::Walls::Folded,
                Walls::Dropped => water::Walls::Dropped,
            },
            dt_s: 0.0,
        };
        let longest_s = match variant.order {
            4 => model.fourth_order_limit() * model.cell_m / model.speed_mps,
            _ => model.longest_stable_s(),
        };
        water::Model { dt_s: self.step_below(longest_s, fps), ..model }
    }

    /// The same for the kernels of water over ground.
    pub(super) fn depth_model(&self, tier: Tier, fps: f64) -> water::DepthModel {
        let model = water::DepthModel {
            cells: self.cells.into(),
            cell_m: self.column_m(),
            gravity_mps2: self.gravity_mps2,
            deepest_m: self.deepest_m,
            fastest_mps: self.fastest_mps,
            damping_per_s: self.damping_per_s,
            thin_m: self.thin_m,
            dt_s: 0.0,
        };
        let longest_s = model.longest_stable_s(tier);
        water::DepthModel { dt_s: self.step_below(longest_s, fps), ..model }
    }

    /// The step that the scene gives, or the longest that divides a picture's time and is 5 % below the limit: fixed steps
    /// near the limit are the most accurate ones of a linear leapfrog, and the cheapest.
    fn step_below(&self, longest_s: f64, fps: f64) -> f64 {
        let steps = (1.0 / (fps * 0.95 * longest_s)).ceil().max(1.0);
        self.dt_s.unwrap_or(1.0 / (fps * steps))
    }
}
