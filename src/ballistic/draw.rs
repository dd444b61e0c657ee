// SPDX-License-Identifier: MIT OR Apache-2.0
//! Effects in a picture: nothing is stored for that either, the vertex shader computes each particle.

use super::{Builtin, Effect, Params};
use crate::{
    draw::{
        sprites::{Path, Sprites, SpritesInfo},
        Stage,
    },
    gpu::{Buffer, Gpu, Recorder, Resource, Result},
    shaders,
};
use std::ffi::CStr;

/// The drawing of one emitter.
pub struct Drawing {
    sprites: Sprites,
}

impl Drawing {
    /// Of an effect that comes with the crate. `ground_m`: the samples of the heightmap, for one that ends on it.
    ///
    /// # Errors
    /// If the device cannot draw.
    ///
    /// # Panics
    /// If `ground_m` is missing for an effect that ends on the ground.
    pub fn new(gpu: &Gpu, stage: &Stage, builtin: Builtin, ground_m: Option<&Buffer>) -> Result<Self> {
        let (name, vertex): (&CStr, &[u8]) = match builtin {
            Builtin::Fire => (c"ballistic.fire", shaders::BALLISTIC_FIRE_VERT),
            Builtin::Rain => (c"ballistic.rain", shaders::BALLISTIC_RAIN_VERT),
            Builtin::Smoke => (c"ballistic.smoke", shaders::BALLISTIC_SMOKE_VERT),
            Builtin::Sparks => (c"ballistic.sparks", shaders::BALLISTIC_SPARKS_VERT),
            Builtin::Snow => (c"ballistic.snow", shaders::BALLISTIC_SNOW_VERT),
            Builtin::Fireworks => (c"ballistic.fireworks", shaders::BALLISTIC_FIREWORKS_VERT),
            Builtin::Dust => (c"ballistic.dust", shaders::BALLISTIC_DUST_VERT),
        };
        Self::of(gpu, stage, name, vertex, &builtin.effect(), ground_m)
    }

    /// Of any effect, from the SPIR-V of its vertex shader.
    ///
    /// # Errors
    /// If the device cannot draw, or the SPIR-V is no such shader.
    ///
    /// # Panics
    /// As [`Drawing::new`].
    pub fn of(
        gpu: &Gpu,
        stage: &Stage,
        name: &CStr,
        vertex: &[u8],
        effect: &Effect,
        ground_m: Option<&Buffer>,
    ) -> Result<Self> {
        let ground: Vec<(&str, Resource<'_>)> = match effect.has_ground {
            true => vec![("Ground", ground_m.expect("an effect with a ground has a heightmap").into())],
            false => Vec::new(),
        };
        let info = SpritesInfo {
            name,
            path: Path::Quads { vertex },
            resources: &ground,
            texture: None,
            soft: false,
            constants: &[],
        };
        Ok(Self { sprites: Sprites::new::<Params>(gpu, stage, &info)? })
    }

    /// Draws the effect as `params` has it, in the sprites of [`Stage::record_layers`].
    pub fn record(&self, rec: &mut Recorder<'_>, params: &Params) {
        self.sprites.record(rec, (params.births * params.burst).min(params.capacity), params);
    }
}
