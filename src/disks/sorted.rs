// SPDX-License-Identifier: MIT OR Apache-2.0
//! `sorted`: disks kept in the order of cells. Reads `glsl/disks/{travel,slot,gather,...}`.

use super::{spread, Borders, Disk, Error, Grid, Model, Params, Response, Space, Stir};
use crate::{
    gpu::{Access, Bound, Buffer, Gpu, Kernel, KernelInfo, Recorder, Residence, Resource, Result},
    prims::{Scan, ScanBound, Sums, TILE},
    shaders,
};
use glam::{DVec3, Vec2, Vec3, Vec4};

/// `p.color` of the dispatch that has the contacts of large disks.
const LARGE_ONES: u32 = u32::MAX;

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

/// What binds to the kernels, by block.
struct Buffers {
    place: Buffer,
    motion: Buffer,
    new_place: Buffer,
    new_motion: Buffer,
    key: Buffer,
    count: Buffer,
    start: Buffer,
    slot: Buffer,
    partner: Buffer,
    wake: Buffer,
    hit: Buffer,
    impulse: Buffer,
}

impl Buffers {
    fn of(&self, block: &'static str) -> (&'static str, Resource<'_>) {
        let buffer = match block {
            "Place" => &self.place,
            "Motion" => &self.motion,
            "NewPlace" => &self.new_place,
            "NewMotion" => &self.new_motion,
            "Key" => &self.key,
            "Count" => &self.count,
            "Start" => &self.start,
            "Slot" => &self.slot,
            "Partner" => &self.partner,
            "Wake" => &self.wake,
            "Hit" => &self.hit,
            _ => &self.impulse,
        };
        (block, buffer.into())
    }

