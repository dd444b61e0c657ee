// SPDX-License-Identifier: MIT OR Apache-2.0
//! Water over ground: dry beds, shores, deep seas, dam breaks and bowls.

use crate::{
    study::{
        depths::{from_twin, tier_of, DepthBasin, ROUNDING},
        hard::{Case, Context, Outcome},
        runs::{farther, larger, Scheme},
        Result,
    },
    water::{
        cpu, cpu_pipes,
        cpu_wet::Depths,
        dam::{steps_to, Bowl, DamBreak, Swing, GRAVITY_MPS2},
        oracle::relative_l2,
        starts, Columns, DepthModel, Model, Tier,
    },
};
use glam::{dvec2, uvec2, UVec2};
use std::sync::LazyLock;

const BOTH: &[&str] = &["wet", "shallow"];

/// The cases, for the table of water.
pub const CASES: &[Case] = &[
    Case {
        id: "W8",
        title: "a column of water on a dry bed spreads, and no column falls below dry",
        variants: BOTH,
        unit: "m below dry",
        limit: 0.0,
        run: lowest_on_dry_bed,
    },
    Case {
        id: "W8",
        title: "a column of water on a dry bed keeps its volume",
        variants: BOTH,
        unit: "of the volume",
        limit: 1e-7,
        run: volume_on_dry_bed,
    },
    Case {
        id: "W9",
        title: "a lake round a rock stays level to 2 ulp, 0, 10 and 1000 m above the level at rest",
        variants: BOTH,
        unit: "ulp of the surface",
        limit: 2.0,
        run: level_lake,
    },
    Case {
        id: "W9",
        title: "nothing flows in a lake round a rock, 0, 10 and 1000 m above the level at rest",
        variants: BOTH,
        unit: "of 4 dt g H / dx ulp",
        limit: 1.0,
        run: still_lake,
    },
    Case {
        id: "W10",
        title: "a ripple of 1 mm on water 1000 m deep is its f64 twin after 2000 steps",
        variants: BOTH,
        unit: "relative L2",
        limit: 1e-5,
        run: ripple_on_the_deep,
    },
    Case {
        id: "W14",
        title: "dam breaks over wet (Stoker) and dry ground (Ritter), 800 columns",
        variants: &["shallow/stoker", "shallow/ritter"],
        unit: "m of water out of place / m of step",
        limit: 0.03,
        run: dam_break,
    },
    Case {
        id: "W15",
        title: "water swings in Thacker's bowl for 5 periods, 400 columns, and none falls below dry",
        variants: &["shallow"],
        unit: "relative L1",
        limit: 0.1,
        run: bowl,
    },
    Case {
        id: "W16",
        title: "shores on grids of 1 x 1, 1 x N, 2 x 2, 17 x 33, 255 x 257 and 1000 x 3 are their f64 twin",
        variants: BOTH,
        unit: "difference / largest rise",
        limit: ROUNDING,
        run: odd_grids,
    },
    Case {
        id: "W17",
        title: "NaN, infinity and numbers beyond 1e6 in one column of a start are refused, whatever the column holds",
        variants: BOTH,
        unit: "starts taken",
        limit: 0.0,
        run: absurd_starts,
    },
];

fn tier(variant: &str) -> Tier {
    tier_of(variant).unwrap_or_else(|| panic!("`{variant}` names no tier"))
}

fn model(tier: Tier, cells: UVec2, deepest_m: f64, share: f64) -> DepthModel {
    let model = DepthModel {
        cells,
        cell_m: 1.0,
        gravity_mps2: GRAVITY_MPS2,
        deepest_m,
        fastest_mps: (GRAVITY_MPS2 * deepest_m).sqrt(),
        damping_per_s: 0.0,
        thin_m: 1e-6,
        dt_s: 1.0,
    };
    model.with_courant(tier, share * tier.courant_limit())
}

const BASIN: UVec2 = uvec2(64, 64);

/// 16 x 16 columns of 1 m in the middle of dry ground.
fn water_column() -> Vec<f32> {
    let is_high = |i: u32| (24..40).contains(&(i % BASIN.x)) && (24..40).contains(&(i / BASIN.x));
    (0..BASIN.element_product()).map(|i| f32::from(u8::from(is_high(i)))).collect()
}

fn volume<T: Copy + Into<f64>>(heights: &[T]) -> f64 {
    heights.iter().map(|&h| h.into()).sum()
}

