// SPDX-License-Identifier: MIT OR Apache-2.0
//! Exact overlap of triangles and cells, in compute. Reads `glsl/volume/{begin,mark,second,extend,keep,resolve}*.comp`.

use super::{kernel, spread, Meshes, VolumeParams};
use crate::{
    cells::Cells,
    gpu::{Access, Bound, Buffer, Gpu, Recorder, Residence, Result},
    shaders,
};
use std::ops::Range;

/// Words before the list in `Work`.
const WORK_WORDS: u64 = 6;

/// What was not marked, and what took more than one invocation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Triangles without an area: they have no normal.
    pub no_area: u32,
    /// Triangles with a corner that is no number, or more than 10^9 cells out.
    pub not_finite: u32,
    /// Triangles whose box overlaps more than 32 cells. The list has room for all there are.
    pub large: u32,
}

/// Voxelisation of a scene's meshes. Meshes that do not move are done once; a step marks those that move, looks once more
/// at the others where a moving plane is now one of a cell's two, and the cells are what voxelising all would give, to the bit.
pub struct Conservative {
    params: VolumeParams,
    begin: Bound,
    mark: Bound,
    mark_large: Bound,
    second: Bound,
    second_large: Bound,
    second_still_large: Bound,
    extend: Bound,
    extend_large: Bound,
    extend_still_large: Bound,
    resolve: Bound,
    moving: Vec<Range<u32>>,
    still: Vec<Range<u32>>,
    work: Buffer,
    still_work: Buffer,
    extents: Buffer,
}

