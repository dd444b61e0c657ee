// SPDX-License-Identifier: MIT OR Apache-2.0
//! Scan, compaction and counting sort against their twins.
#![allow(missing_docs)]

mod common;

use common::{gpu, TestGpu};
use whitecap::{
    gpu::{Buffer, Residence},
    prims::{cpu, Bins, Compact, Scan, ScanBound, Sums},
    random,
};

const SIZES: [u32; 10] = [0, 1, 255, 256, 257, 4095, 4097, (1 << 20) - 1, 1 << 20, (1 << 20) + 1];

/// Both ways to add up, where the device has both.
fn ways(gpu: &TestGpu) -> Vec<Sums> {
    let mut ways = vec![Sums::Shared];
    match gpu.adapter().has("subgroup arithmetic") {
        true => ways.push(Sums::Subgroups),
        false => println!("SKIP: {} has no arithmetic in subgroups", gpu.name()),
    }
    ways
}

fn room(gpu: &TestGpu, size: u32) -> Buffer {
    Buffer::new(gpu, "test.room", 4 * u64::from(size.max(1)), Residence::Device).unwrap()
}

/// Random words; all set, so that sums wrap; none; one in the last place.
fn kinds(size: u32) -> Vec<Vec<u32>> {
    let mut last = vec![0; size as usize];
    if let Some(it) = last.last_mut() {
        *it = 7;
    }
    vec![
        (0..size).map(|i| random::bits(5, 0, i, 0)[1]).collect(),
        vec![u32::MAX; size as usize],
        vec![0; size as usize],
        last,
    ]
}

fn upload(gpu: &TestGpu, values: &[u32]) -> Buffer {
    let padded = if values.is_empty() { &[0][..] } else { values };
    gpu.upload("test.values", padded).unwrap()
}

#[test]
fn a_scan_is_its_twin() {
    let gpu = gpu();
    for sums in ways(&gpu) {
        let scan = Scan::new(&gpu, sums).unwrap();
        for size in SIZES {
            for values in kinds(size) {
                let (from, to) = (upload(&gpu, &values), room(&gpu, size));
                let bound = scan.bind(&from, &to).unwrap();
                gpu.once(|rec| bound.record(rec, size)).unwrap();
                let (want, total) = cpu::exclusive_scan(&values);
                let got = gpu.download::<u32>(&to).unwrap();
                assert!(got[..size as usize] == want, "{sums:?}, {size}");
                assert_eq!(gpu.download::<u32>(bound.sums()).unwrap()[ScanBound::total_at(size)], total);
            }
        }
        // In place, and of a part: what lies behind is left alone.
        let values = &kinds(10_000)[0];
        let both = upload(&gpu, values);
        let bound = scan.bind(&both, &both).unwrap();
        gpu.once(|rec| bound.record(rec, 5000)).unwrap();
        let got = gpu.download::<u32>(&both).unwrap();
        assert!(got[..5000] == cpu::exclusive_scan(&values[..5000]).0 && got[5000..] == values[5000..]);
    }
}

/// Counts that are scanned and cleared, on both sides of the size from which the sums have a dispatch of their own.
#[test]
fn a_clearing_scan_leaves_zeros() {
    let gpu = gpu();
    for sums in ways(&gpu) {
        let scan = Scan::clearing(&gpu, sums).unwrap();
        for size in [1, 4097, 1024 * 4096, 1024 * 4096 + 1] {
            let values = &kinds(size)[0];
            let (from, to) = (upload(&gpu, values), room(&gpu, size));
            let bound = scan.bind(&from, &to).unwrap();
            gpu.once(|rec| bound.record(rec, size)).unwrap();
            let (want, total) = cpu::exclusive_scan(values);
            assert!(gpu.download::<u32>(&to).unwrap() == want, "{sums:?}, {size}");
            assert_eq!(gpu.download::<u32>(bound.sums()).unwrap()[ScanBound::total_at(size)], total);
            assert!(gpu.download::<u32>(&from).unwrap().iter().all(|&it| it == 0), "{sums:?}, {size}");
        }
    }
}

