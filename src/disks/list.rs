// SPDX-License-Identifier: MIT OR Apache-2.0
//! `list/seed`: the tutorial's records, lists and passes. Reads `glsl/disks/list*`.

use super::{spread, Disk, Error, Grid, Model, Params};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Result},
    shaders,
};
use glam::{DVec3, Vec2};
use std::ffi::CStr;

/// The tutorial's record: `ListDisk` in `glsl/disks/list.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct ListDisk {
    /// After the last move (m).
    pub at_m: Vec2,
    /// With the pushes of contacts (m).
    pub new_at_m: Vec2,
    /// After the last move (m/s).
    pub velocity_mps: Vec2,
    /// With what contacts did (m/s).
    pub new_velocity_mps: Vec2,
    /// (m).
    pub radius_m: f32,
    /// 1 when hit, and falls.
    pub temperature: f32,
    /// How many disks it touches.
    pub contacts: u32,
    /// Unused.
    pub unused: u32,
}

const GROUP: u32 = 256;
const NAMES: [&CStr; 4] =
    [c"disks.list_clear", c"disks.list_move", c"disks.list_position", c"disks.list_velocity"];

/// The kernels, for disks between walls.
pub struct List {
    kernels: [Kernel; 4],
    gpu: Gpu,
}

impl List {
    /// What the state must be visible to before [`ListState::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`ListState::record`] touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// If the device does not take the kernels.
    pub fn new(gpu: &Gpu) -> Result<Self> {
        const LISTS: &[&str] = &["Disks", "Head", "Next"];
        let kernel = |name, spv, blocks| {
            Kernel::new::<Params>(gpu, &KernelInfo { name, spv, blocks, constants: &[GROUP] })
        };
        let kernels = [
            kernel(NAMES[0], shaders::DISKS_LIST_CLEAR_COMP, &["Head"])?,
            kernel(NAMES[1], shaders::DISKS_LIST_MOVE_COMP, LISTS)?,
            kernel(NAMES[2], shaders::DISKS_LIST_POSITION_COMP, LISTS)?,
            kernel(NAMES[3], shaders::DISKS_LIST_VELOCITY_COMP, LISTS)?,
        ];
        Ok(Self { kernels, gpu: gpu.clone() })
    }

    /// A box at its start.
    ///
    /// # Errors
    /// Bad input, or the device's.
    ///
    /// # Panics
    /// If the model is not flat, or not between walls.
    pub fn state(&self, model: &Model, disks: &[Disk]) -> Result<ListState, Error> {
        assert_eq!(model.space, super::Space::Flat, "lists are of disks");
        assert_eq!(model.borders, super::Borders::Walls, "lists are of a box with walls");
        model.check(disks)?;
        let grid = Grid::of(model, disks.iter().map(|disk| disk.radius_m));
        let record = |disk: &Disk| {
            let (at, velocity) = (disk.at_m.as_vec3().truncate(), disk.velocity_mps.as_vec3().truncate());
            ListDisk {
                at_m: at,
                new_at_m: at,
                velocity_mps: velocity,
                new_velocity_mps: velocity,
                radius_m: disk.radius_m as f32,
                temperature: 0.0,
                contacts: 0,
                unused: 0,
            }
        };
        let records: Vec<ListDisk> = disks.iter().map(record).collect();
        let records = self.gpu.upload("disks.records", &records)?;
        let words = |name, count: usize| Buffer::new(&self.gpu, name, 4 * count as u64, Residence::Device);
        let (head, next) = (words("disks.head", grid.count())?, words("disks.next", disks.len())?);
        let lists = [("Disks", (&records).into()), ("Head", (&head).into()), ("Next", (&next).into())];
        let bound = [
            self.kernels[0].bind(&[("Head", (&head).into())])?,
            self.kernels[1].bind(&lists)?,
            self.kernels[2].bind(&lists)?,
            self.kernels[3].bind(&lists)?,
        ];
        Ok(ListState { bound, records, params: Params::new(model, &grid, disks), cells: grid.count() as u64 })
    }
}

/// A box on the GPU.
pub struct ListState {
    bound: [Bound; 4],
    records: Buffer,
    params: Params,
    cells: u64,
}

impl ListState {
    /// Records one step: `clear --B-- move --B-- position --B-- velocity`. Submits nothing, waits for nothing.
    pub fn record(&mut self, rec: &mut Recorder<'_>) {
        self.params.step += 1;
        let disks = u64::from(self.params.disks);
        for (pass, count) in [self.cells, disks, disks, disks].into_iter().enumerate() {
            if pass > 0 {
                rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
            }
            let threads = spread(count, GROUP);
            rec.span(NAMES[pass], |rec| rec.dispatch(&self.bound[pass], threads, &self.params));
        }
    }

    /// The records, in the order in which disks were given.
    pub fn records(&self) -> &Buffer {
        &self.records
    }

    /// The disks, in the order in which they were given.
    ///
    /// # Errors
    /// The device's.
    pub fn disks(&self, gpu: &Gpu) -> Result<Vec<Disk>> {
        let records: Vec<ListDisk> = gpu.download(&self.records)?;
        let disk = |r: &ListDisk| Disk {
            at_m: DVec3::from((r.at_m.as_dvec2(), 0.0)),
            velocity_mps: DVec3::from((r.velocity_mps.as_dvec2(), 0.0)),
            radius_m: f64::from(r.radius_m),
        };
        Ok(records.iter().map(disk).collect())
    }
}
