// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a basin of the linear models holds, whichever kernel steps it: planes of `f32` a column, and the dispatches that
//! take them to and fro.

use super::{check_heights, Error, Surface};
use crate::gpu::{Access, Bound, Buffer, Gpu, Kernel, Recorder, Residence, Result};
use glam::UVec2;
use std::ffi::CStr;

/// Heights, which go to and fro between two buffers, and the rates at which they change: one plane of velocities, or
/// several of flows. Rows are padded to a multiple of four columns: column `(x, y)` is at `y * pitch + x` of each plane.
pub struct Planes {
    heights: [Buffer; 2],
    /// Twice the same where the kernel changes them in place.
    rates: [Buffer; 2],
    steps: [Vec<Bound>; 2],
    current: usize,
    cells: UVec2,
    pitch: u32,
    has_land: bool,
}

/// What a kernel wants beside `Height` and `NewHeight`, and in which size.
pub(super) struct Rates {
    /// Names of the buffers, of which the second is not made if the kernel has one block for both.
    pub names: [&'static str; 2],
    /// Names of the blocks that are read and written, or of the one that is both.
    pub blocks: &'static [&'static str],
    /// Numbers a column.
    pub planes: u64,
    /// Of a number: 4, or 2 for halves.
    pub bytes: u64,
}

impl Planes {
    /// For kernels whose blocks are `Height`, the first of `rates`, `NewHeight`, the second if there is one, and another
    /// that each may have.
    pub(super) fn new(
        gpu: &Gpu,
        kernels: &[(&Kernel, Option<(&str, &Buffer)>)],
        cells: UVec2,
        rates: &Rates,
        has_land: bool,
    ) -> Result<Self> {
        let pitch = cells.x.next_multiple_of(4);
        let bytes = rates.bytes * u64::from(pitch) * u64::from(cells.y);
        let buffer = |name: &str, planes: u64| Buffer::new(gpu, name, planes * bytes, Residence::Device);
        let heights = [buffer("water.height_m.0", 1)?, buffer("water.height_m.1", 1)?];
        let [name, new_name] = rates.names;
        let (blocks, planes) = (rates.blocks, rates.planes);
        let first = buffer(name, planes)?;
        let second = if blocks.len() == 1 { first.clone() } else { buffer(new_name, planes)? };
        let rates = [first, second];
        let bind = |from: usize| -> Result<Vec<Bound>> {
            let one = |&(kernel, other): &(&Kernel, Option<(&'_ str, &Buffer)>)| {
                let read = [("Height", &heights[from]), (blocks[0], &rates[from])];
                let written = [("NewHeight", &heights[1 - from])].into_iter();
                let written = written.chain(blocks.get(1).map(|&name| (name, &rates[1 - from])));
                let all = read.into_iter().chain(written).chain(other);
                kernel.bind(&all.map(|(name, of)| (name, of.into())).collect::<Vec<_>>())
            };
            kernels.iter().map(one).collect()
        };
        let steps = [bind(0)?, bind(1)?];
        Ok(Self { heights, rates, steps, current: 0, cells, pitch, has_land })
    }

    /// Size of the grid.
    pub fn cells(&self) -> UVec2 {
        self.cells
    }

    /// Columns from one row to the next.
    pub fn pitch(&self) -> u32 {
        self.pitch
    }

    /// `f32` a column (m above rest): the surface after the steps recorded so far.
    pub fn height(&self) -> &Buffer {
        &self.heights[self.current]
    }

    /// The surface after the steps recorded so far, for drawing and disturbing.
    pub fn surface(&self) -> Surface<'_> {
        self.surfaces()[self.current]
    }

    /// The two between which the steps go to and fro.
    pub fn surfaces(&self) -> [Surface<'_>; 2] {
        let Self { cells, pitch, .. } = *self;
        [0, 1].map(|i| Surface { cells, height_m: &self.heights[i], pitch, stride: 1 })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        let rates = &self.rates[..if self.rates[0].is(&self.rates[1]) { 1 } else { 2 }];
        self.heights.iter().chain(rates).map(Buffer::bytes).sum()
    }

    /// Which of the two surfaces is that after the steps recorded so far.
    pub(super) fn current(&self) -> usize {
        self.current
    }

    /// Planes of rates after the steps recorded so far.
    pub(super) fn rate(&self) -> &Buffer {
        &self.rates[self.current]
    }

    /// The rates of each of [`Planes::surfaces`], where they are velocities: for
    /// [`Disturb::list_of`](super::Disturb::list_of).
    pub(super) fn rates(&self) -> [Option<&Buffer>; 2] {
        [0, 1].map(|i| Some(&self.rates[i]))
    }

