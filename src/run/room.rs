// SPDX-License-Identifier: MIT OR Apache-2.0
//! The meshes of a scene on the GPU, posed on the clock of the scene.

use super::{effects::Emitters, RunError};
use crate::{
    clock::FixedStep,
    draw::{
        mesh::{MeshBuffers, MeshDraw, MeshParams},
        shadow::{Shadow, ShadowView},
        Stage,
    },
    gpu::{Access, Gpu, Recorder},
    mesh::{Pose, Posed},
    scene::{MeshPlan, Plan},
};
use glam::Vec3;

struct Body {
    plan: MeshPlan,
    posed: Posed,
    draw: MeshDraw,
}

/// All meshes of a scene, and how they are seen.
pub(super) struct Room {
    bodies: Vec<Body>,
    clock: FixedStep,
    /// Steps that are recorded; `None`: not even the start is.
    taken: Option<u64>,
    /// A ball round what casts shadows (m).
    ball_m: (Vec3, f32),
}

impl Room {
    /// # Errors
    /// If the device has no room, or cannot draw.
    pub fn new(gpu: &Gpu, stage: &Stage, shadow: &Shadow, plan: &Plan, frame_s: f64) -> Result<Self, RunError> {
        let pose = Pose::new(gpu)?;
        let body = |plan: &MeshPlan| {
            let posed = pose.mesh(&plan.mesh)?;
            let buffers = MeshBuffers {
                triangles: posed.triangles(),
                places: posed.places(),
                rest: posed.rest(),
                matrices: posed.matrices(),
                paint: None,
                count: plan.mesh.triangles.len() as u32,
            };
            let params = MeshParams {
                color: plan.color.extend(plan.mirrors),
                tile_m: plan.tile_m,
                ..MeshParams::default()
            };
            let draw = MeshDraw::new(gpu, stage, shadow, &buffers, params)?;
            Ok(Body { plan: plan.clone(), posed, draw })
        };
        let bodies = plan.meshes.iter().map(body).collect::<Result<_, RunError>>()?;
        let dt_s = plan.volume.as_ref().map_or(frame_s, |volume| volume.dt_s);
        let (low, high) = plan.lit_m();
        Ok(Self {
            bodies,
            clock: FixedStep::new(dt_s, u32::MAX),
            taken: None,
            ball_m: (0.5 * (low + high), 0.5 * low.distance(high)),
        })
    }

    /// What the map of shadows shows, of a sun in this direction.
    pub fn shadow_view(&self, to_sun: Vec3, side: u32) -> ShadowView {
        ShadowView::new(self.ball_m.0, self.ball_m.1, to_sun, side)
    }

    /// Lets `frame_s` pass.
    pub fn advance(&mut self, frame_s: f64) {
        self.clock.advance(frame_s);
    }

    /// Goes on after `pictures` of `frame_s`.
    pub fn restore(&mut self, pictures: u32, frame_s: f64) {
        self.clock = FixedStep::new(self.clock.dt_s(), u32::MAX);
        for _ in 0..pictures {
            self.clock.advance(frame_s);
        }
        self.taken = None;
    }

    /// Records the steps that are due, and leaves the meshes as they are drawn.
    ///
    /// # Errors
    /// If the device has no room for matrices on their way.
    pub fn record(&mut self, rec: &mut Recorder<'_>, emitters: &mut Emitters) -> Result<(), RunError> {
        let dt_s = self.clock.dt_s();
        rec.barrier(Access::GraphicsRead, Access::ComputeWrite);
        rec.barrier(Access::GraphicsRead, Access::CopyWrite);
        if self.taken.is_none() {
            let first = self.clock.steps();
            self.pose(rec, first as f64 * dt_s, dt_s, |_| true)?;
            self.taken = Some(first);
        }
        for index in self.taken.unwrap_or(0)..self.clock.steps() {
            self.pose(rec, (index + 1) as f64 * dt_s, dt_s, MeshPlan::moves)?;
            emitters.record_colliding(rec);
        }
        self.taken = Some(self.clock.steps());
        rec.barrier(Pose::EXIT, MeshDraw::ENTRY);
        rec.barrier(Access::CopyWrite, MeshDraw::ENTRY);
        Ok(())
    }

    fn pose(
        &self,
        rec: &mut Recorder<'_>,
        time_s: f64,
        dt_s: f64,
        which: impl Fn(&MeshPlan) -> bool,
    ) -> Result<(), RunError> {
        rec.barrier(Pose::EXIT, Pose::ENTRY);
        for body in self.bodies.iter().filter(|body| which(&body.plan)) {
            let [now, before] = body.plan.motion.step(time_s, dt_s);
            body.posed.record(rec, time_s, dt_s, now, before)?;
        }
        Ok(())
    }

    /// Draws all meshes.
    pub fn draw(&self, rec: &mut Recorder<'_>) {
        self.bodies.iter().for_each(|body| body.draw.record(rec));
    }

    /// Draws them as the sun sees them.
    pub fn draw_shadow(&self, rec: &mut Recorder<'_>) {
        self.bodies.iter().for_each(|body| body.draw.record_shadow(rec));
    }
}