/// Lowest column of the listings in 600 frames, the most columns below zero, and what they gain of the volume.
static PRINTED_COLLAPSE: LazyLock<(f64, usize, f64)> = LazyLock::new(|| {
    let start = water_column();
    let mut seed = cpu::BookAsPrinted::at_rest(BASIN, &start);
    let (mut low, mut below) = (0.0, 0);
    for _ in 0..600 {
        seed.frame(1.0 / 60.0);
        low = seed.height_m.iter().copied().fold(low, f64::min);
        below = below.max(seed.height_m.iter().filter(|h| **h < 0.0).count());
    }
    (low, below, volume(&seed.height_m) / volume(&start) - 1.0)
});

/// Lowest column, and the largest gain of the volume, at three steps.
fn collapse(context: &Context<'_>, variant: &str) -> Result<Vec<f64>> {
    const LOOKS: u32 = 40;
    const STEPS: u32 = 2000;
    let tier = tier(variant);
    let start = water_column();
    let (mut low, mut gain) = (f64::INFINITY, 0.0);
    for share in [0.14, 0.7, 0.99] {
        let columns = Columns::at_rest(&vec![0.0; start.len()], |i| f64::from(start[i]));
        let mut basin = DepthBasin::new(context.gpu, tier, &model(tier, BASIN, 1.0, share), &columns)?;
        for _ in 0..LOOKS {
            basin.steps(STEPS / LOOKS)?;
            let depths = basin.columns()?.depths_m();
            // A depth that is no number must not get lost.
            low = depths.iter().fold(low, |low, &h| -larger(-low, -h));
            let now = volume(&depths) / volume(&start) - 1.0;
            gain = farther(gain, now);
        }
    }
    Ok(vec![low, gain])
}

fn lowest_on_dry_bed(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let low = context.shared("collapse", variant, || collapse(context, variant))?[0];
    let (seed, below, _) = *PRINTED_COLLAPSE;
    Ok(Outcome::of(if low >= 0.0 { 0.0 } else { -low }).seed(-seed).note(format!(
        "looked at every 50 of 2000 steps, at 0.14, 0.7 and 0.99 of the longest; of the listings up to {below} of \
         4096 columns are below zero in 600 frames"
    )))
}

fn volume_on_dry_bed(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let gain = context.shared("collapse", variant, || collapse(context, variant))?[1];
    Ok(Outcome::of(gain)
        .seed(PRINTED_COLLAPSE.2)
        .note("largest of 40 looks in 2000 steps, at 0.14, 0.7 and 0.99 of the longest; the listings after 600 frames"))
}

/// The lake, and its surface (m).
fn lake(offset_m: f64) -> (Columns, f64) {
    let middle = dvec2(31.3, 30.1);
    let bed: Vec<f64> = (0..BASIN.element_product())
        .map(|i| {
            let from = dvec2(f64::from(i % BASIN.x), f64::from(i / BASIN.x)) - middle;
            offset_m - 0.7 + 1.5 * (-from.length_squared() / 128.0).exp()
        })
        .collect();
    let surface = offset_m + 0.3;
    (Columns::at_rest(&bed, |_| surface), surface)
}

const LAKE_STEPS: u32 = 2000;

/// How far from level (ulp), and the largest flow, of `4 dt g H / dx` ulp.
fn unrest(context: &Context<'_>, variant: &str) -> Result<Vec<f64>> {
    // The first steps one by one, so that no two-step cycle hides.
    const SINGLE: u32 = 20;
    const EVERY: u32 = 20;
    let tier = tier(variant);
    let model = model(tier, BASIN, 1.0, 0.9);
    let (mut ulps, mut flows) = (0.0, 0.0);
    for offset in [0.0, 10.0, 1000.0] {
        let (columns, surface) = lake(offset);
        let nearest = surface as f32;
        let ulp = f64::from(f32::from_bits(nearest.to_bits() + 1) - nearest);
        let allowed = 4.0 * model.dt_s * model.gravity_mps2 / model.cell_m * ulp;
        let mut basin = DepthBasin::new(context.gpu, tier, &model, &columns)?;
        let at_start = columns.depths_m();
        for look in 0..SINGLE + (LAKE_STEPS - SINGLE) / EVERY {
            basin.steps(if look < SINGLE { 1 } else { EVERY })?;
            let now = basin.columns()?;
            let (depths, surfaces) = (now.depths_m(), now.surfaces_m());
            for (i, depth) in depths.iter().enumerate() {
                let was_wet = at_start[i] > 0.0;
                let apart =
                    if was_wet { (surfaces[i] - f64::from(nearest)).abs() / ulp } else { depth / ulp };
                let carries = if tier == Tier::Wet { 1.0 } else { *depth };
                let flow = carries * f64::from(now.east[i].abs().max(now.south[i].abs())) / allowed;
                ulps = larger(ulps, apart);
                flows = larger(flows, flow);
            }
        }
    }
    Ok(vec![ulps, flows])
}

