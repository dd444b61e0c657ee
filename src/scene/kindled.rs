// SPDX-License-Identifier: MIT OR Apache-2.0
//! `[[emitter]]` with `from = "impacts"`: an effect that impacts throw.

use super::{
    emit::PlannedThrows,
    parse::{
        Rule::{AtLeastZero, Within},
        Table,
    },
    particles::EmitterScene,
    EmitterPlan, MeshPlan, MeshScene, PlannedBuffer, Scene, SceneError, VolumePlan,
};
use crate::ballistic::{Effect, KindlingInfo};
use serde::Serialize;

/// Which impacts throw, and how much is kept of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KindledScene {
    /// Emitters whose particles throw as they hit; empty: all that collide.
    pub by: Vec<String>,
    /// Meshes off which they throw; empty: whatever is hit.
    pub on: Vec<String>,
    /// A lesser impulse a mass throws nothing (m/s), default 0.
    pub least_impulse_mps: f32,
    /// Impacts that are kept, default 16384.
    pub most: u32,
}

/// An effect that impacts throw, as it will run.
#[derive(Clone, Debug, PartialEq)]
pub struct KindledPlan {
    /// Its numbers; those of its births are not used.
    pub effect: Effect,
    /// Which impacts throw.
    pub info: KindlingInfo,
}

const FROM: &str = "from";

/// What impacts say, and the scene cannot.
const SAID: [&str; 6] = ["rate_per_s", "at_m", "velocity_mps", "circle_m", "circle_turns_per_s", "light"];
/// What only births from impacts have.
const OWN: [&str; 4] = ["by", "on", "least_impulse_mps", "most"];

/// `None` for an effect whose births go by the clock.
pub(super) fn kindled(table: &mut Table<'_>) -> Option<KindledScene> {
    let is_kindled = table.choice(FROM, &[("impacts", true)]).unwrap_or(false);
    let is_name = |name: &str| !name.is_empty();
    let kindled = is_kindled.then(|| KindledScene {
        by: table.texts("by", "names of emitters with law = \"colliding\"", is_name).unwrap_or_default(),
        on: table.texts("on", "names of solid meshes", is_name).unwrap_or_default(),
        least_impulse_mps: table.maybe("least_impulse_mps", AtLeastZero).unwrap_or(0.0),
        most: table.maybe("most", Within(1.0, f64::from(KindlingInfo::MOST))).unwrap_or(1 << 14),
    });
    let (keys, why) = match is_kindled {
        true => {
            (&SAID[..], "is given beside from = \"impacts\"; impacts say when and where particles are born")
        }
        false => (&OWN[..], "needs from = \"impacts\"; without it births go by the clock"),
    };
    for key in keys {
        if table.has(key) {
            table.conflict(key, why);
        }
    }
    if is_kindled && table.has("impacts") {
        table.conflict(
            "impacts",
            "is given beside from = \"impacts\"; where what they throw lands, nobody is told",
        );
    }
    kindled
}

/// What impacts need of the rest of the scene: notes what is missing.
pub(super) fn check_together(
    root: &mut Table<'_>,
    has_volume: bool,
    emitters: &[EmitterScene],
    meshes: &[MeshScene],
) {
    let colliding: Vec<&str> =
        emitters.iter().filter(|it| it.colliding().is_some()).map(|it| it.name.as_str()).collect();
    let solid: Vec<&str> = meshes.iter().filter(|it| it.solid).map(|it| it.name.as_str()).collect();
    for (table, emitter) in root.tables("emitter").iter().zip(emitters) {
        let Some(kindled) = emitter.kindled() else { continue };
        if !has_volume {
            table.conflict(FROM, "is \"impacts\", and the scene has no [volume] for anything to hit");
        } else if colliding.is_empty() {
            table.conflict(FROM, "is \"impacts\", and no [[emitter]] with law = \"colliding\" makes any");
        }
        for (key, names, allowed) in [("by", &kindled.by, &colliding), ("on", &kindled.on, &solid)] {
            let unknown = names.iter().find(|name| !allowed.contains(&name.as_str()));
            if let (Some(name), true) = (unknown, has_volume) {
                let what = if key == "by" { "emitter that collides" } else { "mesh that is solid" };
                let known = if allowed.is_empty() { "none".to_owned() } else { allowed.join(", ") };
                table.conflict(key, format!("has {name:?}, which is no {what}; there are: {known}"));
            }
        }
    }
}

