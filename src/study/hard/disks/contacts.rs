// SPDX-License-Identifier: MIT OR Apache-2.0
//! Contacts: pairs, crowds in one place, corners.

use super::{at_rest, model};
use crate::{
    disks::{edmd::Exact, starts, Borders, Disk, Model, Space},
    random::{bits, units},
    study::{
        disks::{overlap, Gas, Variant},
        hard::{Context, Outcome},
        runs::larger,
        Result,
    },
};
use glam::{dvec3, DVec3};

/// D1: ten by ten disks, each pair of neighbours a tenth inside each other.
pub fn block(context: &Context<'_>, name: &str) -> Result<Outcome> {
    let moved = |name: &str| -> Result<f64> {
        let variant = Variant::named(name);
        let disk = |i: u32| {
            let at = dvec3(0.5 + 0.036 * f64::from(i % 10), 0.5 + 0.036 * f64::from(i / 10), 0.0);
            Disk { velocity_mps: dvec3(0.2, 0.0, 0.0), ..at_rest(at, 0.02) }
        };
        let disks: Vec<Disk> = (0..100).map(disk).collect();
        let mut gas = Gas::new(context.gpu, &variant, &model(&variant, 2.0, Borders::Walls), &disks, 1)?;
        gas.steps(60)?;
        let mean = |disks: &[Disk]| disks.iter().map(|disk| disk.at_m.x).sum::<f64>() / 100.0;
        Ok(mean(&gas.disks()?) - mean(&disks) - 0.2)
    };
    Ok(Outcome::of(moved(name)?).seed(moved("sorted/seed")?))
}

/// Forty pairs, each in a place of its own, as if each began at another phase of a step.
fn pairs(first: impl Fn(f64) -> [Disk; 2]) -> Vec<Disk> {
    let place = |i: u32| dvec3(1.0 + 2.0 * f64::from(i % 8), 1.0 + 2.0 * f64::from(i / 8), 0.0);
    (0..40)
        .flat_map(|i| first(f64::from(i) / 40.0).map(|disk| Disk { at_m: disk.at_m + place(i), ..disk }))
        .collect()
}

/// D5: against the exact impulse where they meet. Each pair has a box of a metre: in a larger one, f32 says less exactly
/// where a disk is.
pub fn oblique(context: &Context<'_>, name: &str) -> Result<Outcome> {
    let pair = |phase: f64| {
        let (velocity, middle) = (dvec3(1.5, 0.4, 0.0), dvec3(0.5, 0.5, 0.0));
        let ahead = velocity * (phase / 60.0);
        [
            Disk { at_m: middle + dvec3(-0.3, -0.05, 0.0) + ahead, velocity_mps: velocity, radius_m: 0.1 },
            Disk {
                at_m: middle + dvec3(0.0, 0.06, 0.0),
                velocity_mps: dvec3(-0.2, -0.1, 0.0),
                radius_m: 0.05,
            },
        ]
    };
    let error = |name: &str| -> Result<f64> {
        let variant = Variant::named(name);
        let model = model(&variant, 1.0, Borders::Walls);
        let mut gas = Gas::new(context.gpu, &variant, &model, &pair(0.0), model.substeps(&pair(0.0)))?;
        let mut most = 0.0_f64;
        for i in 0..40 {
            let disks = pair(f64::from(i) / 40.0);
            gas.refill(&model, &disks)?;
            gas.steps(18)?;
            let mut exact = Exact::new(model, &disks);
            exact.run(18.0 / 60.0);
            assert_eq!(exact.collisions, 1, "they meet once");
            for (a, b) in gas.disks()?.iter().zip(&exact.disks) {
                most = larger(most, (a.velocity_mps - b.velocity_mps).length() / 1.5);
            }
        }
        Ok(most)
    };
    Ok(Outcome::of(error(name)?).seed(error("sorted/seed")?))
}

/// D6: two in one place, and three; two runs.
pub fn coincident(context: &Context<'_>, name: &str) -> Result<Outcome> {
    let bad = |name: &str| -> Result<f64> {
        let variant = Variant::named(name);
        let z = if variant.space == Space::Flat { 0.0 } else { 1.0 };
        let at = |x: f64| dvec3(x, 1.0, z);
        let disks: Vec<Disk> = [0.5, 0.5, 1.5, 1.5, 1.5].map(|x| at_rest(at(x), 0.1)).into_iter().collect();
        let run = || -> Result<(Vec<Disk>, Vec<u32>)> {
            let mut gas = Gas::new(context.gpu, &variant, &model(&variant, 2.0, Borders::Walls), &disks, 1)?;
            gas.steps(60)?;
            Ok((gas.disks()?, gas.words()?))
        };
        let ((disks, words), (_, again)) = (run()?, run()?);
        let none = |v: DVec3| v.to_array().iter().filter(|x| !x.is_finite()).count();
        let nowhere: usize = disks.iter().map(|disk| none(disk.at_m) + none(disk.velocity_mps)).sum();
        let differ = words.iter().zip(&again).filter(|(a, b)| a != b).count();
        let stuck = disks.windows(2).filter(|pair| pair[0].at_m == pair[1].at_m).count();
        Ok((nowhere + differ + stuck) as f64)
    };
    let seed = bad("sorted/seed")?;
    let outcome = Outcome::of(bad(name)?);
    // Whether 0/0 is a NaN is up to the driver.
    Ok(if seed > 0.0 { outcome.seed(seed) } else { outcome })
}

