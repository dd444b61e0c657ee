// SPDX-License-Identifier: MIT OR Apache-2.0
//! The law `colliding`: ballistic flight in a scene that lies as planes in cells. Reads
//! `glsl/particles/{colliding,collide_look,colliding_flight,collide_sweep,collide_seed}.glsl` and `near.comp`.
//!
//! A pool of this law binds [`Surroundings::resources`]; `particles.near` runs once after each change of the cells. Between
//! impacts a particle is on an exact parabola, and the time of an impact a root of a quadratic, so energy does not depend on
//! the step. What is left out: a ball meets the rim of a plate a little late, when it is half in or its middle is
//! over it (it is then lifted out, at most half a radius a step); a cell holds two planes and borrows a third from its
//! neighbours, more are lost; particles do not turn, and do not see each other.

use super::{Invalid, Law, Options};
use crate::{
    cells::{Cells, Grid},
    gpu::{self, Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Resource},
    impact::Stream,
    shaders,
};
use glam::{vec3, Vec3};

/// How a particle meets the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd)]
#[repr(u32)]
pub enum Method {
    /// Looks up the cell it is in, is pushed out and reflected: the sample of 2007, with explicit Euler.
    Seed = 0,
    /// The same, unless it is leaving.
    Approach = 1,
    /// The same, and no step is longer than a cell.
    Substeps = 2,
    /// Sweeps through the cells, the first plane of each.
    OnePlane = 3,
    /// Sweeps, both planes of each.
    #[default]
    TwoPlanes = 4,
}

impl Method {
    /// All, in the order of what they add.
    pub const ALL: [Self; 5] = [Self::Seed, Self::Approach, Self::Substeps, Self::OnePlane, Self::TwoPlanes];

    /// As scenes and tables have it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Seed => "seed",
            Self::Approach => "approach",
            Self::Substeps => "substeps",
            Self::OnePlane => "dda1",
            Self::TwoPlanes => "dda2",
        }
    }

    /// That of a name.
    pub fn of(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|it| it.name() == name)
    }

    fn constants(self) -> &'static [u32] {
        const OF: [[u32; 1]; 5] = [[0], [1], [2], [3], [4]];
        &OF[self as usize]
    }
}

/// Numbers of the law: `CollidingLaw` in `glsl/particles/colliding.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Colliding {
    /// Where the cells are.
    pub grid: Grid,
    /// (m/s^2).
    pub gravity_mps2: Vec3,
    /// Of a particle (m), a hundredth of a cell or more.
    pub radius_m: f32,
    /// Part of the speed into a surface that comes back, 0 to 1. The seed's method keeps that part of the whole velocity.
    pub restitution: f32,
    /// Coulomb's coefficient, 0 or more.
    pub friction: f32,
    /// How deep a particle may lie in a plane before that counts (m).
    pub slack_m: f32,
    /// No surface is faster (m/s).
    pub surface_mps: f32,
    /// By how much the cells are ahead of the start of a step (s): 0 if voxelised as the scene is then, the step's length if
    /// as it is at its end.
    pub lead_s: f32,
    /// What impacts say.
    pub source: u32,
    /// Particles take turns to say `source`, `source` + 1 and so on: so many, 1 or more.
    pub sources: u32,
    /// 1: a particle below the floor begins anew, so that the population stays; 0: it falls on.
    pub respawns: u32,
    /// Height of the floor (m).
    pub floor_m: f32,
    /// Where it begins, as far as `emitter_radius_m` from here, at rest (m).
    pub emitter_m: Vec3,
    /// (m).
    pub emitter_radius_m: f32,
    /// Of the directions.
    pub seed: u32,
}

impl Colliding {
    /// Balls of `radius_m` that bounce to a quarter of their height, in a scene that does not move.
    pub fn new(grid: Grid, radius_m: f32) -> Self {
        let ([x, y, z], cells) = (grid.low_m, grid.cells.map(|n| n as f32 * grid.cell_m));
        let far = vec3(x, y, z).abs().max(vec3(x + cells[0], y + cells[1], z + cells[2]).abs());
        Self {
            grid,
            gravity_mps2: vec3(0.0, -9.81, 0.0),
            radius_m,
            restitution: 0.5,
            friction: 0.3,
            // What rounding does to a place, or a thousandth of the radius.
            slack_m: (1e-3 * radius_m).max(4.0 * f32::EPSILON * far.max_element()),
            surface_mps: 0.0,
            lead_s: 0.0,
            source: 0,
            sources: 1,
            respawns: 0,
            floor_m: 0.0,
            emitter_m: Vec3::ZERO,
            emitter_radius_m: 0.0,
            seed: 0,
        }
    }

