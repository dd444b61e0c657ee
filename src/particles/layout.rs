// SPDX-License-Identifier: MIT OR Apache-2.0
//! How particles lie in memory: words, and particles of them. Mirrors `glsl/particles/layouts.glsl`.

use super::Particle;

/// How a particle lies in memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// Seven planes of words: 28 bytes. What readers outside know.
    #[default]
    Planes,
    /// Five planes, 20 bytes: velocity in halves, birth to 2^-6 s.
    Packed,
    /// Seven words side by side, 28 bytes, as the book has them.
    Records,
}

impl Layout {
    /// Words of a particle.
    pub fn words(self) -> u32 {
        match self {
            Self::Packed => 5,
            Self::Planes | Self::Records => 7,
        }
    }
}

/// Where nobody is: of a free slot. `NOWHERE_M` in `glsl/particles/particle.glsl`.
pub(super) const NOWHERE_M: f32 = 3.0e38;

/// A word that no pass reads or writes stands behind every plane and every list of a pool, and stays what it is.
pub(super) const CANARY: u32 = 0xdead_beef;

/// Particles as words of a layout, for `stride` slots.
pub fn pack(particles: &[Particle], layout: Layout, stride: u32) -> Vec<u32> {
    let stride = stride as usize;
    let mut words = vec![CANARY; layout.words() as usize * stride];
    for (i, it) in particles.iter().enumerate() {
        let ([x, y, z], [vx, vy, vz]) = (it.at_m.to_array(), it.velocity_mps.to_array());
        let [x, y, z] = [x, y, z].map(f32::to_bits);
        let (own, count) = if layout == Layout::Packed {
            let (one, other) = (u32::from(half(vx)) | u32::from(half(vy)) << 16, u32::from(half(vz)));
            ([x, y, z, one, other | (it.born >> 10) << 16, 0, 0], 5)
        } else {
            ([x, y, z, vx.to_bits(), vy.to_bits(), vz.to_bits(), it.born], 7)
        };
        for (w, word) in own[..count].iter().enumerate() {
            words[if layout == Layout::Records { 7 * i + w } else { w * stride + i }] = *word;
        }
    }
    words
}

/// The inverse of [`pack`], at tick `now`.
pub fn unpack(words: &[u32], layout: Layout, stride: u32, now: u32) -> Vec<Particle> {
    let stride = stride as usize;
    let of = |i: usize| {
        let word = |w: usize| words[if layout == Layout::Records { 7 * i + w } else { w * stride + i }];
        let float = |w: usize| f32::from_bits(word(w));
        let at_m = glam::vec3(float(0), float(1), float(2));
        if layout == Layout::Packed {
            let steps = (now >> 10).wrapping_sub(word(4) >> 16) & 0xffff;
            let velocity_mps = glam::vec3(unhalf(word(3)), unhalf(word(3) >> 16), unhalf(word(4)));
            return Particle { at_m, velocity_mps, born: (now >> 10).wrapping_sub(steps) << 10 };
        }
        Particle { at_m, velocity_mps: glam::vec3(float(3), float(4), float(5)), born: word(6) }
    };
    (0..stride).map(of).collect()
}

/// To the nearest half, ties to even; beyond the largest, infinity.
fn half(x: f32) -> u16 {
    let (sign, bits) = ((x.to_bits() >> 16) as u16 & 0x8000, x.to_bits() & 0x7fff_ffff);
    if bits >= 0x4780_0000 {
        return sign | if bits > 0x7f80_0000 { 0x7e00 } else { 0x7c00 };
    }
    if bits < 0x3880_0000 {
        // Below the smallest normal half: adding 0.5 lets the float unit round at the right bit.
        return sign | ((f32::from_bits(bits) + 0.5).to_bits() - 0.5f32.to_bits()) as u16;
    }
    let even = (bits >> 13) & 1;
    sign | ((bits + 0xfff + even - 0x3800_0000) >> 13) as u16
}

fn unhalf(word: u32) -> f32 {
    let (sign, magnitude) = ((word & 0x8000) << 16, word & 0x7fff);
    let value = match magnitude {
        0..0x400 => magnitude as f32 * (1.0 / 16_777_216.0),
        0x7c00.. => f32::from_bits(0x7f80_0000 | (magnitude & 0x3ff) << 13),
        _ => f32::from_bits((magnitude << 13) + 0x3800_0000),
    };
    f32::from_bits(value.to_bits() | sign)
}