    /// What `record` records, with every kernel bound, takes the planes to the next ones.
    ///
    /// # Panics
    /// If the parameters, whose grid and pitch `grid` are, are of another grid.
    pub(super) fn step(
        &mut self,
        rec: &mut Recorder<'_>,
        name: &'static CStr,
        grid: (UVec2, u32),
        record: impl FnOnce(&mut Recorder<'_>, &[Bound]),
    ) {
        assert_eq!(grid, (self.cells, self.pitch), "grid of the parameters and of the state");
        let steps = &self.steps[self.current];
        rec.span(name, |rec| record(rec, steps));
        self.current = 1 - self.current;
    }

    /// [`Planes::step`] by one dispatch of the only kernel.
    pub(super) fn dispatch<P: bytemuck::Pod>(
        &mut self,
        rec: &mut Recorder<'_>,
        name: &'static CStr,
        threads: UVec2,
        grid: (UVec2, u32),
        params: &P,
    ) {
        self.step(rec, name, grid, |rec, steps| rec.dispatch(&steps[0], [threads.x, threads.y, 1], params));
    }

    /// Sets heights (m above rest, [`LAND_M`](super::LAND_M) for land), without padding.
    pub(super) fn upload_heights(&self, gpu: &Gpu, height_m: &[f32]) -> Result<(), Error> {
        check_heights("height_m", height_m, self.cells, self.has_land)?;
        Ok(gpu.upload_to(self.height(), &padded(height_m, self.cells, self.pitch, 0.0))?)
    }

    /// Sets heights, and velocities (m/s), which are the one plane of rates.
    pub(super) fn upload_moving(
        &self,
        gpu: &Gpu,
        height_m: &[f32],
        velocity_mps: &[f32],
    ) -> Result<(), Error> {
        check_heights("velocity_mps", velocity_mps, self.cells, false)?; // before anything is changed
        self.upload_heights(gpu, height_m)?;
        Ok(gpu.upload_to(self.rate(), &padded(velocity_mps, self.cells, self.pitch, 0.0))?)
    }

    /// Sets every number that the next step writes, padding too.
    #[cfg(test)]
    pub(super) fn spoil(&self, gpu: &Gpu, with: f32) {
        for plane in [&self.heights[1 - self.current], &self.rates[1 - self.current]] {
            gpu.upload_to(plane, &vec![with; plane.bytes() as usize / 4]).expect("an upload");
        }
    }

    /// Heights and velocities.
    pub(super) fn download_moving(&self, gpu: &Gpu) -> Result<(Vec<f32>, Vec<f32>)> {
        let (heights, mut rates) = self.download_all(gpu)?;
        Ok((heights, rates.swap_remove(0)))
    }

    /// Heights, then each plane of rates, without padding.
    pub(super) fn download_all(&self, gpu: &Gpu) -> Result<(Vec<f32>, Vec<Vec<f32>>)> {
        let plane = |all: &[f32]| plain(all, self.cells, self.pitch);
        let size = self.pitch as usize * self.cells.y as usize;
        let rates = gpu.download::<f32>(self.rate())?;
        Ok((plane(&gpu.download(self.height())?), rates.chunks_exact(size).map(plane).collect()))
    }
}

/// Records `steps` steps by `record`, which takes some of them, `most` at a time, and the barriers between.
pub(super) fn in_blocks(
    rec: &mut Recorder<'_>,
    steps: u32,
    most: u32,
    mut record: impl FnMut(&mut Recorder<'_>, u32),
) {
    let mut left = steps;
    while left > 0 {
        let taken = left.min(most);
        record(rec, taken);
        left -= taken;
        if left > 0 {
            rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        }
    }
}

/// Rows of `cells.x` numbers, each filled up to `pitch`.
pub(super) fn padded(plain: &[f32], cells: UVec2, pitch: u32, padding: f32) -> Vec<f32> {
    let mut padded = vec![padding; pitch as usize * cells.y as usize];
    let rows = plain.chunks_exact(cells.x as usize);
    for (to, from) in padded.chunks_exact_mut(pitch as usize).zip(rows) {
        to[..from.len()].copy_from_slice(from);
    }
    padded
}

/// The inverse of [`padded`].
pub(super) fn plain(padded: &[f32], cells: UVec2, pitch: u32) -> Vec<f32> {
    padded.chunks_exact(pitch as usize).flat_map(|row| &row[..cells.x as usize]).copied().collect()
}
