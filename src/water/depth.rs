// SPDX-License-Identifier: MIT OR Apache-2.0
//! Water of any depth over ground, dry where there is none: what [`Wet`](super::Wet) and [`Shallow`](super::Shallow)
//! share. Reads `glsl/water/depth.glsl`, which says how a column is stored and why.
//!
//! A column is its ground, `bed_m`, and its `rise_m`: the water in it less that at rest. Where the ground is below the
//! level of the water at rest, the rise is that of the surface; where it is above, the rise is the depth. Volumes are
//! sums of rises, and no offset of heights costs a digit.

use super::{check_cells, check_heights, planes, Error, Invalid, Surface, Tuning, LAND_M};
use crate::{
    check::{hold, positive},
    gpu::{Access, Bound, Buffer, Gpu, Recorder, Residence, Result},
};
use glam::UVec2;
use std::{f64::consts::FRAC_1_SQRT_2, ffi::CStr};

/// Ground of a column that is a wall: `WALL_M` in `glsl/water/depth.glsl`.
pub const WALL_M: f32 = 1.0e30;

/// How water moves over ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Tier {
    /// Pipes as deep as the water above the ground: waves, floods and shores, but no bores. Flows are the state (m^2/s).
    Wet,
    /// The shallow-water equations: dam breaks and bores as well. Velocities are the state (m/s).
    Shallow,
}

/// Water over ground and how it is stepped, in physical units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthModel {
    /// Columns along x and z.
    pub cells: UVec2,
    /// Edge of a column (m).
    pub cell_m: f64,
    /// (m/s^2).
    pub gravity_mps2: f64,
    /// Deepest water there will be (m): with gravity the speed of the fastest wave.
    pub deepest_m: f64,
    /// Fastest current there will be (m/s). Only [`Tier::Shallow`] asks.
    pub fastest_mps: f64,
    /// Rate at which flow dies away (1/s).
    pub damping_per_s: f64,
    /// No water crosses a face where it would be shallower (m).
    pub thin_m: f64,
    /// Step (s), at most [`DepthModel::longest_stable_s`].
    pub dt_s: f64,
}

/// Push constants of the kernels: `DepthParams` in `glsl/water/depth.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct DepthParams {
    /// Size of the grid.
    pub cells: UVec2,
    /// Columns from one row to the next.
    pub pitch: u32,
    /// `dt / dx` (s/m).
    pub reach: f32,
    /// `g dt / dx` (1/s).
    pub pull: f32,
    /// `exp(-gamma dt)`.
    pub keep: f32,
    /// Falls on every column in this step (m): see [`Rain`].
    pub rain_m: f32,
    /// No water crosses a face where it would be shallower (m).
    pub thin_m: f32,
    /// `dx / dt` (m/s): water crosses no more than a column in a step.
    pub fastest_mps: f32,
}

impl Tier {
    /// Courant number of the longest step: of the fastest wave, `sqrt(g depth)`, for [`Tier::Wet`], and of it and the
    /// fastest current together for [`Tier::Shallow`], whose advection is explicit as well.
    pub fn courant_limit(self) -> f64 {
        match self {
            Self::Wet => FRAC_1_SQRT_2,
            Self::Shallow => 0.45,
        }
    }
}

impl Tier {
    /// How to cut up a grid: as many rows a walk as leave every lane of the device something to do, since each walk loads
    /// four more, or seven in [`Tier::Shallow`], whose groups are one lane high.
    pub fn tuning(self, gpu: &Gpu, cells: UVec2) -> Tuning {
        let (group, rows, fewest) = match (self, gpu.adapter().is_software()) {
            (Self::Wet, true) => (UVec2::new(64, 1), 8..=8, 1),
            (Self::Wet, false) => (UVec2::new(64, 2), 1..=16, 1 << 16),
            (Self::Shallow, true) => (UVec2::new(32, 1), 61..=61, 1),
            (Self::Shallow, false) => (UVec2::new(32, 1), 9..=61, 1 << 16),
        };
        let fours = u64::from(cells.x.div_ceil(4));
        let even = u32::try_from(u64::from(cells.y) * fours / fewest).unwrap_or(u32::MAX);
        Tuning { group, rows: even.clamp(*rows.start(), *rows.end()) }
    }
}

impl DepthModel {
    fn speed_mps(&self, tier: Tier) -> f64 {
        let wave = (self.gravity_mps2 * self.deepest_m).sqrt();
        wave + if tier == Tier::Shallow { self.fastest_mps } else { 0.0 }
    }

    /// Longest step for water no deeper and no faster than the model says (s).
    pub fn longest_stable_s(&self, tier: Tier) -> f64 {
        tier.courant_limit() * self.cell_m / self.speed_mps(tier)
    }

