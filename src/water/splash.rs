// SPDX-License-Identifier: MIT OR Apache-2.0
//! Impacts as disturbances, without the host in between. Reads `glsl/water/splash.comp`.

use super::{disturb::HEADER_BYTES, DisturbParams, Disturbance, Disturbances, Surface};
use crate::{
    gpu::{self, Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder},
    impact::{Count, Stream},
    shaders,
};
use glam::{UVec2, Vec2};

/// Push constants: `SplashParams` in `glsl/water/splash.comp`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SplashParams {
    /// Size of the grid.
    pub cells: UVec2,
    /// Columns from one row to the next.
    pub pitch: u32,
    /// Floats from one column to the next.
    pub stride: u32,
    /// Of the grid, x and z in the world (m).
    pub corner_m: Vec2,
    /// Edge of a column (m).
    pub cell_m: f32,
    /// Of the disc that an impact acts on (m).
    pub radius_m: f32,
    /// That an impact brings (m^3).
    pub volume_m3: f32,
    /// Times the speed that an impact loses: the water that it moves outwards (m^2).
    pub push_m2: f32,
    /// Disturbances an impact: 2 with momentum, else 1.
    pub items: u32,
    /// Unused.
    pub reserved: u32,
}

/// What an impact is to a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Of the disc of the surface that it acts on (m): a column at the least, where there is momentum.
    pub radius_m: f64,
    /// Of what hits (m^3).
    pub volume_m3: f64,
    /// Its volume stays in the water.
    pub volume: bool,
    /// Its momentum acts, on water of this depth (m): for surfaces with a velocity.
    pub momentum_in_m: Option<f64>,
}

impl SplashParams {
    /// For a surface whose grid has its corner at `corner_m`, x and z in the world.
    pub fn new(surface: &Surface<'_>, cell_m: f64, corner_m: Vec2, hit: &Hit) -> Self {
        let push_m2 = |depth_m: f64| 16.0 / 3.0 * depth_m * hit.volume_m3 / (hit.radius_m * hit.radius_m);
        Self {
            cells: surface.cells,
            pitch: surface.pitch,
            stride: surface.stride,
            corner_m,
            cell_m: cell_m as f32,
            radius_m: hit.radius_m as f32,
            volume_m3: if hit.volume { hit.volume_m3 as f32 } else { 0.0 },
            push_m2: hit.momentum_in_m.map_or(0.0, push_m2) as f32,
            items: if hit.momentum_in_m.is_some() { 2 } else { 1 },
            reserved: 0,
        }
    }
}

/// What became of impacts since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct SplashCounts {
    taken_low: u32,
    taken_high: u32,
    missed_low: u32,
    missed_high: u32,
}

impl SplashCounts {
    /// These.
    pub fn new(taken: u64, missed: u64) -> Self {
        Self {
            taken_low: taken as u32,
            taken_high: (taken >> 32) as u32,
            missed_low: missed as u32,
            missed_high: (missed >> 32) as u32,
        }
    }

    /// Over water: they became disturbances.
    pub fn taken(&self) -> u64 {
        u64::from(self.taken_high) << 32 | u64::from(self.taken_low)
    }

    /// On land, or outside the grid.
    pub fn missed(&self) -> u64 {
        u64::from(self.missed_high) << 32 | u64::from(self.missed_low)
    }
}

/// The kernel.
pub struct Splash {
    kernel: Kernel,
    gpu: Gpu,
}

impl Splash {
    /// What stream and list must be visible to before [`Splashing::record`], as well as to [`Access::IndirectRead`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Splashing::record`] touched them last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// # Errors
    /// If the device cannot build the kernel.
    pub fn new(gpu: &Gpu) -> gpu::Result<Self> {
        let info = KernelInfo {
            name: c"water.splash",
            spv: shaders::WATER_SPLASH_COMP,
            blocks: &["Impacts", "Count", "Height", "Disturbances", "Counters"],
            constants: &[],
        };
        Ok(Self { kernel: Kernel::new::<SplashParams>(gpu, &info)?, gpu: gpu.clone() })
    }

