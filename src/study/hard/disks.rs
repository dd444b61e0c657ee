// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hard cases of disks.

use super::{Case, Context, Outcome};
use crate::{
    disks::{edmd::Exact, oracle, starts, Borders, Disk, Model, Response, Space},
    random::{bits, units},
    study::{
        disks::{overlap, seed_pressure, watch, Gas, Seen, Variant, Watch},
        runs::{farther, larger},
        Result,
    },
};
use glam::{dvec3, DVec3};
use std::{collections::BTreeMap, sync::Mutex};

const MATCHING: &str = "sorted/matching3";
const DEFAULT: &[&str] = &[MATCHING];

/// The table.
pub const CASES: &[Case] = &[
    Case {
        id: "D1",
        title: "a block of disks that overlap moves on at its 0.2 m/s",
        variants: &[MATCHING, "sorted/matching8", "sorted/gauss-seidel"],
        unit: "m from where it should be after 1 s",
        limit: 1e-5,
        run: block,
    },
    Case {
        id: "D2",
        title: "momentum holds for 100 s in a box that repeats",
        variants: &[MATCHING, "sorted/gauss-seidel"],
        unit: "of the sum of its lengths",
        limit: 1e-5,
        run: |context, variant| {
            Ok(Outcome::of(long(context, variant)?[0]).seed(long(context, "sorted/seed")?[0]))
        },
    },
    Case {
        id: "D3",
        title: "energy holds for 100 s",
        variants: &[MATCHING, "sorted/gauss-seidel", "sorted/seed"],
        unit: "of the energy",
        limit: 1e-4,
        run: |context, variant| Ok(Outcome::of(long(context, variant)?[1])),
    },
    Case {
        id: "D4",
        title: "the pressure is Henderson's at a way of half a radius a step, 15 Hz",
        variants: &[
            "sorted/matching3/0.2245",
            "sorted/matching3/0.4",
            "sorted/matching3/0.5",
            "sorted/matching8/0.5",
        ],
        unit: "of the pressure",
        limit: 0.01,
        run: |context, variant| pressure(context, variant, 0.5),
    },
    Case {
        id: "D4",
        title: "the pressure is Henderson's at 240 Hz",
        variants: &["sorted/matching3/0.5"],
        unit: "of the pressure",
        limit: 0.01,
        run: |context, variant| pressure(context, variant, 0.5 / 16.0),
    },
    Case {
        id: "D4",
        title: "the pressure is Henderson's in a dense fluid at 15 Hz",
        variants: &["sorted/matching3/0.55", "sorted/matching3/0.65", "sorted/matching8/0.65"],
        unit: "of the pressure",
        limit: 0.03,
        run: |context, variant| pressure(context, variant, 0.5),
    },
    Case {
        id: "D5",
        title: "pairs of unequal disks meet obliquely at 40 phases of a step",
        variants: DEFAULT,
        unit: "of the speed",
        limit: 1e-5,
        run: oblique,
    },
    Case {
        id: "D6",
        title: "disks with one centre stay numbers, and the same ones",
        variants: &[MATCHING, "sorted/matching3/3d", "sorted/gauss-seidel"],
        unit: "words that are none or differ",
        limit: 0.0,
        run: coincident,
    },
    Case {
        id: "D7",
        title: "1000 disks in one bin jump by a diameter at most in a step of 1/240 s",
        variants: DEFAULT,
        unit: "diameters a step",
        limit: 1.0,
        run: |context, variant| {
            Ok(Outcome::of(heap(context, variant)?.0).seed(heap(context, "sorted/seed")?.0))
        },
    },
    Case {
        id: "D7",
        title: "1000 disks in one bin are apart after 2 s",
        variants: DEFAULT,
        unit: "pairs that overlap by more than 0.001 of their radii",
        limit: 0.0,
        run: |context, variant| {
            Ok(Outcome::of(heap(context, variant)?.1).seed(heap(context, "sorted/seed")?.1))
        },
    },
    Case {
        id: "D8",
        title: "a disk wider than four bins overlaps nobody",
        variants: &[MATCHING, "sorted/matching8"],
        unit: "largest overlap of the radii, mean of the frames",
        limit: 5e-3,
        run: large,
    },
    Case {
        id: "D9",
        title: "disks that meet head-on with ten radii a step hit each other, at 40 phases",
        variants: DEFAULT,
        unit: "of the pairs missed",
        limit: 0.0,
        run: head_on,
    },
    Case {
        id: "D10",
        title: "small and large disks have the same mean energy over 60 frames",
        variants: DEFAULT,
        unit: "ratio less 1",
        limit: 0.05,
        run: |context, variant| {
            let [ratio, _] = mixture(context, variant)?;
            Ok(Outcome::of(ratio - 1.0)
                .note(format!("the tutorial's: {:.3}", mixture(context, "sorted/seed")?[0])))
        },
    },
    Case {
        id: "D10",
        title: "energies are those of Maxwell and Boltzmann: mean square over squared mean is 2",
        variants: DEFAULT,
        unit: "less 2",
        limit: 0.1,
        run: |context, variant| {
            let [_, kurtosis] = mixture(context, variant)?;
            Ok(Outcome::of(kurtosis - 2.0)
                .note(format!("the tutorial's: {:.3}", mixture(context, "sorted/seed")?[1])))
        },
    },
    Case {
        id: "D11",
        title: "two runs are equal to the bit",
        variants: &[MATCHING, "sorted/seed", "sorted/gauss-seidel", "sorted/matching3/3d"],
        unit: "words that differ",
        limit: 0.0,
        run: twice,
    },
    Case {
        id: "D12",
        title: "one disk, a disk in a corner, and two in one corner stay in the box; radii of 0 are refused",
        variants: &[MATCHING, "sorted/matching3/3d", "sorted/gauss-seidel"],
        unit: "disks that are nowhere or outside",
        limit: 0.0,
        run: corner,
    },
];

