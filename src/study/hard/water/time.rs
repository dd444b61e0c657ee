// SPDX-License-Identifier: MIT OR Apache-2.0
//! Water and time: a wave must not know how fast frames come.

use crate::{
    clock::FixedStep,
    study::{
        hard::{Context, Outcome},
        runs::{apart, book_constants, Basin, Scheme, Uniform},
        Result,
    },
    water::{cpu, oracle, starts, Model},
};
use glam::{uvec2, UVec2};
use std::{iter::repeat_n, sync::LazyLock};

/// A basin whose frames drive the clock, and the clock the steps: they are run when somebody looks.
struct Driven {
    basin: Basin,
    clock: FixedStep,
    elapsed_s: f64,
    due: u32,
    taken: u32,
}

impl Driven {
    fn new(basin: Basin, model: &Model, cap: u32) -> Self {
        Self { basin, clock: FixedStep::new(model.dt_s, cap), elapsed_s: 0.0, due: 0, taken: 0 }
    }

    fn frame(&mut self, frame_s: f64) {
        self.due += self.clock.advance(frame_s).steps;
        self.elapsed_s += frame_s;
    }

    fn surface(&mut self) -> Result<(Vec<f32>, Vec<f32>)> {
        self.basin.steps(self.due)?;
        self.taken += self.due;
        self.due = 0;
        self.basin.surface()
    }

    /// What the frames say the state is of (s): time lost without a word would show in it.
    fn shown_s(&self) -> f64 {
        self.elapsed_s - self.clock.pending_s()
    }
}

const LONGEST: UVec2 = uvec2(1, 0);

/// Twice the time between the first two zeros; not a number if they do not come. `look` lets `every` frames pass and says
/// when it is, and the amplitude.
fn period(every: u32, mut look: impl FnMut(u32) -> Result<(f64, f64)>) -> Result<f64> {
    const MOST_LOOKS: u32 = 2000;
    let (mut before, mut first) = ((0.0, f64::INFINITY), None);
    for _ in 0..MOST_LOOKS {
        let (t, a) = look(every)?;
        if a * before.1 < 0.0 {
            let zero = before.0 + (t - before.0) * before.1 / (before.1 - a);
            if let Some(first) = first {
                return Ok(2.0 * (zero - first));
            }
            first = Some(zero);
        }
        before = (t, a);
    }
    Ok(f64::NAN)
}

/// Spread over mean, and the values as a reader wants them.
fn spread(values: &[f64]) -> (f64, String) {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    // A value that is no number makes the mean one too.
    let words: Vec<String> = values.iter().map(|v| format!("{v:.4}")).collect();
    ((high - low) / mean, words.join(", "))
}

/// Frames a second.
const RATES: [u32; 4] = [20, 60, 144, 1000];

/// The same of the listings: they know no device, so once is enough.
static PRINTED_PERIODS: LazyLock<(f64, String)> = LazyLock::new(|| {
    let start = starts::standing(book_constants(UVec2::splat(64)), LONGEST, 0.1);
    let mode = oracle::mode(start.model.cells, LONGEST);
    let periods = RATES.map(|rate| {
        let mut seed = cpu::BookAsPrinted::at_rest(start.model.cells, &start.height_m);
        let mut elapsed = 0;
        let look = |frames: u32| {
            (0..frames).for_each(|_| seed.frame(1.0 / f64::from(rate)));
            elapsed += frames;
            let height: Vec<f32> = seed.height_m.iter().map(|&h| h as f32).collect();
            Ok((f64::from(elapsed) / f64::from(rate), oracle::amplitude(&height, &mode)))
        };
        period(rate / 20, look).unwrap_or(f64::NAN)
    });
    spread(&periods)
});

pub fn one_period(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let scheme = Scheme::named(variant);
    let model = scheme.model(book_constants(UVec2::splat(64)));
    let mode = oracle::mode(model.cells, LONGEST);
    let mut periods = Vec::new();
    for rate in RATES {
        let basin = Basin::new(context.gpu, scheme, &starts::standing(model, LONGEST, 0.1))?;
        let mut driven = Driven::new(basin, &model, u32::MAX);
        // Every half second: on a straight line between two looks a zero is 1e-5 of a period off at most.
        periods.push(period(rate / 2, |frames| {
            repeat_n(1.0 / f64::from(rate), frames as usize).for_each(|frame_s| driven.frame(frame_s));
            let (height, _) = driven.surface()?;
            Ok((driven.shown_s(), oracle::amplitude(&height, &mode)))
        })?);
    }
    let ((measured, periods), (seed, seeds)) = (spread(&periods), &*PRINTED_PERIODS);
    Ok(Outcome::of(measured)
        .seed(*seed)
        .note(format!("periods {periods} s; of the listings as printed {seeds} s")))
}

