// SPDX-License-Identifier: MIT OR Apache-2.0
//! Throughput of scan, compaction and counting sort.

use super::{Measured, Suite};
use crate::{
    gpu::{Access, Buffer, Gpu, Residence},
    prims::{cpu, Bins, Compact, Scan, ScanBound, Sums},
    random,
    study::{
        runs::{self, Effort, Timing},
        Error, Result,
    },
};

/// Its rows.
pub const SUITE: Suite = Suite {
    sim: "prims",
    variants: &[
        "scan",
        "scan/shared",
        "scan/clearing",
        "compact",
        "compact/shared",
        "sort",
        "sort/kept",
        "sort/kept/unordered",
    ],
    sizes: &[1 << 20, 1 << 24, 1 << 26],
    largest_on_cpu: 1 << 20,
    label: |size| size.to_string(),
    run: |gpu, variant, size, effort| {
        let timing = time(gpu, variant, size, effort)?;
        // Read once and written once; of a compaction's values half are kept.
        let bytes_per_item = match variant {
            "compact" | "compact/shared" => 10.0,
            "scan/clearing" => 12.0, // and written again
            _ => 8.0,
        };
        Ok(Measured { timing, items: f64::from(size), unit: "element", bytes_per_item })
    },
};

fn wrong(variant: &str) -> Error {
    Error::Wrong { variant: variant.into(), apart: 1.0, allowed: 0.0 }
}

/// Time of one, once it has computed at this size what its twin does.
fn time(gpu: &Gpu, variant: &str, size: u32, effort: Effort) -> Result<Timing> {
    let sums = if variant.ends_with("/shared") { Sums::Shared } else { Sums::for_device(gpu) };
    let both = Access::ComputeReadWrite;
    let values: Vec<u32> = (0..size).map(|i| random::bits(1, 2, i, 3)[0]).collect();
    let room = |name| Buffer::new(gpu, name, 4 * u64::from(size), Residence::Device);
    if variant.starts_with("scan") {
        let from = gpu.upload("bench.values", &values)?;
        let to = room("bench.scanned")?;
        let clears = variant.ends_with("/clearing"); // then it times zeros, which take as long
        let scan =
            if clears { Scan::clearing(gpu, sums)? } else { Scan::new(gpu, sums)? }.bind(&from, &to)?;
        gpu.once(|rec| scan.record(rec, size))?;
        let (want, total) = cpu::exclusive_scan(&values);
        if gpu.download::<u32>(scan.sums())?[ScanBound::total_at(size)] != total
            || gpu.download::<u32>(&to)? != want
            || clears && gpu.download::<u32>(&from)?.iter().any(|&left| left != 0)
        {
            return Err(wrong(variant));
        }
        return runs::time(gpu, effort, |rec| {
            scan.record(rec, size);
            rec.barrier(both, both);
        });
    }
    if variant.starts_with("compact") {
        let flags: Vec<u32> = values.iter().map(|value| value >> 7 & 1).collect();
        let (from, marks) = (gpu.upload("bench.values", &values)?, gpu.upload("bench.flags", &flags)?);
        let to = room("bench.kept")?;
        let compact = Compact::new(gpu, sums)?.bind(&marks, &from, &to)?;
        gpu.once(|rec| compact.record(rec, size))?;
        let want = cpu::compact(&flags, &values);
        if gpu.download::<u32>(&to)?[..want.len()] != want[..] {
            return Err(wrong(variant));
        }
        return runs::time(gpu, effort, |rec| {
            compact.record(rec, size);
            rec.barrier(both, both);
        });
    }
    // One element a bin, about, as collisions have it: anywhere, or near where they were in a state that is kept sorted.
    let is_kept = variant.starts_with("sort/kept");
    let near = |i: u32, value: u32| (i + value % 256).saturating_sub(128).min(size - 1);
    let key = |(i, value): (u32, &u32)| if is_kept { near(i, *value) } else { value % size };
    let keys: Vec<u32> = (0..size).zip(&values).map(key).collect();
    let from = gpu.upload("bench.keys", &keys)?;
    let sort = Bins::new(gpu, sums)?.bind(&from, size)?;
    gpu.once(|rec| sort.record(rec, size, true))?;
    let (firsts, order) = cpu::sort_by_key(&keys, size);
    if gpu.download::<u32>(sort.firsts())? != firsts || gpu.download::<u32>(sort.order())? != order {
        return Err(wrong(variant));
    }
    let is_stable = !variant.ends_with("/unordered");
    runs::time(gpu, effort, |rec| {
        sort.record(rec, size, is_stable);
        rec.barrier(both, both);
    })
}
