// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of pools: whole steps, births and ends among them.

use super::{Measured, Suite};
use crate::{
    gpu::Gpu,
    particles::{
        cpu, Compaction, Drag, Emitter, Layout, Options, Particle, Particles, Pool, PoolInfo, Step, Thrown,
        Tuning, TICKS_PER_S,
    },
    study::{must_be_within, runs, Result},
};
use glam::{vec3, Vec3};

/// Its rows.
pub const SUITE: Suite = Suite {
    sim: "particles",
    variants: &[
        "stable",
        "stable/direct",
        "stable/packed",
        "group",
        "group/packed",
        "group/records",
        "subgroup",
        "atomic",
        "atomic/records",
        "in-place",
        "in-place/packed",
        "ring",
    ],
    sizes: &[1 << 20, 1 << 24, 1 << 26],
    largest_on_cpu: 1 << 20,
    label: |size| size.to_string(),
    run: |gpu, variant, size, effort| {
        let options = options_of(gpu, variant);
        check(gpu, variant, options)?;
        let mut pool = crowd(gpu, options, size)?;
        let mut index = 0;
        let timing = runs::time(gpu, effort, |rec| {
            pool.record(rec, &Step::nth(index, DT_S));
            rec.barrier(Particles::EXIT, Particles::ENTRY);
            index += 1;
        })?;
        let bytes_per_item = f64::from(8 * options.layout.words());
        Ok(Measured { timing, items: f64::from(size), unit: "particle", bytes_per_item })
    },
};

const DT_S: f64 = 1.0 / 60.0;
const LIFE_S: f64 = 10.0;
const DRAG: Drag = Drag { pull_mps2: vec3(0.0, -9.81, 0.0), drag_per_s: 0.7 };

/// The options that a variant names: `stable`, then a layout, `direct` for survivors that are not gathered, or a tuning
/// such as `128x8`.
pub(in crate::study) fn options_of(gpu: &Gpu, variant: &str) -> Options {
    let has = |wanted: &str| variant.split('/').any(|option| option == wanted);
    let compaction = match variant.split('/').next() {
        Some("group") => Compaction::Group,
        Some("subgroup") => Compaction::Subgroup,
        Some("atomic") => Compaction::Atomic,
        Some("in-place") => Compaction::InPlace,
        Some("ring") => Compaction::Ring,
        _ => Compaction::Stable,
    };
    let layout = match (has("packed"), has("records")) {
        (true, _) => Layout::Packed,
        (_, true) => Layout::Records,
        _ => Layout::Planes,
    };
    let mut tuning = Tuning::for_device(gpu);
    tuning.gathers = tuning.gathers && !has("direct");
    for (group, items) in variant.split('/').filter_map(|option| option.split_once('x')) {
        if let (Ok(group), Ok(items)) = (group.parse(), items.parse()) {
            (tuning.group, tuning.items) = (group, items);
        }
    }
    Options { compaction, layout, tuning }
}

fn emitter(rate_per_s: f64) -> Emitter {
    Emitter { at_m: Vec3::Y, velocity_mps: Vec3::ZERO, speed_mps: 5.0, rate_per_s, thrown: Thrown::Singly }
}

/// A pool of `size` particles of all ages at tick 0, with as many births as there are ends. It is filled as any pool is: by
/// a life of births, in steps of a second.
pub(in crate::study) fn crowd(gpu: &Gpu, options: Options, size: u32) -> Result<Pool> {
    let tile = options.tuning.tile();
    let emitters = [emitter(f64::from(size) / LIFE_S)];
    let start = 0u32.wrapping_sub(LIFE_S as u32 * TICKS_PER_S);
    let info = PoolInfo {
        capacity: (size + size / 100 + 2 * tile).next_multiple_of(tile),
        life_s: LIFE_S,
        seed: 1,
        start,
        emitters: &emitters,
        law: bytemuck::bytes_of(&DRAG),
    };
    let mut pool = Particles::new(gpu, &Drag::LAW, options)?.pool(&info)?;
    for second in 0..LIFE_S as u32 {
        let from = start.wrapping_add(second * TICKS_PER_S);
        gpu.once(|rec| {
            pool.record(rec, &Step::between(from, from.wrapping_add(TICKS_PER_S)));
            rec.barrier(Particles::EXIT, Particles::ENTRY);
        })?;
    }
    // The oldest have gone: those of the first tick, and as a packed birth is rounded down, of the first 2^-6 s.
    let early_s = if options.layout == Layout::Packed { 1.0 / 64.0 } else { 1.0 / f64::from(TICKS_PER_S) };
    let allowed = 1.0 + early_s * emitters[0].rate_per_s;
    must_be_within("crowd", (pool.counts()?.alive() as f64 - f64::from(size)).abs(), allowed)?;
    Ok(pool)
}

/// Whether a small pool is its twin after 40 steps of births and ends: the same particles, where they belong.
pub(in crate::study) fn check(gpu: &Gpu, variant: &str, options: Options) -> Result<()> {
    let emitters = [emitter(7013.7)];
    let tile = options.tuning.tile();
    let info = PoolInfo {
        capacity: 4096u32.next_multiple_of(tile) + 2 * tile,
        life_s: 0.3,
        seed: 7,
        start: 0,
        emitters: &emitters,
        law: bytemuck::bytes_of(&DRAG),
    };
    let mut pool = Particles::new(gpu, &Drag::LAW, options)?.pool(&info)?;
    let mut twin = cpu::Pool::new(&info);
    gpu.once(|rec| {
        for index in 0..40 {
            pool.record(rec, &Step::nth(index, DT_S));
            rec.barrier(Particles::EXIT, Particles::ENTRY);
        }
    })?;
    (0..40).for_each(|index| twin.step(&Step::nth(index, DT_S), &|it, dt_s| cpu::drag(&DRAG, it, dt_s)));
    let (got, mut want) = (pool.living()?, twin.living());
    let packed = options.layout == Layout::Packed;
    // A packed birth is rounded down to 2^-6 s: some have gone before their time.
    want.retain(|it| !packed || twin.now.wrapping_sub(it.born & !1023) < twin.life_ticks);
    // To each its nearest of the same age: many compactions leave the order to the scheduler.
    let nearest = |of: &Particle| {
        let alike = got.iter().filter(|it| it.at_m.is_finite() && it.born >> 10 == of.born >> 10);
        alike.map(|it| f64::from((it.at_m - of.at_m).abs().max_element())).fold(f64::INFINITY, f64::min)
    };
    let allowed = if packed { 5.3e-3 } else { 1e-4 };
    let is_complete = got.len() == want.len();
    let apart = if is_complete { want.iter().map(nearest).fold(0.0, f64::max) } else { f64::INFINITY };
    must_be_within(variant, apart, allowed)
}
