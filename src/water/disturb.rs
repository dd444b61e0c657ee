// SPDX-License-Identifier: MIT OR Apache-2.0
//! Drops, pushes and bodies, from a list on the GPU: `glsl/water/weigh.comp` prepares it, `glsl/water/disturb.comp` adds
//! it to a surface.

use super::Surface;
use crate::{
    gpu::{Access, Bound, Buffer, Error, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};
use glam::{UVec2, Vec2};

/// Acts on a disc of the surface: `Disturbance` in `glsl/water/disturb.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Disturbance {
    /// From the corner of the grid (m).
    pub at_m: Vec2,
    /// (m).
    pub radius_m: f32,
    /// Added to the water (m^3).
    pub volume_m3: f32,
    /// Added to the rate at which the surface rises (m^3/s).
    pub push_m3ps: f32,
    /// Written by `water.weigh` (1/m^2).
    pub scale: f32,
    /// 1: it is refused if the one before it in the list is; its disc holds that one's.
    pub tied: u32,
    /// Unused.
    pub reserved: u32,
}

/// Push constants: `DisturbParams` in `glsl/water/disturb.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DisturbParams {
    /// Size of the grid.
    pub cells: UVec2,
    /// Columns from one row to the next.
    pub pitch: u32,
    /// Floats from one column to the next.
    pub stride: u32,
    /// Edge of a column (m).
    pub cell_m: f32,
    /// No disturbance may lift the surface by more (m), nor speed it up by more (m/s).
    pub limit_m: f32,
    /// 0: there is no velocity to push, and a push is rejected.
    pub has_velocity: u32,
}

/// What became of disturbances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Counts {
    /// Added to the surface.
    pub applied: u32,
    /// Not finite, or beyond the limit.
    pub rejected: u32,
    /// On land or outside the grid.
    pub missed: u32,
}

/// The kernels.
pub struct Disturb {
    weigh: Kernel,
    apply: Kernel,
    gpu: Gpu,
}

impl Disturb {
    /// What surface and list must be visible to before [`Disturbances::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Disturbances::record`] touched them last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// If the device cannot build the kernels.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        let kernel = |name, spv, blocks| {
            Kernel::new::<DisturbParams>(gpu, &KernelInfo { name, spv, blocks, constants: &[] })
        };
        Ok(Self {
            weigh: kernel(
                c"water.weigh",
                shaders::WATER_WEIGH_COMP,
                &["Height", "Disturbances", "Counters"],
            )?,
            apply: kernel(
                c"water.disturb",
                shaders::WATER_DISTURB_COMP,
                &["Disturbances", "Height", "Velocity"],
            )?,
            gpu: gpu.clone(),
        })
    }

    /// A list of up to `capacity` disturbances that acts on `surfaces`, the two between which a model goes to and fro.
    /// A model without velocity gives its heights for it: they are not touched as such.
    ///
    /// # Errors
    /// If the device has no room.
    pub fn list(
        &self,
        surfaces: [Surface<'_>; 2],
        velocity: Option<&Buffer>,
        capacity: u32,
    ) -> Result<Disturbances> {
        self.list_of(surfaces, [velocity; 2], capacity)
    }

    /// The same where each surface has a velocity of its own.
    ///
    /// # Errors
    /// If the device has no room.
    pub fn list_of(
        &self,
        surfaces: [Surface<'_>; 2],
        velocities: [Option<&Buffer>; 2],
        capacity: u32,
    ) -> Result<Disturbances> {
        let allowed = self.gpu.limits().max_compute_work_group_count[0].min(u32::MAX / 64);
        if capacity > allowed {
            return Err(Error::Limit {
                name: "water.disturbances".into(),
                needed: capacity.into(),
                device: self.gpu.name().into(),
                allowed: allowed.into(),
                limit: "maxComputeWorkGroupCount, a workgroup a disturbance",
            });
        }
        let bytes = HEADER_BYTES as u64 + u64::from(capacity) * size_of::<Disturbance>() as u64;
        let list = Buffer::new(&self.gpu, "water.disturbances", bytes, Residence::Device)?;
        let counters = self.gpu.upload("water.disturbance_counts", &[Counts::default()])?;
        let bind = |surface: &Surface<'_>, velocity: Option<&Buffer>| -> Result<_> {
            let height = surface.height_m;
            let weigh = self.weigh.bind(&[
                ("Height", height.into()),
                ("Disturbances", (&list).into()),
                ("Counters", (&counters).into()),
            ])?;
            let apply = self.apply.bind(&[
                ("Disturbances", (&list).into()),
                ("Height", height.into()),
                ("Velocity", velocity.unwrap_or(height).into()),
            ])?;
            Ok(Target { height: height.clone(), has_velocity: velocity.is_some(), weigh, apply })
        };
        let bound = [bind(&surfaces[0], velocities[0])?, bind(&surfaces[1], velocities[1])?];
        Ok(Disturbances { list, counters, bound, capacity, gpu: self.gpu.clone() })
    }
}

