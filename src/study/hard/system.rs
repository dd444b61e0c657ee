// SPDX-License-Identifier: MIT OR Apache-2.0
//! What every system owes, whatever it simulates: limits that are named, and runs that can be had again.

use super::{Case, Context, Outcome};
use crate::{
    gpu::Submitter,
    run::World,
    scene::{Plan, Scene},
    study::{
        depths::{bench_model, landscape, tier_of, DepthBasin},
        runs::{Basin, Scheme},
        Error, Result,
    },
    water::{self, starts, Disturb, Disturbance, Model, Tier, Tuning, Waves},
};
use glam::{uvec2, vec2, UVec2};

/// The table.
pub const CASES: &[Case] = &[
    Case {
        id: "S2",
        title: "grids of 0, 1, as many columns as there may be, and one more: they run, or the limit is named",
        variants: &["book", "waves/w0.25", "wet", "shallow"],
        unit: "sizes that do neither",
        limit: 0.0,
        run: grids_at_the_limit,
    },
    Case {
        id: "S2",
        title: "lists of 0, 1, as many disturbances as there may be, and one more: they run, or the limit is named",
        variants: &["waves/w0.25"],
        unit: "lists that do neither",
        limit: 0.0,
        run: lists_at_the_limit,
    },
    Case {
        id: "S4",
        title: "the same seed twice, and once more from a checkpoint at half time, is the same to the bit",
        variants: &["book", "waves"],
        unit: "numbers that differ",
        limit: 0.0,
        run: the_same_again,
    },
];

/// Whether there were steps and all their numbers are finite; or why there were none.
fn steps(context: &Context<'_>, variant: &str, cells: UVec2) -> Result<bool> {
    let gpu = context.gpu;
    if let Some(tier) = tier_of(variant) {
        let model = bench_model(tier, cells);
        model.check(tier).map_err(water::Error::from)?;
        let mut basin = DepthBasin::new(gpu, tier, &model, &landscape(cells))?;
        basin.steps(2)?;
        return Ok(basin.columns()?.rise_m.iter().all(|h| h.is_finite()));
    }
    let scheme = Scheme::named(variant);
    let model = scheme.model(starts::model(cells, scheme.diagonal));
    scheme.check(&model).map_err(water::Error::from)?;
    let mut basin = Basin::new(gpu, scheme, &starts::hump(model))?;
    basin.steps(2)?;
    Ok(basin.heights()?.iter().all(|h| h.is_finite()))
}

/// What became of sizes: how many ran, and how many were refused in words that name the limit.
#[derive(Default)]
struct Tally {
    ran: u32,
    refused: u32,
    wrong: Vec<String>,
}

impl Tally {
    fn note(&mut self, size: String, must_run: bool, limit: &str, outcome: Result<bool>) {
        match outcome {
            Ok(true) if must_run => self.ran += 1,
            Err(error) if !must_run && error.to_string().contains(limit) => self.refused += 1,
            Err(error) => self.wrong.push(format!("{size}: {error}")),
            Ok(is_finite) => self.wrong.push(format!("{size}: ran, finite: {is_finite}")),
        }
    }

    fn outcome(self, ran: u32, refused: u32) -> Outcome {
        let note = format!("{} ran, {} refused; {}", self.ran, self.refused, self.wrong.join("; "));
        Outcome::of(self.wrong.len() as f64)
            .only_if((self.ran, self.refused) == (ran, refused))
            .note(note.trim_end_matches([';', ' ']))
    }
}

fn grids_at_the_limit(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    const MOST: u32 = Model::MOST_CELLS;
    let mut tally = Tally::default();
    for (cells, must_run) in [
        (uvec2(0, 0), false),
        (uvec2(0, 7), false),
        (uvec2(7, 0), false),
        (uvec2(1, 1), true),
        (uvec2(MOST, 1), true),
        (uvec2(1, MOST), true),
        (uvec2(MOST + 1, 1), false),
        (uvec2(1, MOST + 1), false),
    ] {
        let allowed = format!("1 to {MOST}");
        tally.note(format!("{} x {}", cells.x, cells.y), must_run, &allowed, steps(context, variant, cells));
    }
    // The largest square may be beyond the device.
    let square = UVec2::splat(MOST);
    let gpu = context.gpu;
    let state = match (variant, tier_of(variant)) {
        (_, Some(Tier::Wet)) => water::Wet::new(gpu, Tier::Wet.tuning(gpu, square))?.state(square).map(drop),
        (_, Some(Tier::Shallow)) => {
            water::Shallow::new(gpu, Tier::Shallow.tuning(gpu, square))?.state(square).map(drop)
        }
        ("book", _) => water::Book::new(gpu)?.state(square).map(drop),
        _ => Waves::new(gpu, Tuning::for_grid(gpu, square), false)?.state(square).map(drop),
    };
    // Of the largest buffer: both flows of a column lie side by side over ground, and all that it has in the book's.
    let bytes_a_column = match (variant, tier_of(variant)) {
        ("book", _) => 20,
        (_, Some(_)) => 8,
        _ => 4,
    };
    let bytes = bytes_a_column * u64::from(MOST).pow(2);
    let fits = bytes <= u64::from(gpu.limits().max_storage_buffer_range);
    let state = state.map(|()| true).map_err(Error::from);
    tally.note(format!("{MOST} x {MOST}"), fits, "maxStorageBufferRange", state);
    Ok(if fits { tally.outcome(4, 5) } else { tally.outcome(3, 6) })
}

