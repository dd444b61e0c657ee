// SPDX-License-Identifier: MIT OR Apache-2.0
//! Effects in closed form: fire, rain and whatever else flies on its own, bounces off nothing and asks nobody (after Luna,
//! "Introduction to 3D Game Programming with DirectX 11", 2012, chapter 20).
//!
//! Where such a particle is follows from how it began and how old it is, and how it began follows from its serial number:
//! so nothing need be stored. [`stateless`] computes particle `i` of an emitter from `i`, at any time, in any order;
//! [`stored`] keeps what each began with and its age in a list, as the book does, and is there to be compared and ported;
//! [`stream`] is that list written by transform feedback, where a device has it; [`kindled`] takes its births from impacts.
//!
//! An effect is one GLSL file: numbers in its first comment ([`Effect::parse`]), `birth` and `look` below it.
//!
//! | kernel                 | reads                    | writes          | CPU twin           |
//! | ---------------------- | ------------------------ | --------------- | ------------------ |
//! | `ballistic.EFFECT`     | ground, if any           | vertices        | [`cpu::flight`]    |
//! | `ballistic.age`        | list, counter            | list, counter   | [`cpu::age_of`]    |
//! | `ballistic.fire_emit`  |                          | list, counter   | [`cpu::birth`]     |
//! | `ballistic.count`      | counters                 | counters        |                    |
//! | `ballistic.stream`     | list                     | list            | [`cpu::age_of`]    |
//! | `ballistic.fall`       | falls                    | times           | [`cpu::fall_time`] |
//! | `ballistic.mark`       | impacts                  | marks, ring     | [`cpu_kindled::Kept::step`] |
//! | `ballistic.turn`       | ring, sums               | ring            | [`cpu_kindled::Kept::step`] |
//! | `ballistic.kindle`     | impacts, marks, ring     | ring            | [`cpu_kindled::Kept::step`] |
//! | `ballistic.living`     | ring                     | ring            | [`cpu_kindled::Kept::living`] |
//! | `ballistic.EFFECT_kindled` | ring, ground if any  | vertices        | [`cpu_kindled::Kept::flight`] |
//! | `ballistic.EFFECT_land` | effect, ground          | impacts, count  | [`land::landings`] |
//!
//! Left out: collisions among particles and with meshes, and forces that depend on the place: those need a state, and
//! steps.

pub mod cpu;
pub mod cpu_kindled;
pub mod draw;
mod effect;
mod emission;
mod ground;
pub mod kindled;
pub mod land;
pub mod stateless;
pub mod stored;
pub mod stream;

pub use draw::Drawing;
pub use effect::{BadEffect, Blend, Effect, Emitter, GroundGrid, Params};
pub use emission::{Emission, Live, Moment};
pub use ground::Ground;
pub use kindled::{Kindling, KindlingInfo};
pub use land::{Land, LandParams, Landing};
pub use stateless::{Counts, Materialise, Vertex, Vertices};
pub use stored::StoredEffect;
pub use stream::StreamedEffect;

use crate::{
    gpu::{Gpu, Result},
    shaders,
};
use std::ffi::CStr;

/// The effects that come with the crate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Builtin {
    /// A ball of flame.
    Fire,
    /// Rain round the camera, that ends on the ground.
    Rain,
    /// Smoke that grows as it rises.
    Smoke,
    /// Sparks that gravity and air slow down.
    Sparks,
    /// Snow that sways.
    Snow,
    /// Shells that rise and burst.
    Fireworks,
    /// What impacts knock off, and air stops.
    Dust,
}

impl Builtin {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Fire, Self::Rain, Self::Smoke, Self::Sparks, Self::Snow, Self::Fireworks, Self::Dust];

    /// As scenes name it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fire => "fire",
            Self::Rain => "rain",
            Self::Smoke => "smoke",
            Self::Sparks => "sparks",
            Self::Snow => "snow",
            Self::Fireworks => "fireworks",
            Self::Dust => "dust",
        }
    }

    /// The effect of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|effect| effect.name() == name)
    }

    /// Its file: numbers and snippet.
    pub fn file(self) -> (&'static str, &'static str) {
        let name = format!("ballistic/{}.glsl", self.name());
        *shaders::INCLUDES.iter().find(|(file, _)| *file == name).expect("every effect has a file")
    }

    /// Its numbers.
    ///
    /// # Panics
    /// If its file is damaged: a test reads them all.
    pub fn effect(self) -> Effect {
        let (file, text) = self.file();
        Effect::parse(file, text).unwrap_or_else(|error| panic!("{error}"))
    }

    /// SPIR-V of its landings, if it has a ground.
    pub fn landing(self) -> Option<&'static [u8]> {
        match self {
            Self::Rain => Some(shaders::BALLISTIC_RAIN_LAND_COMP),
            Self::Snow => Some(shaders::BALLISTIC_SNOW_LAND_COMP),
            Self::Fire | Self::Smoke | Self::Sparks | Self::Fireworks | Self::Dust => None,
        }
    }

    /// Its kernel.
    ///
    /// # Errors
    /// The device's.
    pub fn materialise(self, gpu: &Gpu) -> Result<Materialise> {
        self.materialise_by(gpu, Materialise::ITEMS)
    }

    /// Its kernel, of so many particles an invocation.
    ///
    /// # Errors
    /// The device's.
    pub fn materialise_by(self, gpu: &Gpu, items: u32) -> Result<Materialise> {
        let (name, spv): (&CStr, &[u8]) = match self {
            Self::Fire => (c"ballistic.fire", shaders::BALLISTIC_FIRE_COMP),
            Self::Rain => (c"ballistic.rain", shaders::BALLISTIC_RAIN_COMP),
            Self::Smoke => (c"ballistic.smoke", shaders::BALLISTIC_SMOKE_COMP),
            Self::Sparks => (c"ballistic.sparks", shaders::BALLISTIC_SPARKS_COMP),
            Self::Snow => (c"ballistic.snow", shaders::BALLISTIC_SNOW_COMP),
            Self::Fireworks => (c"ballistic.fireworks", shaders::BALLISTIC_FIREWORKS_COMP),
            Self::Dust => (c"ballistic.dust", shaders::BALLISTIC_DUST_COMP),
        };
        Materialise::tuned(gpu, name, spv, self.effect().has_ground, items)
    }
}
