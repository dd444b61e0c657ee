// SPDX-License-Identifier: MIT OR Apache-2.0
//! What particles of the law `colliding` look at before anything else: which cells are near an occupied one, and which planes
//! are met in each. Reads `glsl/particles/{near,met}.comp`.

use crate::{
    cells::{Cells, Grid},
    gpu::{self, Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Resource},
    impact::Stream,
    shaders,
};

/// Push constants: `NearParams` in `glsl/particles/near_params.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct NearParams {
    /// Along x, y and z.
    pub cells: [u32; 3],
    /// How far is looked.
    pub reach: u32,
    /// Side of a cell (m).
    pub cell_m: f32,
}

/// What pools of the law collide with: cells, and which of them are near an occupied one.
pub struct Surroundings {
    cells: Cells,
    near: Buffer,
    /// Along x, y and z.
    spread: [Bound; 3],
    met: Bound,
    reach: u32,
}

impl Surroundings {
    /// Most cells that are looked at on each side.
    pub const MOST_REACH: u32 = 15;

    /// What the cells must be visible to before [`Surroundings::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Surroundings::record`] touched its own last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// On the device, beside the cells (bytes): of each a bit and half a word, and two bits on the way.
    pub fn bytes(grid: &Grid) -> u64 {
        19 * 4 * grid.count().div_ceil(32) as u64
    }

    /// Of `cells`, looked at within `reach` cells. Nothing is near before the first [`Surroundings::record`].
    ///
    /// # Errors
    /// The device's.
    ///
    /// # Panics
    /// If `reach` is not 1 to [`Surroundings::MOST_REACH`].
    pub fn new(gpu: &Gpu, cells: &Cells, reach: u32) -> gpu::Result<Self> {
        assert!((1..=Self::MOST_REACH).contains(&reach), "a reach of {reach} cells");
        let words = Self::bytes(&cells.grid()) / 19;
        let near = Buffer::new(gpu, "particles.near", 17 * words, Residence::Device)?;
        // Of their own, so that nothing on the way waits for what is met.
        let near_x = Buffer::new(gpu, "particles.near_x", words, Residence::Device)?;
        let near_y = Buffer::new(gpu, "particles.near_y", words, Residence::Device)?;
        gpu.once(|rec| rec.fill(&near, 0))?;
        let along = |axis: u32, from: &Buffer, to: &Buffer| {
            let info = KernelInfo {
                name: c"particles.near",
                spv: shaders::PARTICLES_NEAR_COMP,
                blocks: &["From", "To"],
                constants: &[axis],
            };
            Kernel::new::<NearParams>(gpu, &info)?.bind(&[("From", from.into()), ("To", to.into())])
        };
        let spread =
            [along(0, cells.occupied(), &near_x)?, along(1, &near_x, &near_y)?, along(2, &near_y, &near)?];
        let info = KernelInfo {
            name: c"particles.met",
            spv: shaders::PARTICLES_MET_COMP,
            blocks: &["Occupied", "Planes", "Near"],
            constants: &[],
        };
        let met = Kernel::new::<NearParams>(gpu, &info)?.bind(&[
            ("Occupied", cells.occupied().into()),
            ("Planes", cells.planes().into()),
            ("Near", (&near).into()),
        ])?;
        Ok(Self { cells: cells.clone(), near, spread, met, reach })
    }

    /// After each change of the cells, before the pools step.
    ///
    /// met, near along x --B-- near along y --B-- near along z
    pub fn record(&self, rec: &mut Recorder<'_>) {
        let grid = self.cells.grid();
        let params = NearParams { cells: grid.cells, reach: self.reach, cell_m: grid.cell_m };
        let threads = |items: usize| {
            let groups = items.div_ceil(64) as u32;
            let rows = groups.div_ceil(65_535).max(1);
            [groups.div_ceil(rows) * 64, rows, 1]
        };
        let both = Access::ComputeReadWrite;
        let words = threads(grid.count().div_ceil(32));
        let [x, y, z] = &self.spread;
        rec.span(c"particles.met", |rec| rec.dispatch(&self.met, threads(grid.count().div_ceil(2)), &params));
        rec.span(c"particles.near", |rec| {
            rec.dispatch(x, words, &params);
            rec.barrier(both, both);
            rec.dispatch(y, words, &params);
            rec.barrier(both, both);
            rec.dispatch(z, words, &params);
        });
    }

    /// What a pool of the law binds.
    pub fn resources<'a>(&'a self, stream: &'a Stream) -> [(&'static str, Resource<'a>); 5] {
        [
            ("Occupied", self.cells.occupied().into()),
            ("Planes", self.cells.planes().into()),
            ("Near", (&self.near).into()),
            ("Impacts", stream.impacts().into()),
            ("Count", stream.count().into()),
        ]
    }

    /// For [`Colliding::reach`](super::colliding::Colliding::reach).
    pub fn reach(&self) -> u32 {
        self.reach
    }

    /// A bit a cell: whether one within reach is occupied; then half a word each: which planes are met in it.
    pub fn near(&self) -> &Buffer {
        &self.near
    }

    /// The cells.
    pub fn cells(&self) -> &Cells {
        &self.cells
    }
}