    /// Courant number of the chosen step.
    pub fn courant(&self, tier: Tier) -> f64 {
        self.speed_mps(tier) * self.dt_s / self.cell_m
    }

    /// The model with a step of `courant` cells.
    pub fn with_courant(self, tier: Tier, courant: f64) -> Self {
        Self { dt_s: courant * self.cell_m / self.speed_mps(tier), ..self }
    }

    /// # Errors
    /// The first parameter that is out of range.
    pub fn check(&self, tier: Tier) -> Result<(), Invalid> {
        check_cells(self.cells)?;
        positive("cell_m", self.cell_m)?;
        positive("gravity_mps2", self.gravity_mps2)?;
        positive("deepest_m", self.deepest_m)?;
        let is_speed = self.fastest_mps.is_finite() && self.fastest_mps >= 0.0;
        hold(is_speed, "fastest_mps", self.fastest_mps, "a finite number from 0")?;
        hold(
            (0.0..=1e6).contains(&self.damping_per_s),
            "damping_per_s",
            self.damping_per_s,
            "0 to 1e6 (1/s)",
        )?;
        hold((0.0..=1.0).contains(&self.thin_m), "thin_m", self.thin_m, "0 to 1 (m)")?;
        positive("dt_s", self.dt_s)?;
        let limit = self.longest_stable_s(tier);
        // A step computed as exactly the limit may come out above it by rounding.
        let allowed = format!(
            "at most {limit:.6} s, the longest step of {} m cells, water {} m deep and currents of {} m/s",
            self.cell_m, self.deepest_m, self.fastest_mps
        );
        hold(self.dt_s <= limit * (1.0 + 1e-12), "dt_s", self.dt_s, allowed)
    }

    /// Push constants of a dry step, for a state with `pitch` columns from row to row.
    pub fn params(&self, pitch: u32) -> DepthParams {
        DepthParams {
            cells: self.cells,
            pitch,
            reach: (self.dt_s / self.cell_m) as f32,
            pull: (self.gravity_mps2 * self.dt_s / self.cell_m) as f32,
            keep: (-self.damping_per_s * self.dt_s).exp() as f32,
            rain_m: 0.0,
            thin_m: self.thin_m as f32,
            fastest_mps: (self.cell_m / self.dt_s) as f32,
        }
    }
}

impl DepthParams {
    /// For the first step from a start at rest: half the pull brings the flow to the middle of the step, where the
    /// leapfrog wants it.
    pub fn first_from_rest(self) -> Self {
        Self { pull: 0.5 * self.pull, ..self }
    }

    /// The same step with rain.
    pub fn with_rain(self, rain_m: f32) -> Self {
        Self { rain_m, ..self }
    }
}

/// Rain as `f32` columns can take it. Rain of 10 mm/h is 3e-8 m in a step of 0.01 s, half of which is lost wherever the
/// surface is 0.5 m above rest: so it is saved up, and falls in whole drops of [`Rain::DROP_M`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rain {
    owed_m: f64,
}

impl Rain {
    /// A power of two, so that sums of it are exact (m).
    pub const DROP_M: f64 = 1.0 / 16384.0;

    /// What falls in a step of `dt_s` (s) at `rate_mps` (m/s); negative rates dry. For [`DepthParams::with_rain`].
    pub fn fall(&mut self, rate_mps: f64, dt_s: f64) -> f32 {
        self.owed_m += rate_mps * dt_s;
        let falls = (self.owed_m / Self::DROP_M).trunc() * Self::DROP_M;
        self.owed_m -= falls;
        falls as f32
    }

    /// What has not fallen yet (m).
    pub fn owed_m(&self) -> f64 {
        self.owed_m
    }
}

/// Ground and water, one number a column, without padding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// Ground, above the level of the water at rest (m).
    pub bed_m: Vec<f32>,
    /// Water less that at rest (m), [`LAND_M`] for a wall.
    pub rise_m: Vec<f32>,
    /// Through the east face of each column: flow (m^2/s) or velocity (m/s), as the [`Tier`] has it.
    pub east: Vec<f32>,
    /// Through the south face.
    pub south: Vec<f32>,
}

impl Columns {
    /// Water at rest below `surface_m`, dry ground above it; both above the level at rest (m). Rounded once.
    pub fn at_rest(bed_m: &[f64], surface_m: impl Fn(usize) -> f64) -> Self {
        let rise = |(i, &bed): (usize, &f64)| {
            let bed = f64::from(bed as f32);
            (surface_m(i).max(bed) - bed.max(0.0)) as f32
        };
        Self {
            bed_m: bed_m.iter().map(|&bed| bed as f32).collect(),
            rise_m: bed_m.iter().enumerate().map(rise).collect(),
            east: vec![0.0; bed_m.len()],
            south: vec![0.0; bed_m.len()],
        }
    }

