// SPDX-License-Identifier: MIT OR Apache-2.0
//! The impact stream: how simulations meet without knowing each other. Those who move particles append what they hit; those
//! who paint, splash or count read it after the step. Reads `glsl/impact/{impact.glsl,close.comp,locate.comp}`.
//!
//! | kernel          | reads                                              | writes                                | CPU twin       |
//! | --------------- | -------------------------------------------------- | ------------------------------------- | -------------- |
//! | `impact.close`  | count                                              | count, dropped, arguments             | [`cpu::close`] |
//! | `impact.locate` | impacts, count, places, triangles, uvs, firsts     | mesh and texture coordinates          | [`cpu::locate`] |
//!
//! A step is [`Stream::record_begin`], the producers (any number, with barriers between them as their own writes need), then
//! [`Stream::record_end`]. An append is one atomic; beyond the capacity impacts are dropped and counted. They lie in the
//! order in which they came, which no two runs share: [`Impact::order`] tells them apart for those who must be the same to
//! the bit. What is left out: impacts are of one step, nobody keeps them.

pub mod cpu;

use crate::{
    gpu::{self, Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence},
    shaders,
};
use glam::Vec3;

/// What hits what, 64 bytes: `Impact` in `glsl/impact/impact.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Impact {
    /// Where they touch, on the surface (m).
    pub at_m: Vec3,
    /// Place of the particle in its step, times 8, plus the number of the bounce: tells all impacts of a step apart.
    pub order: u32,
    /// Of the surface, unit, towards the particle.
    pub normal: Vec3,
    /// Change of the velocity along it: impulse a mass (m/s).
    pub impulse_mps: f32,
    /// Of the particle before, seen from the surface (m/s).
    pub velocity_mps: Vec3,
    /// Of all meshes' one after the other, plus 1; 0: none (water, terrain).
    pub triangle: u32,
    /// Texture coordinate, once `impact.locate` has run.
    pub u: f32,
    /// Likewise.
    pub v: f32,
    /// Likewise; [`NO_MESH`]: none.
    pub mesh: u32,
    /// Who threw the particle, as the law's numbers say.
    pub source: u32,
}

/// An impact on what is no mesh.
pub const NO_MESH: u32 = u32::MAX;

/// Counts and arguments on the GPU: `ImpactCount` in `glsl/impact/impact.glsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Count {
    /// Impacts that are stored.
    pub count: u32,
    /// Most of a step.
    pub capacity: u32,
    /// For which there was no room, since the start: low word.
    pub dropped_low: u32,
    /// High word.
    pub dropped_high: u32,
    /// Indirect dispatch of workgroups of 64, an invocation an impact, at [`Count::GROUPS`].
    pub groups_x: u32,
    /// The same.
    pub groups_y: u32,
    /// The same.
    pub groups_z: u32,
    /// Of the step under way, stored or not.
    pub appended: u32,
    /// Indirect draw of six vertices an impact, at [`Count::QUADS`].
    pub quad_vertices: u32,
    /// The same.
    pub quad_instances: u32,
    /// The same.
    pub quad_first_vertex: u32,
    /// The same.
    pub quad_first_instance: u32,
    /// Stored since the start: low word.
    pub stored_low: u32,
    /// High word.
    pub stored_high: u32,
}

impl Count {
    /// Offset of the arguments of a dispatch of workgroups of 64, an invocation an impact (bytes).
    pub const GROUPS: u64 = std::mem::offset_of!(Self, groups_x) as u64;
    /// Offset of the arguments of a draw of six vertices an impact (bytes).
    pub const QUADS: u64 = std::mem::offset_of!(Self, quad_vertices) as u64;

    /// For which there was no room, since the start.
    pub fn dropped(&self) -> u64 {
        u64::from(self.dropped_high) << 32 | u64::from(self.dropped_low)
    }

    /// Stored since the start.
    pub fn stored(&self) -> u64 {
        u64::from(self.stored_high) << 32 | u64::from(self.stored_low)
    }
}

/// Push constants: `LocateParams` in `glsl/impact/locate.comp`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct LocateParams {
    /// Meshes that there are.
    pub meshes: u32,
}

/// Triangles of all meshes, one mesh after the other, as the impacts number them.
#[derive(Clone, Copy)]
pub struct Surfaces<'a> {
    /// Six `f32` a vertex: place (m), velocity (m/s).
    pub places: &'a Buffer,
    /// Three vertices a triangle, `u32`.
    pub triangles: &'a Buffer,
    /// Texture coordinates, two `f32` a vertex.
    pub uvs: &'a Buffer,
    /// The first triangle of each mesh, then how many there are of all, `u32`.
    pub first_triangle: &'a Buffer,
}

