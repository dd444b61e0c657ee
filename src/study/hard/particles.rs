// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hard cases of the pool: B8, B9, and S1 and S2 as far as they are its own.

use super::{Case, Context, Outcome};
use crate::{
    gpu::Gpu,
    particles::{
        compile_law, cpu, Compaction, Drag, Emitter, Law, Layout, Options, Particles, Pool, PoolInfo, Step,
        Thrown, Tuning, TICKS_PER_S,
    },
    study::Result,
};
use glam::Vec3;

/// The table.
pub const CASES: &[Case] = &[
    Case {
        id: "B8",
        title: "an emitter inside the horizon, and a pool that is full, lose nobody silently",
        variants: &["stable", "group", "in-place"],
        unit: "particles unaccounted for",
        limit: 0.0,
        run: inside_the_horizon,
    },
    Case {
        id: "B9",
        title: "lives of 10 s end on their tick, at steps that do not divide them",
        variants: &["stable", "group", "in-place"],
        unit: "particles too many or too few",
        limit: 0.0,
        run: ends_of_lives,
    },
    Case {
        id: "S1",
        title: "ten times more births than room: dropped ones are counted, canaries round the buffers live",
        variants: &["stable", "group", "atomic", "in-place"],
        unit: "particles miscounted, and words overwritten",
        limit: 0.0,
        run: ten_times_too_many,
    },
    Case {
        id: "S2",
        title: "capacities of 0, 1, the limit and one more run or are refused with the limit",
        variants: &["stable"],
        unit: "set-ups that do neither",
        limit: 0.0,
        run: at_the_limits,
    },
];

fn options(gpu: &Gpu, variant: &str) -> Options {
    let compaction = match variant {
        "group" => Compaction::Group,
        "atomic" => Compaction::Atomic,
        "in-place" => Compaction::InPlace,
        _ => Compaction::Stable,
    };
    Options { compaction, layout: Layout::Planes, tuning: Tuning::for_device(gpu) }
}

fn emitter(rate_per_s: f64) -> Emitter {
    Emitter {
        at_m: Vec3::ZERO,
        velocity_mps: Vec3::ZERO,
        speed_mps: 5.0,
        rate_per_s,
        thrown: Thrown::Corners,
    }
}

fn run(gpu: &Gpu, pool: &mut Pool, steps: impl Iterator<Item = Step>) -> Result<()> {
    gpu.once(|rec| {
        for step in steps {
            pool.record(rec, &step);
            rec.barrier(Particles::EXIT, Particles::ENTRY);
        }
    })?;
    Ok(())
}

/// Births of an emitter up to a tick, in integers.
fn births_until(emitter: &Emitter, tick: u64) -> u64 {
    u64::from(emitter.batch()) * ((tick << 32) / emitter.period())
}

/// The law: straight on, and an end in a ball of 4 m round the origin.
const HORIZON: &str =
    "layout(set = 0, binding = LAW_BINDING, std430) readonly buffer Law { float radius_m; };
bool advance(inout Particle it, float dt_s) {
    it.at_m += it.velocity_mps * dt_s;
    return dot(it.at_m, it.at_m) > radius_m * radius_m;
}
";

fn inside_the_horizon(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let spv = compile_law(HORIZON, "horizon.glsl").expect("a law of this file");
    let law = Law {
        name: c"particles.horizon",
        spv: &spv,
        subgroups: None,
        deferred: None,
        constants: &[],
        blocks: &[],
    };
    let inside = emitter(6000.0);
    // 600 a second stay for two seconds: more than there is room for.
    let outside = Emitter { at_m: Vec3::X * 20.0, speed_mps: 0.5, rate_per_s: 600.0, ..inside };
    let emitters = [inside, outside];
    let info = PoolInfo {
        capacity: 1000,
        life_s: 2.0,
        seed: 1,
        start: 0,
        emitters: &emitters,
        law: bytemuck::bytes_of(&4f32),
    };
    let mut pool = Particles::new(context.gpu, &law, options(context.gpu, variant))?.pool(&info)?;
    run(context.gpu, &mut pool, (0..240).map(|i| Step::nth(i, 1.0 / 60.0)))?;
    let counts = pool.counts()?;
    let thrown: u64 = emitters.iter().map(|it| births_until(it, u64::from(pool.now()))).sum();
    let living = pool.living()?;
    let inside = living.iter().filter(|it| it.at_m.length() < 3.999).count() as u64;
    let lost =
        thrown.abs_diff(counts.born + counts.dropped) + counts.alive().abs_diff(living.len() as u64) + inside;
    let note = format!("{thrown} thrown: {counts:?}, {} alive", counts.alive());
    Ok(Outcome::of(lost as f64).only_if(counts.ended > 10_000 && counts.dropped > 0).note(note))
}

const STILL: Drag = Drag { pull_mps2: Vec3::ZERO, drag_per_s: 0.0 };

const RATE_PER_S: f64 = 120.0;

