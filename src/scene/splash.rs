// SPDX-License-Identifier: MIT OR Apache-2.0
//! `[[water.splash]]`: impacts that ripple a water.

use super::{
    parse::{Rule::Within, Table},
    particles::{EffectScene, Throws},
    schema::LENGTH,
    EmitterPlan, EmitterScene, Model, PlannedBuffer, PlannedThrows, Scene, SceneError, Spv, WaterScene,
};
use crate::{
    ballistic::{Builtin, Effect, GroundGrid, Landing},
    impact::{self, Impact},
    water::{splash::Hit, Disturbance},
};
use serde::Serialize;
use std::f64::consts::PI;

/// Most impacts of a step: each is told its place among the others by comparing it with all of them.
pub(super) const MOST_IMPACTS: f64 = 16_384.0;

/// What an emitter throws ripples the water where it lands.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SplashScene {
    /// Name of the emitter.
    pub from: String,
    /// Of a drop (m), 1e-4..=1e7: it brings 4/3 pi r³ of water.
    pub drop_radius_m: f32,
    /// Of the disc of the surface that a drop acts on (m), a column at the least.
    pub radius_m: f32,
    /// What acts, default both for `waves` and the volume for the others, which have no velocity to push.
    pub brings: Brings,
}

/// What of a drop acts on a water.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Brings {
    /// Its water, and the momentum of its fall.
    #[default]
    Both,
    /// Its water.
    Volume,
    /// The momentum of its fall.
    Momentum,
}

