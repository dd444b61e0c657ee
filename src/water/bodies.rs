// SPDX-License-Identifier: MIT OR Apache-2.0
//! Spheres and boxes on their way through the water: `glsl/water/draught.comp` prepares their poses,
//! `glsl/water/body.comp` moves the water that they push aside.
//!
//! `h` is the head of the water, what a gauge would show: where a body lies, the water below it is `h` less its draught.
//! A column whose draught grows by `ds` in a step is raised by `ds`, so the body's volume is in the water exactly, and a
//! closed passage gives back all that it took. The surface is raised where a body enters and lowered where it leaves; waves
//! carry that away.
//!
//! Bodies move as they are told: water does not push back, and the draught is taken below the level of rest. They are not
//! drawn yet.

use super::Surface;
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};
use glam::{dvec2, dvec3, ivec2, DVec3, IVec2, UVec2, Vec2, Vec3};
use std::f64::consts::{PI, TAU};

/// Most bodies in one water.
pub const MOST: u32 = 16;

/// What a body looks like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// Of this radius (m).
    Sphere(f64),
    /// Half its length, height and width (m).
    Box(DVec3),
}

/// Where a body is at which time; y is up.
#[derive(Clone, Debug, PartialEq)]
pub enum Path {
    /// Time (s) and place (m), in the order of time; straight between them, at rest before and after.
    Keys(Vec<(f64, DVec3)>),
    /// Round a centre at one height, from +x towards +z. A box turns with its way.
    Circle {
        /// (m).
        centre_m: DVec3,
        /// (m).
        radius_m: f64,
        /// Time of a turn (s).
        period_s: f64,
        /// Angle at time 0 (rad).
        start_rad: f64,
    },
    /// To and fro, as the sine of time.
    Swing {
        /// Middle (m).
        at_m: DVec3,
        /// From the middle to where it turns (m).
        by_m: DVec3,
        /// Time from and to the same end (s).
        period_s: f64,
    },
}

/// A body and its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// What it looks like.
    pub shape: Shape,
    /// Where it is.
    pub path: Path,
    /// How a box is turned, from +x towards +z (rad); added to what a circle turns it.
    pub yaw_rad: f64,
}

impl Path {
    /// Place (m) and turn (rad) at a time (s).
    pub fn at(&self, time_s: f64) -> (DVec3, f64) {
        match self {
            Self::Keys(keys) => {
                let next = keys.partition_point(|(t, _)| *t <= time_s);
                let place = match (next.checked_sub(1).map(|i| keys[i]), keys.get(next)) {
                    (Some((t0, from)), Some((t1, to))) => from.lerp(*to, (time_s - t0) / (t1 - t0)),
                    (Some((_, last)), None) => last,
                    (None, first) => first.map_or(DVec3::ZERO, |(_, place)| *place),
                };
                (place, 0.0)
            }
            Self::Circle { centre_m, radius_m, period_s, start_rad } => {
                let angle = start_rad + TAU * (time_s / period_s).rem_euclid(1.0);
                let out = dvec3(angle.cos(), 0.0, angle.sin());
                (*centre_m + *radius_m * out, angle + 0.5 * PI)
            }
            Self::Swing { at_m, by_m, period_s } => {
                (*at_m + *by_m * (TAU * (time_s / period_s).rem_euclid(1.0)).sin(), 0.0)
            }
        }
    }
}

impl Shape {
    /// Volume below the level (m^3) when the centre is at `y_m` above it.
    pub fn submerged_m3(&self, y_m: f64) -> f64 {
        match *self {
            Self::Sphere(radius) => {
                let deep = (radius - y_m).clamp(0.0, 2.0 * radius);
                PI * deep * deep * (3.0 * radius - deep) / 3.0
            }
            Self::Box(half) => 4.0 * half.x * half.z * ((half.y - y_m).max(0.0) - (-half.y - y_m).max(0.0)),
        }
    }
}

