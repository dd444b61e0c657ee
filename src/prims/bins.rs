// SPDX-License-Identifier: MIT OR Apache-2.0
//! Counting sort by key. Reads `glsl/prims/{bin_count,bin_place,bin_order}.comp` and the scan.

use super::{kernel, threads, Params, Scan, ScanBound, Sums, GROUP};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, Recorder, Residence, Result},
    shaders,
};

/// The kernels.
pub struct Bins {
    count: Kernel,
    scan: Scan,
    place: Kernel,
    order: Kernel,
    gpu: Gpu,
}

impl Bins {
    /// What the keys must be visible to before [`BinsBound::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`BinsBound::record`] touched the buffers last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// If the device cannot build the kernels.
    pub fn new(gpu: &Gpu, sums: Sums) -> Result<Self> {
        let (count, place) = (shaders::PRIMS_BIN_COUNT_COMP, shaders::PRIMS_BIN_PLACE_COMP);
        let order = shaders::PRIMS_BIN_ORDER_COMP;
        Ok(Self {
            count: kernel(gpu, c"prims.bin_count", count, &["Keys", "Counts", "Ranks"])?,
            scan: Scan::new(gpu, sums)?,
            place: kernel(gpu, c"prims.bin_place", place, &["Keys", "Firsts", "Ranks", "Order"])?,
            order: kernel(gpu, c"prims.bin_order", order, &["Firsts", "Order"])?,
            gpu: gpu.clone(),
        })
    }

    /// For `u32` of `keys` below `bins`; one that is not counts as `bins - 1`.
    ///
    /// # Errors
    /// If the device has no room.
    ///
    /// # Panics
    /// If there are no bins.
    pub fn bind(&self, keys: &Buffer, bins: u32) -> Result<BinsBound> {
        assert!(bins > 0, "no bins");
        let gpu = &self.gpu;
        let buffer = |name: &str, bytes| Buffer::new(gpu, name, bytes, Residence::Device);
        let firsts = buffer("prims.firsts", 4 * u64::from(bins))?;
        let ranks = buffer("prims.ranks", keys.bytes())?;
        let order = buffer("prims.order", keys.bytes())?;
        Ok(BinsBound {
            count: self.count.bind(&[
                ("Keys", keys.into()),
                ("Counts", (&firsts).into()),
                ("Ranks", (&ranks).into()),
            ])?,
            scan: self.scan.bind(&firsts, &firsts)?,
            place: self.place.bind(&[
                ("Keys", keys.into()),
                ("Firsts", (&firsts).into()),
                ("Ranks", (&ranks).into()),
                ("Order", (&order).into()),
            ])?,
            order_bins: self.order.bind(&[("Firsts", (&firsts).into()), ("Order", (&order).into())])?,
            firsts,
            order,
            bins,
            most: (keys.bytes() / 4) as u32,
        })
    }
}

/// A sort of one buffer of keys.
pub struct BinsBound {
    count: Bound,
    scan: ScanBound,
    place: Bound,
    order_bins: Bound,
    firsts: Buffer,
    order: Buffer,
    bins: u32,
    most: u32,
}

impl BinsBound {
    /// fill --B-- count --B-- scan --B-- place, and --B-- order if `is_stable`: else the scheduler decides the order within
    /// a bin. Of the first `count` keys.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn record(&self, rec: &mut Recorder<'_>, count: u32, is_stable: bool) {
        assert!(count <= self.most, "{count} of {} keys", self.most);
        let params = Params { count, tiles: count.div_ceil(GROUP), bins: self.bins };
        let both = Access::ComputeReadWrite;
        rec.barrier(both, Access::FillWrite);
        rec.span(c"prims.bin_clear", |rec| rec.fill(&self.firsts, 0));
        rec.barrier(Access::FillWrite, both);
        rec.span(c"prims.bin_count", |rec| rec.dispatch(&self.count, threads(params.tiles), &params));
        rec.barrier(both, both);
        self.scan.record(rec, self.bins);
        rec.barrier(both, both);
        rec.span(c"prims.bin_place", |rec| rec.dispatch(&self.place, threads(params.tiles), &params));
        if is_stable {
            rec.barrier(both, both);
            let groups = threads(self.bins.div_ceil(GROUP));
            rec.span(c"prims.bin_order", |rec| rec.dispatch(&self.order_bins, groups, &params));
        }
    }

    /// Where each bin begins in [`BinsBound::order`].
    pub fn firsts(&self) -> &Buffer {
        &self.firsts
    }

    /// Indices of the elements by key.
    pub fn order(&self) -> &Buffer {
        &self.order
    }
}
