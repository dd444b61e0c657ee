// SPDX-License-Identifier: MIT OR Apache-2.0
//! Random numbers without a state: twin of `glsl/common/random.glsl`, to the bit.

use glam::{vec2, vec3, Vec2, Vec3};

/// Four words, of (seed, stream, serial, purpose): pcg4d (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT
/// 9(3), 2020).
pub fn bits(seed: u32, stream: u32, serial: u32, purpose: u32) -> [u32; 4] {
    let mut v =
        [seed, stream, serial, purpose].map(|x| x.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    let stir = |v: &mut [u32; 4]| {
        for (to, a, b) in [(0, 1, 3), (1, 2, 0), (2, 0, 1), (3, 1, 2)] {
            v[to] = v[to].wrapping_add(v[a].wrapping_mul(v[b]));
        }
    };
    stir(&mut v);
    v.iter_mut().for_each(|x| *x ^= *x >> 16);
    stir(&mut v);
    v
}

/// 0 to 1, without 1: 24 bits, exact.
pub fn units(bits: [u32; 4]) -> [f32; 4] {
    bits.map(|x| (x >> 8) as f32 * (1.0 / 16_777_216.0))
}

/// Cosine and sine of a part of a turn, 0 to 1.
pub fn cos_sin_of_turn(turns: f32) -> Vec2 {
    let half_turn = turns - 0.5;
    let quarter = 0.25 - half_turn.abs();
    let x = quarter.abs().min(0.25 - quarter.abs());
    let xx = x * x;
    let s = x * (6.283_185 + xx * (-41.341_63 + xx * (81.588_13 - xx * 75.240_07)));
    let c = 1.0 + xx * (-19.739_168 + xx * (64.923_225 - xx * 83.665_92));
    let (x, y) = if quarter.abs() > 0.125 { (c, s) } else { (s, c) };
    vec2(x.copysign(-quarter), y.copysign(-half_turn))
}

/// A unit vector, all directions alike, of two units.
pub fn direction_of([u, v]: [f32; 2]) -> Vec3 {
    let y = 2.0 * u - 1.0;
    let radius = (1.0 - y * y).max(0.0).sqrt();
    let way = cos_sin_of_turn(v);
    vec3(radius * way.x, y, radius * way.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_round() {
        for i in 0..=4096 {
            let turns = i as f32 / 4096.0;
            let (sin, cos) = (f64::from(turns) * std::f64::consts::TAU).sin_cos();
            let got = cos_sin_of_turn(turns);
            let apart = (f64::from(got.x) - cos).abs().max((f64::from(got.y) - sin).abs());
            assert!(apart < 1.2e-7, "{turns}: {apart:e}");
        }
    }

    #[test]
    fn directions_and_bits_are_even() {
        let n = 1 << 16;
        let (mut sum, mut squares, mut bins) = (glam::DVec3::ZERO, glam::DVec3::ZERO, [0u32; 64]);
        for serial in 0..n {
            let [u, v, w, _] = units(bits(7, 3, serial, 0));
            let d = direction_of([u, v]).as_dvec3();
            assert!((d.length() - 1.0).abs() < 3e-7);
            sum += d;
            squares += d * d;
            bins[(w * 64.0) as usize] += 1;
        }
        // Mean and variance within four standard errors of 0 and 1/3, chi-square of 63 degrees below its 99.9 % point.
        let n = f64::from(n);
        assert!((sum / n).abs().max_element() < 4.0 / (3.0 * n).sqrt());
        assert!((squares / n - 1.0 / 3.0).abs().max_element() < 4.0 * (4.0 / 45.0 / n).sqrt());
        let even = n / 64.0;
        let chi: f64 = bins.iter().map(|&count| (f64::from(count) - even).powi(2) / even).sum();
        assert!(chi < 103.4, "{chi}");
    }
}
