// SPDX-License-Identifier: MIT OR Apache-2.0
//! Paint from the impact stream. Reads `glsl/paint/{mark,bits,drops}.comp`, and what gathers.

use super::{
    gather::{upload_coats, Culled, Input},
    Canvas, Coat, Invalid, Method, Paint, Taken, Work,
};
use crate::{
    gpu::{self, Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence},
    impact::{Count, Stream},
    prims::{Scan, ScanBound, Sums},
    shaders,
};

/// Push constants of `paint.mark` and `paint.drops`: `SplatParams` in `glsl/paint/splat.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SplatParams {
    /// Sources.
    pub coats: u32,
    /// Maps.
    pub meshes: u32,
    /// Unused.
    pub unused: [u32; 2],
}

/// The kernels that put impacts in order.
pub(super) struct Order {
    mark: Kernel,
    bits: Kernel,
    scan: Scan,
    drops: Kernel,
}

impl Order {
    pub(super) fn new(gpu: &Gpu) -> gpu::Result<Self> {
        let kernel = |name, spv, blocks| {
            Kernel::new::<SplatParams>(gpu, &KernelInfo { name, spv, blocks, constants: &[] })
        };
        let bits = KernelInfo {
            name: c"paint.bits",
            spv: shaders::PAINT_BITS_COMP,
            blocks: &["Marks", "Before"],
            constants: &[],
        };
        Ok(Self {
            mark: kernel(
                c"paint.mark",
                shaders::PAINT_MARK_COMP,
                &["Impacts", "Count", "Coats", "Marks", "WorkToDo"],
            )?,
            bits: Kernel::new::<u32>(gpu, &bits)?,
            scan: Scan::new(gpu, Sums::for_device(gpu))?,
            drops: kernel(
                c"paint.drops",
                shaders::PAINT_DROPS_COMP,
                &["Impacts", "Count", "Coats", "Marks", "Before", "Maps", "Drops", "Homes"],
            )?,
        })
    }
}

impl Paint {
    /// From the impacts of `stream`, which knows the meshes of `canvas` in the same order, a coat of `coats` each; they have
    /// taken turns ([`Coat::take_turns`]).
    ///
    /// # Errors
    /// Coats that have not, more than 65535 coats or meshes, more than [`super::MOST_DROPS`] impacts a step, or if the device has no room.
    pub fn splat(&self, canvas: &Canvas, stream: &Stream, coats: &[Coat]) -> Result<Splat, super::Error> {
        let gpu = &self.gpu;
        let orders: u64 = coats.iter().map(|coat| u64::from(coat.orders)).sum();
        if orders == 0 || orders > u64::from(Coat::MOST_ORDERS) {
            let allowed = format!("1 to {} for all sources", Coat::MOST_ORDERS);
            return Err(Invalid { key: "orders", value: orders.to_string(), allowed }.into());
        }
        let meshes = canvas.maps().len() as u32;
        if meshes > 1 << 16 {
            let allowed = "up to 65536".to_string();
            return Err(Invalid { key: "meshes", value: meshes.to_string(), allowed }.into());
        }
        let coats = upload_coats(gpu, coats)?;
        let capacity = stream.capacity();
        let words = orders.div_ceil(32) as u32;
        let device =
            |name, count: u32, bytes| Buffer::new(gpu, name, bytes * u64::from(count), Residence::Device);
        let (marks, before) = (device("paint.marks", words, 4)?, device("paint.before", words, 4)?);
        let (drops, homes) = (device("paint.drops", capacity, 16)?, device("paint.homes", capacity, 4)?);
        let scan = self.order.scan.bind(&before, &before)?;
        let input = Input { drops: &drops, homes: &homes, coats: &coats, sums: scan.sums() };
        let culled = self.impacts.bind(gpu, canvas, &input, capacity)?;
        let (impacts, count) = (stream.impacts(), stream.count());
        let mark = self.order.mark.bind(&[
            ("Impacts", impacts.into()),
            ("Count", count.into()),
            ("Coats", (&coats).into()),
            ("Marks", (&marks).into()),
            ("WorkToDo", (&culled.work).into()),
        ])?;
        let bits = self.order.bits.bind(&[("Marks", (&marks).into()), ("Before", (&before).into())])?;
        let bound_drops = self.order.drops.bind(&[
            ("Impacts", impacts.into()),
            ("Count", count.into()),
            ("Coats", (&coats).into()),
            ("Marks", (&marks).into()),
            ("Before", (&before).into()),
            ("Maps", (&canvas.map_table).into()),
            ("Drops", (&drops).into()),
            ("Homes", (&homes).into()),
        ])?;
        let params = SplatParams { coats: culled.coats, meshes, unused: [0; 2] };
        let count = count.clone();
        Ok(Splat { mark, bits, scan, bound_drops, culled, marks, drops, count, params, words, capacity })
    }
}

/// Paint from one stream on one canvas.
pub struct Splat {
    mark: Bound,
    bits: Bound,
    scan: ScanBound,
    bound_drops: Bound,
    culled: Culled,
    marks: Buffer,
    drops: Buffer,
    count: Buffer,
    params: SplatParams,
    words: u32,
    capacity: u32,
}

impl Splat {
    /// Records the coats of the impacts of a step, after [`Stream::record_end`]. Submits nothing, waits for nothing,
    /// allocates nothing.
    pub fn record(&self, rec: &mut Recorder<'_>) {
        self.record_by(rec, Method::Sifted);
    }

    /// The same by another method, to compare with: it changes no bit.
    pub fn record_by(&self, rec: &mut Recorder<'_>, method: Method) {
        let both = Access::ComputeReadWrite;
        let (groups, p) = (Count::GROUPS, &self.params);
        rec.barrier(Access::ComputeWrite, Access::IndirectRead);
        rec.barrier(both, Access::FillWrite);
        rec.fill(&self.marks, 0);
        rec.barrier(Access::FillWrite, both);
        rec.barrier(both, both);
        rec.span(c"paint.mark", |rec| rec.dispatch_indirect(&self.mark, &self.count, groups, p));
        rec.barrier(both, both);
        let threads = super::spread(self.words.div_ceil(64), 64);
        rec.span(c"paint.bits", |rec| rec.dispatch(&self.bits, threads, &self.words));
        rec.barrier(both, both);
        self.scan.record(rec, self.words);
        rec.barrier(both, both);
        rec.span(c"paint.drops", |rec| rec.dispatch_indirect(&self.bound_drops, &self.count, groups, p));
        rec.barrier(both, both);
        let total_at = ScanBound::total_at(self.words) as u32;
        let params = self.culled.params(&Taken::all(self.capacity), 0.0, total_at);
        self.culled.record(rec, method, &params, true);
    }

    /// [`super::Drop`]s in order, of the last step.
    pub fn drops(&self) -> &Buffer {
        &self.drops
    }

    /// What became of the impacts. Submits and waits: for tools and tests.
    ///
    /// # Errors
    /// The device's.
    pub fn work(&self, gpu: &Gpu) -> gpu::Result<Work> {
        Ok(gpu.download::<Work>(&self.culled.work)?[0])
    }
}
