// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a scene says of a water, with defaults filled in and every value within its range.

use super::{
    splash::SplashScene,
    works::{Body, Borders, Wall},
    Choice,
};
use serde::Serialize;

/// One body of water.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WaterScene {
    /// Name, unique in the scene: 1 to 64 letters, digits, `_` and `-`, not digits only; default `water`.
    pub name: String,
    /// The rung that moves it: as the scene asks, or the cheapest that does.
    pub model: Model,
    /// Order of the error, 2 or 4: 4 is for `waves`, default 2, or as `tolerance` needs it.
    pub order: u32,
    /// Relative error that is allowed at the end of the scene, 1e-6..=1; `None` asks for no accuracy.
    pub tolerance: Option<f64>,
    /// White water where it is fast, for the models that know flows, default for `wet` and `shallow`.
    pub foam: bool,
    /// Cells along x and z, each 1..=16384.
    pub cells: [u32; 2],
    /// Extent along x and z (m), more than 0; default the terrain's.
    pub size_m: [f32; 2],
    /// World height of the surface at rest (m), finite, default 0.
    pub level_m: f32,
    /// Depth at rest (m), more than 0: it sets the wave speed sqrt(g·depth). Over ground, where it is deepest.
    pub depth_m: f64,
    /// Deepest water there will be (m), which limits the step of `wet` and `shallow`, default the depth at rest and the
    /// highest of the start.
    pub deepest_m: f64,
    /// Fastest current there will be (m/s), which limits the step of `shallow`, default sqrt(g·deepest).
    pub fastest_mps: f64,
    /// No water crosses a face of a column where it would be shallower (m), 0..=1, default 1e-4; for `wet` and `shallow`.
    pub thin_m: f64,
    /// Gravity (m/s²), more than 0, default 9.81.
    pub gravity_mps2: f64,
    /// Rate at which velocities decay (1/s), 0..=100, default 0.03.
    pub damping_per_s: f64,
    /// Weight of the diagonal pipes, 0..=1, default 0.25 and 1 for `book`, or as `tolerance` needs it; 0 where a model has
    /// none.
    pub diagonal: f64,
    /// What happens to diagonal pipes at the walls, default folded; `book` has only dropped.
    pub walls: Walls,
    /// Time step (s), more than 0 and stable; `None` is the longest that divides a picture's time and is 5 % below the
    /// limit.
    pub dt_s: Option<f64>,
    /// Most steps per picture before simulated time is given up, 1..=10 000; `None` is 8, or twice what a picture takes.
    pub max_catch_up_steps: Option<u32>,
    /// The surface at time 0, default flat.
    pub start: Start,
    /// Scheduled disturbances.
    #[serde(rename = "drop")]
    pub drops: Vec<Drop>,
    /// Random disturbances, and what falls evenly.
    pub rain: Option<Rain>,
    /// Impacts that ripple it.
    #[serde(rename = "splash", skip_serializing_if = "Vec::is_empty")]
    pub splashes: Vec<SplashScene>,
    /// Springs and drains.
    #[serde(rename = "source")]
    pub sources: Vec<Source>,
    /// What the borders do with waves, default reflect; only `waves` has others.
    pub borders: Borders,
    /// Width of the strips in which absorbing borders damp waves (m), two columns to half the shorter side; `None` is 32
    /// columns, or a quarter of the shorter side where that is less.
    pub absorb_width_m: Option<f64>,
    /// Walls that stand in the water, for all but `book`.
    #[serde(rename = "wall")]
    pub barriers: Vec<Wall>,
    /// Bodies that move through it, at most 16, for `book`, `waves` and `pipes`.
    #[serde(rename = "body")]
    pub bodies: Vec<Body>,
    /// Why this model, and what the others would have missed.
    #[serde(skip)]
    pub choice: Choice,
}

/// The simulation that moves a water.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Model {
    /// Virtual pipes with stored flows, as the book has them.
    Book,
    /// The same waves with the flows eliminated.
    Waves,
    /// The same waves with the flows as an output.
    Pipes,
    /// Pipes over ground that floods and falls dry.
    Wet,
    /// The shallow-water equations over such ground: dam breaks and bores.
    Shallow,
}

