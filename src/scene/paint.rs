// SPDX-License-Identifier: MIT OR Apache-2.0
//! `[paint]`: what particles leave on the meshes that they hit, or come near.

use super::{
    meshes::MeshPlan,
    parse::{Rule::Within, Table},
    schema::LENGTH,
    EmitterPlan, Scene, SceneError,
};
use crate::paint::{Atlas, Coat, Method, MOST_DROPS};
use glam::UVec2;
use serde::Serialize;
use std::ops::Range;

/// How particles become paint.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PaintScene {
    /// What paints.
    pub from: PaintedBy,
    /// Of particles, every so many steps each takes part once, 1..=1024, default 1: all in every step.
    pub share: u32,
    /// Who finds the texels of a splotch: all of them paint the same.
    pub variant: Painter,
    /// Radius of a splotch (m).
    pub radius_m: f32,
}

/// What paints.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PaintedBy {
    /// Each impact, the mesh that it hit.
    #[default]
    Impacts,
    /// Each particle in each step, whatever is nearer than the radius: the seed's.
    Particles,
}

impl PaintedBy {
    /// With their names.
    pub const ALL: [(&str, Self); 2] = [("impacts", Self::Impacts), ("particles", Self::Particles)];
}

/// Who finds the texels of a splotch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Painter {
    /// Texels ask the impacts that are near their block.
    #[default]
    Sifted,
    /// Texels ask all impacts that are near their tile.
    Tiles,
    /// Each texel asks all impacts: the seed's.
    Brute,
}

impl Painter {
    /// With their names.
    pub const ALL: [(&str, Self); 3] =
        [("sifted", Self::Sifted), ("tiles", Self::Tiles), ("brute", Self::Brute)];

    /// As scenes and results have it.
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, it)| *it == self).map_or("", |(name, _)| name)
    }

    /// As the simulation has it.
    pub fn method(self) -> Method {
        match self {
            Self::Sifted => Method::Sifted,
            Self::Tiles => Method::Tiles,
            Self::Brute => Method::Brute,
        }
    }
}

pub(super) fn paint(mut table: Table<'_>) -> PaintScene {
    let from = table.choice("from", &PaintedBy::ALL).unwrap_or_default();
    let share = table.maybe("share", Within(1.0, 1024.0));
    if share.is_some() && from == PaintedBy::Impacts {
        table.conflict("share", "is for paint from particles; every impact paints");
    }
    let paint = PaintScene {
        from,
        share: share.unwrap_or(1),
        variant: table.choice("variant", &Painter::ALL).unwrap_or_default(),
        radius_m: table.number("radius_m", LENGTH),
    };
    table.finish();
    paint
}

/// Paint as it will run.
#[derive(Clone, Debug, PartialEq)]
pub struct PaintPlan {
    /// Who paints how.
    pub scene: PaintScene,
    /// Maps of the meshes that are painted: the first of [`Plan::solid`](super::Plan::solid).
    pub atlas: Atlas,
    /// What each emitter that collides leaves, in the order of the scene.
    pub coats: Vec<Coat>,
    /// Places of each emitter among the drops that particles make: none where it does not collide, or impacts paint.
    pub drops: Vec<Range<u32>>,
}

impl PaintPlan {
    /// Drops of a step, at the most.
    pub fn most_drops(&self, impacts: u32) -> u32 {
        match self.scene.from {
            PaintedBy::Impacts => impacts,
            PaintedBy::Particles => self.drops.last().map_or(0, |last| last.end),
        }
    }
}

/// Texels beside a chart that take its paint.
const GUTTER: u32 = 2;

impl Scene {
    /// The maps, and what texture coordinates make of them: two triangles in one texel are a warning.
    ///
    /// # Errors
    /// A mesh that cannot be painted, by name.
    pub(super) fn plan_paint(
        &self,
        solid: &[&MeshPlan],
        emitters: &[EmitterPlan],
        warnings: &mut Vec<String>,
    ) -> Result<Option<PaintPlan>, SceneError> {
        let Some(scene) = &self.paint else { return Ok(None) };
        let painted: Vec<_> = solid.iter().filter(|mesh| mesh.map > 0).collect();
        let sizes: Vec<_> = painted.iter().map(|it| (&it.mesh, UVec2::splat(it.map))).collect();
        let refused = |name: &str, reason: String| SceneError::Shader { file: name.into(), reason };
        let atlas = Atlas::new(&sizes, GUTTER)
            .map_err(|error| refused(&format!("mesh.{}", error.name), error.what))?;
        for (mesh, charts) in painted.iter().zip(&atlas.charts) {
            if let Some(example) = charts.example {
                warnings.push(format!(
                    "mesh `{}`: {:.1} % of its texels are in two triangles, such as {} and {}: where one is painted, so is the other",
                    mesh.name,
                    100.0 * charts.overlap(),
                    example.triangles[0],
                    example.triangles[1],
                ));
            }
        }
        let colliding =
            self.emitters.iter().zip(emitters).filter_map(|(it, plan)| Some((it, it.colliding()?, plan)));
        let (mut coats, mut orders) = (Vec::new(), Vec::new());
        for (it, colliding, plan) in colliding {
            let coat = Coat::new(colliding.paint.into(), colliding.opacity, scene.radius_m);
            coats
                .push(coat.map_err(|invalid| refused(&format!("emitter.{}", it.name), invalid.to_string()))?);
            // All slots of a step, births after the others, and up to eight impacts each.
            orders.push(plan.capacity.saturating_mul(16));
        }
        Coat::take_turns(&mut coats, &orders).map_err(|invalid| refused("emitter", invalid.to_string()))?;
        let mut drops = Vec::new();
        for (it, plan) in self.emitters.iter().zip(emitters) {
            let first = drops.last().map_or(0, |last: &Range<u32>| last.end);
            let is_taken = scene.from == PaintedBy::Particles && it.colliding().is_some();
            drops.push(first..first.saturating_add(if is_taken { plan.capacity } else { 0 }));
        }
        let plan = PaintPlan { scene: scene.clone(), atlas, coats, drops };
        let most = plan.most_drops(0);
        if most > MOST_DROPS {
            let reason = format!("{most} particles paint; allowed: {MOST_DROPS} in all");
            return Err(refused("paint", reason));
        }
        Ok(Some(plan))
    }
}