/// Largest change of the surface (m), and the largest flow, of `4 dt g H / dx` ulp of the level, when pipes take depths for
/// heights.
static DEPTH_DRIVEN: LazyLock<(f64, f64)> = LazyLock::new(|| {
    let depths: Vec<f32> = lake(0.0).0.depths_m().iter().map(|&h| h as f32).collect();
    let model = Model { cell_m: 1.0, speed_mps: GRAVITY_MPS2.sqrt(), ..starts::model(BASIN, 0.0) };
    let model = model.with_courant(0.9 * model.courant_limit());
    let mut twin = cpu_pipes::Pipes::<f64>::at_rest(&Model { damping_per_s: 0.0, ..model }, &depths);
    let (mut rise, mut flow) = (0.0, 0.0);
    for _ in 0..LAKE_STEPS {
        twin.step();
        let apart = twin.height_m.iter().zip(&depths).map(|(a, &b)| (a - f64::from(b)).abs());
        rise = apart.fold(rise, f64::max);
        flow = twin.flow_mps.iter().flatten().map(|f| f.abs()).fold(flow, f64::max);
    }
    (rise, flow * model.cell_m / (4.0 * model.dt_s * GRAVITY_MPS2 / model.cell_m * LEVEL_ULP))
});

/// Of the lake's surface at no offset, 0.3 m.
const LEVEL_ULP: f64 = f32::EPSILON as f64 / 4.0;

fn level_lake(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let ulps = context.shared("unrest", variant, || unrest(context, variant))?[0];
    let (rise, _) = *DEPTH_DRIVEN;
    Ok(Outcome::of(ulps).seed(rise / LEVEL_ULP).note(format!(
        "heights as they come: the level is not told; pipes that depths drive move the surface by {rise:.2} m"
    )))
}

fn still_lake(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let flows = context.shared("unrest", variant, || unrest(context, variant))?[1];
    Ok(Outcome::of(flows)
        .seed(DEPTH_DRIVEN.1)
        .note(format!("largest in {LAKE_STEPS} steps; pipes that depths drive in a twin")))
}

fn ripple_on_the_deep(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    const STEPS: u32 = 2000;
    const DEPTH_M: f64 = 1000.0;
    let tier = tier(variant);
    let cells = uvec2(64, 48);
    let deep = DepthModel { fastest_mps: 0.0, cell_m: 100.0, ..model(tier, cells, DEPTH_M, 1.0) };
    let deep = deep.with_courant(tier, 0.9 * tier.courant_limit());
    let waves = Model { damping_per_s: 0.0, ..starts::model(cells, 0.0) };
    let ripple: Vec<f32> = starts::gauss(waves, 0.1).height_m.iter().map(|h| 1e-3 * h).collect();
    let columns = Columns::at_rest(&vec![-DEPTH_M; ripple.len()], |i| f64::from(ripple[i]));
    let mut basin = DepthBasin::new(context.gpu, tier, &deep, &columns)?;
    basin.steps(STEPS)?;
    let mut exact = Depths::<f64>::new(tier, &deep, &columns);
    (0..STEPS).for_each(|_| exact.step());

    // Heights from the ground up, in the pipes of the book.
    let above_ground: Vec<f32> = ripple.iter().map(|h| DEPTH_M as f32 + h).collect();
    let mut seed = cpu::Book::<f32>::at_rest(&waves, &above_ground);
    let mut seed_exact = cpu::Book::<f64>::at_rest(&waves, &ripple);
    for _ in 0..STEPS {
        seed.step();
        seed_exact.step();
    }
    let of_seed: Vec<f32> = seed.height_m.iter().map(|h| h - DEPTH_M as f32).collect();
    Ok(Outcome::of(relative_l2(&basin.columns()?.rise_m, &exact.rise_m))
        .seed(relative_l2(&of_seed, &seed_exact.height_m))
        .note("heights of the pipes from the ground up, in f32, against f64"))
}

