// SPDX-License-Identifier: MIT OR Apache-2.0
//! `sorted`: disks kept in the order of cells. Its kernels, which passes.rs names; state.rs steps a box with them.

mod passes;
mod state;

pub use state::SortedState;

use super::{Borders, Disk, Error, Model, Response, Space};
use crate::{
    gpu::{Access, Gpu, Kernel, KernelInfo, Result},
    prims::{Scan, Sums},
};
use passes::{Constants, Pass};

/// The kernels of a response. They hold no box, so one set steps any number of them.
pub struct Sorted {
    travel: Kernel,
    scan: Scan,
    slot: Kernel,
    gather: Kernel,
    respond: Vec<Kernel>,
    group: u32,
    space: Space,
    borders: Borders,
    response: Response,
    measures: bool,
    has_large: bool,
    gpu: Gpu,
}

impl Sorted {
    /// What the state must be visible to before [`SortedState::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`SortedState::record`] touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// For boxes like that of `model`. `has_large` says whether they may hold disks wider than a cell, `measures` whether
    /// impulses are summed, for pressures.
    ///
    /// # Errors
    /// If the device does not take the kernels.
    pub fn new(gpu: &Gpu, model: &Model, has_large: bool, measures: bool) -> Result<Self> {
        // 64, 128 and 256 are within 15 % of each other on an H100, and 256 the fastest but once (docs/disks.md).
        Self::tuned(gpu, model, has_large, measures, 256)
    }

    /// [`Sorted::new`] with workgroups of so many invocations: it changes no bit.
    ///
    /// # Errors
    /// If the device does not take the kernels.
    pub fn tuned(gpu: &Gpu, model: &Model, has_large: bool, measures: bool, group: u32) -> Result<Self> {
        let constants = Constants {
            group,
            periodic: model.borders == Borders::Periodic,
            has_large,
            measures,
            response: model.response,
        };
        let kernel = |pass: &Pass| {
            let info = KernelInfo {
                name: pass.names[usize::from(model.space == Space::Solid)],
                spv: pass.spv[usize::from(model.space == Space::Solid)],
                blocks: pass.blocks,
                constants: &constants.of(pass),
            };
            Kernel::new::<super::Params>(gpu, &info)
        };
        let respond = passes::responding(model.space, model.response);
        Ok(Self {
            travel: kernel(&passes::TRAVEL)?,
            scan: Scan::clearing(gpu, Sums::for_device(gpu))?,
            slot: kernel(&passes::SLOT)?,
            gather: kernel(&passes::GATHER)?,
            respond: respond.iter().map(|pass| kernel(pass)).collect::<Result<_>>()?,
            group,
            space: model.space,
            borders: model.borders,
            response: model.response,
            measures,
            has_large,
            gpu: gpu.clone(),
        })
    }

    /// A box at its start.
    ///
    /// # Errors
    /// Bad input, or the device's.
    ///
    /// # Panics
    /// If the kernels are of another space, other borders or another response, or without large disks where there are
    /// some.
    pub fn state(&self, model: &Model, disks: &[Disk]) -> Result<SortedState, Error> {
        SortedState::new(self, model, disks)
    }
}
