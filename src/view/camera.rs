// SPDX-License-Identifier: MIT OR Apache-2.0
//! The camera of the window: the scene's own, or one that a hand moves.

use crate::{draw::Camera, scene::Scene};
use glam::{vec3, Vec2, Vec3};

/// How it is moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Where the scene has it, on its way round if it circles.
    Home,
    /// Round a point, by dragging.
    Orbit,
    /// Through the scene, by keys, looking where the pointer drags.
    Fly,
}

/// Keys that are held down while flying: along the right, up and forward, -1 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Held {
    /// To the right.
    pub right: f32,
    /// Up.
    pub up: f32,
    /// Forward.
    pub forward: f32,
    /// Ten times as fast.
    pub is_fast: bool,
}

/// The camera of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    mode: Mode,
    camera: Camera,
    /// Of the scene, which sets the pace (m).
    extent_m: f32,
}

/// Turn of a drag over one pixel (rad).
const TURN: f32 = 0.006;
/// Straight up and down have no heading.
const STEEPEST: f32 = 1.55;

impl Rig {
    /// At home.
    pub fn new(scene: &Scene, home: Camera) -> Self {
        Self { mode: Mode::Home, camera: home, extent_m: scene.extent_m() }
    }

    /// How it is moved.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Where it is; `home` is where the scene has its own now.
    pub fn camera(&mut self, home: Camera) -> Camera {
        if self.mode == Mode::Home {
            self.camera = home;
        }
        self.camera
    }

    /// From here on, moved so.
    pub fn set_mode(&mut self, mode: Mode) {
        self.mode = mode;
    }

    /// Sees all of the scene from where it looks now.
    pub fn fit(&mut self, scene: &Scene) {
        self.mode = Mode::Orbit;
        self.extent_m = scene.extent_m();
        let level_m = scene.water.first().map_or(0.0, |water| water.level_m);
        let forward = (self.camera.target_m - self.camera.eye_m).normalize_or(vec3(-0.4, -0.6, -0.7));
        self.camera.target_m = vec3(0.0, level_m, 0.0);
        let away_m = 0.6 * self.extent_m / (0.5 * self.camera.fov_rad).tan();
        self.camera.eye_m = self.camera.target_m - away_m * forward;
    }

    /// The pointer has dragged by so many pixels.
    pub fn turn(&mut self, by: Vec2) {
        self.leave_home();
        let Camera { eye_m, target_m, .. } = self.camera;
        let arm = target_m - eye_m;
        let (yaw, pitch) = angles(arm);
        let arm = arm.length() * direction(yaw - TURN * by.x, pitch - TURN * by.y);
        match self.mode {
            Mode::Fly => self.camera.target_m = eye_m + arm,
            _ => self.camera.eye_m = target_m - arm,
        }
    }

    /// The pointer has dragged the scene itself, in a picture so many pixels high.
    pub fn pan(&mut self, by: Vec2, height: f32) {
        self.leave_home();
        let arm = self.camera.target_m - self.camera.eye_m;
        let m_per_pixel = 2.0 * arm.length() * (0.5 * self.camera.fov_rad).tan() / height.max(1.0);
        let right = arm.cross(Vec3::Y).normalize_or(Vec3::X);
        let up = right.cross(arm).normalize_or(Vec3::Y);
        self.shift(m_per_pixel * (by.y * up - by.x * right));
    }

    /// The wheel has turned by so many notches: nearer for more than 0.
    pub fn zoom(&mut self, notches: f32) {
        self.leave_home();
        let arm = self.camera.target_m - self.camera.eye_m;
        match self.mode {
            Mode::Fly => self.shift(0.02 * self.extent_m * notches * arm.normalize_or(Vec3::NEG_Z)),
            _ => {
                let nearest_m = (1e-4 * self.extent_m).max(0.05);
                let away_m = (arm.length() * 0.88f32.powf(notches)).clamp(nearest_m, 1e6);
                self.camera.eye_m = self.camera.target_m - away_m * arm.normalize_or(Vec3::NEG_Z);
            }
        }
    }

