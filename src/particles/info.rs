// SPDX-License-Identifier: MIT OR Apache-2.0
//! A pool to be made, and what is allowed of it.

use super::{options::DEFERRED_WORDS, Compaction, Emitter, Error, Invalid, Layout, Options, TICKS_PER_S};
use crate::gpu::Gpu;

/// A pool to be made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoolInfo<'a> {
    /// Most particles.
    pub capacity: u32,
    /// Life of every particle (s), to the tick.
    pub life_s: f64,
    /// Of the births.
    pub seed: u32,
    /// Tick at which it begins.
    pub start: u32,
    /// What throws particles into it.
    pub emitters: &'a [Emitter],
    /// Numbers of the law.
    pub law: &'a [u8],
}

impl PoolInfo<'_> {
    /// Life of every particle.
    pub fn life_ticks(&self) -> u32 {
        (self.life_s * f64::from(TICKS_PER_S)).round() as u32
    }
}

/// The life in ticks, if all is in range. A law that `defers` particles lists them, 40 bytes each.
pub(super) fn check(info: &PoolInfo<'_>, options: Options, defers: bool, gpu: &Gpu) -> Result<u32, Error> {
    let invalid = |key, value: String, allowed: String| Error::Invalid(Invalid { key, value, allowed });
    let words = options.layout.words();
    let range = u64::from(gpu.limits().max_storage_buffer_range).min(4 * u64::from(u32::MAX));
    let per_particle = if defers { DEFERRED_WORDS } else { words.max(2) };
    // Indices of words and vertices stay below 2^32, in whole lines of 32; the list of the deferred has a head of 4 words.
    let most = ((range - 16) / u64::from(4 * per_particle)).min(u64::from(u32::MAX / 7)) / 32 * 32 - 1;
    if !(1..=most).contains(&u64::from(info.capacity)) {
        let allowed =
            format!("1 to {most}, what {} sees of a buffer at {} bytes each", gpu.name(), 4 * per_particle);
        return Err(invalid("capacity", info.capacity.to_string(), allowed));
    }
    let tile = options.tuning.tile();
    if options.compaction == Compaction::Ring && !info.capacity.is_multiple_of(tile) {
        let allowed = format!("a multiple of {tile} in a ring");
        return Err(invalid("capacity", info.capacity.to_string(), allowed));
    }
    // An age is told from a time to come by half a round of the clock; a packed birth has less.
    let most = match options.layout {
        Layout::Packed => 512.0,
        Layout::Planes | Layout::Records => f64::from(1u32 << 31) / f64::from(TICKS_PER_S),
    };
    if !(1.0 / f64::from(TICKS_PER_S)..=most).contains(&info.life_s) {
        let allowed = format!("2^-16 s to {most} s");
        return Err(invalid("life_s", info.life_s.to_string(), allowed));
    }
    if info.emitters.len() > Emitter::MOST {
        let allowed = format!("at most {}", Emitter::MOST);
        return Err(invalid("emitters", info.emitters.len().to_string(), allowed));
    }
    info.emitters.iter().try_for_each(Emitter::check)?;
    let all: f64 = info.emitters.iter().map(|it| it.rate_per_s).sum();
    if all > Emitter::MOST_PER_S {
        let allowed = format!("at most {:e} of all emitters", Emitter::MOST_PER_S);
        return Err(invalid("rate_per_s", all.to_string(), allowed));
    }
    if info.law.is_empty() || !info.law.len().is_multiple_of(4) {
        return Err(invalid(
            "law",
            format!("{} bytes", info.law.len()),
            "words of 4 bytes, one at least".into(),
        ));
    }
    Ok(info.life_ticks())
}