    /// Depth of each column (m); below zero is a debt, see [`DepthState::columns`]. Walls have none.
    pub fn depths_m(&self) -> Vec<f64> {
        self.columns()
            .map(|(bed, rise)| if rise == LAND_M { 0.0 } else { still_m(bed) + f64::from(rise) })
            .collect()
    }

    /// Surface of each column above the level at rest, ground where it is dry (m).
    pub fn surfaces_m(&self) -> Vec<f64> {
        self.columns()
            .map(|(bed, rise)| f64::from(bed.max(0.0)) + f64::from(rise).max(-still_m(bed)))
            .collect()
    }

    fn columns(&self) -> impl Iterator<Item = (f32, f32)> + '_ {
        self.bed_m.iter().copied().zip(self.rise_m.iter().copied())
    }
}

/// Depth of the water at rest over ground at `bed_m` (m).
fn still_m(bed_m: f32) -> f64 {
    f64::from(-bed_m).max(0.0)
}

/// One basin. Row by row, rows padded to a multiple of four columns: column `(x, y)` is at `y * pitch + x`.
pub struct DepthState {
    rises: [Buffer; 2],
    /// Rise a step before that of the same place, where a tier asks for it.
    befores: Option<[Buffer; 2]>,
    flows: [Buffer; 2],
    bed: Buffer,
    steps: [Bound; 2],
    name: &'static CStr,
    current: usize,
    tier: Tier,
    cells: UVec2,
    pitch: u32,
    /// Invocations of a step.
    threads: UVec2,
}

/// What a step binds.
pub(super) struct Buffers<'a> {
    pub bed: &'a Buffer,
    pub rise: &'a Buffer,
    pub new_rise: &'a Buffer,
    /// The rise a step before; for a tier that does not ask, the rise.
    pub before: &'a Buffer,
    pub new_before: &'a Buffer,
    pub flow: &'a Buffer,
    pub new_flow: &'a Buffer,
}