/// Amplitude of the swing of a mode, whatever its phase: from `a = A r^n cos(n turn + phase)` now and a step before.
fn envelope(model: &Model, m: UVec2, height: &[f32], velocity: &[f32]) -> f64 {
    let mode = oracle::mode(model.cells, m);
    let now = oracle::amplitude(height, &mode);
    let before = now - model.dt_s * oracle::amplitude(velocity, &mode);
    // Roots of l^2 - (1 + d - d theta^2) l + d, d = what a step keeps of the flow.
    let keep = (-model.damping_per_s * model.dt_s).exp();
    let theta2 = model.courant().powi(2) * oracle::symbol(oracle::mode_k(model.cells, m), model.diagonal);
    let cos = (1.0 + keep - keep * theta2) / (2.0 * keep.sqrt());
    now.hypot((before * keep.sqrt() - now * cos) / (1.0 - cos * cos).sqrt())
}

pub fn one_half_life(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let scheme = Scheme::named(variant);
    let rates = [30, 144, 1000];
    let model = scheme.model(book_constants(UVec2::splat(64)));
    let m = LONGEST;
    let half_life =
        |early: (f64, f64), late: (f64, f64)| (late.0 - early.0) * 2f64.ln() / (early.1 / late.1).ln();
    let (mut lives, mut seeds) = (Vec::new(), Vec::new());
    for rate in rates {
        let frame_s = 1.0 / f64::from(rate);
        let basin = Basin::new(context.gpu, scheme, &starts::standing(model, m, 0.1))?;
        let mut driven = Driven::new(basin, &model, u32::MAX);
        let mut look = |seconds: u32| -> Result<_> {
            (0..seconds * rate).for_each(|_| driven.frame(frame_s));
            let (height, velocity) = driven.surface()?;
            Ok((driven.shown_s(), envelope(&model, m, &height, &velocity)))
        };
        lives.push(half_life(look(1)?, look(20)?));

        // The rule of the listings in a twin without leaks: a frame is a step, and each keeps 0.9995.
        let cells = uvec2(64, 2);
        let seed = Model {
            cells,
            speed_mps: (0.3 / frame_s).sqrt(),
            damping_per_s: -0.9995f64.ln() / frame_s,
            dt_s: frame_s,
            ..model
        };
        let seed = Scheme::named("waves/w1").model(seed);
        let mut twin = cpu::Waves::<f64>::at_rest(&seed, &starts::standing(seed, m, 0.1).height_m);
        let mut look = |frames: u32| {
            (0..frames).for_each(|_| twin.step());
            let single = |numbers: &[f64]| -> Vec<f32> { numbers.iter().map(|&n| n as f32).collect() };
            envelope(&seed, m, &single(&twin.height_m), &single(&twin.velocity_mps))
        };
        seeds.push(half_life((0.0, look(20)), (1000.0 * frame_s, look(1000))));
    }
    let ((measured, lives), (seed, seeds)) = (spread(&lives), spread(&seeds));
    let want = 2.0 * 2f64.ln() / model.damping_per_s;
    Ok(Outcome::of(measured)
        .seed(seed)
        .note(format!("half-lives {lives} s, exact {want:.4} s; 0.9995 a frame makes it {seeds} s")))
}

fn hitch_model(scheme: Scheme) -> Model {
    scheme.model(Model { speed_mps: 0.33 / FRAME_S, ..book_constants(UVec2::splat(64)) })
}

const FRAME_S: f64 = 1.0 / 60.0;

/// A second and a half, a hitch, and as much again.
fn frames_with_hitch() -> impl Iterator<Item = f64> {
    repeat_n(FRAME_S, 90).chain([0.5]).chain(repeat_n(FRAME_S, 90))
}