impl Scene {
    /// Who is heard: impacts number those that collide in their order, and meshes as `solid` has them.
    pub(super) fn plan_kindled(
        &self,
        solid: &[&MeshPlan],
        plans: &mut [EmitterPlan],
    ) -> Result<(), SceneError> {
        let colliding = self.emitters.iter().zip(&*plans).filter(|(it, _)| it.colliding().is_some());
        // All slots of a step, births after the others, and up to eight impacts each.
        let orders: Vec<(&str, u32)> =
            colliding.map(|(it, plan)| (it.name.as_str(), plan.capacity.saturating_mul(16))).collect();
        for (emitter, plan) in self.emitters.iter().zip(plans) {
            let (Some(scene), PlannedThrows::Kindled(kindled)) = (emitter.kindled(), &mut plan.throws) else {
                continue;
            };
            let is_heard = |name: &str| scene.by.is_empty() || scene.by.iter().any(|by| by == name);
            let heard = orders.iter().map(|&(name, orders)| if is_heard(name) { orders } else { 0 });
            kindled.info.sources = heard.collect();
            if !scene.on.is_empty() {
                kindled.info.meshes = solid.iter().map(|mesh| scene.on.contains(&mesh.name)).collect();
            }
            let file = format!("emitter.{}", emitter.name);
            kindled.info.check().map_err(|reason| SceneError::Shader { file, reason })?;
        }
        Ok(())
    }
}

impl KindledPlan {
    /// Of an effect with the numbers of the scene; who is heard is not known yet.
    pub(super) fn new(scene: &KindledScene, effect: Effect) -> Self {
        let info = KindlingInfo {
            most: scene.most,
            burst: effect.burst,
            life_s: effect.life_s,
            least_impulse_mps: scene.least_impulse_mps,
            sources: Vec::new(),
            meshes: Vec::new(),
        };
        Self { effect, info }
    }

    /// Of a full ring; of a product that is too large [`Scene::plan_kindled`] complains.
    pub(super) fn most_particles(&self) -> u32 {
        self.info.most.saturating_mul(self.info.burst)
    }

    pub(super) fn reason(&self, scene: &KindledScene) -> String {
        let of =
            |names: &[String], all: &str| if names.is_empty() { all.to_owned() } else { names.join(", ") };
        format!(
            "`{}` in closed form, {} from each impact of {} on {} with an impulse of {} m/s or more; the last {} of them are kept, in \
             their order: what lives beyond that is overwritten and counted",
            self.effect.name,
            self.info.burst,
            of(&scene.by, "whatever collides"),
            of(&scene.on, "whatever it hits"),
            scene.least_impulse_mps,
            scene.most,
        )
    }

    pub(super) fn list_buffers(&self, name: &str, list: &mut Vec<PlannedBuffer>) {
        for (buffer, bytes) in self.info.buffers() {
            let because = match buffer {
                "ballistic.strikes" => format!("emitter.{name}.most"),
                _ => format!("emitter.{name}.from"),
            };
            list.push(PlannedBuffer { name: buffer.into(), bytes, because });
        }
    }

    pub(super) fn list_steps(&self, name: &str, often: f64, list: &mut Vec<(String, f64)>) {
        list.push((format!("ballistic.mark, prims.scan, ballistic.turn, .kindle ({name})"), often));
        list.push((format!("ballistic.living ({name})"), 1.0));
    }
}

/// Steps of a picture in which there can be impacts.
pub(super) fn often(volume: Option<&VolumePlan>, fps: f64) -> f64 {
    volume.map_or(0.0, |volume| 1.0 / (fps * volume.dt_s))
}