    fn bind(&self, kernel: &Kernel, blocks: &[&'static str]) -> Result<Bound> {
        let used: Vec<_> = blocks.iter().map(|block| self.of(block)).collect();
        kernel.bind(&used)
    }

    fn all(&self) -> [&Buffer; 12] {
        [
            &self.place,
            &self.motion,
            &self.new_place,
            &self.new_motion,
            &self.key,
            &self.count,
            &self.start,
            &self.slot,
            &self.partner,
            &self.wake,
            &self.hit,
            &self.impulse,
        ]
    }
}

const TRAVEL: &[&str] =
    &["Place", "Motion", "Start", "Partner", "Wake", "NewPlace", "NewMotion", "Key", "Count", "Impulse"];
const SLOT: &[&str] = &["Key", "Start", "Slot"];
const GATHER: &[&str] = &["Slot", "Start", "NewPlace", "NewMotion", "Place", "Motion"];
const CONTACTS: &[&str] = &["Place", "Start", "Partner", "Hit"];
const CONTACTS_SOLID: &[&str] = &["Place", "Start", "Partner", "Hit", "Motion"];
const PROPOSE: &[&str] = &["Place", "Motion", "Start", "Partner", "Wake"];
const COLLIDE: &[&str] = &["Place", "Motion", "Start", "Partner", "Wake", "Hit", "Impulse"];
const SWEEP: &[&str] = &["Place", "Motion", "Start", "Hit", "Impulse"];

fn respond_blocks(space: Space, response: Response) -> &'static [&'static [&'static str]] {
    match response {
        Response::Seed if space == Space::Flat => &[CONTACTS],
        Response::Seed => &[CONTACTS_SOLID],
        Response::GaussSeidel => &[SWEEP],
        Response::Matching { .. } => &[PROPOSE, COLLIDE],
    }
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
        let is_flat = model.space == Space::Flat;
        let (periodic, large, measured) =
            (u32::from(model.borders == Borders::Periodic), u32::from(has_large), u32::from(measures));
        let kernel = |flat, solid, flat_spv, solid_spv, blocks, constants: &[u32]| {
            let (name, spv) = if is_flat { (flat, flat_spv) } else { (solid, solid_spv) };
            let mut all = vec![group];
            all.extend(constants);
            Kernel::new::<Params>(gpu, &KernelInfo { name, spv, blocks, constants: &all })
        };
        let response = match model.response {
            Response::Seed => 0,
            Response::GaussSeidel => 1,
            Response::Matching { .. } => 2,
        };
        let respond = match model.response {
            Response::Seed => vec![kernel(
                c"disks.contacts",
                c"disks.contacts_solid",
                shaders::DISKS_CONTACTS_COMP,
                shaders::DISKS_CONTACTS_SOLID_COMP,
                respond_blocks(model.space, model.response)[0],
                &[periodic, large],
            )?],
            Response::GaussSeidel => vec![kernel(
                c"disks.sweep",
                c"disks.sweep_solid",
                shaders::DISKS_SWEEP_COMP,
                shaders::DISKS_SWEEP_SOLID_COMP,
                SWEEP,
                &[periodic, large, measured],
            )?],
            Response::Matching { rewinds, .. } => vec![
                kernel(
                    c"disks.propose",
                    c"disks.propose_solid",
                    shaders::DISKS_PROPOSE_COMP,
                    shaders::DISKS_PROPOSE_SOLID_COMP,
                    PROPOSE,
                    &[periodic, large, u32::from(rewinds)],
                )?,
                kernel(
                    c"disks.collide",
                    c"disks.collide_solid",
                    shaders::DISKS_COLLIDE_COMP,
                    shaders::DISKS_COLLIDE_SOLID_COMP,
                    COLLIDE,
                    &[periodic, large, u32::from(rewinds), measured],
                )?,
            ],
        };
        Ok(Self {
            travel: kernel(
                c"disks.travel",
                c"disks.travel_solid",
                shaders::DISKS_TRAVEL_COMP,
                shaders::DISKS_TRAVEL_SOLID_COMP,
                TRAVEL,
                &[periodic, large, response, measured],
            )?,
            scan: Scan::clearing(gpu, Sums::for_device(gpu))?,
            slot: kernel(
                c"disks.slot",
                c"disks.slot_solid",
                shaders::DISKS_SLOT_COMP,
                shaders::DISKS_SLOT_SOLID_COMP,
                SLOT,
                &[],
            )?,
            gather: kernel(
                c"disks.gather",
                c"disks.gather_solid",
                shaders::DISKS_GATHER_COMP,
                shaders::DISKS_GATHER_SOLID_COMP,
                GATHER,
                &[],
            )?,
            respond,
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
        assert_eq!(
            (model.space, model.borders, model.response),
            (self.space, self.borders, self.response),
            "the kernels are of another model"
        );
        model.check(disks)?;
        let grid = Grid::of(model, disks.iter().map(|disk| disk.radius_m));
        assert!(self.has_large || grid.large == 0, "{} disks are wider than a cell", grid.large);
        let (gpu, count) = (&self.gpu, disks.len());
        let mut order: Vec<u32> = (0..count as u32).collect();
        if grid.large > 0 {
            order.sort_by_key(|&i| disks[i as usize].radius_m <= grid.small_m); // large ones first
        }
        let (place, motion) = pack(model.space, order.iter().map(|&id| (id, &disks[id as usize])));

        let words = |name: &str, count: usize| Buffer::new(gpu, name, 4 * count as u64, Residence::Device);
        // One more than there are cells, for the end of the last.
        let cells = (grid.count() + 1).next_multiple_of(TILE as usize);
        let buffers = Buffers {
            new_place: words("disks.new_place_m", place.len())?,
            new_motion: words("disks.new_motion", motion.len())?,
            place: gpu.upload("disks.place_m", &place)?,
            motion: gpu.upload("disks.motion", &motion)?,
            key: words("disks.key", 2 * count)?,
            count: words("disks.count", cells)?,
            start: words("disks.start", cells)?,
            slot: words("disks.slot", count)?,
            partner: words("disks.partner", count)?,
            wake: words("disks.wake", count)?,
            hit: words("disks.hit", count)?,
            impulse: words("disks.impulse", if self.measures { 2 * count } else { 2 })?,
        };
        gpu.once(|rec| {
            for buffer in [&buffers.count, &buffers.start, &buffers.wake, &buffers.hit, &buffers.impulse] {
                rec.fill(buffer, 0);
            }
            rec.fill(&buffers.partner, super::cpu::NONE);
            rec.barrier(Access::FillWrite, Self::ENTRY);
        })?;
        let respond = self.respond.iter().zip(respond_blocks(self.space, self.response));
        Ok(SortedState {
            travel: buffers.bind(&self.travel, TRAVEL)?,
            scan: self.scan.bind(&buffers.count, &buffers.start)?,
            slot: buffers.bind(&self.slot, SLOT)?,
            gather: buffers.bind(&self.gather, GATHER)?,
            respond: respond.map(|(kernel, blocks)| buffers.bind(kernel, blocks)).collect::<Result<_>>()?,
            params: Params::new(model, &grid, count),
            group: self.group,
            space: self.space,
            response: self.response,
            cells: cells as u32,
            buffers,
        })
    }
}

/// A box on the GPU.
pub struct SortedState {
    travel: Bound,
    scan: ScanBound,
    slot: Bound,
    gather: Bound,
    respond: Vec<Bound>,
    buffers: Buffers,
    params: Params,
    group: u32,
    space: Space,
    response: Response,
    cells: u32,
}

impl SortedState {
    /// Records one step. Submits nothing, waits for nothing, allocates nothing. The barriers from and to the rest of the
    /// frame are the caller's: from [`Sorted::EXIT`] to [`Sorted::ENTRY`] where another step follows.
    pub fn record(&mut self, rec: &mut Recorder<'_>) {
        self.record_stirred(rec, None);
    }

    /// One step in which a point pushes.
    pub fn record_stirred(&mut self, rec: &mut Recorder<'_>, stir: Option<&Stir>) {
        self.params.step += 1;
        let p = self.params.stirred(stir);
        let all = spread(u64::from(p.disks), self.group);
        let between =
            |rec: &mut Recorder<'_>| rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        rec.span(c"disks.travel", |rec| rec.dispatch(&self.travel, all, &p));
        between(rec);
        self.scan.record(rec, self.cells); // from counts to starts; the counts are 0 again
        between(rec);
        rec.span(c"disks.slot", |rec| rec.dispatch(&self.slot, all, &p));
        between(rec);
        rec.span(c"disks.gather", |rec| rec.dispatch(&self.gather, all, &p));
        between(rec);
        match self.response {
            Response::Seed => rec.span(c"disks.contacts", |rec| rec.dispatch(&self.respond[0], all, &p)),
            Response::GaussSeidel => rec.span(c"disks.sweep", |rec| {
                if p.large > 0 {
                    rec.dispatch(&self.respond[0], [1, 1, 1], &Params { color: LARGE_ONES, ..p });
                    between(rec);
                }
                let colors = if self.space == Space::Flat { 9 } else { 27 };
                for color in 0..colors {
                    if color > 0 {
                        between(rec);
                    }
                    let [x, y, z, _] = p.cells.map(|n| u64::from(n.div_ceil(3)));
                    rec.dispatch(&self.respond[0], spread(x * y * z, self.group), &Params { color, ..p });
                }
            }),
            Response::Matching { rounds, .. } => {
                for round in 0..rounds {
                    if round > 0 {
                        between(rec);
                    }
                    let p = Params { is_first: u32::from(round == 0), ..p };
                    rec.span(c"disks.propose", |rec| rec.dispatch(&self.respond[0], all, &p));
                    between(rec);
                    rec.span(c"disks.collide", |rec| rec.dispatch(&self.respond[1], all, &p));
                }
            }
        }
    }

    /// Flat: x, y, radius, id; solid: x, y, z, radius (m).
    pub fn place(&self) -> &Buffer {
        &self.buffers.place
    }

    /// Flat: velocity; solid: velocity, id (m/s).
    pub fn motion(&self) -> &Buffer {
        &self.buffers.motion
    }

    /// By id: the step of the last hit, 0 for none.
    pub fn hits(&self) -> &Buffer {
        &self.buffers.hit
    }

    /// Steps recorded so far.
    pub fn steps(&self) -> u32 {
        self.params.step
    }

    /// The push constants of a step.
    pub fn params(&self) -> &Params {
        &self.params
    }

    /// Disks or spheres.
    pub fn space(&self) -> Space {
        self.space
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.scan.sums().bytes() + self.buffers.all().iter().map(|buffer| buffer.bytes()).sum::<u64>()
    }

    /// The disks, in the order in which they were given.
    ///
    /// # Errors
    /// The device's.
    pub fn disks(&self, gpu: &Gpu) -> Result<Vec<Disk>> {
        let place: Vec<Vec4> = gpu.download(&self.buffers.place)?;
        let nothing = Disk { at_m: DVec3::ZERO, velocity_mps: DVec3::ZERO, radius_m: 0.0 };
        let mut disks = vec![nothing; place.len()];
        match self.space {
            Space::Flat => {
                let motion: Vec<Vec2> = gpu.download(&self.buffers.motion)?;
                for (place, velocity) in place.iter().zip(motion) {
                    disks[place.w.to_bits() as usize] = Disk {
                        at_m: DVec3::new(place.x.into(), place.y.into(), 0.0),
                        velocity_mps: DVec3::from((velocity.as_dvec2(), 0.0)),
                        radius_m: place.z.into(),
                    };
                }
            }
            Space::Solid => {
                let motion: Vec<Vec4> = gpu.download(&self.buffers.motion)?;
                for (place, motion) in place.iter().zip(motion) {
                    disks[motion.w.to_bits() as usize] = Disk {
                        at_m: Vec3::from_slice(&place.to_array()).as_dvec3(),
                        velocity_mps: Vec3::from_slice(&motion.to_array()).as_dvec3(),
                        radius_m: place.w.into(),
                    };
                }
            }
        }
        Ok(disks)
    }

    /// Places, velocities and ids as they lie in memory: equal to the bit on every run.
    ///
    /// # Errors
    /// The device's.
    pub fn words(&self, gpu: &Gpu) -> Result<Vec<u32>> {
        let mut words: Vec<u32> = gpu.download(&self.buffers.place)?;
        words.extend(gpu.download::<u32>(&self.buffers.motion)?);
        Ok(words)
    }

    /// By id: the sum of impulse times distance of the centres over its pairs, of which each counts once, and of the
    /// impulses of walls; since the start.
    ///
    /// # Errors
    /// The device's.
    ///
    /// # Panics
    /// If the kernels do not measure.
    pub fn impulses(&self, gpu: &Gpu) -> Result<Vec<[f32; 2]>> {
        assert!(
            self.buffers.impulse.bytes() >= 8 * u64::from(self.params.disks),
            "the kernels do not measure"
        );
        gpu.download(&self.buffers.impulse)
    }

    /// All that the next step depends on.
    ///
    /// # Errors
    /// The device's.
    pub fn save(&self, gpu: &Gpu) -> Result<Vec<u32>> {
        let mut words = vec![self.params.step];
        for buffer in self.kept() {
            words.extend(gpu.download::<u32>(buffer)?);
        }
        Ok(words)
    }

    /// Goes on from what [`SortedState::save`] gave. `false` if it is of another box.
    ///
    /// # Errors
    /// The device's.
    pub fn restore(&mut self, gpu: &Gpu, words: &[u32]) -> Result<bool> {
        let needed = 1 + self.kept().iter().map(|buffer| buffer.bytes() / 4).sum::<u64>();
        if words.len() as u64 != needed {
            return Ok(false);
        }
        self.params.step = words[0];
        let mut rest = &words[1..];
        for buffer in self.kept() {
            let (mine, others) = rest.split_at(buffer.bytes() as usize / 4);
            gpu.upload_to(buffer, mine)?;
            rest = others;
        }
        Ok(true)
    }

    fn kept(&self) -> [&Buffer; 7] {
        let b = &self.buffers;
        [&b.place, &b.motion, &b.start, &b.partner, &b.wake, &b.hit, &b.impulse]
    }
}

/// Ids and disks as `place_m` and `motion` have them.
fn pack<'a>(space: Space, disks: impl Iterator<Item = (u32, &'a Disk)>) -> (Vec<f32>, Vec<f32>) {
    let (mut place, mut motion) = (Vec::new(), Vec::new());
    for (id, disk) in disks {
        let (at, velocity) = (disk.at_m.as_vec3(), disk.velocity_mps.as_vec3());
        let (radius, id) = (disk.radius_m as f32, f32::from_bits(id));
        match space {
            Space::Flat => {
                place.extend([at.x, at.y, radius, id]);
                motion.extend([velocity.x, velocity.y]);
            }
            Space::Solid => {
                place.extend([at.x, at.y, at.z, radius]);
                motion.extend([velocity.x, velocity.y, velocity.z, id]);
            }
        }
    }
    (place, motion)
}