/// 2^26 elements, where the device sees so many: 256 MiB a buffer.
#[test]
fn a_scan_and_a_sort_of_2_to_the_26_are_their_twins() {
    const SIZE: u32 = 1 << 26;
    let gpu = gpu();
    let range = u64::from(gpu.limits().max_storage_buffer_range);
    if range < 4 * u64::from(SIZE) {
        println!(
            "SKIP: {} sees {range} bytes of a buffer, 2^26 elements are {}",
            gpu.name(),
            4 * u64::from(SIZE)
        );
        return;
    }
    let values: Vec<u32> = (0..SIZE).map(|i| random::bits(5, 0, i, 0)[1]).collect();
    let (from, to) = (upload(&gpu, &values), room(&gpu, SIZE));
    let scan = Scan::new(&gpu, Sums::for_device(&gpu)).unwrap().bind(&from, &to).unwrap();
    gpu.once(|rec| scan.record(rec, SIZE)).unwrap();
    assert!(gpu.download::<u32>(&to).unwrap() == cpu::exclusive_scan(&values).0);
    let keys: Vec<u32> = values.iter().map(|value| value % SIZE).collect();
    let from = upload(&gpu, &keys);
    let sort = Bins::new(&gpu, Sums::for_device(&gpu)).unwrap().bind(&from, SIZE).unwrap();
    gpu.once(|rec| sort.record(rec, SIZE, true)).unwrap();
    let (firsts, order) = cpu::sort_by_key(&keys, SIZE);
    assert!(gpu.download::<u32>(sort.firsts()).unwrap() == firsts);
    assert!(gpu.download::<u32>(sort.order()).unwrap() == order);
}

#[test]
fn a_compaction_is_its_twin() {
    let gpu = gpu();
    for sums in ways(&gpu) {
        let compact = Compact::new(&gpu, sums).unwrap();
        for size in SIZES {
            let values = &kinds(size)[0];
            let random: Vec<u32> = values.iter().map(|value| value & 6).collect();
            for flags in kinds(size).into_iter().skip(1).chain([random]) {
                let (from, marks, to) = (upload(&gpu, values), upload(&gpu, &flags), room(&gpu, size));
                let bound = compact.bind(&marks, &from, &to).unwrap();
                gpu.once(|rec| bound.record(rec, size)).unwrap();
                let want = cpu::compact(&flags, values);
                let kept = gpu.download::<u32>(bound.sums()).unwrap()[ScanBound::total_at(size)];
                assert_eq!(kept as usize, want.len(), "{sums:?}, {size}");
                assert!(gpu.download::<u32>(&to).unwrap()[..want.len()] == want, "{sums:?}, {size}");
            }
        }
    }
}

#[test]
fn a_sort_is_its_twin() {
    let gpu = gpu();
    let sort = Bins::new(&gpu, Sums::for_device(&gpu)).unwrap();
    for size in SIZES {
        let random = &kinds(size)[0];
        let spread: Vec<u32> = random.iter().map(|key| key % size.max(1)).collect();
        let few: Vec<u32> = random.iter().map(|key| key % 3).collect();
        let falling: Vec<u32> = (0..size).rev().collect();
        for (keys, bins) in [(&spread, size.max(1)), (&falling, size.max(1)), (&few, 5), (&spread, 1)] {
            // Bins of a million are put in order by one invocation each: a minute.
            if size > 5000 && bins < 6 {
                continue;
            }
            let from = upload(&gpu, keys);
            let bound = sort.bind(&from, bins).unwrap();
            gpu.once(|rec| bound.record(rec, size, true)).unwrap();
            let (firsts, order) = cpu::sort_by_key(keys, bins);
            assert!(gpu.download::<u32>(bound.firsts()).unwrap() == firsts, "{size} in {bins}");
            assert!(
                gpu.download::<u32>(bound.order()).unwrap()[..size as usize] == order,
                "{size} in {bins}"
            );
        }
    }
}
