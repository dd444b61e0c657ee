// SPDX-License-Identifier: MIT OR Apache-2.0
//! One emitter on the GPU: an effect in closed form or a pool, and the shaders that draw it.

use super::{kindled::Kindled, stats::EmitterStats, swarm::Swarm, RunError};
use crate::{
    ballistic::{Effect, GroundGrid, Moment, Params},
    draw::{
        sprites::{Path, SplatSprites, Splats, Sprites, SpritesInfo, Texture},
        Stage,
    },
    gpu::{Gpu, Resource},
    particles::balls::BallsDraw,
    scene::{Draw, EmitterPlan},
};
use std::ffi::CStr;

/// The seed of a scene, as effects have it.
pub(super) fn seed_of(scene: u64) -> u32 {
    (scene ^ scene >> 32) as u32
}

/// The shaders of one emitter's sprites, bound.
pub(super) enum Drawn {
    Triangles(Sprites),
    Splat(SplatSprites),
    Balls(BallsDraw),
}

impl Drawn {
    /// `P`: push constants of the effect.
    pub fn new<P>(
        gpu: &Gpu,
        stage: &Stage,
        splats: Option<&Splats>,
        plan: &EmitterPlan,
        name: &'static CStr,
        resources: &[(&str, Resource<'_>)],
    ) -> Result<Self, RunError> {
        let texture = plan.texture.as_ref().map(|(size, rgba)| Texture::new(gpu, *size, rgba)).transpose()?;
        let path = match plan.draw {
            Draw::Quads => Path::Quads { vertex: &plan.sprites },
            Draw::Geometry => Path::Geometry { geometry: &plan.sprites },
            Draw::Balls => unreachable!("a pool draws its balls itself"),
            Draw::Splat => {
                let splats = splats.expect("sums for those who splat");
                let sprites = SplatSprites::new::<P>(gpu, stage, splats, (name, &plan.sprites), resources)?;
                return Ok(Self::Splat(sprites));
            }
        };
        let info =
            SpritesInfo { name, path, resources, texture: texture.as_ref(), soft: plan.soft, constants: &[] };
        Ok(Self::Triangles(Sprites::new::<P>(gpu, stage, &info)?))
    }
}

/// An effect in closed form.
pub(super) struct Flow {
    pub name: String,
    pub effect: Effect,
    pub ground: GroundGrid,
    pub seed: u32,
    pub stream: u32,
    pub capacity: u32,
    pub drawn: Drawn,
    pub params: Params,
}

impl Flow {
    pub fn at(&mut self, time_s: f64) {
        let now = Moment::from_s(time_s);
        self.params = self.effect.params(now, self.seed, self.stream, &self.ground, self.capacity);
    }

    pub fn count(&self) -> u32 {
        (self.params.births * self.params.burst).min(self.capacity)
    }

    pub fn counts(&self) -> EmitterStats {
        let burst = u64::from(self.params.burst);
        let births = u64::from(self.params.newest) + (u64::from(self.params.newest_high) << 32) + 1;
        let (born, alive) = (births * burst, u64::from(self.params.births) * burst);
        EmitterStats {
            name: self.name.clone(),
            born,
            alive,
            dropped: alive - u64::from(self.count()),
            aged: born - alive,
            ..EmitterStats::default()
        }
    }
}

/// What one emitter is on the GPU.
pub(super) enum Source {
    Flow(Box<Flow>),
    Kindled(Box<Kindled>),
    Swarm(Box<Swarm>),
}

impl Source {
    pub fn go_on_from(&mut self, old: &Self) -> Result<(), RunError> {
        match (self, old) {
            (Self::Swarm(new), Self::Swarm(old)) => new.go_on_from(old),
            (Self::Kindled(new), Self::Kindled(old)) => new.go_on_from(old),
            _ => Ok(()), // what is not stored has nothing to go on with
        }
    }

    pub fn is_triangles(&self) -> bool {
        match self {
            Self::Flow(flow) => matches!(flow.drawn, Drawn::Triangles(_)),
            Self::Kindled(kindled) => kindled.is_triangles(),
            Self::Swarm(swarm) => swarm.is_triangles(),
        }
    }

    /// Whether it has a state.
    pub fn is_stored(&self) -> bool {
        !matches!(self, Self::Flow(_))
    }

    /// All words of its state, floats in name only.
    pub fn state(&self) -> Result<Option<Vec<f32>>, RunError> {
        match self {
            Self::Flow(_) => Ok(None),
            Self::Kindled(kindled) => kindled.state().map(Some),
            Self::Swarm(swarm) => swarm.state().map(Some),
        }
    }

    /// Goes on from a state after `pictures` of `frame_s`. `false` if it is of another.
    pub fn restore(&mut self, state: &[f32], pictures: u32, frame_s: f64) -> Result<bool, RunError> {
        match self {
            Self::Flow(_) => Ok(false),
            Self::Kindled(kindled) => kindled.restore(state),
            Self::Swarm(swarm) => swarm.restore(state, pictures, frame_s),
        }
    }

    /// Of its state.
    pub fn hash(&self) -> Result<Option<u64>, RunError> {
        match self {
            Self::Flow(_) => Ok(None),
            Self::Kindled(kindled) => kindled.hash().map(Some),
            Self::Swarm(swarm) => swarm.hash().map(Some),
        }
    }
}