    /// # Errors
    /// The first number that is out of range.
    pub fn check(&self) -> Result<(), Invalid> {
        let invalid = |key, value: String, allowed: String| Err(Invalid { key, value, allowed });
        if let Err(what) = self.grid.check() {
            return invalid("grid", what, "a grid of cells".into());
        }
        let (least, most) = (0.01 * self.grid.cell_m, 64.0 * self.grid.cell_m);
        if !(least..=most).contains(&self.radius_m) || self.radius_m < 4.0 * self.slack_m {
            let allowed = format!("{} m, or four times what rounding does, to {most} m", least);
            return invalid("radius_m", self.radius_m.to_string(), allowed);
        }
        let all = [self.gravity_mps2, self.emitter_m];
        if let Some(bad) = all.iter().find(|it| !it.is_finite()) {
            return invalid("gravity_mps2, emitter_m", bad.to_string(), "finite".into());
        }
        for (key, value, most) in [
            ("slack_m", self.slack_m, 1e6),
            ("restitution", self.restitution, 1.0),
            ("friction", self.friction, 1e6),
            ("surface_mps", self.surface_mps, 1e6),
            ("lead_s", self.lead_s, 1.0),
            ("emitter_radius_m", self.emitter_radius_m, 1e6),
        ] {
            if !(0.0..=most).contains(&value) {
                return invalid(key, value.to_string(), format!("0 to {most}"));
            }
        }
        if self.sources == 0 {
            return invalid("sources", "0".into(), "1 or more".into());
        }
        Ok(())
    }

    /// Cells that a particle of `speed_mps` can come to touch in a step of `dt_s`: what [`Surroundings::new`] is asked for,
    /// so that those that are no faster fly at the cost of one look. It is what is looked at round the middle of the way.
    pub fn reach_of(&self, speed_mps: f32, dt_s: f32) -> u32 {
        let fall = 0.5 * self.gravity_mps2.abs().max_element() * dt_s * dt_s;
        let far = 0.5 * (speed_mps * dt_s + fall) + 0.25 * fall + self.radius_m + self.slack_m;
        let pad = self.surface_mps * (dt_s + self.lead_s) + 0.128 * self.grid.cell_m;
        (((far + pad) / self.grid.cell_m).ceil() as u32).clamp(1, Surroundings::MOST_REACH)
    }

    /// Of the pool's own kernel, which only tells who flies freely: as for any short law.
    pub fn options(gpu: &Gpu) -> Options {
        Options::for_device(gpu)
    }

    /// The kernel of a method.
    pub fn law(method: Method) -> Law<'static> {
        Law {
            name: c"particles.colliding",
            spv: shaders::PARTICLES_COLLIDING_COMP,
            subgroups: None,
            deferred: (method >= Method::OnePlane)
                .then_some((c"particles.colliding_deferred", shaders::PARTICLES_COLLIDING_DEFERRED_COMP)),
            constants: method.constants(),
            blocks: &["Deferred", "Occupied", "Planes", "Near", "Impacts", "Count"],
        }
    }
}

/// What the slab round a corner of cells has, which a particle's one look asks. It changes who waits for the sweep, and no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slabs {
    /// What the eight cells round it have: found sooner, for cells that change in every step.
    OfEight,
    /// All that is felt within a cell of it: fewer wait, where cells stay as they are.
    OfAll,
}

impl Slabs {
    /// For cells that are filled anew in every step, or not.
    pub fn of(moves: bool) -> Self {
        if moves {
            Self::OfEight
        } else {
            Self::OfAll
        }
    }

    fn axis(self) -> u32 {
        match self {
            Self::OfEight => 4,
            Self::OfAll => 5,
        }
    }
}

/// Push constants: `NearParams` in `glsl/particles/near.comp`.
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

