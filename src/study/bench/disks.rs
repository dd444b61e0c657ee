// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of disks: whole steps, about one disk a cell, in the tutorial's start.

use super::{Measured, Suite};
use crate::{
    disks::{cpu, starts, Borders, Model, Space},
    gpu::Gpu,
    study::{
        disks::{strays, Gas, Variant},
        must_be_within,
        runs::Effort,
        Result,
    },
};

/// Its rows.
pub const SUITE: Suite = Suite {
    sim: "disks",
    variants: &VARIANTS,
    sizes: &[100_000, 1_000_000, 1 << 24],
    largest_on_cpu: 1_000_000,
    label: |size| size.to_string(),
    run,
};

const VARIANTS: [&str; 11] = [
    "list/seed",
    "sorted/seed",
    "sorted/gauss-seidel",
    "sorted/matching1",
    "sorted/matching3",
    "sorted/matching8",
    "sorted/matching3/no-toi",
    "sorted/xpbd",
    "sorted/seed/3d",
    "sorted/matching3/3d",
    "sorted/matching8/3d",
];

/// What a disk needs at the least in a step (bytes): of the records of 48, all read and written by the pass that moves, and
/// read by the two that respond; of sorted ones, its state read and written once, a cell's start read and written.
fn bytes_per_disk(variant: &Variant) -> f64 {
    match (variant.is_list, variant.space) {
        (true, _) => 48.0 + 48.0 + 48.0 + 48.0 + 16.0,
        (false, Space::Flat) => 48.0 + 8.0,
        (false, Space::Solid) => 64.0 + 8.0,
    }
}

/// Steps before the clock starts: the first ones sort what is at random, and part what overlaps.
const WARM: u32 = 60;

fn run(gpu: &Gpu, name: &str, size: u32, effort: Effort) -> Result<Measured> {
    let variant = Variant::named(name);
    // Seen to be its twin first, on a number that nothing divides: all but one disk of a hundred within 1 % of a radius.
    let mut small = variant.start(1237);
    small.model.dt_s = 1.0 / 60.0;
    let mut gas = Gas::new(gpu, &variant, &small.model, &small.disks, 1)?;
    gas.steps(3)?;
    let mut twin = cpu::Disks::new(small.model, &small.disks);
    (0..3).for_each(|_| twin.step());
    must_be_within(name, strays(&small.model, &gas.disks()?, &twin.disks(), 0.01), 0.01)?;
    drop(gas);

    let start = variant.start(size);
    let model = Model { dt_s: 1.0 / 60.0, ..start.model };
    let mut gas = Gas::new(gpu, &variant, &model, &start.disks, 1)?;
    gas.steps(WARM)?;
    let timing = gas.time(effort)?;
    Ok(Measured { timing, items: f64::from(size), unit: "disk", bytes_per_item: bytes_per_disk(&variant) })
}

impl Variant {
    /// The tutorial's start, of this many: random places overlap, so that the first steps part them.
    fn start(&self, count: u32) -> starts::Start {
        let mut start = starts::seed(self.space, count, Borders::Walls, 1);
        start.model.response = self.response;
        start
    }
}