/// D7: the longest jump beyond the way that speed explains (diameters), and the pairs that overlap at the end.
pub fn heap(context: &Context<'_>, name: &str) -> Result<Vec<f64>> {
    context.shared("heap", name, || {
        let variant = Variant::named(name);
        let mut start = starts::seed(Space::Flat, 1000, Borders::Walls, 1);
        let bin = 2.0 / 31.0;
        for (i, disk) in (0..).zip(&mut start.disks) {
            let [x, y, ..] = units(bits(9, i, 0, 0)).map(f64::from);
            disk.at_m = dvec3(1.0 + bin * x, 1.0 + bin * y, 0.0);
        }
        let model = Model { dt_s: 1.0 / 240.0, response: variant.response, ..start.model };
        let mut gas = Gas::new(context.gpu, &variant, &model, &start.disks, 1)?;
        let (mut before, mut longest) = (start.disks, 0.0_f64);
        for _ in 0..480 {
            gas.steps(1)?;
            let now = gas.disks()?;
            for (a, b) in before.iter().zip(&now) {
                let way = (b.at_m - a.at_m).length() - b.velocity_mps.length() * model.dt_s;
                longest = larger(longest, way / (2.0 * a.radius_m));
            }
            before = now;
        }
        let are_apart = |a: &Disk, b: &Disk| (a.at_m - b.at_m).length() >= 0.999 * (a.radius_m + b.radius_m);
        let pairs = (0..1000).flat_map(|i| (0..i).map(move |k| (i, k)));
        let left = pairs.filter(|&(i, k)| !are_apart(&before[i], &before[k])).count();
        Ok(vec![longest, left as f64])
    })
}

/// D8: radius 0.3, bins of 0.14.
pub fn large(context: &Context<'_>, name: &str) -> Result<Outcome> {
    let mean = |name: &str| -> Result<f64> {
        let variant = Variant::named(name);
        let mut start = starts::seed(Space::Flat, 200, Borders::Walls, 1);
        start.disks[0] =
            Disk { at_m: dvec3(1.0, 1.0, 0.0), velocity_mps: dvec3(0.1, 0.05, 0.0), radius_m: 0.3 };
        let model = Model { response: variant.response, ..start.model };
        let substeps = model.substeps(&start.disks);
        let mut gas = Gas::new(context.gpu, &variant, &model, &start.disks, substeps)?;
        gas.steps(120)?; // the start is at random, and overlaps
        let mut sum = 0.0;
        for _ in 0..60 {
            gas.steps(5)?;
            sum += overlap(&model, &gas.disks()?);
        }
        Ok(sum / 60.0)
    };
    Ok(Outcome::of(mean(name)?).seed(mean("list/seed")?))
}

/// D9: a pair is missed if the one from the left has not turned back.
pub fn head_on(context: &Context<'_>, name: &str) -> Result<Outcome> {
    let radius_m = 0.05;
    let disks = pairs(|phase| {
        let speed = 5.0 * radius_m * 60.0; // ten radii a step, from both sides
        let disk = |side: f64| Disk {
            at_m: dvec3(side * (0.6 - 0.25 * phase), 0.0, 0.0),
            velocity_mps: dvec3(-side * speed, 0.0, 0.0),
            radius_m,
        };
        [disk(-1.0), disk(1.0)]
    });
    let missed = |name: &str| -> Result<(f64, u32)> {
        let variant = Variant::named(name);
        let model = model(&variant, 16.0, Borders::Walls);
        let substeps = model.substeps(&disks);
        let mut gas = Gas::new(context.gpu, &variant, &model, &disks, substeps)?;
        gas.steps(3)?;
        let after = gas.disks()?;
        let hit = after.chunks_exact(2).filter(|pair| pair[0].velocity_mps.x < 0.0).count();
        Ok(((40 - hit) as f64 / 40.0, substeps))
    };
    let (measured, substeps) = missed(name)?;
    Ok(Outcome::of(measured).seed(missed("sorted/seed")?.0).note(format!("each step in {substeps}")))
}

/// D12: disks that are not in the box after 2 s of gravity into a corner.
pub fn corner(context: &Context<'_>, name: &str) -> Result<Outcome> {
    let variant = Variant::named(name);
    let flat = if variant.space == Space::Flat { 0.0 } else { 1.0 };
    let mut outside = 0;
    let model =
        Model { gravity_mps2: dvec3(-5.0, -5.0, -5.0 * flat), ..model(&variant, 1.0, Borders::Walls) };
    let in_corner = at_rest(dvec3(0.05, 0.05, 0.05 * flat), 0.1); // half of it is outside
    for count in 1..=3 {
        let disks = vec![in_corner; count];
        let mut gas = Gas::new(context.gpu, &variant, &model, &disks, 4)?;
        gas.steps(120)?;
        let is_inside = |disk: &Disk| {
            let at = &disk.at_m.to_array()[..variant.space.dimensions() as usize];
            at.iter().all(|x| (0.0999..=0.9001).contains(x))
        };
        outside += gas.disks()?.iter().filter(|disk| !is_inside(disk)).count();
    }
    let refuses = [0.0, f64::NAN, -0.1]
        .iter()
        .all(|&radius_m| model.check(&[at_rest(in_corner.at_m, radius_m)]).is_err());
    Ok(Outcome::of(f64::from(outside as u32)).only_if(refuses))
}