impl Model {
    /// As scenes name it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Book => "book",
            Self::Waves => "waves",
            Self::Pipes => "pipes",
            Self::Wet => "wet",
            Self::Shallow => "shallow",
        }
    }

    /// Whether it knows the ground: how deep the water is, and where there is none.
    pub const fn has_ground(self) -> bool {
        matches!(self, Self::Wet | Self::Shallow)
    }
}

/// What happens to a diagonal pipe that would leave the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Walls {
    /// Its weight moves to the pipe along the wall, so that waves meet walls squarely.
    Folded,
    /// It is left out, as in the book.
    Dropped,
}

/// The surface at time 0, relative to the rest level.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(tag = "shape", rename_all = "lowercase")]
pub enum Start {
    /// At rest.
    #[default]
    Flat,
    /// A Gaussian.
    Hump {
        /// Amplitude (m), finite.
        height_m: f32,
        /// Centre, x and z (m), finite, default the origin.
        at_m: [f32; 2],
        /// Standard deviation (m), more than 0.
        radius_m: f32,
    },
    /// The book's `sin(r)/r`.
    Sombrero {
        /// Amplitude (m), finite.
        height_m: f32,
        /// Centre, x and z (m), finite, default the origin.
        at_m: [f32; 2],
        /// Radius of the first zero (m), more than 0.
        radius_m: f32,
    },
    /// A standing wave of the closed basin.
    Mode {
        /// Amplitude (m), finite.
        height_m: f32,
        /// Half waves along x and z, each 0..=cells.
        waves: [u32; 2],
    },
    /// A box in which the surface is higher or lower: a reservoir behind a dam that is gone, a lake up a valley.
    Block {
        /// Of the surface above the level at rest (m), finite; over ground the box holds water up to there.
        height_m: f32,
        /// One corner, x and z (m), within 1e7.
        from_m: [f32; 2],
        /// The corner across (m), within 1e7.
        to_m: [f32; 2],
    },
}

/// A disturbance that falls once or again and again.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Drop {
    /// Centre, x and z (m), finite.
    pub at_m: [f32; 2],
    /// Radius (m), more than 0.
    pub radius_m: f32,
    /// Water that it adds (m³), finite, default 0. This or `push_m3ps` is not zero.
    pub volume_m3: f32,
    /// Vertical momentum that it adds, as a rate of volume (m³/s), finite, default 0.
    pub push_m3ps: f32,
    /// First fall (s), 0 or more, default 0.
    pub start_s: f64,
    /// Time between falls (s), more than 0; `None` falls once.
    pub every_s: Option<f64>,
    /// Number of falls, 1 or more, only with `every_s`; `None` there is without end.
    pub count: Option<u32>,
}

/// Disturbances at uniformly random places and times, and what falls evenly on water and land.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Rain {
    /// On every column (mm/h), 0..=1 000 000, for `wet` and `shallow`, default 0. This or `drops_per_s` is given.
    pub mm_per_h: f64,
    /// Mean rate of drops over the whole water (1/s), 0..=1 000 000, default 0 beside `mm_per_h`.
    pub drops_per_s: f64,
    /// Radius of a drop (m), more than 0; 0 if there are no drops.
    pub radius_m: f32,
    /// Water that a drop adds (m³), finite, default 0. This or `push_m3ps` is not zero.
    pub volume_m3: f32,
    /// Vertical momentum that a drop adds, as a rate of volume (m³/s), finite, default 0.
    pub push_m3ps: f32,
}

impl Drop {
    /// When the drop falls for the `n`-th time (s), counted from 0; `None` after its last fall.
    pub fn time_s(&self, n: u32) -> Option<f64> {
        match self.every_s {
            Some(every) => {
                self.count.is_none_or(|count| n < count).then(|| self.start_s + f64::from(n) * every)
            }
            None => (n == 0).then_some(self.start_s),
        }
    }
}

/// A spring or a drain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Source {
    /// Centre, x and z (m), finite.
    pub at_m: [f32; 2],
    /// Radius (m), more than 0.
    pub radius_m: f32,
    /// Water that it gives (m³/s), finite and not 0; less than 0 takes.
    pub rate_m3ps: f64,
    /// It begins (s), 0 or more, default 0.
    pub start_s: f64,
    /// It ends (s), after it begins; `None` never does.
    pub end_s: Option<f64>,
}