    /// Keys have been held for `seconds`.
    pub fn fly(&mut self, held: &Held, seconds: f32) {
        if self.mode != Mode::Fly {
            return;
        }
        let arm = self.camera.target_m - self.camera.eye_m;
        let right = arm.cross(Vec3::Y).normalize_or(Vec3::X);
        let forward = arm.normalize_or(Vec3::NEG_Z);
        let pace_mps = 0.15 * self.extent_m * if held.is_fast { 10.0 } else { 1.0 };
        self.shift(seconds * pace_mps * (held.right * right + held.up * Vec3::Y + held.forward * forward));
    }

    fn shift(&mut self, by_m: Vec3) {
        self.camera.eye_m += by_m;
        self.camera.target_m += by_m;
    }

    fn leave_home(&mut self) {
        if self.mode == Mode::Home {
            self.mode = Mode::Orbit;
        }
    }
}

/// Heading and steepness of a direction (rad).
fn angles(v: Vec3) -> (f32, f32) {
    let v = v.normalize_or(Vec3::NEG_Z);
    (v.x.atan2(v.z), v.y.clamp(-1.0, 1.0).asin())
}

fn direction(yaw: f32, pitch: f32) -> Vec3 {
    let pitch = pitch.clamp(-STEEPEST, STEEPEST);
    vec3(yaw.sin() * pitch.cos(), pitch.sin(), yaw.cos() * pitch.cos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::builtin;

    fn rig() -> (Scene, Rig) {
        let scene = builtin::load("pond", &[]).expect("a built-in scene");
        let home = Camera { eye_m: vec3(6.0, 14.0, 24.0), target_m: vec3(0.0, -0.5, 1.0), fov_rad: 0.7 };
        let rig = Rig::new(&scene, home);
        (scene, rig)
    }

    #[test]
    fn a_drag_leaves_home_and_keeps_the_distance() {
        let (_, mut rig) = rig();
        let home = rig.camera;
        rig.turn(Vec2::new(40.0, -25.0));
        let camera = rig.camera(home);
        assert_eq!(rig.mode(), Mode::Orbit);
        let away = |it: Camera| it.eye_m.distance(it.target_m);
        assert!((away(camera) - away(home)).abs() < 1e-3, "{camera:?}");
        assert!(camera.eye_m.distance(home.eye_m) > 1.0);
        rig.set_mode(Mode::Home);
        assert_eq!(rig.camera(home), home);
    }

    #[test]
    fn a_pan_moves_the_point_under_the_pointer_with_it() {
        let (_, mut rig) = rig();
        let home = rig.camera;
        rig.pan(Vec2::new(100.0, 0.0), 540.0);
        let moved = rig.camera(home).target_m - home.target_m;
        let away = home.eye_m.distance(home.target_m);
        let expected = 100.0 * 2.0 * away * (0.35f32).tan() / 540.0;
        assert!((moved.length() - expected).abs() < 1e-3 * expected, "{moved}");
    }

    #[test]
    fn flying_goes_where_it_looks() {
        let (scene, mut rig) = rig();
        let home = rig.camera;
        rig.set_mode(Mode::Fly);
        rig.fly(&Held { forward: 1.0, ..Held::default() }, 1.0);
        let moved = rig.camera(home).eye_m - home.eye_m;
        let forward = (home.target_m - home.eye_m).normalize();
        assert!((moved.length() - 0.15 * scene.extent_m()).abs() < 1e-3);
        assert!(moved.normalize().dot(forward) > 0.9999);
    }

    #[test]
    fn no_drag_turns_it_over() {
        let (_, mut rig) = rig();
        (0..100).for_each(|_| rig.turn(Vec2::new(0.0, 50.0)));
        let camera = rig.camera(rig.camera);
        assert!(camera.eye_m.is_finite());
        assert!((camera.target_m - camera.eye_m).normalize().y.abs() < 0.9999);
    }

    #[test]
    fn fit_sees_the_whole_scene() {
        let (scene, mut rig) = rig();
        rig.zoom(-30.0);
        rig.fit(&scene);
        let camera = rig.camera(rig.camera);
        let away = camera.eye_m.distance(camera.target_m);
        assert!(away * (0.5 * camera.fov_rad).tan() > 0.5 * scene.extent_m());
    }
}