pub(super) const HEADER_BYTES: usize = 16;

/// A surface that the kernels are bound to.
struct Target {
    height: Buffer,
    has_velocity: bool,
    weigh: Bound,
    apply: Bound,
}

/// A list on the GPU: a count, then the disturbances. Other simulations may fill it there.
pub struct Disturbances {
    list: Buffer,
    counters: Buffer,
    bound: [Target; 2],
    capacity: u32,
    gpu: Gpu,
}

impl Disturbances {
    /// Prepares and adds what is in the list now.
    ///
    /// # Panics
    /// If `surface` is not one of the two that the list was made for, or `params` are of another grid, or of a velocity
    /// that there is not.
    pub fn record(&self, rec: &mut Recorder<'_>, surface: &Surface<'_>, params: &DisturbParams) {
        let Target { weigh, apply, .. } = self.target(surface, params);
        rec.span(c"water.weigh", |rec| rec.dispatch(weigh, [64 * self.capacity, 1, 1], params));
        rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        rec.span(c"water.disturb", |rec| rec.dispatch(apply, [params.cells.x, params.cells.y, 1], params));
    }

    /// The same of a list that a kernel has filled, whose header has the dispatch: count, 1, 1. It is visible to
    /// [`Access::IndirectRead`] as well.
    ///
    /// # Panics
    /// As [`Disturbances::record`].
    pub fn record_listed(&self, rec: &mut Recorder<'_>, surface: &Surface<'_>, params: &DisturbParams) {
        let Target { weigh, apply, .. } = self.target(surface, params);
        rec.span(c"water.weigh", |rec| rec.dispatch_indirect(weigh, &self.list, 0, params));
        rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        rec.span(c"water.disturb", |rec| rec.dispatch(apply, [params.cells.x, params.cells.y, 1], params));
    }

    fn target(&self, surface: &Surface<'_>, params: &DisturbParams) -> &Target {
        let bound = self.bound.iter().find(|target| target.height.is(surface.height_m));
        let target = bound.expect("a surface that the list was made for");
        let (asked, there) =
            ((params.cells, params.pitch, params.stride), (surface.cells, surface.pitch, surface.stride));
        assert_eq!(asked, there, "grid of the parameters and of the surface");
        assert!(target.has_velocity || params.has_velocity == 0, "the surface has no velocity");
        target
    }

    /// A staging buffer with up to [`Disturbances::capacity`] of `items`, to be copied over [`Disturbances::list`], and
    /// how many did not fit.
    ///
    /// # Errors
    /// If there is no room.
    pub fn staging(&self, items: &[Disturbance]) -> Result<(Buffer, usize)> {
        let taken = &items[..items.len().min(self.capacity as usize)];
        let staging =
            Buffer::new(&self.gpu, "water.disturbances.upload", self.list.bytes(), Residence::Upload)?;
        staging.write(0, &[taken.len() as u32, 0, 0, 0]);
        staging.write(HEADER_BYTES, taken);
        Ok((staging, items.len() - taken.len()))
    }

    /// Count and disturbances.
    pub fn list(&self) -> &Buffer {
        &self.list
    }

    /// Most disturbances at a time.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// What became of all so far.
    ///
    /// # Errors
    /// The device's.
    pub fn counts(&self) -> Result<Counts> {
        Ok(self.gpu.download::<Counts>(&self.counters)?[0])
    }
}