/// How far the hitched run is from as many steps without clock or frames.
fn hitch(context: &Context<'_>, variant: &str, cap: u32) -> Result<(Driven, f64)> {
    let scheme = Scheme::named(variant);
    let model = hitch_model(scheme);
    let start = starts::hump(model);
    let mut driven = Driven::new(Basin::new(context.gpu, scheme, &start)?, &model, cap);
    frames_with_hitch().for_each(|frame_s| driven.frame(frame_s));
    let (height, _) = driven.surface()?;
    let mut steady = Basin::new(context.gpu, scheme, &start)?;
    steady.steps(driven.taken)?;
    let want: Vec<f64> = steady.heights()?.into_iter().map(f64::from).collect();
    let difference = apart(&height, &want);
    Ok((driven, difference))
}

pub fn hitch_caught_up(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let (driven, difference) = hitch(context, variant, u32::MAX)?;
    let start = starts::hump(hitch_model(Scheme::named("book")));
    let seed = |frames: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        let mut seed = cpu::BookAsPrinted::at_rest(start.model.cells, &start.height_m);
        frames.for_each(|frame_s| seed.frame(frame_s));
        seed.height_m
    };
    let hitched: Vec<f32> = seed(&mut frames_with_hitch()).into_iter().map(|h| h as f32).collect();
    let seed = apart(&hitched, &seed(&mut repeat_n(FRAME_S, 210)));
    Ok(Outcome::of(difference)
        .seed(seed)
        .only_if(driven.taken == 210)
        .note(format!("{} steps", driven.taken)))
}

pub fn hitch_capped(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let (driven, difference) = hitch(context, variant, 8)?;
    let (elapsed_s, lost_s) = (driven.elapsed_s, driven.clock.lost_s());
    let unreported = elapsed_s - f64::from(driven.taken) * FRAME_S - driven.clock.pending_s() - lost_s;
    // The listings step once, by 0.05 s at most, and say nothing.
    Ok(Outcome::of(unreported).seed(0.5 - 0.05).only_if(difference <= 1e-5).note(format!(
        "{lost_s:.4} s lost and reported; {difference:e} of the highest wave from a steady run of as many steps; the \
         listings lose 0.45 s and do not say so"
    )))
}

/// Frames for 1e4 steps of 1 s, 50 to 150 % of it.
fn jittered() -> impl Iterator<Item = f64> {
    Uniform(1).map(|u| 0.5 + u)
}

pub fn jitter(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    const STEPS: u32 = 10_000;
    let scheme = Scheme::named(variant);
    // A mode with theta = 1, where variable steps do the most harm. All its columns differ: equal ones would round alike,
    // and their errors add up instead of averaging out.
    let m = uvec2(61, 35);
    let model = scheme.model(Model { damping_per_s: 0.0, dt_s: 1.0, ..book_constants(UVec2::splat(128)) });
    let theta_1 = oracle::symbol(oracle::mode_k(model.cells, m), model.diagonal).sqrt().recip();
    // To the next speed whose pull f32 holds: the energy is of the parameters that really run.
    let pull = Model { speed_mps: theta_1, ..model }.params(model.cells.x).pull;
    let model = Model { speed_mps: (f64::from(pull) * (1.0 + 2.0 * model.diagonal)).sqrt(), ..model };
    let mut driven =
        Driven::new(Basin::new(context.gpu, scheme, &starts::standing(model, m, 0.1))?, &model, u32::MAX);
    let mut energies = Vec::new();
    let mut frames = jittered().map(|share| share * model.dt_s);
    let mut counts = [0u32; 3];
    for goal in [1, 1 + STEPS] {
        while driven.taken + driven.due < goal {
            let before = driven.due;
            driven.frame(frames.next().expect("the frames never end"));
            counts[(driven.due - before) as usize] += 1;
        }
        let (height, velocity) = driven.surface()?;
        energies.push((driven.taken, oracle::energy(&model, &height, &velocity)));
    }
    let [(from, early), (to, late)] = energies[..] else { unreachable!("two goals") };
    let drift = (late / early - 1.0) / f64::from(to - from);
    let [none, one, two] = counts;
    Ok(Outcome::of(drift).seed(jittered_growth(STEPS)).note(format!(
        "frames of no step {none}, one {one}, two {two}; the naive oscillator steps by the frame"
    )))
}

/// Growth of the energy per step of the same mode, if each step is as long as its frame.
fn jittered_growth(steps: u32) -> f64 {
    let (mut x, mut v) = (1.0f64, 0.0f64);
    for dt in jittered().take(steps as usize) {
        v -= dt * x;
        x += dt * v;
    }
    (x * x + v * v).ln() / f64::from(steps)
}
