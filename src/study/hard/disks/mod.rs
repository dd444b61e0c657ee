// SPDX-License-Identifier: MIT OR Apache-2.0
//! Hard cases of disks.

mod contacts;
mod fluid;

use super::{Case, Context, Outcome};
use crate::{
    disks::{starts, Borders, Disk, Model},
    study::{
        disks::{Gas, Variant},
        Result,
    },
};
use contacts::{block, coincident, corner, head_on, heap, large, oblique};
use fluid::{long, mixture, pressure};
use glam::DVec3;

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
            Ok(Outcome::of(heap(context, variant)?[0]).seed(heap(context, "sorted/seed")?[0]))
        },
    },
    Case {
        id: "D7",
        title: "1000 disks in one bin are apart after 2 s",
        variants: DEFAULT,
        unit: "pairs that overlap by more than 0.001 of their radii",
        limit: 0.0,
        run: |context, variant| {
            Ok(Outcome::of(heap(context, variant)?[1]).seed(heap(context, "sorted/seed")?[1]))
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
            Ok(Outcome::of(mixture(context, variant)?[0] - 1.0)
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
            Ok(Outcome::of(mixture(context, variant)?[1] - 2.0)
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
