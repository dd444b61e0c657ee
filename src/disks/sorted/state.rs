// SPDX-License-Identifier: MIT OR Apache-2.0
//! A box of sorted disks on the GPU: its buffers, its steps, and what can be read back.

use super::{
    passes::{responding, Pass, GATHER, SLOT, TRAVEL},
    Sorted,
};
use crate::{
    disks::{cpu::NONE, spread, Disk, Error, Grid, Model, Params, Response, Space, Stir},
    gpu::{Access, Bound, Buffer, Gpu, Kernel, Recorder, Residence, Resource, Result},
    prims::{ScanBound, TILE},
};
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::ffi::CStr;

/// `p.color` of the dispatch that has the contacts of large disks.
const LARGE_ONES: u32 = u32::MAX;

/// Ids lie among floats, with this bit: `glsl/disks/id.glsl`.
const ID_BIT: u32 = 0x4000_0000;

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

    fn bind(&self, kernel: &Kernel, pass: &Pass) -> Result<Bound> {
        let used: Vec<_> = pass.blocks.iter().map(|block| self.of(block)).collect();
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
    /// [`Sorted::state`].
    pub(super) fn new(kernels: &Sorted, model: &Model, disks: &[Disk]) -> Result<Self, Error> {
        assert_eq!(
            (model.space, model.borders, model.response),
            (kernels.space, kernels.borders, kernels.response),
            "the kernels are of another model"
        );
        model.check(disks)?;
        let grid = Grid::of(model, disks.iter().map(|disk| disk.radius_m));
        assert!(kernels.has_large || grid.large == 0, "{} disks are wider than two cells", grid.large);
        let (gpu, count) = (&kernels.gpu, disks.len());
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
            impulse: words("disks.impulse", if kernels.measures { 2 * count } else { 2 })?,
        };
        gpu.once(|rec| {
            for buffer in [&buffers.count, &buffers.start, &buffers.wake, &buffers.hit, &buffers.impulse] {
                rec.fill(buffer, 0);
            }
            rec.fill(&buffers.partner, NONE);
            rec.barrier(Access::FillWrite, Sorted::ENTRY);
        })?;
        let respond = kernels.respond.iter().zip(responding(kernels.space, kernels.response));
        Ok(Self {
            travel: buffers.bind(&kernels.travel, &TRAVEL)?,
            scan: kernels.scan.bind(&buffers.count, &buffers.start)?,
            slot: buffers.bind(&kernels.slot, &SLOT)?,
            gather: buffers.bind(&kernels.gather, &GATHER)?,
            respond: respond.map(|(kernel, pass)| buffers.bind(kernel, pass)).collect::<Result<_>>()?,
            params: Params::new(model, &grid, disks),
            group: kernels.group,
            space: kernels.space,
            response: kernels.response,
            cells: cells as u32,
            buffers,
        })
    }

    /// Records one step. Submits nothing, waits for nothing, allocates nothing. The barriers from and to the rest of the
    /// frame are the caller's: from [`Sorted::EXIT`] to [`Sorted::ENTRY`] where another step follows.
    pub fn record(&mut self, rec: &mut Recorder<'_>) {
        self.record_stirred(rec, None);
    }

    /// One step in which a point pushes, no disk beyond [`Model::stirred_mps`].
    ///
    /// # Panics
    /// If a number of `stir` is none.
    pub fn record_stirred(&mut self, rec: &mut Recorder<'_>, stir: Option<&Stir>) {
        stir.into_iter().for_each(Stir::assert_finite);
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
            Response::GaussSeidel => self.record_colors(rec, c"disks.sweep", &self.respond[0], &p),
            Response::Xpbd { bounces } => {
                // What the pushes start from; `new_place` is free once it is gathered.
                rec.barrier(Access::ComputeReadWrite, Access::CopyRead);
                rec.barrier(Access::ComputeReadWrite, Access::CopyWrite);
                rec.span(c"disks.keep", |rec| rec.copy(&self.buffers.place, &self.buffers.new_place));
                rec.barrier(Access::CopyRead, Access::ComputeReadWrite);
                rec.barrier(Access::CopyWrite, Access::ComputeReadWrite);
                self.record_colors(rec, c"disks.xpbd_part", &self.respond[0], &p);
                between(rec);
                rec.span(c"disks.xpbd_derive", |rec| rec.dispatch(&self.respond[1], all, &p));
                if bounces {
                    between(rec);
                    self.record_colors(rec, c"disks.xpbd_bounce", &self.respond[2], &p);
                }
            }
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

    /// The contacts of large disks, then one colour of cells after the other: `glsl/disks/colors.glsl`.
    fn record_colors(&self, rec: &mut Recorder<'_>, name: &'static CStr, pass: &Bound, p: &Params) {
        let colors = if self.space == Space::Flat { 9 } else { 27 };
        let [x, y, z, _] = p.cells.map(|n| u64::from(n.div_ceil(3)));
        let cells = spread(x * y * z, self.group);
        rec.span(name, |rec| {
            if p.large > 0 {
                rec.dispatch(pass, [1, 1, 1], &Params { color: LARGE_ONES, ..*p });
                rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
            }
            for color in 0..colors {
                if color > 0 {
                    rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
                }
                rec.dispatch(pass, cells, &Params { color, ..*p });
            }
        });
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
                    disks[id_of(place.w)] = Disk {
                        at_m: DVec3::new(place.x.into(), place.y.into(), 0.0),
                        velocity_mps: DVec3::from((velocity.as_dvec2(), 0.0)),
                        radius_m: place.z.into(),
                    };
                }
            }
            Space::Solid => {
                let motion: Vec<Vec4> = gpu.download(&self.buffers.motion)?;
                for (place, motion) in place.iter().zip(motion) {
                    disks[id_of(motion.w)] = Disk {
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

fn id_of(word: f32) -> usize {
    (word.to_bits() & !ID_BIT) as usize
}

/// Ids and disks as `place_m` and `motion` have them.
fn pack<'a>(space: Space, disks: impl Iterator<Item = (u32, &'a Disk)>) -> (Vec<f32>, Vec<f32>) {
    let (mut place, mut motion) = (Vec::new(), Vec::new());
    for (id, disk) in disks {
        let (at, velocity) = (disk.at_m.as_vec3(), disk.velocity_mps.as_vec3());
        let (radius, id) = (disk.radius_m as f32, f32::from_bits(id | ID_BIT));
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
