// SPDX-License-Identifier: MIT OR Apache-2.0
//! Twin of `glsl/ballistic/{mark,turn,kindle,living}.comp` and `kindled.glsl`, to the bit.

use super::{
    cpu::{birth_of, fly, Flight, Struck, Who, Wide},
    effect::Params,
    emission::Moment,
    kindled::{KindlingInfo, Strike},
    Builtin, Ground,
};
use crate::impact::Impact;
use std::collections::VecDeque;

/// A ring, its births oldest first.
#[derive(Clone, Debug, PartialEq)]
pub struct Kept {
    info: KindlingInfo,
    /// Those that have a slot.
    pub strikes: VecDeque<Strike>,
    /// Births since the start.
    pub births: u64,
    /// Those that lived when others took their slots.
    pub overwritten: u64,
    /// Impacts beyond what their source said.
    pub lost: u64,
}

impl Kept {
    /// Without a birth.
    pub fn new(info: &KindlingInfo) -> Self {
        Self { info: info.clone(), strikes: VecDeque::new(), births: 0, overwritten: 0, lost: 0 }
    }

    /// Takes the impacts of a step that ends at `now`, in whatever order.
    pub fn step(&mut self, impacts: &[Impact], now: Moment) {
        let keys = self.info.keys();
        let mut struck = Vec::new();
        for it in impacts {
            let [first, orders] = keys.get(it.source as usize).copied().unwrap_or_default();
            let mesh = self.info.meshes.get(it.mesh as usize).copied();
            let is_hard = it.impulse_mps >= self.info.least_impulse_mps;
            if !is_hard || orders == 0 || !mesh.unwrap_or(self.info.meshes.is_empty()) {
                continue;
            }
            match it.order < orders {
                true => struck.push((first + it.order, it)),
                false => self.lost += 1,
            }
        }
        struck.sort_by_key(|(key, _)| *key);
        let most = self.info.most as usize;
        self.overwritten += (self.living(now) + struck.len()).saturating_sub(most) as u64;
        self.births += struck.len() as u64;
        self.strikes.extend(struck.iter().map(|(_, it)| Strike {
            at_m: it.at_m,
            born_low: now.ticks as u32,
            normal: it.normal,
            born_high: (now.ticks >> 32) as u32,
            velocity_mps: it.velocity_mps,
            impulse_mps: it.impulse_mps,
        }));
        self.strikes.drain(..self.strikes.len().saturating_sub(most));
    }

    /// Births that live at `now`, the newest; those to come count as well.
    pub fn living(&self, now: Moment) -> usize {
        let life = Moment::from_s(self.info.life_s).ticks;
        let is_over = |it: &&Strike| now.ticks.checked_sub(it.born().ticks).is_some_and(|age| age >= life);
        self.strikes.iter().rev().take_while(|it| !is_over(it)).count()
    }

    /// Particle `i` at `now`, 0 the oldest that lives, if it is to be seen.
    pub fn flight(
        &self,
        effect: Builtin,
        p: &Params,
        ground: Option<&Ground<'_>>,
        now: Moment,
        i: u32,
    ) -> Option<Flight> {
        let (strike, who) = self.who(p, now, i);
        let age = age_between(strike.born(), now)?;
        let struck = Struck {
            at_m: strike.at_m,
            normal: strike.normal,
            velocity_mps: strike.velocity_mps,
            impulse_mps: strike.impulse_mps,
        };
        fly(effect, p, ground, who, (age, birth_of(effect, p, who, &struck)))
    }

    /// The impact that threw particle `i`, and which of its burst it is.
    pub fn who(&self, p: &Params, now: Moment, i: u32) -> (&Strike, Who) {
        let back = self.living(now) - (i / p.burst) as usize;
        let who = Who { serial: self.births - back as u64, member: i % p.burst };
        (&self.strikes[self.strikes.len() - back], who)
    }
}

/// `None` of a birth that is still to come.
pub fn age_between(born: Moment, now: Moment) -> Option<Wide> {
    let ticks = now.ticks.checked_sub(born.ticks)?;
    let (whole, upper) = ((ticks >> 32) as f32, (ticks as u32 >> 16) as f32 * (1.0 / 65536.0));
    let lower = (ticks & 0xffff) as f32 * (1.0 / 4_294_967_296.0);
    let high = whole + upper;
    let low = (upper - (high - whole)) + lower;
    let sum = high + low;
    Some(Wide { high: sum, low: low - (sum - high) })
}