/// Impacts of one step.
pub struct Stream {
    impacts: Buffer,
    count: Buffer,
    close: Bound,
    locate: Option<(Bound, LocateParams)>,
    capacity: u32,
    gpu: Gpu,
}

impl Stream {
    /// What the stream must be visible to when a step begins: [`Stream::record_begin`] has seen to it.
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Stream::record_end`] touched it last: whoever dispatches or draws by its counts adds a barrier to
    /// [`Access::IndirectRead`].
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// Room for `capacity` impacts a step.
    ///
    /// # Errors
    /// If the device has no room, or sees no buffer of that size.
    ///
    /// # Panics
    /// If the capacity is 0.
    pub fn new(gpu: &Gpu, capacity: u32) -> gpu::Result<Self> {
        assert!(capacity > 0, "a stream of no impacts");
        let bytes = u64::from(capacity) * size_of::<Impact>() as u64;
        let impacts = Buffer::new(gpu, "impact.impacts", bytes, Residence::Device)?;
        let empty = Count { capacity, groups_y: 1, groups_z: 1, quad_instances: 1, ..Count::default() };
        let count = gpu.upload("impact.count", &[empty])?;
        let close = KernelInfo {
            name: c"impact.close",
            spv: shaders::IMPACT_CLOSE_COMP,
            blocks: &["Count"],
            constants: &[],
        };
        let close = Kernel::new::<()>(gpu, &close)?.bind(&[("Count", (&count).into())])?;
        Ok(Self { impacts, count, close, locate: None, capacity, gpu: gpu.clone() })
    }

    /// From now on impacts are told where on which texture they are.
    ///
    /// # Errors
    /// The device's.
    ///
    /// # Panics
    /// If there is no mesh.
    pub fn locate_on(&mut self, on: &Surfaces<'_>) -> gpu::Result<()> {
        let info = KernelInfo {
            name: c"impact.locate",
            spv: shaders::IMPACT_LOCATE_COMP,
            blocks: &["Impacts", "Count", "Places", "Triangles", "Uvs", "Firsts"],
            constants: &[],
        };
        let meshes = (on.first_triangle.bytes() / 4) as u32 - 1;
        assert!(meshes > 0, "`{}`: no mesh", on.first_triangle.name());
        let bound = Kernel::new::<LocateParams>(&self.gpu, &info)?.bind(&[
            ("Impacts", (&self.impacts).into()),
            ("Count", (&self.count).into()),
            ("Places", on.places.into()),
            ("Triangles", on.triangles.into()),
            ("Uvs", on.uvs.into()),
            ("Firsts", on.first_triangle.into()),
        ])?;
        self.locate = Some((bound, LocateParams { meshes }));
        Ok(())
    }

    /// Before the producers of a step: who read the last has read it.
    pub fn record_begin(&self, rec: &mut Recorder<'_>) {
        rec.barrier(Access::ComputeReadWrite, Self::ENTRY);
        rec.barrier(Access::GraphicsRead, Access::ComputeWrite);
        rec.barrier(Access::IndirectRead, Access::ComputeWrite);
    }

    /// After them: close --B-- locate.
    pub fn record_end(&self, rec: &mut Recorder<'_>) {
        let both = Access::ComputeReadWrite;
        rec.barrier(both, both);
        rec.span(c"impact.close", |rec| rec.dispatch(&self.close, [1, 1, 1], &()));
        if let Some((bound, params)) = &self.locate {
            rec.barrier(both, both);
            rec.barrier(Access::ComputeWrite, Access::IndirectRead);
            rec.span(c"impact.locate", |rec| {
                rec.dispatch_indirect(bound, &self.count, Count::GROUPS, params)
            });
        }
    }

    /// [`Impact`]s, as many as [`Count::count`] says.
    pub fn impacts(&self) -> &Buffer {
        &self.impacts
    }

    /// [`Count`].
    pub fn count(&self) -> &Buffer {
        &self.count
    }

    /// Most impacts of a step.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Reads the counts. Submits and waits: for tools and tests, not for a frame loop.
    ///
    /// # Errors
    /// The device's.
    pub fn counts(&self) -> gpu::Result<Count> {
        Ok(self.gpu.download::<Count>(&self.count)?[0])
    }

    /// The impacts of the last step by [`Impact::order`], and the counts. Submits and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self) -> gpu::Result<(Vec<Impact>, Count)> {
        let counts = self.counts()?;
        let mut impacts = self.gpu.download::<Impact>(&self.impacts)?;
        impacts.truncate(counts.count as usize);
        impacts.sort_by_key(|it| it.order);
        Ok((impacts, counts))
    }
}
