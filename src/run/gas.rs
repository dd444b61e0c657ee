// SPDX-License-Identifier: MIT OR Apache-2.0
//! A box of disks of a scene, on the GPU.

use super::{checkpoint::fnv, live::Counters, stats::DisksStats, RunError};
use crate::{
    clock::FixedStep,
    disks::{draw::DisksDraw, oracle, starts::Start, Grid, Sorted, SortedState, Stir},
    draw::Stage,
    gpu::{Access, Gpu, Recorder},
    scene::{DisksScene, Scene},
};

/// Disks times steps of a submission.
const DISK_STEPS: u64 = 1 << 24;

pub(super) struct Gas {
    name: String,
    state: SortedState,
    start: Start,
    draw: DisksDraw,
    clock: FixedStep,
    taken: u64,
    /// In the steps of the next picture.
    stir: Option<Stir>,
}

impl Gas {
    pub fn new(gpu: &Gpu, stage: &Stage, disks: &DisksScene, scene: &Scene) -> Result<Self, RunError> {
        let start = disks.start(scene.seed);
        start.model.check(&start.disks).map_err(crate::disks::Error::from)?;
        let mut start = start;
        start.model = start.model.cut(start.model.substeps(&start.disks));
        let grid = Grid::of(&start.model, start.disks.iter().map(|disk| disk.radius_m));
        let state =
            Sorted::new(gpu, &start.model, grid.large > 0, false)?.state(&start.model, &start.disks)?;
        let draw = DisksDraw::new(gpu, stage, &state, disks.origin_m())?;
        let clock = FixedStep::new(start.model.dt_s, u32::MAX);
        Ok(Self { name: disks.name.clone(), state, start, draw, clock, taken: 0, stir: None })
    }

    pub fn advance(&mut self, frame_s: f64) {
        self.clock.advance(frame_s);
    }

    /// Whether one submission holds the steps that are due.
    pub fn is_nearly_due(&self) -> bool {
        self.clock.steps() - self.taken <= self.most_steps()
    }

    fn most_steps(&self) -> u64 {
        (DISK_STEPS / self.start.disks.len() as u64).max(1)
    }

    /// Records steps that are due; `false` if some are left for another submission.
    pub fn record(&mut self, rec: &mut Recorder<'_>) -> bool {
        let due = (self.clock.steps() - self.taken).min(self.most_steps());
        for _ in 0..due {
            rec.barrier(Access::GraphicsRead, Access::ComputeWrite); // the last picture may be on its way
            rec.barrier(Sorted::EXIT, Sorted::ENTRY);
            self.state.record_stirred(rec, self.stir.as_ref());
        }
        self.taken += due;
        self.taken == self.clock.steps()
    }

    /// A point pushes from now on; `None` ends it.
    pub fn stir(&mut self, stir: Option<Stir>) {
        self.stir = stir;
    }

    /// Goes on with the disks of `old`, which are as many and as large.
    pub fn go_on_from(&mut self, gpu: &Gpu, old: &Self) -> Result<(), RunError> {
        if self.state.restore(gpu, &old.state.save(gpu)?)? && self.clock.dt_s() == old.clock.dt_s() {
            (self.clock, self.taken) = (old.clock.clone(), old.taken);
        }
        Ok(())
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn steps(&self) -> u64 {
        self.taken
    }

    pub fn before_drawing(&self, rec: &mut Recorder<'_>) {
        rec.barrier(Sorted::EXIT, DisksDraw::ENTRY);
    }

    pub fn draw(&self, rec: &mut Recorder<'_>) {
        self.draw.record(rec, &self.state);
    }

    pub fn hash(&self, gpu: &Gpu) -> Result<String, RunError> {
        let words = self.state.words(gpu)?;
        Ok(format!("{:016x}", fnv(bytemuck::cast_slice::<_, u8>(&words).iter().copied())))
    }

    /// Words, floats in name only.
    pub fn state(&self, gpu: &Gpu) -> Result<Vec<f32>, RunError> {
        Ok(self.state.save(gpu)?.into_iter().map(f32::from_bits).collect())
    }

    /// Goes on from a state after `pictures` of `frame_s`. `false` if it is of another box.
    pub fn restore(
        &mut self,
        gpu: &Gpu,
        state: &[f32],
        pictures: u32,
        frame_s: f64,
    ) -> Result<bool, RunError> {
        let words: Vec<u32> = state.iter().map(|x| x.to_bits()).collect();
        if !self.state.restore(gpu, &words)? {
            return Ok(false);
        }
        self.clock = FixedStep::new(self.clock.dt_s(), u32::MAX);
        for _ in 0..pictures {
            self.clock.advance(frame_s);
        }
        self.taken = self.clock.steps();
        Ok(true)
    }

    pub fn counters(&self) -> Counters {
        let counts = vec![("steps", self.taken), ("disks", self.start.disks.len() as u64)];
        Counters { name: self.name.clone(), counts }
    }

    pub fn stats(&self, gpu: &Gpu) -> Result<DisksStats, RunError> {
        let model = &self.start.model;
        let before = oracle::total_energy(model, &self.start.disks);
        let after = oracle::total_energy(model, &self.state.disks(gpu)?);
        Ok(DisksStats {
            name: self.name.clone(),
            count: self.start.disks.len() as u64,
            packing: model.packing(&self.start.disks),
            steps: self.taken,
            dt_s: model.dt_s,
            energy_drift: if before > 0.0 { after / before - 1.0 } else { 0.0 },
            state_hash: self.hash(gpu)?,
        })
    }
}
