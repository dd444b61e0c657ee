// SPDX-License-Identifier: MIT OR Apache-2.0
//! When particles are born: birth `i` at `i / rate`, in whole numbers, so that a day later it is as exact as at the start
//! and no frame rate matters.

use std::ops::Range;

/// A time of a scene, in ticks of 2^-32 s: 136 years of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Moment {
    /// Since the start.
    pub ticks: u64,
}

const TICKS_PER_S: f64 = 4_294_967_296.0;
/// Rates are whole multiples of 2^-20 a second.
const RATE_UNIT: f64 = 1_048_576.0;
/// Ticks of a second times units of a rate of one: births in 1 / 2^52.
const BIRTH: u128 = 1 << 52;

impl Moment {
    /// The tick nearest to `s` (s); the start for what is less or no number.
    pub fn from_s(s: f64) -> Self {
        Self { ticks: (s * TICKS_PER_S).round() as u64 }
    }

    /// The end of frame `frame` at `per_s` frames a second: of all frames alike, as they are counted, not summed.
    ///
    /// # Panics
    /// If `per_s` is 0.
    pub fn of_frame(frame: u64, per_s: u32) -> Self {
        Self { ticks: ((u128::from(frame) << 32) / u128::from(per_s)) as u64 }
    }

    /// (s).
    pub fn as_s(self) -> f64 {
        self.ticks as f64 / TICKS_PER_S
    }
}

/// How often, and for how long.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emission {
    rate: u64,
    life: u64,
}

/// What lives at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Live {
    /// Serial number of the newest birth.
    pub newest: u64,
    /// How many, the newest and those before it.
    pub births: u64,
}

impl Emission {
    /// Lowest and highest rate (births per second).
    pub const RATES_PER_S: [f64; 2] = [1.0 / RATE_UNIT, 134_217_728.0];
    /// Longest life (s).
    pub const LONGEST_S: f64 = 86400.0;

    /// `None` if the rate (1/s) is not in [`Emission::RATES_PER_S`], or the life (s) not above 0 and up to
    /// [`Emission::LONGEST_S`].
    pub fn new(rate_per_s: f64, life_s: f64) -> Option<Self> {
        let [lowest, highest] = Self::RATES_PER_S;
        let life = Moment::from_s(life_s).ticks;
        let fits = (lowest..=highest).contains(&rate_per_s) && life_s <= Self::LONGEST_S && life > 0;
        fits.then(|| Self { rate: (rate_per_s * RATE_UNIT).round() as u64, life })
    }

    /// Births after the start: number 0 is at the start and not one of them.
    pub fn births_by(self, now: Moment) -> u64 {
        (self.at(now) / BIRTH) as u64
    }

    /// Serial numbers of the births after `before` and up to `now`, the one at the start among them if `before` is `None`.
    pub fn born(self, before: Option<Moment>, now: Moment) -> Range<u64> {
        before.map_or(0, |before| self.births_by(before) + 1)..self.births_by(now) + 1
    }

    /// Births from `now` less the life, which is over, to `now`, which has begun.
    pub fn live(self, now: Moment) -> Live {
        let newest = self.births_by(now);
        let gone = now.ticks.checked_sub(self.life).map(|ticks| self.births_by(Moment { ticks }));
        Live { newest, births: newest + 1 - gone.map_or(0, |gone| gone + 1) }
    }

    /// Serial numbers of the births that may end between the two moments, as [`Emission::born`] has them: some that have
    /// lived a little longer are among them, and some that are about to be born, so that who goes by rounded times misses none.
    pub fn ending(self, after: Option<Moment>, by: Moment) -> Range<u64> {
        let slack = (self.life >> 16) + 1;
        let before = after.and_then(|after| after.ticks.checked_sub(self.life + slack));
        self.born(before.map(|ticks| Moment { ticks }), Moment { ticks: by.ticks.saturating_add(slack) })
    }

    /// The most that live at one moment.
    pub fn most(self) -> u64 {
        (u128::from(self.life) * u128::from(self.rate)).div_ceil(BIRTH) as u64
    }

    /// From birth `serial` to `now` (s), rounded once; below 0 if it is still to come.
    pub fn age_s(self, now: Moment, serial: u64) -> f64 {
        let left = self.at(now) as i128 - (u128::from(serial) * BIRTH) as i128;
        left as f64 / (self.rate as f64 * TICKS_PER_S)
    }

    /// Between births (s).
    pub fn interval_s(self) -> f64 {
        RATE_UNIT / self.rate as f64
    }

    /// From birth to end (s).
    pub fn life_s(self) -> f64 {
        self.life as f64 / TICKS_PER_S
    }

    fn at(self, now: Moment) -> u128 {
        u128::from(now.ticks) * u128::from(self.rate)
    }
}
