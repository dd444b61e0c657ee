// SPDX-License-Identifier: MIT OR Apache-2.0
//! Kernels that take several steps of a tile: `water.fused`, `water.fused_f16` and `water.pipes_fused`. In basins with land
//! there are two of each, for tiles of open water and for tiles with a shore: a shore costs several times what open water
//! does, and registers that open water would miss too. Land does not move, so lists of both are made when heights are set.

use super::{
    planes::{Planes, Rates},
    FusedParams, FusedTuning, LAND_M,
};
use crate::gpu::{Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result};
use glam::{IVec2, UVec2};
use std::{collections::BTreeSet, ffi::CStr};

/// The kernels: one, or two for basins with land.
pub(super) struct TileKernels {
    kernels: Vec<Kernel>,
    tuning: FusedTuning,
    name: &'static CStr,
    gpu: Gpu,
}

/// Words of the head of a list: `groups` and `count` of `Tiles` in `glsl/water/tiles.glsl`.
const HEAD: usize = 4;
/// Most workgroups along x: every device takes 65535.
const WIDE: u32 = 1024;

impl TileKernels {
    /// `blocks` are those before `Tiles`; `option` is the last constant but that of shores.
    pub fn new(
        gpu: &Gpu,
        (name, spv): (&'static CStr, &[u8]),
        blocks: [&str; 4],
        tuning: FusedTuning,
        has_land: bool,
        option: bool,
    ) -> Result<Self> {
        tuning.check(gpu, &name.to_string_lossy())?;
        let [x, y, lanes, rows, steps, buffers] = tuning.constants();
        let kernel = |has_shores: bool| {
            let [land, option, shores] = [has_land, option, has_shores].map(u32::from);
            let [a, b, c, d] = blocks;
            let info = KernelInfo {
                name,
                spv,
                blocks: &[a, b, c, d, "Tiles"],
                constants: &[x, y, lanes, rows, steps, buffers, land, option, shores],
            };
            Kernel::new::<FusedParams>(gpu, &info)
        };
        let kernels = if has_land { vec![kernel(false)?, kernel(true)?] } else { vec![kernel(false)?] };
        Ok(Self { kernels, tuning, name, gpu: gpu.clone() })
    }

    /// A basin whose memory is not set yet.
    pub fn state(&self, cells: UVec2, rates: &Rates) -> Result<(Planes, Tiles)> {
        let (has_land, tuning) = (self.kernels.len() == 2, self.tuning);
        let words =
            if has_land { HEAD as u64 + tuning.groups(cells).as_u64vec2().element_product() } else { 4 };
        let list = |name: &str| Buffer::new(&self.gpu, name, 4 * words, Residence::Device);
        let lists = match has_land {
            true => vec![list("water.tiles_open")?, list("water.tiles_shore")?],
            false => vec![list("water.tiles")?],
        };
        let kernels: Vec<_> =
            self.kernels.iter().zip(&lists).map(|(kernel, list)| (kernel, Some(("Tiles", list)))).collect();
        let planes = Planes::new(&self.gpu, &kernels, cells, rates, has_land)?;
        Ok((planes, Tiles { lists, tuning, cells, name: self.name }))
    }
}

/// The kernels of a model that takes one step a dispatch or several, as it is tuned.
pub(super) enum Step {
    One(Kernel),
    Tiles(TileKernels),
}

impl Step {
    /// A basin whose memory is not set yet.
    pub fn state(
        &self,
        gpu: &Gpu,
        cells: UVec2,
        rates: &Rates,
        has_land: bool,
    ) -> Result<(Planes, Option<Tiles>)> {
        match self {
            Self::One(step) => Ok((Planes::new(gpu, &[(step, None)], cells, rates, has_land)?, None)),
            Self::Tiles(kernels) => kernels.state(cells, rates).map(|(planes, tiles)| (planes, Some(tiles))),
        }
    }
}

/// Which tiles are of which kind, on the GPU.
pub(super) struct Tiles {
    lists: Vec<Buffer>,
    tuning: FusedTuning,
    cells: UVec2,
    name: &'static CStr,
}

impl Tiles {
    /// Most steps a dispatch.
    pub fn steps(&self) -> u32 {
        self.tuning.steps
    }

    /// Records a dispatch of up to as many steps as the tuning says.
    pub fn record(&self, rec: &mut Recorder<'_>, planes: &mut Planes, params: &FusedParams) {
        let grid = (params.water.cells, params.water.pitch);
        planes.step(rec, self.name, grid, |rec, steps| match &self.lists[..] {
            [open, shore] => {
                rec.dispatch_indirect(&steps[0], open, 0, params);
                // No barrier: a tile is in one of the lists, writes its own columns, and reads what neither writes. Layers that
                // take buffers whole report write after write here.
                rec.dispatch_indirect(&steps[1], shore, 0, params);
            }
            _ => {
                let threads = self.tuning.groups(self.cells) * self.tuning.group;
                rec.dispatch(&steps[0], [threads.x, threads.y, 1], params);
            }
        });
    }