/// What pools of the law collide with: cells, and how far their corners are from an occupied one.
pub struct Surroundings {
    cells: Cells,
    near: Buffer,
    passes: [Bound; 5],
    reach: u32,
}

impl Surroundings {
    /// Most cells that are looked at on each side.
    pub const MOST_REACH: u32 = 14;

    const PLANES: u32 = 3;

    /// What the cells must be visible to before [`Surroundings::record`].
    pub const ENTRY: Access = Access::ComputeReadWrite;
    /// How [`Surroundings::record`] touched its own last.
    pub const EXIT: Access = Access::ComputeReadWrite;

    /// Of `cells`, looked at within `reach` cells, and with such slabs. Nothing is near before the first [`Surroundings::record`].
    ///
    /// # Errors
    /// The device's.
    ///
    /// # Panics
    /// If `reach` is not 1 to [`Surroundings::MOST_REACH`].
    pub fn new(gpu: &Gpu, cells: &Cells, reach: u32, slabs: Slabs) -> gpu::Result<Self> {
        assert!((1..=Self::MOST_REACH).contains(&reach), "a reach of {reach} cells");
        let [near, between] = Self::words(&cells.grid()).map(|words| 4 * words);
        let buffer = |name, bytes| Buffer::new(gpu, name, bytes, Residence::Device);
        let near = buffer("particles.near", near)?;
        let between = buffer("particles.near.between", between)?;
        gpu.once(|rec| {
            rec.fill(&near, u32::MAX);
            rec.fill(&between, 0);
        })?;
        let pass = |axis: u32, from: &Buffer, to: &Buffer| {
            let info = KernelInfo {
                name: c"particles.near",
                spv: shaders::PARTICLES_NEAR_COMP,
                blocks: &["Occupied", "Planes", "Extents", "From", "Near"],
                constants: &[axis],
            };
            Kernel::new::<NearParams>(gpu, &info)?.bind(&[
                ("Occupied", cells.occupied().into()),
                ("Planes", cells.planes().into()),
                ("Extents", cells.extents().into()),
                ("From", from.into()),
                ("Near", to.into()),
            ])
        };
        let passes = [
            pass(0, &between, &near)?,
            pass(1, &near, &between)?,
            pass(2, &between, &near)?,
            pass(Self::PLANES, &between, &near)?,
            pass(slabs.axis(), &near, &near)?,
        ];
        Ok(Self { cells: cells.clone(), near, passes, reach })
    }

    /// After each change of the cells, before the pools step.
    pub fn record(&self, rec: &mut Recorder<'_>) {
        let grid = self.cells.grid();
        let params = NearParams { cells: grid.cells, reach: self.reach, cell_m: grid.cell_m };
        rec.span(c"particles.near", |rec| {
            for (axis, pass) in (0..).zip(&self.passes) {
                // Which planes are met depends on no distance.
                if axis > 0 && axis != Self::PLANES {
                    rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
                }
                let bricks = grid.cells.iter().map(|cells| cells.div_ceil(4)).product();
                let groups = if axis >= Self::PLANES { bricks } else { grid.count().div_ceil(8 * 64) as u32 };
                let rows = groups.div_ceil(65_535).max(1);
                rec.dispatch(pass, [groups.div_ceil(rows) * 64, rows, 1], &params);
            }
        });
    }

    /// Bytes on the device beside the cells, for a grid.
    pub fn bytes(grid: &Grid) -> u64 {
        Self::words(grid).map(|words| 4 * words).iter().sum()
    }

    /// Of what is found, and of what lies between the passes: eight cells may begin in its last word.
    fn words(grid: &Grid) -> [u64; 2] {
        let count = grid.count() as u64;
        [count.div_ceil(8) + 5 * count, count.div_ceil(8) + 1]
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

    /// Cells within which it looks.
    pub fn reach(&self) -> u32 {
        self.reach
    }

    /// Four bits for the least corner of each cell: how many cells lie between it and the nearest occupied one; then four words a
    /// cell: its extents, and which planes are met in it; then a word a corner: a slab in which all lies that
    /// is felt within a cell of it, and how far it may be asked (`glsl/particles/cell_bits.glsl`).
    pub fn near(&self) -> &Buffer {
        &self.near
    }

    /// The cells.
    pub fn cells(&self) -> &Cells {
        &self.cells
    }
}
