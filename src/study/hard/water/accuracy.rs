// SPDX-License-Identifier: MIT OR Apache-2.0
//! How well waves run: in every direction, along walls, on grids of every shape.

use crate::{
    gpu::Gpu,
    study::{
        hard::{Context, Outcome},
        runs::{apart, book_constants, larger, twin, Basin, Scheme, Tunings},
        Result,
    },
    water::{
        cpu, oracle,
        starts::{self, Start},
        Model, Walls,
    },
};
use glam::{uvec2, UVec2};
use std::f64::consts::{FRAC_PI_2, PI};

/// Frequency of a mode as it was run (rad/s), and how far the surface was from the mode's shape, of its amplitude.
struct Swing {
    frequency: f64,
    residual: f64,
}

/// Runs a mode, from rest with the first half step, to its ninth zero or thereabouts, where the phase is as sharp as the
/// amplitude. `frequency` has to be good to a quarter of a turn there, no better.
fn swing(
    model: &Model,
    m: UVec2,
    frequency: f64,
    run: impl FnOnce(&Start, u32) -> Result<Vec<f32>>,
) -> Result<Swing> {
    const AMPLITUDE: f64 = 0.1;
    let zero = FRAC_PI_2 + 8.0 * PI;
    let steps = (zero / (frequency * model.dt_s)).round();
    let height = run(&starts::standing(*model, m, AMPLITUDE), steps as u32)?;
    let mode = oracle::mode(model.cells, m);
    let amplitude = oracle::amplitude(&height, &mode);
    let phase = zero - (amplitude / AMPLITUDE).asin();
    let residual = height.iter().zip(&mode).map(|(&h, shape)| (f64::from(h) - amplitude * shape).abs());
    Ok(Swing { frequency: phase / (steps * model.dt_s), residual: residual.fold(0.0, larger) / AMPLITUDE })
}

fn on_gpu<'a>(context: &'a Context<'_>, scheme: Scheme) -> impl Fn(&Start, u32) -> Result<Vec<f32>> + 'a {
    move |start, steps| {
        let mut basin = Basin::new(context.gpu, scheme, start)?;
        basin.first_step()?;
        basin.steps(steps - 1)?;
        basin.heights()
    }
}

fn in_twin(start: &Start, steps: u32) -> Result<Vec<f32>> {
    let mut twin = cpu::Waves::<f64>::at_rest(&start.model, &start.height_m);
    twin.first_step_from_rest();
    (1..steps).for_each(|_| twin.step());
    Ok(twin.height_m.into_iter().map(|h| h as f32).collect())
}

/// `c |k|`: what the frequency ought to be (rad/s).
fn exact(model: &Model, m: UVec2) -> f64 {
    let [x, y] = oracle::mode_k(model.cells, m);
    model.speed_mps / model.cell_m * x.hypot(y)
}

/// Speed at 45 degrees over speed along the axis, less one: two modes whose wavelengths are 8 cells to 0.03 %.
fn anisotropy(model: Model, run: impl Fn(&Start, u32) -> Result<Vec<f32>>) -> Result<f64> {
    let speed = |m| {
        Ok::<f64, crate::study::Error>(swing(&model, m, exact(&model, m), &run)?.frequency / exact(&model, m))
    };
    let (axis, diagonal) = (uvec2(41, 0), uvec2(29, 29));
    // What the axis would show at the wavelength of the diagonal, by the dispersion of the scheme along the axis.
    let along_axis = |m: UVec2| {
        let [x, y] = oracle::mode_k(model.cells, m);
        let k = x.hypot(y);
        2.0 * (0.5 * model.courant() * oracle::symbol([k, 0.0], model.diagonal).sqrt()).asin() / k
    };
    Ok(speed(diagonal)? / speed(axis)? * along_axis(axis) / along_axis(diagonal) - 1.0)
}

pub fn isotropy(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let scheme = Scheme::named(variant);
    let model = |diagonal| {
        let model =
            Model { damping_per_s: 0.0, diagonal, walls: Walls::Folded, ..book_constants(UVec2::splat(164)) };
        model.with_courant(0.9 * model.courant_limit())
    };
    let seed = anisotropy(model(1.0), in_twin)?;
    Ok(Outcome::of(anisotropy(model(scheme.diagonal), on_gpu(context, scheme))?)
        .seed(seed)
        .note("closed basin of 164 x 164, modes (41, 0) and (29, 29); the book's stencil in a twin"))
}

const SIZES: [u32; 4] = [16, 32, 64, 128];
/// Along a wall, 2 half waves on every grid.
const ALONG: UVec2 = uvec2(2, 0);

fn wall_model(cells: u32, diagonal: f64, walls: Walls) -> Model {
    let model = book_constants(UVec2::splat(cells));
    Model { damping_per_s: 0.0, diagonal, walls, ..model }.with_courant(0.5)
}

