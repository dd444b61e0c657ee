// SPDX-License-Identifier: MIT OR Apache-2.0
//! Stable compaction: values whose flag is not 0. Reads `glsl/prims/{flags.comp,sums.glsl,compact.glsl}`.

use super::{kernel, scan::sums_of, threads, Params, Sums, TILE};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, Recorder, Result},
    shaders,
};

/// The kernels.
pub struct Compact {
    flags: Kernel,
    sums: Kernel,
    compact: Kernel,
    gpu: Gpu,
}

impl Compact {
    /// What the buffers must be visible to before [`CompactBound::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`CompactBound::record`] touched them last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// If the device cannot build the kernels.
    pub fn new(gpu: &Gpu, sums: Sums) -> Result<Self> {
        let flags = sums.of(shaders::PRIMS_FLAGS_SUBGROUP_COMP, shaders::PRIMS_FLAGS_COMP);
        let all = sums.of(shaders::PRIMS_SUMS_SUBGROUP_COMP, shaders::PRIMS_SUMS_COMP);
        let compact = sums.of(shaders::PRIMS_COMPACT_SUBGROUP_COMP, shaders::PRIMS_COMPACT_COMP);
        Ok(Self {
            flags: kernel(gpu, c"prims.flags", flags, &["Values", "Sums"])?,
            sums: kernel(gpu, c"prims.sums", all, &["Sums"])?,
            compact: kernel(gpu, c"prims.compact", compact, &["Flags", "Values", "Sums", "Kept"])?,
            gpu: gpu.clone(),
        })
    }

    /// For `u32` of `values` and as many of `flags`, into `kept`.
    ///
    /// # Errors
    /// If the device has no room.
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn bind(&self, flags: &Buffer, values: &Buffer, kept: &Buffer) -> Result<CompactBound> {
        let sizes = [flags, values, kept].map(Buffer::bytes);
        assert_eq!(sizes, [flags.bytes(); 3], "sizes of flags, values and kept");
        let sums = sums_of(&self.gpu, "prims.sums", flags)?;
        let between = (&sums).into();
        Ok(CompactBound {
            flags: self.flags.bind(&[("Values", flags.into()), ("Sums", between)])?,
            all: self.sums.bind(&[("Sums", between)])?,
            compact: self.compact.bind(&[
                ("Flags", flags.into()),
                ("Values", values.into()),
                ("Sums", between),
                ("Kept", kept.into()),
            ])?,
            sums,
            most: (flags.bytes() / 4) as u32,
        })
    }
}

/// A compaction of one set of buffers.
pub struct CompactBound {
    flags: Bound,
    all: Bound,
    compact: Bound,
    sums: Buffer,
    most: u32,
}

impl CompactBound {
    /// flags --B-- sums --B-- compact, of the first `count` values. How many are kept is at word
    /// [`ScanBound::total_at`](super::ScanBound::total_at) of [`CompactBound::sums`].
    ///
    /// # Panics
    /// If there are not so many.
    pub fn record(&self, rec: &mut Recorder<'_>, count: u32) {
        assert!(count <= self.most, "{count} of {} values", self.most);
        let params = Params { count, tiles: count.div_ceil(TILE), bins: 0 };
        let both = Access::ComputeReadWrite;
        rec.span(c"prims.flags", |rec| rec.dispatch(&self.flags, threads(params.tiles), &params));
        rec.barrier(both, both);
        rec.span(c"prims.sums", |rec| rec.dispatch(&self.all, threads(1), &params));
        rec.barrier(both, both);
        rec.span(c"prims.compact", |rec| rec.dispatch(&self.compact, threads(params.tiles), &params));
    }

    /// How many are kept of the tiles before each, then of all.
    pub fn sums(&self) -> &Buffer {
        &self.sums
    }
}