impl Conservative {
    /// What places must be visible to before [`Conservative::record`], and whoever read the cells must be done.
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Conservative::record`] touched the cells last.
    pub const EXIT: Access = Access::ComputeWrite;

    /// Voxelises the meshes that do not move into `cells`. Submits, and waits.
    ///
    /// # Errors
    /// If the device has no room, or cannot see buffers of that size.
    pub fn new(gpu: &Gpu, meshes: &Meshes, cells: &Cells) -> Result<Self> {
        let params = VolumeParams::new(cells.grid(), meshes);
        let (count, number) = (cells.grid().count() as u64, u64::from(meshes.count()));
        let buffer = |name: &str, bytes: u64| Buffer::new(gpu, name, bytes, Residence::Device);
        let first_keys = buffer("volume.first_keys", 4 * count)?;
        let second_keys = buffer("volume.second_keys", 4 * count)?;
        let still_keys = buffer("volume.still_keys", 8 * count)?;
        let still_extents = buffer("volume.still_extents", 12 * count)?;
        let normals = buffer("volume.normals", 16 * number)?;
        let work = buffer("volume.work", 4 * (WORK_WORDS + number))?;
        let still_work = buffer("volume.still_work", 4 * (WORK_WORDS + number))?;
        let all = [
            ("Places", meshes.places()),
            ("Triangles", meshes.triangles()),
            ("Normals", &normals),
            ("FirstKeys", &first_keys),
            ("SecondKeys", &second_keys),
            ("StillKeys", &still_keys),
            ("Occupied", cells.occupied()),
            ("Planes", cells.planes()),
            ("Extents", cells.extents()),
            ("StillExtents", &still_extents),
        ];
        // Bound twice: with the list of what moves, and with that of the others.
        let both = |name, spv, blocks: &[&str]| -> Result<[Bound; 2]> {
            let kernel = kernel(gpu, name, spv, blocks)?;
            let bind = |work| {
                let buffer = |block: &str| all.iter().find(|it| it.0 == block).map_or(work, |it| it.1);
                kernel.bind(&blocks.iter().map(|block| (*block, buffer(block).into())).collect::<Vec<_>>())
            };
            Ok([bind(&work)?, bind(&still_work)?])
        };
        let one = |name, spv, blocks: &[&str]| both(name, spv, blocks).map(|[bound, _]| bound);
        let (places, triangles) = ("Places", "Triangles");
        let (first, second, still) = ("FirstKeys", "SecondKeys", "StillKeys");
        let blocks = [still, first, second, "Work"];
        let [begin, begin_still] = both(c"volume.begin", shaders::VOLUME_BEGIN_COMP, &blocks)?;
        let blocks = [places, triangles, "Normals", first, "Work"];
        let [mark, mark_still] = both(c"volume.mark", shaders::VOLUME_MARK_COMP, &blocks)?;
        let blocks = [places, triangles, first, "Work"];
        let [mark_large, mark_still_large] =
            both(c"volume.mark_large", shaders::VOLUME_MARK_LARGE_COMP, &blocks)?;
        let blocks = [places, triangles, "Normals", first, still, second, "Work"];
        let [second_large, second_still_large] =
            both(c"volume.second_large", shaders::VOLUME_SECOND_LARGE_COMP, &blocks)?;
        let second_pass = one(c"volume.second", shaders::VOLUME_SECOND_COMP, &blocks[..6])?;
        let blocks = [places, triangles, "Normals", first, still, second, "Extents", "Work"];
        let [extend_large, extend_still_large] =
            both(c"volume.extend_large", shaders::VOLUME_EXTEND_LARGE_COMP, &blocks)?;
        let extend = one(c"volume.extend", shaders::VOLUME_EXTEND_COMP, &blocks[..7])?;
        let blocks = [first, second, still, "Extents", "StillExtents"];
        let keep = one(c"volume.keep", shaders::VOLUME_KEEP_COMP, &blocks)?;
        let blocks =
            [places, triangles, first, still, second, "Occupied", "Planes", "Extents", "StillExtents"];
        let resolve = one(c"volume.resolve", shaders::VOLUME_RESOLVE_COMP, &blocks)?;
        let this = Self {
            params,
            begin,
            mark,
            mark_large,
            second: second_pass,
            second_large,
            second_still_large,
            extend,
            extend_large,
            extend_still_large,
            resolve,
            moving: meshes.runs(true),
            still: meshes.runs(false),
            work,
            still_work,
            extents: cells.extents().clone(),
        };
        gpu.once(|rec| {
            rec.fill(&still_keys, u32::MAX);
            rec.fill(&still_extents, 0);
            rec.fill(&this.extents, 0);
            rec.fill(&normals, 0);
            rec.barrier(Access::FillWrite, Access::ComputeReadWrite);
            this.over_cells(rec, &this.begin);
            rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
            this.over_cells(rec, &begin_still);
            rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
            this.over(rec, &mark_still, &this.still, 0);
            this.over_list(rec, &mark_still_large, &this.still_work);
            rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
            this.over(rec, &this.second, &this.still, 0);
            rec.dispatch_indirect(&this.second_still_large, &this.still_work, 0, &this.params);
            rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
            this.over(rec, &this.extend, &this.still, 0);
            rec.dispatch_indirect(&this.extend_still_large, &this.still_work, 0, &this.params);
            rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
            this.over_cells(rec, &keep);
            rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
            this.over_cells(rec, &this.resolve);
            for reader in [Access::ComputeReadWrite, Access::GraphicsRead] {
                rec.barrier(Access::ComputeWrite, reader);
            }
        })?;
        Ok(this)
    }

    /// Fills the cells again, if anything moves.
    ///
    /// begin --B-- mark, mark_large --B-- second, second_large --B-- extend, extend_large --B-- resolve
    pub fn record(&self, rec: &mut Recorder<'_>) {
        if self.moving.is_empty() {
            return;
        }
        rec.barrier(Access::IndirectRead, Access::ComputeReadWrite); // the list that a step before dispatched by
        rec.barrier(Access::ComputeReadWrite, Access::FillWrite);
        rec.span(c"volume.begin", |rec| {
            rec.fill(&self.extents, 0);
            self.over_cells(rec, &self.begin);
        });
        rec.barrier(Access::FillWrite, Access::ComputeReadWrite);
        rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
        rec.span(c"volume.mark", |rec| self.over(rec, &self.mark, &self.moving, 0));
        rec.span(c"volume.mark_large", |rec| self.over_list(rec, &self.mark_large, &self.work));
        rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
        rec.span(c"volume.second", |rec| self.over_all(rec, &self.second));
        let [moving, still] = [&self.second_large, &self.second_still_large];
        rec.span(c"volume.second_large", |rec| self.over_lists(rec, moving, still));
        rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
        rec.span(c"volume.extend", |rec| self.over_all(rec, &self.extend));
        let [moving, still] = [&self.extend_large, &self.extend_still_large];
        rec.span(c"volume.extend_large", |rec| self.over_lists(rec, moving, still));
        rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
        rec.span(c"volume.resolve", |rec| self.over_cells(rec, &self.resolve));
    }

    fn over_cells(&self, rec: &mut Recorder<'_>, bound: &Bound) {
        rec.dispatch(bound, spread(self.params.grid.count() as u32, 256), &self.params);
    }

    fn over(&self, rec: &mut Recorder<'_>, bound: &Bound, runs: &[Range<u32>], only_changed: u32) {
        for run in runs {
            let params =
                VolumeParams { first: run.start, triangles: run.len() as u32, only_changed, ..self.params };
            rec.dispatch(bound, spread(params.triangles, 128), &params);
        }
    }

    /// Over what moves, and over the others where that changes something.
    fn over_all(&self, rec: &mut Recorder<'_>, bound: &Bound) {
        self.over(rec, bound, &self.moving, 0);
        self.over(rec, bound, &self.still, 1);
    }

    /// The same over both lists. They were seen to when they were made: nothing here waits for anything.
    fn over_lists(&self, rec: &mut Recorder<'_>, moving: &Bound, still: &Bound) {
        rec.dispatch_indirect(moving, &self.work, 0, &self.params);
        if !self.still.is_empty() {
            let params = VolumeParams { only_changed: 1, ..self.params };
            rec.dispatch_indirect(still, &self.still_work, 0, &params);
        }
    }

    /// Over a list that has just been made.
    fn over_list(&self, rec: &mut Recorder<'_>, bound: &Bound, work: &Buffer) {
        rec.barrier(Access::ComputeWrite, Access::IndirectRead);
        rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
        rec.dispatch_indirect(bound, work, 0, &self.params);
    }

    /// What the last step, and the meshes that do not move, left out. Submits, and waits.
    ///
    /// # Errors
    /// As [`Gpu::download`].
    pub fn counts(&self, gpu: &Gpu) -> Result<Counts> {
        let (a, b): (Vec<u32>, Vec<u32>) = (gpu.download(&self.work)?, gpu.download(&self.still_work)?);
        Ok(Counts { large: a[3] + b[3], no_area: a[4] + b[4], not_finite: a[5] + b[5] })
    }
}
