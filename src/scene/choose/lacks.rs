// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a scene asks for and a variant does not have.

use super::{
    super::{Model, Walls, WaterScene},
    expected::waves_of,
    Refusal, Variant, Wishes,
};

/// A key that does not go with a variant: what that has instead, or not, and what the key goes with.
pub(super) struct Lack {
    pub key: &'static str,
    pub why: &'static str,
    allowed: String,
}

impl Lack {
    pub fn refusal(&self, variant: &Variant) -> Refusal {
        let Self { key, why, allowed } = self;
        (key, format!("does not go with {}, which has {why}; allowed: {allowed}", variant.asked()))
    }
}

/// Keys that do not go with a variant, whoever asks for it.
pub(super) fn lacks(variant: &Variant, water: &WaterScene, wishes: &Wishes) -> Vec<Lack> {
    use Model::{Book, Pipes, Shallow, Waves, Wet};
    let mut list = Vec::new();
    let mut needs = |is_there: bool, key: &'static str, models: &[Model], why: &'static str| {
        if is_there && !models.contains(&variant.model) {
            let allowed: Vec<_> = models.iter().map(|model| format!("{:?}", model.name())).collect();
            list.push(Lack { key, why, allowed: allowed.join(", ") });
        }
    };
    let pushes = water.drops.iter().any(|drop| drop.push_m3ps != 0.0);
    let rain = water.rain.as_ref();
    needs(pushes, "drop", &[Waves], "no velocity of the surface to push");
    needs(
        rain.is_some_and(|rain| rain.push_m3ps != 0.0),
        "rain",
        &[Waves],
        "no velocity of the surface to push",
    );
    needs(
        rain.is_some_and(|rain| rain.mm_per_h != 0.0),
        "rain",
        &[Wet, Shallow],
        "no land for mm_per_h to fall on",
    );
    needs(
        water.splashes.iter().any(|it| it.brings.has_momentum()),
        "splash",
        &[Waves],
        "no velocity of the surface for momentum to push",
    );
    needs(water.borders.any_absorbs(), "borders", &[Waves], "no velocity of the surface to damp");
    needs(!water.barriers.is_empty(), "wall", &[Waves, Pipes, Wet, Shallow], "the whole grid as its basin");
    needs(
        !water.bodies.is_empty(),
        "body",
        &[Book, Waves, Pipes],
        "no level that stays, for bodies to float at",
    );
    needs(wishes.foam == Some(true), "foam", &[Pipes, Wet, Shallow], "no flows to show");
    needs(wishes.diagonal.is_some(), "diagonal", &[Book, Waves, Pipes], "no diagonal pipes");
    needs(wishes.walls == Some(Walls::Folded), "walls", &[Waves, Pipes], "no diagonal pipes to fold");
    needs(wishes.walls == Some(Walls::Dropped), "walls", &[Book, Waves, Pipes], "no diagonal pipes to drop");
    needs(wishes.order == Some(4), "order", &[Waves], "order 2");
    if variant.order == 4 {
        let mut fixed = |is_other: bool, key: &'static str, why: &'static str, allowed: &str| {
            if is_other {
                list.push(Lack { key, why, allowed: allowed.into() });
            }
        };
        fixed(wishes.diagonal.is_some_and(|w| w != 0.25), "diagonal", "one stencil", "0.25");
        fixed(wishes.walls == Some(Walls::Dropped), "walls", "walls that are mirrors", "\"folded\"");
        fixed(wishes.order == Some(2), "order", "order 4", "4");
    } else if variant.model == Waves && wishes.order == Some(4) {
        list.push(Lack { key: "order", why: "order 2", allowed: "2".into() });
    }
    list
}

/// What a scene has that a variant would get wrong, where the choice is ours.
pub(super) fn features(variant: &Variant, water: &WaterScene, wishes: &Wishes) -> Vec<Lack> {
    let mut list = Vec::new();
    let mut wrong = |is_there: bool, key: &'static str, why: &'static str| {
        if is_there {
            list.push(Lack { key, why, allowed: String::new() });
        }
    };
    let has_ground = variant.model.has_ground();
    wrong(wishes.has_terrain && !has_ground, "terrain", "the bottom is not even, and shores move");
    wrong(!water.sources.is_empty() && !has_ground, "source", "levels rise, and a drain may fall dry");
    let is_rough = variant.model != Model::Shallow && breaks(water);
    wrong(
        water.tolerance.is_none() && is_rough,
        "start",
        "it breaks into a bore, which only advection carries",
    );
    list
}

fn breaks(water: &WaterScene) -> bool {
    waves_of(water).iter().any(|wave| wave.is_dam(water.depth_m))
}