/// On each grid the error of the frequency, then on each grid the residual of the shape.
fn along_wall(
    walls: Walls,
    diagonal: f64,
    run: impl Fn(&Start, u32) -> Result<Vec<f32>>,
) -> Result<Vec<f64>> {
    let swung = |cells| {
        let model = wall_model(cells, diagonal, walls);
        let want = exact(&model, ALONG);
        let swing = swing(&model, ALONG, want, &run)?;
        Ok((swing.frequency / want - 1.0, swing.residual))
    };
    let all = SIZES.into_iter().map(swung).collect::<Result<Vec<_>>>()?;
    Ok(all.iter().map(|(error, _)| *error).chain(all.iter().map(|(_, residual)| *residual)).collect())
}

/// Frequency errors and residuals, of the variant and of the book's walls in a twin.
fn waves_along_wall(context: &Context<'_>, variant: &str) -> Result<[Vec<f64>; 4]> {
    let scheme = Scheme::named(variant);
    let mut measured = context.shared("along a wall", variant, || {
        along_wall(Walls::Folded, scheme.diagonal, on_gpu(context, scheme))
    })?;
    let mut seed =
        context.shared("along a wall", "the book's", || along_wall(Walls::Dropped, 1.0, in_twin))?;
    let (residuals, of_seed) = (measured.split_off(SIZES.len()), seed.split_off(SIZES.len()));
    Ok([measured, residuals, seed, of_seed])
}

/// Between each grid and the next.
fn orders(errors: &[f64]) -> Vec<f64> {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).abs().log2()).collect()
}

fn farthest_from_2(orders: &[f64]) -> f64 {
    orders.iter().map(|order| order - 2.0).max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(f64::NAN)
}

pub fn order_along_wall(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let [errors, _, seed_errors, _] = waves_along_wall(context, variant)?;
    let (measured, seed) = (orders(&errors), orders(&seed_errors));
    let words = |numbers: &[f64]| numbers.iter().map(|n| format!("{n:.2}")).collect::<Vec<_>>().join(", ");
    Ok(Outcome::of(farthest_from_2(&measured)).seed(farthest_from_2(&seed)).note(format!(
        "orders {}, error {:.1e} at 128 cells; the book's walls in a twin: orders {}",
        words(&measured),
        errors[SIZES.len() - 1],
        words(&seed)
    )))
}

pub fn shape_along_wall(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let [_, residuals, _, seed] = waves_along_wall(context, variant)?;
    let worst = |residuals: Vec<f64>| residuals.into_iter().fold(0.0, larger);
    Ok(Outcome::of(worst(residuals)).seed(worst(seed)).note("the book's walls in a twin"))
}

const STEPS: u32 = 16;
/// What rounding explains after 16 steps at 0.9 of the longest, of the highest column, with u = 2^-24. Each step rounds
/// the height, u, and a height once wrong swings by 1 / sqrt(1 - 0.9^2) = 2.3 of that: 16 * 2.3 u. It rounds the
/// velocity three times, 3 u dt v with dt v at most 2.5 of the highest column on these starts, and a velocity once wrong
/// raises the surface as long as it lasts: 3 * 2.5 u * (1 + 2 + .. + 16). Three rounded parameters turn each wave by
/// 3 u / 2 of its 2 rad a step: 16 * 3 u. Together 1105 u if all errors had one sign; a twentieth of it is usual.
pub const ROUNDING: f64 = 1105.0 / (1 << 24) as f64;

const GRIDS: [UVec2; 8] = [
    uvec2(1, 1),
    uvec2(1, 40),
    uvec2(40, 1),
    uvec2(2, 2),
    uvec2(3, 5),
    uvec2(17, 33),
    uvec2(255, 257),
    uvec2(1000, 3),
];

/// How far a grid is from its f64 twin, of the highest column: at most [`ROUNDING`].
pub fn from_twin(gpu: &Gpu, scheme: Scheme, tunings: Tunings, cells: UVec2) -> Result<f64> {
    let model = scheme.model(starts::model(cells, scheme.diagonal));
    let model = model.with_courant(0.9 * model.courant_limit());
    let start = if scheme.has_land { starts::islands(model) } else { starts::hump(model) };
    let mut basin = Basin::tuned(gpu, scheme, &start, tunings)?;
    basin.steps(STEPS)?;
    Ok(apart(&basin.heights()?, &twin(scheme, &start, STEPS)))
}

pub fn odd_grids(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let scheme = Scheme::named(variant);
    let (mut worst, mut at) = (0.0, UVec2::ZERO);
    for cells in GRIDS {
        let apart = from_twin(context.gpu, scheme, Tunings::for_grid(context.gpu, cells), cells)?;
        if larger(worst, apart) != worst {
            (worst, at) = (apart, cells);
        }
    }
    let worst_at = if worst > 0.0 { format!("worst at {} x {}", at.x, at.y) } else { "all equal".into() };
    Ok(Outcome::of(worst)
        .note(format!("{worst_at}, after {STEPS} steps; the listings take multiples of 16 only")))
}
