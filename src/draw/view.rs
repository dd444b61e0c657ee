// SPDX-License-Identifier: MIT OR Apache-2.0
use glam::{Mat4, UVec2, Vec2, Vec3, Vec4};

/// Where a picture is taken from. World: y up, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// (m).
    pub eye_m: Vec3,
    /// What is in the middle of the picture (m).
    pub target_m: Vec3,
    /// Angle from the lower to the upper border (rad).
    pub fov_rad: f32,
}

/// What every drawing shader knows of the picture: `View` in `glsl/draw/view.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct View {
    /// Reversed depth, infinitely far.
    pub clip_from_world: Mat4,
    /// Eye (m); w: time of the scene (s).
    pub eye_m: Vec4,
    /// Direction through a pixel = forward + x right + y up, x and y from -1 to 1.
    pub ray_right: Vec4,
    /// See `ray_right`.
    pub ray_up: Vec4,
    /// See `ray_right`.
    pub ray_forward: Vec4,
    /// Unit vector; w: exposure.
    pub to_sun: Vec4,
    /// Extent along x and z, round the origin (m).
    pub terrain_size_m: Vec2,
    /// Samples along x and z.
    pub terrain_cells: UVec2,
    /// Of the picture.
    pub pixels: UVec2,
    /// Of sun and sky, 1 at noon, 0 is none.
    pub daylight: f32,
    /// Unused.
    pub reserved: u32,
    /// A light that is no sun: where it is (m).
    pub lamp_m: Vec4,
    /// Its light at a distance of 1 m, linear; black is none.
    pub lamp: Vec4,
}

impl View {
    /// The view of `camera` at `time_s` of the scene, with the sun in the direction `to_sun`.
    pub fn new(camera: &Camera, pixels: UVec2, time_s: f32, to_sun: Vec3, exposure: f32) -> Self {
        const NEAR_M: f32 = 0.1;
        let aspect = pixels.x as f32 / pixels.y as f32;
        let forward = (camera.target_m - camera.eye_m).normalize_or(Vec3::NEG_Z);
        let up = if forward.y.abs() > 0.999 { Vec3::NEG_Z } else { Vec3::Y }; // straight down, north is up
        let world_to_eye = glam::camera::rh::view::look_to_mat4(camera.eye_m, forward, up);
        let right = forward.cross(up).normalize();
        let tan = (0.5 * camera.fov_rad).tan();
        // Depth is near / distance: 1 at the near plane, 0 at infinity.
        let clip_from_eye = Mat4::from_cols(
            Vec4::new(1.0 / (tan * aspect), 0.0, 0.0, 0.0),
            Vec4::new(0.0, 1.0 / tan, 0.0, 0.0),
            Vec4::new(0.0, 0.0, 0.0, -1.0),
            Vec4::new(0.0, 0.0, NEAR_M, 0.0),
        );
        Self {
            clip_from_world: clip_from_eye * world_to_eye,
            eye_m: camera.eye_m.extend(time_s),
            ray_right: (tan * aspect * right).extend(0.0),
            ray_up: (tan * right.cross(forward)).extend(0.0),
            ray_forward: forward.extend(0.0),
            to_sun: to_sun.normalize_or(Vec3::Y).extend(exposure),
            terrain_size_m: Vec2::ONE,
            terrain_cells: UVec2::ONE,
            pixels,
            daylight: 1.0,
            reserved: 0,
            lamp_m: Vec4::ZERO,
            lamp: Vec4::ZERO,
        }
    }
}
