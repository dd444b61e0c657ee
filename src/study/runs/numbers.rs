// SPDX-License-Identifier: MIT OR Apache-2.0
//! Comparisons that no NaN gets through, and random numbers.

use crate::water::LAND_M;

/// Largest difference, of the largest height wanted. Land has to be land in both; what is no number is infinitely far.
pub fn apart(got: &[f32], want: &[f64]) -> f64 {
    let is_land = |h: f64| h == f64::from(LAND_M);
    let water = || got.iter().map(|&a| f64::from(a)).zip(want.iter().copied()).filter(|&(_, b)| !is_land(b));
    let moved = got.iter().zip(want).any(|(&a, &b)| is_land(f64::from(a)) != is_land(b));
    if got.len() != want.len() || moved || water().any(|(a, _)| !a.is_finite()) {
        return f64::INFINITY;
    }
    let apart = water().map(|(a, b)| (a - b).abs()).fold(0.0, larger);
    match water().map(|(_, b)| b.abs()).fold(0.0, larger) {
        0.0 => f64::INFINITY, // a comparison of nothing
        highest => apart / highest,
    }
}

/// The larger of two; what is no number is larger than all, where `f64::max` would lose it.
pub fn larger(a: f64, b: f64) -> f64 {
    if b <= a || a.is_nan() {
        a
    } else {
        b
    }
}

/// The one farther from zero; what is no number is farther than all.
pub fn farther(a: f64, b: f64) -> f64 {
    if b.abs() <= a.abs() || a.is_nan() {
        a
    } else {
        b
    }
}

/// Root of the mean square.
pub fn rms<T: Copy + Into<f64>>(numbers: &[T]) -> f64 {
    (numbers.iter().map(|&h| h.into().powi(2)).sum::<f64>() / numbers.len() as f64).sqrt()
}

/// Uniform numbers between 0 and 1 (Steele and others, "Fast Splittable Pseudorandom Number Generators", 2014).
pub struct Uniform(pub u64);

impl Iterator for Uniform {
    type Item = f64;
    fn next(&mut self) -> Option<f64> {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        Some(((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64)
    }
}
