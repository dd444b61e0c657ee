// SPDX-License-Identifier: MIT OR Apache-2.0
//! `law = "colliding"` of an `[[emitter]]`: particles that meet the scene's meshes, and the paint that they leave.

use super::{
    parse::{Rule::Within, Table},
    particles::MOST_PARTICLES,
    schema::{LENGTH, PLACE},
    EmitterScene, LawScene, Scene, VolumePlan,
};
use crate::particles::colliding::{Colliding, Method};
use serde::Serialize;

fn by_name<S: serde::Serializer>(method: &Method, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(method.name())
}

/// Numbers of the law `colliding`, and the paint that its particles leave.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CollidingScene {
    /// Of a particle (m).
    pub radius_m: f32,
    /// Share of the normal velocity that comes back, 0..=1, default 0.5.
    pub restitution: f32,
    /// Coulomb's, 0..=10, default 0.2.
    pub friction: f32,
    /// (m/s²), default the earth's.
    pub gravity_mps2: [f32; 3],
    /// How it meets surfaces, default `dda2`.
    #[serde(serialize_with = "by_name")]
    pub variant: Method,
    /// How many there are from the start, none born or ended later; 0 goes by rate and life.
    pub population: u32,
    /// Radius of the ball that they start and come back in (m), default 0.
    pub spread_m: f32,
    /// Who falls below it comes back (m); `None`: it ends with its life.
    pub respawn_below_m: Option<f32>,
    /// Linear colour of its paint, default `color`.
    pub paint: [f32; 3],
    /// How much a splotch covers, 0..=1, default 1.
    pub opacity: f32,
}

pub(super) fn colliding(table: &mut Table<'_>, law: &LawScene) -> CollidingScene {
    let share = Within(0.0, 1.0);
    let population = table.maybe("population", Within(1.0, MOST_PARTICLES as f64)).unwrap_or(0);
    let respawn_below_m = table.maybe("respawn_below_m", PLACE);
    if population > 0 && law.capacity.is_some() {
        table.conflict("capacity", "is given beside population, which is just as many");
    }
    if population > 0 && law.corners {
        table.conflict("thrown", "is for those who are born at a rate, not for a population");
    }
    let spread_m = table.maybe("spread_m", Within(0.0, 1e6));
    if spread_m.is_some() && population == 0 && respawn_below_m.is_none() {
        table.conflict(
            "spread_m",
            "is for a population, or for those who come back; those who are born are born in a point",
        );
    }
    CollidingScene {
        radius_m: table.number("radius_m", LENGTH),
        restitution: table.maybe("restitution", share).unwrap_or(0.5),
        friction: table.maybe("friction", Within(0.0, 10.0)).unwrap_or(0.2),
        gravity_mps2: table.maybe("gravity_mps2", Within(-1e6, 1e6)).unwrap_or([0.0, -9.81, 0.0]),
        variant: table.choice("variant", &Method::ALL.map(|it| (it.name(), it))).unwrap_or_default(),
        population,
        spread_m: spread_m.unwrap_or(0.0),
        respawn_below_m,
        paint: table.maybe("paint", share).unwrap_or(law.color.map(|x| x.min(1.0))),
        opacity: table.maybe("opacity", share).unwrap_or(1.0),
    }
}

impl Scene {
    /// The numbers of the law; impacts say which of the emitters that collide it is.
    pub(super) fn colliding(
        &self,
        emitter: &EmitterScene,
        scene: &CollidingScene,
        volume: &VolumePlan,
    ) -> Colliding {
        let colliding = self.emitters.iter().filter(|it| it.colliding().is_some());
        let source = colliding.take_while(|it| it.name != emitter.name).count() as u32;
        let seed = (self.seed ^ self.seed >> 32) as u32;
        Colliding {
            gravity_mps2: scene.gravity_mps2.into(),
            restitution: scene.restitution,
            friction: scene.friction,
            surface_mps: volume.surface_mps,
            // Cells are filled with the scene as it is at the end of the step.
            lead_s: volume.dt_s as f32,
            source,
            respawns: u32::from(scene.respawn_below_m.is_some()),
            floor_m: scene.respawn_below_m.unwrap_or(0.0),
            emitter_m: emitter.at_m.unwrap_or_default().into(),
            emitter_radius_m: scene.spread_m,
            seed: seed.wrapping_add(source.wrapping_mul(0x9e37_79b9)),
            ..Colliding::new(volume.scene.grid(), scene.radius_m)
        }
    }
}

/// How particles meet surfaces, and what the rule of the study would take: a look-up at one place is for steps of less than
/// a cell and where leaks do not matter; where walls meet in a cell one plane is too few.
pub(super) fn meets(scene: &CollidingScene, volume: &VolumePlan) -> String {
    let cells = volume.cells_a_step;
    let why = match scene.variant {
        Method::TwoPlanes => "no wall is passed, whatever the step",
        Method::OnePlane => "where two walls meet in a cell it leaks",
        _ if cells > 1.0 => "it leaks: in a step of more than a cell a wall is passed unseen",
        _ => "it leaks where two walls meet in a cell",
    };
    let rule = match cells > 1.0 {
        true => "more than one: the rule takes `dda2`, or `dda1` where there are no corners",
        false => "less than one: the rule takes `approach` where leaks do not matter, else `dda2`",
    };
    let name = scene.variant.name();
    format!("`colliding` by `{name}`: {why}; {cells:.2} cells a step at the most, {rule}")
}
