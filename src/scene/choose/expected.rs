// SPDX-License-Identifier: MIT OR Apache-2.0
//! The error to expect of a variant. That of the model is fitted to smooth humps of height `A` and half width `b` in water of
//! depth `H` after a way `X` (docs/water.md). That of the grid: the phases of the scheme against those of the wave equation,
//! from the exact symbol of the stencil, over the spectrum of what is let go.

use super::{
    super::{Body, BodyPath, BodyShape, Model, Start, WaterScene},
    Variant,
};
use crate::water::oracle;
use std::f64::consts::{FRAC_PI_4, PI};

/// Where a wave is higher than this share of the depth it breaks, and a block of it is a bore.
const BREAKING: f64 = 1.0 / 3.0;

/// Something that is let go: how high, how wide, of which wave numbers.
pub(super) struct Wave {
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
    pub fn is_dam(&self, depth_m: f64) -> bool {
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
pub(super) fn waves_of(water: &WaterScene) -> Vec<Wave> {
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
    list.extend(water.splashes.iter().map(|it| bell(it.radius_m, it.drop_m3() as f32, 0.0)));
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
pub(super) fn expected_errors(water: &WaterScene, variant: &Variant, span_s: f64, step_s: f64) -> [f64; 2] {
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
