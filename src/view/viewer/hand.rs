// SPDX-License-Identifier: MIT OR Apache-2.0
//! Events: keys, buttons, wheel; and the hand that reaches into the scene.

use super::Viewer;
use crate::{
    run::Ray,
    view::{
        camera::{Held, Mode},
        keys::Action,
        ViewError,
    },
};
use glam::Vec2;
use winit::{
    event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent},
    keyboard::{KeyCode, PhysicalKey},
};

/// Pixels within which an emitter is under the pointer.
const GRASP: f32 = 16.0;

/// What the left button holds.
pub(super) enum Grasp {
    /// Water and disks.
    Touch,
    /// An emitter by its number, at a height (m).
    Emitter(usize, f32),
}

impl Viewer {
    /// Something has happened to the window. `false` if it is the end.
    ///
    /// # Errors
    /// As [`Viewer::new`].
    pub fn on_event(&mut self, event: &WindowEvent) -> Result<bool, ViewError> {
        let is_taken = self.painter.on_event(&self.window, event);
        match event {
            WindowEvent::CloseRequested => return Ok(false),
            WindowEvent::Resized(size) => self.frames.resize((*size).into()),
            WindowEvent::RedrawRequested => return self.redraw(),
            WindowEvent::KeyboardInput { event, .. } => {
                let PhysicalKey::Code(code) = event.physical_key else { return Ok(true) };
                let is_down = event.state == ElementState::Pressed;
                if is_down && (is_taken || self.painter.wants_keys()) {
                    return Ok(true);
                }
                self.hold(code, is_down);
                let flies = self.rig.mode() == Mode::Fly && matches!(code, KeyCode::KeyA | KeyCode::KeyD);
                if is_down && !event.repeat && !flies {
                    return Action::of(code).map_or(Ok(true), |action| self.act(action));
                }
            }
            WindowEvent::Occluded(is_covered) => self.is_covered = *is_covered,
            WindowEvent::Focused(true) => self.has_focus = true,
            WindowEvent::Focused(false) => {
                self.has_focus = false;
                self.held = Held::default();
                (self.turns, self.pans) = (false, false);
                self.let_go();
            }
            WindowEvent::CursorMoved { position, .. } => {
                let at = Vec2::new(position.x as f32, position.y as f32);
                let by = at - self.pointer;
                self.pointer = at;
                if self.turns {
                    self.rig.turn(by);
                }
                if self.pans {
                    self.rig.pan(by, self.height());
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let is_down = *state == ElementState::Pressed;
                if is_down && (is_taken || self.painter.wants_pointer()) {
                    return Ok(true);
                }
                match button {
                    MouseButton::Left if is_down => self.grasp = Some(self.grasp_at(self.pointer)),
                    MouseButton::Left => self.let_go(),
                    MouseButton::Right => self.turns = is_down,
                    MouseButton::Middle => self.pans = is_down,
                    _ => {}
                }
            }
            WindowEvent::MouseWheel { delta, .. } if !is_taken && !self.painter.wants_pointer() => {
                self.rig.zoom(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => *lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
                });
            }
            _ => {}
        }
        Ok(true)
    }

    pub(super) fn height(&self) -> f32 {
        self.frames.size().map_or(1.0, |[_, height]| height as f32)
    }

    pub(super) fn hold(&mut self, code: KeyCode, is_down: bool) {
        let x = if is_down { 1.0 } else { 0.0 };
        match code {
            KeyCode::KeyW => self.held.forward = x,
            KeyCode::KeyS => self.held.forward = -x,
            KeyCode::KeyD => self.held.right = x,
            KeyCode::KeyA => self.held.right = -x,
            KeyCode::KeyE => self.held.up = x,
            KeyCode::KeyQ => self.held.up = -x,
            KeyCode::ShiftLeft | KeyCode::ShiftRight => self.held.is_fast = is_down,
            _ => {}
        }
    }

    fn ray(&mut self, at: Vec2) -> Ray {
        let size = Vec2::from(self.frames.size().unwrap_or([1, 1]).map(|n| n as f32));
        let camera = self.rig.camera(self.world.camera());
        let at = Vec2::new(2.0 * at.x / size.x - 1.0, 1.0 - 2.0 * at.y / size.y);
        Ray::new(&camera, size.as_uvec2(), at)
    }

    /// The emitter under the pointer, or else whatever can be touched.
    pub(super) fn grasp_at(&mut self, at: Vec2) -> Grasp {
        let ray = self.ray(at);
        let reach = GRASP * self.rig.camera(self.world.camera()).fov_rad / self.height();
        let placed = self.plan.emitters.iter().enumerate().filter(|(_, it)| it.has_place());
        let angles = placed.map(|(i, it)| (ray.angle_to(it.at_m), i, it.at_m.y));
        match angles.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((angle, emitter, height_m)) if angle < reach => Grasp::Emitter(emitter, height_m),
            _ => Grasp::Touch,
        }
    }

    /// What is held follows the pointer.
    pub(super) fn reach_in(&mut self) -> Result<(), ViewError> {
        let ray = self.ray(self.pointer);
        match self.grasp {
            None => self.world.let_go(),
            Some(Grasp::Touch) => {
                self.world.let_go();
                self.is_touched |= self.world.touch(&self.gpu, &ray)?.is_some();
            }
            Some(Grasp::Emitter(emitter, height_m)) => {
                if let Some(at_m) = ray.at_height(height_m) {
                    self.world.move_emitter(emitter, at_m);
                    self.is_touched = true;
                }
            }
        }
        Ok(())
    }

    /// Where an emitter was let go goes into the scene.
    pub(super) fn let_go(&mut self) {
        if let Some(Grasp::Emitter(emitter, height_m)) = self.grasp.take() {
            let ray = self.ray(self.pointer);
            if let Some(at_m) = ray.at_height(height_m) {
                let numbers = at_m.to_array().map(|x| f64::from((x * 1e3).round() * 1e-3));
                self.edit(|document| {
                    document.set_numbers(&format!("emitter.{emitter}.at_m"), &numbers, false)
                });
            }
        }
        self.world.let_go();
    }
}