fn ends_of_lives(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let (mut worst, mut seed) = (0, 0);
    for dt_s in [1.0 / 24.0, 0.0137, 0.3] {
        let emitters = [Emitter { thrown: Thrown::Singly, ..emitter(RATE_PER_S) }];
        let info = PoolInfo {
            capacity: 2000,
            life_s: 10.0,
            seed: 1,
            start: 0,
            emitters: &emitters,
            law: bytemuck::bytes_of(&STILL),
        };
        let mut pool = Particles::new(context.gpu, &Drag::LAW, options(context.gpu, variant))?.pool(&info)?;
        let frames = (13.0 / dt_s) as u64;
        run(context.gpu, &mut pool, (0..frames).map(|i| Step::nth(i, dt_s)))?;
        let now = u64::from(pool.now());
        let ended = now - u64::from(pool.life_ticks());
        // Who is born within tick `ended` is of that tick, and a life old now: all before tick `ended + 1` have gone.
        let gone = u64::from(emitters[0].batch()) * ((((ended + 1) << 32) - 1) / emitters[0].period());
        let exact_now = (births_until(&emitters[0], now) - gone) as i64;
        worst = worst.max((pool.living()?.len() as i64 - exact_now).unsigned_abs());
        seed = seed.max((as_the_book(frames, dt_s) as i64 - exact_now).unsigned_abs());
    }
    Ok(Outcome::of(worst as f64).seed(seed as f64))
}

/// Born at frames, ages summed in floats, ends at frames: who lives after so many.
fn as_the_book(frames: u64, dt_s: f64) -> usize {
    let mut ages: Vec<f32> = Vec::new();
    for frame in 0..frames {
        let births = |frame: u64| (frame as f64 * dt_s * RATE_PER_S).floor() as usize;
        ages.resize(ages.len() + births(frame + 1) - births(frame), 0.0);
        ages.iter_mut().for_each(|age| *age += dt_s as f32);
        ages.retain(|age| *age < 10.0);
    }
    ages.len()
}

fn ten_times_too_many(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let mut wrong = 0;
    for capacity in [1, 33, 1000, 4097] {
        let emitters = [emitter(10.0 * f64::from(capacity) / 0.25)];
        let law = bytemuck::bytes_of(&STILL);
        let info = PoolInfo { capacity, life_s: 0.25, seed: 1, start: 0, emitters: &emitters, law };
        let mut pool = Particles::new(context.gpu, &Drag::LAW, options(context.gpu, variant))?.pool(&info)?;
        run(context.gpu, &mut pool, (0..60).map(|i| Step::nth(i, 1.0 / 60.0)))?;
        let mut twin = cpu::Pool::new(&info);
        (0..60).for_each(|i| twin.step(&Step::nth(i, 1.0 / 60.0), &|it, dt_s| cpu::drag(&STILL, it, dt_s)));
        let counts = pool.counts()?;
        let snapshot = pool.snapshot()?;
        let arguments = snapshot.state[3].max(snapshot.state[4] / 6).max(snapshot.state[8]);
        wrong += counts.dropped.abs_diff(twin.tally.dropped)
            + counts.born.abs_diff(twin.tally.born)
            + snapshot.trespasses(capacity) as u64
            + u64::from(arguments.saturating_sub(capacity))
            + (pool.living()?.len() as u64).abs_diff(counts.alive());
    }
    Ok(Outcome::of(wrong as f64))
}

fn at_the_limits(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let particles = Particles::new(context.gpu, &Drag::LAW, options(context.gpu, variant))?;
    let most = u64::from(context.gpu.limits().max_storage_buffer_range / 28 / 32 * 32 - 1);
    let most = most.min(u64::from(u32::MAX / 7)) as u32;
    let (mut wrong, mut notes) = (0, Vec::new());
    for capacity in [0, 1, most, most + 1] {
        let emitters = [emitter(8.0 * f64::from(TICKS_PER_S) / 65.0)];
        let law = bytemuck::bytes_of(&STILL);
        let info = PoolInfo { capacity, life_s: 1.0, seed: 1, start: 0, emitters: &emitters, law };
        match particles.pool(&info) {
            Ok(mut pool) => {
                run(context.gpu, &mut pool, (0..3).map(|i| Step::nth(i, 1.0 / 60.0)))?;
                let counts = pool.counts()?;
                let is_right =
                    counts.born == births_until(&emitters[0], u64::from(pool.now())).min(capacity.into());
                wrong += u32::from(!is_right || !(1..=most).contains(&capacity));
                notes.push(format!("{capacity} ran"));
            }
            // A device may have less memory than it sees of a buffer: it says so.
            Err(crate::particles::Error::Gpu(error)) if capacity == most => notes.push(error.to_string()),
            Err(error) => {
                let is_named = error.to_string().contains(&format!("1 to {most}"));
                wrong += u32::from(!is_named || (1..=most).contains(&capacity));
                notes.push(format!("{capacity} refused"));
            }
        }
    }
    Ok(Outcome::of(f64::from(wrong)).note(notes.join(", ")))
}