/// Pipes of even depth, as they would be for a lake of the mean depth: what they make of a surface (m), from rest.
fn linear(cells: u32, cell_m: f64, depth_m: f64, start_m: &[f32], time_s: f64) -> Vec<f64> {
    let scheme = Scheme::named("waves/w0");
    let model =
        Model { cells: uvec2(cells, 1), cell_m, damping_per_s: 0.0, ..starts::model(uvec2(cells, 1), 0.0) };
    let model = scheme.model(Model { speed_mps: (GRAVITY_MPS2 * depth_m).sqrt(), ..model }).with_courant(0.7);
    let steps = (time_s / model.dt_s).ceil();
    let mut twin = cpu::Waves::<f64>::at_rest(&Model { dt_s: time_s / steps, ..model }, start_m);
    twin.first_step_from_rest();
    (1..steps as u32).for_each(|_| twin.step());
    twin.height_m
}

fn dam_break(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    const CELLS: u32 = 800;
    let tier = tier(variant);
    let dam = DamBreak::new(1.0, if variant.ends_with("stoker") { 0.1 } else { 0.0 });
    let model = dam.model(tier, CELLS);
    let start = dam.columns(model.cells);
    let mut basin = DepthBasin::new(context.gpu, tier, &model, &start)?;
    basin.first_step()?;
    basin.steps(steps_to(&model, DamBreak::TIME_S) - 1)?;
    let depths = basin.columns()?.depths_m();
    let mean = 0.5 * (dam.high_m + dam.low_m);
    let pipes = linear(CELLS, model.cell_m, mean, &start.rise_m, DamBreak::TIME_S);
    Ok(Outcome::of(dam.distance(&depths))
        .seed(dam.distance(&pipes))
        .only_if(depths.iter().all(|h| *h >= 0.0))
        .note("pipes of even, mean depth in a twin"))
}

fn bowl(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    const CELLS: u32 = 400;
    let tier = tier(variant);
    let bowl = Bowl::new(Swing::Tilting);
    let time_s = 5.0 * bowl.period_s();
    let model = bowl.model(tier, CELLS, time_s);
    let start = bowl.columns(tier, &model);
    let mut basin = DepthBasin::new(context.gpu, tier, &model, &start)?;
    let (looks, steps) = (100, steps_to(&model, time_s));
    let mut low = f64::INFINITY;
    for look in 0..looks {
        basin.steps(steps * (look + 1) / looks - steps * look / looks)?;
        low = basin.columns()?.depths_m().into_iter().fold(low, |low, h| -larger(-low, -h));
    }
    let depths = basin.columns()?.depths_m();

    let wet_surface = |(h, surface): (f64, f64)| if h > 0.0 { surface as f32 } else { 0.0 };
    let surface: Vec<f32> = start.depths_m().into_iter().zip(start.surfaces_m()).map(wet_surface).collect();
    let pipes = linear(CELLS, model.cell_m, bowl.depth_m, &surface, time_s);
    let pipes: Vec<f64> =
        pipes.iter().zip(&start.bed_m).map(|(h, &bed)| (h - f64::from(bed)).max(0.0)).collect();
    Ok(Outcome::of(bowl.distance(&model, &depths, time_s))
        .seed(bowl.distance(&model, &pipes, time_s))
        .only_if(low >= 0.0)
        .note(format!("lowest column {low:e} m; pipes of even depth in a twin")))
}

fn absurd_starts(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    const BAD: [f32; 4] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30];
    let tier = tier(variant);
    let model = model(tier, BASIN, 1.0, 0.9);
    let (good, _) = lake(0.0);
    let taken = |columns: &Columns| DepthBasin::new(context.gpu, tier, &model, columns).is_ok();
    let mut wrong = 0;
    for bad in BAD {
        for field in 0..4 {
            let mut columns = good.clone();
            [&mut columns.bed_m, &mut columns.rise_m, &mut columns.east, &mut columns.south][field][77] = bad;
            wrong += u32::from(taken(&columns));
        }
    }
    Ok(Outcome::of(f64::from(wrong))
        .only_if(taken(&good))
        .note(format!("of {} starts; the same one without them is taken", 4 * BAD.len())))
}

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

fn odd_grids(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let tier = tier(variant);
    let mut worst = (0.0, UVec2::ZERO);
    for cells in GRIDS {
        let apart = from_twin(context.gpu, tier, tier.tuning(context.gpu, cells), cells)?;
        if apart > worst.0 || apart.is_nan() {
            worst = (apart, cells);
        }
    }
    Ok(Outcome::of(worst.0).note(format!("worst at {} x {}", worst.1.x, worst.1.y)))
}
