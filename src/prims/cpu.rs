// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twins of the prims, in plain loops.

/// The sum of all values before each, and of all; sums wrap.
pub fn exclusive_scan(values: &[u32]) -> (Vec<u32>, u32) {
    let mut sum = 0u32;
    let scanned = values.iter().map(|value| {
        let before = sum;
        sum = sum.wrapping_add(*value);
        before
    });
    (scanned.collect(), sum)
}

/// The values whose flag is not 0, in their order.
pub fn compact(flags: &[u32], values: &[u32]) -> Vec<u32> {
    flags.iter().zip(values).filter(|(flag, _)| **flag != 0).map(|(_, value)| *value).collect()
}

/// Where each bin begins, and the indices of the elements by key; equal keys keep their order. A key beyond the last bin
/// counts as the last.
pub fn sort_by_key(keys: &[u32], bins: u32) -> (Vec<u32>, Vec<u32>) {
    let bin = |key: u32| key.min(bins - 1) as usize;
    let mut counts = vec![0u32; bins as usize];
    keys.iter().for_each(|key| counts[bin(*key)] += 1);
    let (firsts, _) = exclusive_scan(&counts);
    let (mut next, mut order) = (firsts.clone(), vec![0; keys.len()]);
    for (key, i) in keys.iter().zip(0..) {
        let to = &mut next[bin(*key)];
        order[*to as usize] = i;
        *to += 1;
    }
    (firsts, order)
}