    /// [`Tiles::record`] of one list alone.
    #[cfg(test)]
    pub fn record_list(&self, rec: &mut Recorder<'_>, planes: &mut Planes, of: usize, params: &FusedParams) {
        let grid = (params.water.cells, params.water.pitch);
        planes.step(rec, self.name, grid, |rec, steps| {
            rec.dispatch_indirect(&steps[of], &self.lists[of], 0, params);
        });
    }

    /// Makes the lists for land where `height_m`, without padding, has it.
    pub fn set(&self, gpu: &Gpu, height_m: &[f32]) -> Result<()> {
        let [open, shore] = &self.lists[..] else { return Ok(()) };
        let shores = shores(&self.tuning, self.cells, height_m);
        let groups = self.tuning.groups(self.cells);
        let all = (0..groups.y).flat_map(|y| (0..groups.x).map(move |x| (y, x)));
        let (with, without): (Vec<_>, Vec<_>) = all.partition(|tile| shores.contains(tile));
        for (list, tiles) in [(open, without), (shore, with)] {
            let count = tiles.len() as u32;
            let wide = count.min(WIDE);
            let head = [wide, count.div_ceil(wide.max(1)), 1, count];
            let mut words = vec![0; list.bytes() as usize / 4];
            words[..HEAD].copy_from_slice(&head);
            for (word, (y, x)) in words[HEAD..].iter_mut().zip(tiles) {
                *word = y << 16 | x;
            }
            gpu.upload_to(list, &words)?;
        }
        Ok(())
    }
}

/// Row and column of every tile that has land in reach, as all beyond the grid is.
fn shores(tuning: &FusedTuning, cells: UVec2, height_m: &[f32]) -> BTreeSet<(u32, u32)> {
    let (groups, tile, inner, halo) =
        (tuning.groups(cells), tuning.tile(), tuning.inner().unwrap_or(UVec2::ONE), tuning.halo());
    let mut shores = BTreeSet::new();
    for (y, x) in (0..groups.y).flat_map(|y| (0..groups.x).map(move |x| (y, x))) {
        let corner = (UVec2::new(x, y) * inner).as_ivec2() - halo.as_ivec2();
        if corner.min_element() < 0 || (corner + tile.as_ivec2()).cmpgt(cells.as_ivec2()).any() {
            shores.insert((y, x));
        }
    }
    let mut last = None; // most land lies beside land of the same tiles
    for (i, _) in height_m.iter().enumerate().filter(|(_, height)| **height == LAND_M) {
        let at = UVec2::new(i as u32 % cells.x, i as u32 / cells.x);
        // Tiles t with t inner - halo <= at < t inner - halo + tile.
        let to = ((at + halo) / inner).min(groups - 1);
        let from = (at + halo + 1).as_ivec2() - tile.as_ivec2();
        let from = (from.max(IVec2::ZERO).as_uvec2() + inner - 1) / inner;
        if last == Some((from, to)) {
            continue;
        }
        last = Some((from, to));
        for y in from.y..=to.y {
            (from.x..=to.x).for_each(|x| {
                shores.insert((y, x));
            });
        }
    }
    shores
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        gpu::GpuOptions,
        water::{starts, Fused, Model, Walls},
    };

    /// The columns that each of the two dispatches writes, of a basin where nothing is what a column may become.
    fn written(gpu: &Gpu, tuning: FusedTuning, cells: UVec2, of: usize) -> Vec<[bool; 2]> {
        let start = starts::coast(Model { walls: Walls::Folded, ..starts::model(cells, 0.25) });
        let fused = Fused::new(gpu, tuning, Walls::Folded, true).expect("a tuning that it takes");
        let mut state = fused.state(cells).expect("room");
        let at_rest = vec![0.0; start.height_m.len()];
        state.upload(gpu, &start.height_m, &at_rest).expect("heights");
        state.spoil(gpu, f32::MAX);
        let params = FusedParams { water: start.model.params(state.pitch()), steps: tuning.steps };
        gpu.once(|rec| state.record_list(rec, of, &params)).expect("a dispatch");
        let (height_m, velocity_mps) = state.download(gpu).expect("heights");
        height_m.iter().zip(&velocity_mps).map(|(h, v)| [h, v].map(|it| *it != f32::MAX)).collect()
    }

    #[test]
    fn tiles_of_both_lists_write_each_column_once() {
        let gpu = Gpu::headless(&GpuOptions::default()).expect("a Vulkan 1.3 device");
        let tuning = |x, y, rows, steps| FusedTuning { group: UVec2::new(x, y), rows, steps, buffers: 1 };
        for (tuning, cells) in [
            (tuning(8, 4, 8, 6), UVec2::new(255, 130)),
            (tuning(8, 4, 4, 3), UVec2::new(257, 129)),
            (tuning(16, 8, 8, 8), UVec2::new(600, 400)),
        ] {
            let [open, shore] = [0, 1].map(|of| written(&gpu, tuning, cells, of));
            let count = |of: &[[bool; 2]]| of.iter().filter(|it| it[0]).count();
            assert!(count(&open) > 0 && count(&shore) > 0, "{cells}: one list has no tile");
            for (i, (open, shore)) in open.iter().zip(&shore).enumerate() {
                let by = [0, 1].map(|of| u32::from(open[of]) + u32::from(shore[of]));
                assert_eq!(by, [1, 1], "{cells}: height and velocity of column {i} are written so often");
            }
        }
    }
}