    /// From `stream` into `list`, on `surfaces`, the two between which a model goes to and fro.
    ///
    /// # Errors
    /// The device's.
    ///
    /// # Panics
    /// If the list has no room for `items` disturbances of each impact that the stream has room for.
    pub fn bind(
        &self,
        stream: &Stream,
        surfaces: [Surface<'_>; 2],
        list: Disturbances,
        items: u32,
    ) -> gpu::Result<Splashing> {
        let room = u64::from(list.capacity());
        assert!(u64::from(items) * u64::from(stream.capacity()) <= room, "a list of {room} disturbances");
        let counters = self.gpu.upload("water.splash_counts", &[SplashCounts::default()])?;
        let bind = |surface: &Surface<'_>| -> gpu::Result<_> {
            let bound = self.kernel.bind(&[
                ("Impacts", stream.impacts().into()),
                ("Count", stream.count().into()),
                ("Height", surface.height_m.into()),
                ("Disturbances", list.list().into()),
                ("Counters", (&counters).into()),
            ])?;
            Ok((surface.height_m.clone(), bound))
        };
        let bound = [bind(&surfaces[0])?, bind(&surfaces[1])?];
        Ok(Splashing {
            bound,
            arguments: stream.count().clone(),
            list,
            counters,
            items,
            gpu: self.gpu.clone(),
        })
    }
}

/// A stream of impacts on its way into a water.
pub struct Splashing {
    bound: [(Buffer, Bound); 2],
    arguments: Buffer,
    list: Disturbances,
    counters: Buffer,
    items: u32,
    gpu: Gpu,
}

impl Splashing {
    /// Records what the impacts of a step do to the surface, after [`Stream::record_end`]:
    /// clear --B-- splash --B-- weigh --B-- disturb. Submits nothing, waits for nothing, allocates nothing.
    ///
    /// # Panics
    /// If `surface` is not one of the two, or parameters are of another grid or of other impacts.
    pub fn record(
        &self,
        rec: &mut Recorder<'_>,
        surface: &Surface<'_>,
        params: &SplashParams,
        disturb: &DisturbParams,
    ) {
        let (_, bound) =
            self.bound.iter().find(|(height, _)| height.is(surface.height_m)).expect("its surface");
        let (asked, there) =
            ((params.cells, params.pitch, params.stride), (surface.cells, surface.pitch, surface.stride));
        assert_eq!(asked, there, "grid of the parameters and of the surface");
        assert_eq!(params.items, self.items, "disturbances an impact");
        let both = Access::ComputeReadWrite;
        // Without impacts no workgroup runs that would write the header.
        rec.barrier(both, Access::FillWrite);
        rec.barrier(Access::IndirectRead, Access::FillWrite);
        rec.update(self.list.list(), &[0u32, 1, 1, 0]);
        rec.barrier(Access::FillWrite, both);
        rec.span(c"water.splash", |rec| rec.dispatch_indirect(bound, &self.arguments, Count::GROUPS, params));
        rec.barrier(both, both);
        rec.barrier(both, Access::IndirectRead);
        rec.barrier(Access::FillWrite, Access::IndirectRead);
        self.list.record_listed(rec, surface, disturb);
    }

    /// The disturbances.
    pub fn list(&self) -> &Disturbances {
        &self.list
    }

    /// [`SplashCounts`].
    pub fn counters(&self) -> &Buffer {
        &self.counters
    }

    /// What became of the impacts so far.
    ///
    /// # Errors
    /// The device's.
    pub fn counts(&self) -> gpu::Result<SplashCounts> {
        Ok(self.gpu.download::<SplashCounts>(&self.counters)?[0])
    }

    /// The disturbances of the last step, in their order. Submits and waits.
    ///
    /// # Errors
    /// The device's.
    pub fn download(&self) -> gpu::Result<Vec<Disturbance>> {
        let words: Vec<u32> = self.gpu.download(self.list.list())?;
        let all: &[Disturbance] = bytemuck::cast_slice(&words[HEADER_BYTES / 4..]);
        Ok(all[..words[0] as usize].to_vec())
    }
}