impl Brings {
    /// As scenes name them.
    pub const ALL: [(&'static str, Self); 3] =
        [("both", Self::Both), ("volume", Self::Volume), ("momentum", Self::Momentum)];

    /// Its momentum acts.
    pub fn has_momentum(self) -> bool {
        self != Self::Volume
    }
}

impl SplashScene {
    /// Water of a drop (m^3).
    pub fn drop_m3(&self) -> f64 {
        4.0 / 3.0 * PI * f64::from(self.drop_radius_m).powi(3)
    }

    /// What a drop is to a water of this depth (m).
    fn hit(&self, depth_m: f64) -> Hit {
        Hit {
            radius_m: self.radius_m.into(),
            volume_m3: self.drop_m3(),
            volume: self.brings != Brings::Momentum,
            momentum_in_m: self.brings.has_momentum().then_some(depth_m),
        }
    }
}

/// The keys of `[[water.splash]]`, of columns of this edge (m), and whether `brings` is among them.
pub(super) fn splash(mut table: Table<'_>, column_m: f64) -> (SplashScene, bool) {
    let from = table.text("from", "the name of an emitter", |name| !name.is_empty());
    if !table.has("from") {
        table.missing("from", format_args!("the name of an emitter with impacts"));
    }
    let brings = table.choice("brings", &Brings::ALL);
    let splash = SplashScene {
        from: from.unwrap_or_default().to_owned(),
        drop_radius_m: table.number("drop_radius_m", LENGTH),
        radius_m: table.number("radius_m", LENGTH),
        brings: brings.unwrap_or(Brings::Volume), // which every model has
    };
    if table.is_clean() && f64::from(splash.radius_m) < column_m {
        let message = format!("is {}; allowed: at least a column, {column_m} m", splash.radius_m);
        table.blame("radius_m", super::ProblemKind::OutOfRange, message);
    }
    table.finish();
    (splash, brings.is_some())
}

/// Once the model is known: momentum too where it has it, and `asked` says that nothing else was asked for.
pub(super) fn settle(water: &mut WaterScene, asked: &[bool]) {
    if water.model == Model::Waves {
        let free = water.splashes.iter_mut().zip(asked).filter(|(_, is_asked)| !**is_asked);
        free.for_each(|(splash, _)| splash.brings = Brings::Both);
    }
}

/// Where emitters that a splash names are not, or do not land.
pub(super) fn check_together(root: &mut Table<'_>, emitters: &[EmitterScene]) {
    if !root.is_clean() {
        return;
    }
    for mut water in root.tables("water") {
        for mut splash in water.tables("splash") {
            let Some(name) = splash.text("from", "", |_| true) else { continue };
            let Some(emitter) = emitters.iter().find(|it| it.name == name) else {
                let all: Vec<String> = emitters.iter().map(|it| format!("{:?}", it.name)).collect();
                let all =
                    if all.is_empty() { "none: the scene has no [[emitter]]".into() } else { all.join(", ") };
                splash.conflict("from", format!("is {name:?}, which is no emitter; allowed: {all}"));
                continue;
            };
            match &emitter.throws {
                Throws::Law(law) => splash.conflict(
                    "from",
                    format!("is {name:?}, of the law {:?}, whose particles do not land in water; allowed: emitters of an effect", law.file),
                ),
                Throws::Effect(effect) if effect.impacts.is_none() => splash.conflict(
                    "from",
                    format!("is {name:?}, which has no impacts; allowed: emitters that have `impacts`, the most of a step"),
                ),
                Throws::Effect(_) => {}
            }
        }
    }
}

/// An effect that ends on no ground has no impacts. Those of files are seen when they are read.
pub(super) fn check_effect(table: &mut Table<'_>, file: &str) {
    let lands = Builtin::named(file).is_none_or(|it| it.landing().is_some());
    if table.has("impacts") && !lands {
        let all: Vec<_> =
            Builtin::ALL.iter().filter(|it| it.landing().is_some()).map(|it| it.name()).collect();
        table.conflict(
            "impacts",
            format!(
                "is given, and effect {file:?} ends on no ground; allowed: {}, or a file with `ground = 1`",
                all.join(", ")
            ),
        );
    }
}

/// Impacts of an emitter, the most of a step.
pub(super) fn impacts(table: &mut Table<'_>) -> Option<u32> {
    table.maybe("impacts", Within(1.0, MOST_IMPACTS))
}

/// A splash as it will run.
#[derive(Clone, Debug, PartialEq)]
pub struct SplashPlan {
    /// What the emitter throws, and where from; its number is the source of its impacts.
    pub landing: Landing,
    /// The kernel that finds what lands.
    pub spv: Spv,
    /// Most impacts of a step.
    pub impacts: u32,
    /// What drops fall on.
    pub grid: GroundGrid,
    /// What a drop is to the water.
    pub hit: Hit,
}

impl SplashPlan {
    /// Disturbances of an impact.
    pub fn items(&self) -> u32 {
        if self.hit.momentum_in_m.is_some() {
            2
        } else {
            1
        }
    }

    /// Number of the emitter in the scene.
    pub fn emitter(&self) -> usize {
        self.landing.source as usize
    }

    pub(super) fn list_buffers(&self, water: &str, list: &mut Vec<PlannedBuffer>) {
        let mut add = |name: &str, bytes: usize, because: &str| {
            list.push(PlannedBuffer { name: name.into(), bytes: bytes as u64, because: because.into() });
        };
        let (impacts, because) = (self.impacts as usize, format!("water.{water}.splash"));
        let why = format!("{because}, emitter.{}.impacts", self.emitter());
        add("impact.impacts", impacts * size_of::<Impact>(), &why);
        add("impact.count", size_of::<impact::Count>(), &because);
        add("ballistic.effect", size_of::<crate::ballistic::Params>(), &because);
        let items = impacts * self.items() as usize;
        add("water.disturbances", 16 + items * size_of::<Disturbance>(), &why);
        add("water.disturbance_counts, .splash_counts", 12 + 16, &because);
    }
}

impl Scene {
    /// Of impacts that nobody reads, which are not made; and of waters below the one that all drops end on.
    pub(super) fn warn_of_impacts(&self, warnings: &mut Vec<String>) {
        let splashes = || self.water.iter().flat_map(|water| &water.splashes);
        for emitter in &self.emitters {
            let Throws::Effect(EffectScene { impacts: Some(_), .. }) = &emitter.throws else { continue };
            if splashes().all(|it| it.from != emitter.name) {
                let name = &emitter.name;
                warnings.push(format!(
                    "emitter `{name}` has impacts, and no [[water.splash]] is from it: none are made"
                ));
            }
        }
        let highest_m = self.water.iter().map(|it| it.level_m).fold(f32::NEG_INFINITY, f32::max);
        for water in self.water.iter().filter(|it| !it.splashes.is_empty() && it.level_m < highest_m) {
            warnings.push(format!(
                "water `{}`: drops end at {highest_m} m, the level of the highest water, and ripple this one at {} m",
                water.name, water.level_m
            ));
        }
    }

    /// The splashes of a water, once its emitters are planned.
    pub(super) fn plan_splashes(
        &self,
        water: &WaterScene,
        emitters: &[EmitterPlan],
        grid: GroundGrid,
    ) -> Result<Vec<SplashPlan>, SceneError> {
        let plan = |splash: &SplashScene| {
            let number =
                emitters.iter().position(|it| it.name == splash.from).expect("checked with the scene");
            let (scene, planned) = (&self.emitters[number], &emitters[number]);
            let (Throws::Effect(of), PlannedThrows::Effect(effect)) = (&scene.throws, &planned.throws) else {
                unreachable!("checked with the scene");
            };
            Ok(SplashPlan {
                spv: self.landing_of(&of.file, effect)?,
                landing: Landing { effect: effect.clone(), source: number as u32 },
                impacts: of.impacts.expect("checked with the scene"),
                grid,
                hit: splash.hit(water.depth_m),
            })
        };
        water.splashes.iter().map(plan).collect()
    }

    fn landing_of(&self, file: &str, effect: &Effect) -> Result<Spv, SceneError> {
        let shader = |reason: String| SceneError::Shader { file: file.to_owned(), reason };
        if !effect.has_ground {
            return Err(shader(
                "has impacts, and ends on no ground; allowed: effects with `ground = 1`".into(),
            ));
        }
        let most = effect.most_particles();
        if most > Landing::MOST {
            let allowed = Landing::MOST;
            return Err(shader(format!(
                "has impacts, and {most} particles live at once; allowed: {allowed}"
            )));
        }
        match Builtin::named(file).and_then(Builtin::landing) {
            Some(spv) => Ok(spv.into()),
            None => self.compile_landing(file),
        }
    }
}
