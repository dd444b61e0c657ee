// SPDX-License-Identifier: MIT OR Apache-2.0
//! `stateless`: nothing is stored. Reads `glsl/ballistic/materialise.glsl`.

use super::{Effect, GroundGrid, Moment, Params};
use crate::gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Resource, Result};
use std::ffi::CStr;

/// A vertex that `ballistic.materialise` writes.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// (m).
    pub at_m: [f32; 3],
    /// Red, green, blue (linear, premultiplied, up to 1), and age in 255ths of the life.
    pub look: [u8; 4],
}

/// Invocations of a workgroup.
const GROUP: u32 = 256;
/// Workgroups in a row: beyond it there are rows, as devices count few workgroups along one axis.
const ROW: u32 = 1 << 12;

/// The kernel of one effect. It holds no particles.
pub struct Materialise {
    kernel: Kernel,
    items: u32,
    has_ground: bool,
    gpu: Gpu,
}

impl Materialise {
    /// What the vertices must be visible to before `record`.
    pub const ENTRY: Access = Access::ComputeWrite;
    /// How `record` touched them last.
    pub const EXIT: Access = Access::ComputeWrite;
    /// Particles of an invocation: of an H100 two are 8 % faster than one, four as fast as two.
    pub const ITEMS: u32 = 2;

    /// From the SPIR-V of an effect's kernel; `name` is how captures and errors show it.
    ///
    /// # Errors
    /// If the SPIR-V is no such kernel.
    pub fn new(gpu: &Gpu, name: &CStr, spv: &[u8], has_ground: bool) -> Result<Self> {
        Self::tuned(gpu, name, spv, has_ground, Self::ITEMS)
    }

    /// The same with `items` particles an invocation: the speed differs, not the vertices.
    ///
    /// # Errors
    /// If the SPIR-V is no such kernel.
    pub fn tuned(gpu: &Gpu, name: &CStr, spv: &[u8], has_ground: bool, items: u32) -> Result<Self> {
        let blocks: &[&str] = if has_ground { &["Vertices", "Ground"] } else { &["Vertices"] };
        let constants = &[GROUP, items, GROUP];
        let kernel = Kernel::new::<Params>(gpu, &KernelInfo { name, spv, blocks, constants })?;
        Ok(Self { kernel, items, has_ground, gpu: gpu.clone() })
    }

    /// Room for `capacity` vertices; `ground_m` has the samples of the heightmap.
    ///
    /// # Errors
    /// If the device has no room, or cannot see a buffer of that size.
    ///
    /// # Panics
    /// If `ground_m` is missing for an effect that ends on the ground.
    pub fn vertices(&self, capacity: u32, ground_m: Option<&Buffer>) -> Result<Vertices> {
        let bytes = u64::from(capacity.max(1)) * size_of::<Vertex>() as u64;
        let buffer = Buffer::new(&self.gpu, "ballistic.vertices", bytes, Residence::Device)?;
        let mut resources: Vec<(&str, Resource<'_>)> = vec![("Vertices", (&buffer).into())];
        if self.has_ground {
            resources.push(("Ground", ground_m.expect("an effect with a ground has a heightmap").into()));
        }
        let bound = self.kernel.bind(&resources)?;
        Ok(Vertices { bound, buffer, items: self.items, capacity })
    }
}

/// Room for the vertices of one emitter.
pub struct Vertices {
    bound: Bound,
    buffer: Buffer,
    items: u32,
    capacity: u32,
}

impl Vertices {
    /// Records the particles of `effect` at `now`, oldest first. Submits nothing, waits for nothing. Returns how many there
    /// are, and how many of the newest found no room.
    pub fn record(
        &self,
        rec: &mut Recorder<'_>,
        effect: &Effect,
        now: Moment,
        seed: u32,
        stream: u32,
        ground: &GroundGrid,
    ) -> Counts {
        let params = effect.params(now, seed, stream, ground, self.capacity);
        self.record_params(rec, &params)
    }

    /// The same from numbers that are at hand.
    pub fn record_params(&self, rec: &mut Recorder<'_>, params: &Params) -> Counts {
        let wanted = params.births * params.burst;
        let written = wanted.min(self.capacity);
        let params = Params { capacity: self.capacity, ..*params };
        let groups = written.div_ceil(GROUP * self.items);
        let threads = [groups.min(ROW) * GROUP, groups.div_ceil(ROW), 1];
        rec.span(c"ballistic.materialise", |rec| rec.dispatch(&self.bound, threads, &params));
        Counts { written, dropped: wanted - written }
    }

    /// [`Vertex`] each.
    pub fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    /// The first `count` vertices. Submits to the queue and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self, gpu: &Gpu, count: u32) -> Result<Vec<Vertex>> {
        let mut all: Vec<Vertex> = gpu.download(&self.buffer)?;
        all.truncate(count as usize);
        Ok(all)
    }
}

/// What came of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Particles written.
    pub written: u32,
    /// Particles without room: the newest.
    pub dropped: u32,
}