/// A body at one moment: `Body` in `glsl/water/body.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Pose {
    /// Centre: x and z from the corner of the grid, y above the level of rest (m).
    pub at_m: Vec3,
    /// 0 for a sphere.
    pub is_box: u32,
    /// Half its extent along its own axes; a sphere's radius, three times (m).
    pub half_m: Vec3,
    /// Volume below the level of rest (m^3).
    pub submerged_m3: f32,
    /// Its own x axis, in x and z.
    pub axis: Vec2,
    /// Written by `water.draught`.
    pub scale: f32,
    /// Volume on water, neither on land nor outside the grid, written by `water.draught` (m^3).
    pub displaced_m3: f32,
}

impl Body {
    /// The body at a time (s); `origin_m` is the corner of the grid at the level of rest.
    pub fn pose(&self, time_s: f64, origin_m: DVec3) -> Pose {
        let (place, turn) = self.path.at(time_s);
        let at = place - origin_m;
        let (half, is_box) = match self.shape {
            Shape::Sphere(radius) => (DVec3::splat(radius), 0),
            Shape::Box(half) => (half, 1),
        };
        let yaw = self.yaw_rad + turn;
        Pose {
            at_m: at.as_vec3(),
            is_box,
            half_m: half.as_vec3(),
            submerged_m3: self.shape.submerged_m3(at.y) as f32,
            axis: dvec2(yaw.cos(), yaw.sin()).as_vec2(),
            ..Pose::default()
        }
    }
}

impl Pose {
    /// Columns that the body can reach, on a grid without end: `reach_of` in `glsl/water/body.glsl`.
    pub(super) fn reach(&self, cell_m: f32) -> (IVec2, IVec2) {
        let (along, half) = (self.axis.abs(), self.half_m);
        let reach = match self.is_box {
            1 => Vec2::new(along.x * half.x + along.y * half.z, along.y * half.x + along.x * half.z),
            _ => Vec2::new(half.x, half.z),
        };
        let at = Vec2::new(self.at_m.x, self.at_m.z);
        let clamp = |v: Vec2| v.clamp(Vec2::splat(-65536.0), Vec2::splat(65536.0)).as_ivec2();
        (
            clamp(((at - reach) / cell_m - 0.5).floor()),
            clamp(((at + reach) / cell_m + 0.5).floor() + Vec2::ONE),
        )
    }
}

/// Push constants: `BodyParams` in `glsl/water/body.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct BodyParams {
    /// Size of the grid.
    pub cells: UVec2,
    /// Of the rectangle that the bodies reach.
    pub origin: UVec2,
    /// Of the rectangle that the bodies reach.
    pub size: UVec2,
    /// Columns from one row to the next.
    pub pitch: u32,
    /// Floats from one column to the next.
    pub stride: u32,
    /// Pose of the first body before the step; those after it follow.
    pub first: u32,
    /// Bodies.
    pub count: u32,
    /// Edge of a column (m).
    pub cell_m: f32,
}

impl BodyParams {
    /// For the whole grid of `surface`.
    pub fn new(surface: &Surface<'_>, cells: UVec2, cell_m: f64, count: u32) -> Self {
        let (pitch, stride) = (surface.pitch, surface.stride);
        Self {
            cells,
            origin: UVec2::ZERO,
            size: cells,
            pitch,
            stride,
            first: 0,
            count,
            cell_m: cell_m as f32,
        }
    }

    /// For the columns that `poses` reach.
    fn around(self, poses: &[Pose]) -> Self {
        let cells = self.cells.as_ivec2();
        let none = (cells, ivec2(0, 0));
        // A column more: the host need not round as the device does.
        let (lo, hi) = poses
            .iter()
            .map(|pose| pose.reach(self.cell_m))
            .fold(none, |all, one| (all.0.min(one.0 - IVec2::ONE), all.1.max(one.1 + IVec2::ONE)));
        let (lo, hi) = (lo.clamp(IVec2::ZERO, cells), hi.clamp(IVec2::ZERO, cells));
        Self { origin: lo.as_uvec2(), size: (hi - lo).max(IVec2::ZERO).as_uvec2(), ..self }
    }
}

/// The kernels.
pub struct Bodies {
    draught: Kernel,
    body: Kernel,
    gpu: Gpu,
}

