// SPDX-License-Identifier: MIT OR Apache-2.0
//! Which rung steps a water: the cheapest that has what the scene asks for and is expected to keep within its tolerance.
//!
//! [`lacks`]: what the scene asks for; [`expected`]: the error to expect; [`cost`]: what it costs; [`step`]: its step.

mod cost;
mod expected;
mod lacks;
mod step;

pub(super) use cost::land_factor;
pub(super) use step::step_s;

use super::{Model, Walls, WaterScene};
use crate::water::Tier;
use cost::cost_ns;
use expected::expected_errors;
use lacks::{features, lacks, Lack};
use serde::Serialize;

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
            ns_per_column_second: cost_ns(water, variant, wishes.has_terrain, fps, step_s)
                .map(|ns| ns / step_s),
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
