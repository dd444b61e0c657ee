// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exclusive scan: the sum of all values before each. Reads `glsl/prims/{reduce,sums,scan}.glsl`.

use super::{kernel, threads, tuned_kernel, Params, Sums, FEW_TILES, TILE};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, Recorder, Residence, Result},
    shaders,
};

/// The kernels.
pub struct Scan {
    reduce: Kernel,
    pub(super) sums: Kernel,
    scan: Kernel,
    clears: bool,
    gpu: Gpu,
}

impl Scan {
    /// What the buffers must be visible to before [`ScanBound::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`ScanBound::record`] touched them last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// If the device cannot build the kernels.
    pub fn new(gpu: &Gpu, sums: Sums) -> Result<Self> {
        Self::built(gpu, sums, false)
    }

    /// One that leaves zeros where it has read, for who counts into them again. Its buffers are two.
    ///
    /// # Errors
    /// If the device cannot build the kernels.
    pub fn clearing(gpu: &Gpu, sums: Sums) -> Result<Self> {
        Self::built(gpu, sums, true)
    }

    fn built(gpu: &Gpu, sums: Sums, clears: bool) -> Result<Self> {
        let reduce = sums.of(shaders::PRIMS_REDUCE_SUBGROUP_COMP, shaders::PRIMS_REDUCE_COMP);
        let all = sums.of(shaders::PRIMS_SUMS_SUBGROUP_COMP, shaders::PRIMS_SUMS_COMP);
        let scan = sums.of(shaders::PRIMS_SCAN_SUBGROUP_COMP, shaders::PRIMS_SCAN_COMP);
        Ok(Self {
            reduce: kernel(gpu, c"prims.reduce", reduce, &["Values", "Sums"])?,
            sums: kernel(gpu, c"prims.sums", all, &["Sums"])?,
            scan: tuned_kernel(
                gpu,
                c"prims.scan",
                scan,
                &["Values", "Sums", "Scanned"],
                &[u32::from(clears)],
            )?,
            clears,
            gpu: gpu.clone(),
        })
    }

    /// For `u32` of `values`, into `scanned`, which may be the same buffer if it is not [`Scan::clearing`].
    ///
    /// # Errors
    /// If the device has no room.
    ///
    /// # Panics
    /// If `scanned` is smaller than `values`, or the same where values are cleared.
    pub fn bind(&self, values: &Buffer, scanned: &Buffer) -> Result<ScanBound> {
        assert!(
            scanned.bytes() >= values.bytes(),
            "`{}` is smaller than `{}`",
            scanned.name(),
            values.name()
        );
        assert!(!(self.clears && values.is(scanned)), "`{}` is cleared as it is read", values.name());
        let sums = sums_of(&self.gpu, "prims.sums", values)?;
        let (from, to, between) = (values.into(), scanned.into(), (&sums).into());
        Ok(ScanBound {
            reduce: self.reduce.bind(&[("Values", from), ("Sums", between)])?,
            all: self.sums.bind(&[("Sums", between)])?,
            scan: self.scan.bind(&[("Values", from), ("Sums", between), ("Scanned", to)])?,
            sums,
            most: (values.bytes() / 4) as u32,
        })
    }
}

/// Room for the sums of the tiles of `values`, and of all.
pub(super) fn sums_of(gpu: &Gpu, name: &str, values: &Buffer) -> Result<Buffer> {
    let tiles = (values.bytes() / 4).div_ceil(u64::from(TILE));
    Buffer::new(gpu, name, 4 * (tiles + 1), Residence::Device)
}

/// A scan of one pair of buffers.
pub struct ScanBound {
    reduce: Bound,
    all: Bound,
    scan: Bound,
    sums: Buffer,
    most: u32,
}

impl ScanBound {
    /// reduce --B-- sums --B-- scan, of the first `count` values; reduce --B-- scan where the scan can add up the sums.
    ///
    /// # Panics
    /// If there are not so many.
    pub fn record(&self, rec: &mut Recorder<'_>, count: u32) {
        assert!(count <= self.most, "{count} of {} values", self.most);
        let params = Params { count, tiles: count.div_ceil(TILE), bins: 0 };
        let both = Access::ComputeReadWrite;
        rec.span(c"prims.reduce", |rec| rec.dispatch(&self.reduce, threads(params.tiles), &params));
        rec.barrier(both, both);
        if params.tiles == 0 || params.tiles > FEW_TILES {
            rec.span(c"prims.sums", |rec| rec.dispatch(&self.all, threads(1), &params));
            rec.barrier(both, both);
        }
        rec.span(c"prims.scan", |rec| rec.dispatch(&self.scan, threads(params.tiles), &params));
    }

    /// The sum of all values, after [`ScanBound::record`] of `count`: at this word of [`ScanBound::sums`].
    pub fn total_at(count: u32) -> usize {
        count.div_ceil(TILE) as usize
    }

    /// Of the tiles; after them, the sum of all.
    pub fn sums(&self) -> &Buffer {
        &self.sums
    }
}