impl Bodies {
    /// What surface and poses must be visible to before [`BodyList::record_draughts`] and [`BodyList::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How they touched them last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// If the device cannot build the kernels.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let kernel = |name, spv| {
            let info = KernelInfo { name, spv, blocks: &["Height", "Bodies"], constants: &[] };
            Kernel::new::<BodyParams>(gpu, &info)
        };
        Ok(Self {
            draught: kernel(c"water.draught", shaders::WATER_DRAUGHT_COMP)?,
            body: kernel(c"water.body", shaders::WATER_BODY_COMP)?,
            gpu: gpu.clone(),
        })
    }

    /// Room for `most_steps` steps of `params.count` bodies that act on `surfaces`, the two between which a model goes to
    /// and fro.
    ///
    /// # Errors
    /// If the device has no room.
    ///
    /// # Panics
    /// If there are no bodies, or more than [`MOST`].
    pub fn list(&self, surfaces: [Surface<'_>; 2], params: BodyParams, most_steps: u32) -> Result<BodyList> {
        assert!((1..=MOST).contains(&params.count), "{} bodies", params.count);
        let bytes = u64::from(params.count) * (u64::from(most_steps) + 1) * size_of::<Pose>() as u64;
        let list = Buffer::new(&self.gpu, "water.bodies", bytes, Residence::Device)?;
        let bind = |surface: &Surface<'_>| -> Result<_> {
            let blocks = [("Height", surface.height_m.into()), ("Bodies", (&list).into())];
            Ok((surface.height_m.clone(), self.draught.bind(&blocks)?, self.body.bind(&blocks)?))
        };
        let bound = [bind(&surfaces[0])?, bind(&surfaces[1])?];
        Ok(BodyList { list, bound, poses: Vec::new(), params, gpu: self.gpu.clone() })
    }
}

/// Poses on the GPU: all bodies before the first step, then after it, then after the next.
pub struct BodyList {
    list: Buffer,
    bound: [(Buffer, Bound, Bound); 2],
    poses: Vec<Pose>,
    params: BodyParams,
    gpu: Gpu,
}

impl BodyList {
    /// A staging buffer with `poses`, to be copied over [`BodyList::poses`].
    ///
    /// # Errors
    /// If there is no room.
    ///
    /// # Panics
    /// If there are more poses than room.
    pub fn staging(&mut self, poses: Vec<Pose>) -> Result<Buffer> {
        let staging = Buffer::new(&self.gpu, "water.bodies.upload", self.list.bytes(), Residence::Upload)?;
        staging.write(0, &poses);
        self.poses = poses;
        Ok(staging)
    }

    /// Prepares all poses that were staged last.
    ///
    /// # Panics
    /// If `surface` is not one of the two that the list was made for.
    pub fn record_draughts(&self, rec: &mut Recorder<'_>, surface: &Surface<'_>) {
        let threads = [64 * self.poses.len() as u32, 1, 1];
        rec.span(c"water.draught", |rec| rec.dispatch(&self.bound(surface).1, threads, &self.params));
    }

    /// Moves the water for step `step` of those that were staged last.
    ///
    /// # Panics
    /// If `surface` is not one of the two that the list was made for, or the step was not staged.
    pub fn record(&self, rec: &mut Recorder<'_>, surface: &Surface<'_>, step: u32) {
        let first = step * self.params.count;
        let of_step = &self.poses[first as usize..(first + 2 * self.params.count) as usize];
        let params = BodyParams { first, ..self.params.around(of_step) };
        if params.size.min_element() > 0 {
            let threads = [params.size.x, params.size.y, 1];
            rec.span(c"water.body", |rec| rec.dispatch(&self.bound(surface).2, threads, &params));
        }
    }

    fn bound(&self, surface: &Surface<'_>) -> &(Buffer, Bound, Bound) {
        let bound = self.bound.iter().find(|(height, ..)| height.is(surface.height_m));
        bound.expect("a surface that the list was made for")
    }

    /// The poses, with what [`BodyList::record_draughts`] wrote.
    pub fn poses(&self) -> &Buffer {
        &self.list
    }
}