fn lists_at_the_limit(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let gpu = context.gpu;
    let scheme = Scheme::named(variant);
    let model = scheme.model(starts::model(UVec2::splat(16), scheme.diagonal));
    let drop = Disturbance { at_m: vec2(3.0, 3.0), radius_m: 1.0, volume_m3: 0.01, ..Disturbance::default() };
    let mut tally = Tally::default();
    for count in [0, 1, 100] {
        let mut basin = Basin::new(gpu, scheme, &starts::flat(model, 0.0))?;
        let counts = basin.disturb(&vec![drop; count])?;
        let all_counted = counts.applied as usize == count;
        tally.note(format!("{count} in a list of {count}"), true, "", Ok(all_counted));
    }
    // Lists alone: as long as the device allows takes as many workgroups.
    let state = Waves::new(gpu, Tuning::for_grid(gpu, model.cells), false)?.state(model.cells)?;
    let most = gpu.limits().max_compute_work_group_count[0].min(u32::MAX / 64);
    let list = |capacity: u32| {
        Disturb::new(gpu)?.list_of(state.surfaces(), state.velocities(), capacity).map_err(Error::from)
    };
    let fits = list(1).and_then(|list| {
        let (_, left) = list.staging(&[drop; 3])?;
        Ok(left == 2 && list.capacity() == 1)
    });
    tally.note("3 in a list of 1".into(), true, "", fits);
    tally.note(format!("a list of {most}"), true, "", list(most).map(|_| true));
    tally.note(
        format!("a list of {most} + 1"),
        false,
        "maxComputeWorkGroupCount",
        list(most + 1).map(|_| true),
    );
    Ok(tally.outcome(5, 1))
}

const PICTURES: u32 = 12;

fn scene(model: &str, seed: u32) -> Result<(Scene, Plan)> {
    let text = format!(
        "seed = {seed}\n[output]\nsize = [32, 24]\nfps = 30\nframes = {PICTURES}\n\
         [[water]]\nname = \"pool\"\nmodel = \"{model}\"\ncells = [49, 33]\nsize_m = [4.9, 3.3]\ndepth_m = 0.5\n\
         damping_per_s = 0.1\n[water.rain]\ndrops_per_s = 300\nradius_m = 0.2\nvolume_m3 = 0.001\n"
    );
    let scene = Scene::parse(&text, "hard case", None, &[]).map_err(crate::run::RunError::from)?;
    let plan = scene.plan().map_err(crate::run::RunError::from)?;
    Ok((scene, plan))
}

/// The state after all pictures, in bits; gone on with in a new world after `half`, if asked to.
fn end(context: &Context<'_>, (scene, plan): &(Scene, Plan), half: Option<u32>) -> Result<Vec<u32>> {
    let gpu = context.gpu;
    let mut submitter = Submitter::new(gpu, 0)?;
    let mut world = World::new(gpu, scene, plan)?;
    for picture in 0..PICTURES {
        world.frame(&mut submitter, 1.0 / scene.output.fps)?;
        if Some(picture + 1) == half {
            let checkpoint = world.checkpoint(gpu, picture + 1)?;
            world = World::new(gpu, scene, plan)?;
            if !world.restore(gpu, &checkpoint)? {
                return Ok(Vec::new());
            }
        }
    }
    let states = world.checkpoint(gpu, PICTURES)?.states;
    Ok(states.into_iter().flatten().map(f32::to_bits).collect())
}

fn the_same_again(context: &Context<'_>, variant: &str) -> Result<Outcome> {
    let (scene_1, other) = (scene(variant, 1)?, scene(variant, 2)?);
    let first = end(context, &scene_1, None)?;
    let differ = |other: &[u32]| {
        let pairs = first.iter().zip(other).filter(|(a, b)| a != b).count();
        pairs + first.len().abs_diff(other.len())
    };
    let again = differ(&end(context, &scene_1, None)?);
    let resumed = differ(&end(context, &scene_1, Some(PICTURES / 2))?);
    let of_another = differ(&end(context, &other, None)?);
    Ok(Outcome::of((again + resumed) as f64).only_if(of_another > 0).note(format!(
        "{} numbers after {PICTURES} pictures in rain: {again} differ in a second run, {resumed} in one resumed at half \
         time, {of_another} with another seed",
        first.len()
    )))
}