fn model(variant: &Variant, size_m: f64, borders: Borders) -> Model {
    Model {
        space: variant.space,
        size_m: DVec3::splat(size_m),
        borders,
        gravity_mps2: DVec3::ZERO,
        response: variant.response,
        dt_s: 1.0 / 60.0,
    }
}

fn at_rest(at_m: DVec3, radius_m: f64) -> Disk {
    Disk { at_m, velocity_mps: DVec3::ZERO, radius_m }
}

/// D1: ten by ten disks, each pair of neighbours a tenth inside each other.
fn block(context: &Context<'_>, name: &str) -> Result<Outcome> {
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

/// Runs that two cases share.
type Runs<T> = Mutex<BTreeMap<(String, String), T>>;

fn once<T: Clone>(
    runs: &Runs<T>,
    context: &Context<'_>,
    name: &str,
    run: impl FnOnce() -> Result<T>,
) -> Result<T> {
    let key = (context.gpu.adapter().uuid.clone(), name.to_owned());
    let mut runs = runs.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    if let Some(done) = runs.get(&key) {
        return Ok(done.clone());
    }
    let made = run()?;
    runs.insert(key, made.clone());
    Ok(made)
}

/// D2, D3: momentum and energy lost in 100 s of the tutorial's start, with places on a lattice.
fn long(context: &Context<'_>, name: &str) -> Result<[f64; 2]> {
    static RUNS: Runs<[f64; 2]> = Mutex::new(BTreeMap::new());
    once(&RUNS, context, name, || {
        // The way in a step is 0.09 radii, as in the tutorial.
        let mut start = starts::fluid(Space::Flat, 500, 0.2245, 6);
        start.model.dt_s = 0.09;
        let variant = Variant::named(name);
        start.model.response = variant.response;
        let substeps = start.model.substeps(&start.disks);
        let mut gas = Gas::new(context.gpu, &variant, &start.model, &start.disks, substeps)?;
        let (mut lost, mut energy) = (0.0_f64, 0.0_f64);
        let before = oracle::energy(&start.model, &start.disks);
        let (was, _) = oracle::momentum(&start.model, &start.disks);
        for _ in 0..20 {
            gas.steps(300)?;
            let disks = gas.disks()?;
            let (momentum, lengths) = oracle::momentum(&start.model, &disks);
            lost = larger(lost, (momentum - was).length() / lengths);
            let drift = oracle::energy(&start.model, &disks) / before - 1.0;
            energy = farther(energy, drift);
        }
        Ok([lost, energy])
    })
}

/// D4: from pairs in a box that repeats; the tutorial's, which has no impulse of a pair, from walls, against exact motion
/// in the same box.
fn pressure(context: &Context<'_>, name: &str, way: f64) -> Result<Outcome> {
    let packing: f64 = name.rsplit('/').next().and_then(|it| it.parse().ok()).expect("a packing");
    let variant = Variant::named(name);
    // Near freezing, a fluid takes long to forget the lattice that it started from.
    let collisions = if packing > 0.6 { [200.0, 400.0] } else { [40.0, 120.0] };
    let what = Watch { disks: 1600, packing, way, collisions };
    let Seen { pressure, doubt, substeps, .. } = watch(context.gpu, &variant, what, None)?;
    let outcome = Outcome::of(pressure);
    let note = format!("each step in {substeps}; standard error {doubt:.1e}");
    if variant.response != (Response::Matching { rounds: 3, rewinds: true }) || way < 0.5 || packing > 0.6 {
        return Ok(outcome.note(note));
    }
    let (seed, doubt) = seed_pressure(context.gpu, packing, 0.1, 80.0)?;
    Ok(outcome.seed(seed).note(format!("{note}, {doubt:.1e} of the tutorial's")))
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
fn oblique(context: &Context<'_>, name: &str) -> Result<Outcome> {
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
fn coincident(context: &Context<'_>, name: &str) -> Result<Outcome> {
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
fn heap(context: &Context<'_>, name: &str) -> Result<(f64, f64)> {
    static RUNS: Runs<(f64, f64)> = Mutex::new(BTreeMap::new());
    once(&RUNS, context, name, || {
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
        Ok((longest, left as f64))
    })
}

/// D8: radius 0.3, bins of 0.14.
fn large(context: &Context<'_>, name: &str) -> Result<Outcome> {
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
fn head_on(context: &Context<'_>, name: &str) -> Result<Outcome> {
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

/// D10: mean energy of the smaller half over that of the larger, and the mean square of the energy over the squared mean.
fn mixture(context: &Context<'_>, name: &str) -> Result<[f64; 2]> {
    static RUNS: Runs<[f64; 2]> = Mutex::new(BTreeMap::new());
    once(&RUNS, context, name, || {
        let variant = Variant::named(name);
        let start = starts::seed(Space::Flat, 2000, Borders::Walls, 3);
        let model = Model { response: variant.response, ..start.model };
        let mut gas = Gas::new(context.gpu, &variant, &model, &start.disks, model.substeps(&start.disks))?;
        gas.steps(900)?; // some twenty collisions a disk
        let mut order: Vec<usize> = (0..start.disks.len()).collect();
        order.sort_by(|&a, &b| start.disks[a].radius_m.total_cmp(&start.disks[b].radius_m));
        let (mut halves, mut squares) = ([0.0; 2], 0.0);
        for _ in 0..60 {
            gas.steps(10)?;
            let disks = gas.disks()?;
            for (rank, &i) in order.iter().enumerate() {
                let energy =
                    0.5 * model.space.mass(disks[i].radius_m) * disks[i].velocity_mps.length_squared();
                halves[rank / 1000] += energy;
                squares += energy * energy;
            }
        }
        let mean = (halves[0] + halves[1]) / 120_000.0;
        Ok([halves[0] / halves[1], squares / 120_000.0 / (mean * mean)])
    })
}

/// D11: words of two runs that differ; of the tutorial's lists too, if they do.
fn twice(context: &Context<'_>, name: &str) -> Result<Outcome> {
    let differ = |name: &str| -> Result<f64> {
        let variant = Variant::named(name);
        let start = starts::seed(variant.space, 5000, Borders::Walls, 2);
        let run = || -> Result<Vec<u32>> {
            let model = Model { response: variant.response, dt_s: 1.0 / 60.0, ..start.model };
            let mut gas = Gas::new(context.gpu, &variant, &model, &start.disks, 1)?;
            gas.steps(100)?;
            gas.words()
        };
        Ok(run()?.iter().zip(&run()?).filter(|(a, b)| a != b).count() as f64)
    };
    let outcome = Outcome::of(differ(name)?);
    let seed = differ("list/seed")?;
    Ok(if seed > 0.0 { outcome.seed(seed) } else { outcome })
}

/// D12: disks that are not in the box after 2 s of gravity into a corner.
fn corner(context: &Context<'_>, name: &str) -> Result<Outcome> {
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