impl DepthState {
    /// `bind` binds what a step reads and writes; `threads` are its invocations, for a pitch.
    pub(super) fn new(
        gpu: &Gpu,
        (tier, name): (Tier, &'static CStr),
        cells: UVec2,
        threads: impl Fn(u32) -> UVec2,
        bind: impl Fn(&Buffers<'_>) -> Result<Bound>,
    ) -> Result<Self> {
        let pitch = cells.x.next_multiple_of(4);
        let bytes = 4 * u64::from(pitch) * u64::from(cells.y);
        let buffer = |name: &str, floats: u64| Buffer::new(gpu, name, floats * bytes, Residence::Device);
        let bed = buffer("water.bed_m", 1)?;
        let rises = [buffer("water.rise_m.0", 1)?, buffer("water.rise_m.1", 1)?];
        let flows = [buffer("water.flow.0", 2)?, buffer("water.flow.1", 2)?];
        let befores = match tier {
            Tier::Wet => None,
            Tier::Shallow => Some([buffer("water.before_m.0", 1)?, buffer("water.before_m.1", 1)?]),
        };
        let asked = befores.as_ref().unwrap_or(&rises);
        let bind = |from: usize| {
            bind(&Buffers {
                bed: &bed,
                rise: &rises[from],
                new_rise: &rises[1 - from],
                before: &asked[from],
                new_before: &asked[1 - from],
                flow: &flows[from],
                new_flow: &flows[1 - from],
            })
        };
        let (steps, threads) = ([bind(0)?, bind(1)?], threads(pitch));
        Ok(Self { rises, befores, flows, bed, steps, name, current: 0, tier, cells, pitch, threads })
    }

    /// Records one step. Submits nothing, waits for nothing, allocates nothing. The barriers from and to the rest of the
    /// frame are the caller's: from [`DepthState::EXIT`] to [`DepthState::ENTRY`] where another step follows.
    ///
    /// # Panics
    /// If `params` are of another grid.
    pub fn record(&mut self, rec: &mut Recorder<'_>, params: &DepthParams) {
        assert_eq!(
            (params.cells, params.pitch),
            (self.cells, self.pitch),
            "grid of the parameters and of the state"
        );
        let (step, threads) = (&self.steps[self.current], [self.threads.x, self.threads.y, 1]);
        rec.span(self.name, |rec| rec.dispatch(step, threads, params));
        self.current = 1 - self.current;
    }

    /// What the state must be visible to before [`DepthState::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`DepthState::record`] touched it last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// How the water moves.
    pub fn tier(&self) -> Tier {
        self.tier
    }

    /// `f32` a column (m): see [`Columns::rise_m`].
    pub fn rise(&self) -> &Buffer {
        &self.rises[self.current]
    }

    /// `f32` a column (m): the rise a step before, where a tier asks for it. With rise, flow and bed it is the whole state.
    pub fn before(&self) -> Option<&Buffer> {
        self.befores.as_ref().map(|befores| &befores[self.current])
    }

    /// `f32` a column (m): see [`Columns::bed_m`], [`WALL_M`] for a wall.
    pub fn bed(&self) -> &Buffer {
        &self.bed
    }

    /// For each four columns of a row, four `f32` through their east faces and four through their south faces: see
    /// [`Columns::east`].
    pub fn flow(&self) -> &Buffer {
        &self.flows[self.current]
    }

    /// The flows of each of [`DepthState::surfaces`].
    pub fn flows(&self) -> [&Buffer; 2] {
        [0, 1].map(|i| &self.flows[i])
    }

    /// Columns from one row to the next.
    pub fn pitch(&self) -> u32 {
        self.pitch
    }

    /// The rise after the steps recorded so far, for disturbing, and for drawing where no ground is above the level at
    /// rest. A disturbance that takes more than a column holds leaves it in debt: see [`DepthState::columns`].
    pub fn surface(&self) -> Surface<'_> {
        self.surfaces()[self.current]
    }

    /// The two between which the steps go to and fro.
    pub fn surfaces(&self) -> [Surface<'_>; 2] {
        [0, 1].map(|i| Surface { cells: self.cells, height_m: &self.rises[i], pitch: self.pitch, stride: 1 })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        let befores = self.befores.as_ref().map_or(0, |befores| befores[0].bytes());
        self.bed.bytes() + 2 * (self.rises[0].bytes() + befores + self.flows[0].bytes())
    }

    /// Sets ground and water.
    ///
    /// # Errors
    /// [`Error::Invalid`] if a number is not finite, a column holds less than no water, or the sizes differ, else the
    /// device's.
    pub fn upload(&self, gpu: &Gpu, columns: &Columns) -> Result<(), Error> {
        let fields = [
            ("bed_m", &columns.bed_m),
            ("rise_m", &columns.rise_m),
            ("east", &columns.east),
            ("south", &columns.south),
        ];
        for (key, numbers) in fields {
            check_heights(key, numbers, self.cells, key == "rise_m")?;
        }
        if let Some(i) = columns.depths_m().iter().position(|depth| *depth < 0.0) {
            let value = format!("{} in cell {i}", columns.rise_m[i]);
            let allowed = format!("no less than {}, which is dry", -still_m(columns.bed_m[i]));
            return Err(Invalid { key: "rise_m", value, allowed }.into());
        }
        let padded = |plain: &[f32], padding| planes::padded(plain, self.cells, self.pitch, padding);
        let bed: Vec<f32> =
            columns.columns().map(|(bed, rise)| if rise == LAND_M { WALL_M } else { bed }).collect();
        gpu.upload_to(&self.bed, &padded(&bed, WALL_M))?;
        let rise = padded(&columns.rise_m, LAND_M);
        gpu.upload_to(self.rise(), &rise)?;
        if let Some(befores) = &self.befores {
            gpu.upload_to(&befores[self.current], &rise)?;
        }
        let (east, south) = (padded(&columns.east, 0.0), padded(&columns.south, 0.0));
        let fours: Vec<f32> =
            east.chunks(4).zip(south.chunks(4)).flat_map(|(e, s)| [e, s].concat()).collect();
        gpu.upload_to(self.flow(), &fours)?;
        Ok(())
    }

    /// Ground and water. A rise below that of a dry column is a debt, left by a sink that took more than there was:
    /// nothing flows out until what flows in has paid it, so that volumes stay exact and nothing is cut off in silence.
    ///
    /// # Errors
    /// The device's.
    pub fn columns(&self, gpu: &Gpu) -> Result<Columns> {
        let plain = |padded: &[f32]| planes::plain(padded, self.cells, self.pitch);
        let flows = gpu.download::<f32>(self.flow())?;
        let of = |side: usize| -> Vec<f32> {
            plain(
                &flows
                    .chunks_exact(8)
                    .flat_map(|both| &both[4 * side..4 * side + 4])
                    .copied()
                    .collect::<Vec<_>>(),
            )
        };
        Ok(Columns {
            bed_m: plain(&gpu.download(&self.bed)?),
            rise_m: plain(&gpu.download(self.rise())?),
            east: of(0),
            south: of(1),
        })
    }
}
