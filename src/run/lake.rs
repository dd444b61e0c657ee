// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{
    basin::Basin,
    checkpoint::fnv,
    falls::Falls,
    live::Counters,
    splashes::{Drops, Ripples},
    stats::{SplashStats, WaterStats},
    RunError,
};
use crate::{
    ballistic::Moment,
    clock::FixedStep,
    draw::Stage,
    gpu::{Access, Buffer, Gpu, Recorder},
    scene::{self, WaterPlan, WaterScene},
    water::{
        self as sim,
        draw::{Look, SurfaceDraw, SurfaceParams},
        Absorb, Absorbing, Bodies, Body, BodyList, BodyParams, Counts, Disturb, DisturbParams, Disturbance,
        Disturbances,
    },
};
use glam::{dvec3, DVec3, UVec2, Vec2, Vec3};

/// Slope of the ripples that a grid is too coarse for, in the shaded look.
const RIPPLE: f32 = 0.035;
/// Depth below which there is foam, where the water is deep enough for some (m).
const FOAM_M: f64 = 0.22;

/// Columns times steps of a submission: a tenth of a second on a small GPU.
const COLUMN_STEPS: u64 = 1 << 28;
/// Disturbances that a step takes; what is more is counted as dropped.
const FALLS_A_STEP: usize = 4096;

/// Speed above which water is white where it runs faster than its waves (m/s).
const WHITE_MPS: f32 = 1.6;

/// Bodies on their ways.
struct Fleet {
    bodies: Vec<Body>,
    /// Corner of the grid at the level of rest, in the world (m).
    origin_m: DVec3,
    list: BodyList,
}

/// How a basin is disturbed.
fn disturb_params(basin: &Basin, cells: UVec2, cell_m: f64, depth_m: f64) -> DisturbParams {
    let surface = basin.surface();
    DisturbParams {
        cells,
        pitch: surface.pitch,
        stride: surface.stride,
        cell_m: cell_m as f32,
        // A wave higher than the water is deep is beyond the model by far.
        limit_m: (4.0 * depth_m).max(10.0) as f32,
        has_velocity: u32::from(basin.velocities()[0].is_some()),
    }
}

/// For what falls into a basin, or is thrown.
fn list_of(
    gpu: &Gpu,
    basin: &Basin,
    params: DisturbParams,
) -> Result<(Disturbances, DisturbParams), sim::Error> {
    Ok((Disturb::new(gpu)?.list_of(basin.surfaces(), basin.velocities(), scene::DISTURBANCES)?, params))
}

/// One water of a scene, on the GPU.
pub(super) struct Lake {
    name: String,
    variant: String,
    basin: Basin,
    clock: FixedStep,
    /// Time of the scene when the clock began (s): of another lake's, if it goes on from one.
    since_s: f64,
    falls: Falls,
    list: Option<(Disturbances, DisturbParams)>,
    /// What lands in it.
    ripples: Vec<Ripples>,
    fleet: Option<Fleet>,
    absorbing: Option<Absorbing>,
    draw: SurfaceDraw,
    surface: SurfaceParams,
    depth_m: f64,
    /// The basin may fall dry.
    draws_ground: bool,
    start_gain_m3: f64,
    start_energy: Option<f64>,
    given_m3: f64,
    not_listed: u64,
    /// Of a step, in columns: its own, and what impacts take to be ordered, eight comparisons a column.
    work: u64,
    /// Steps that are recorded.
    taken: u64,
    /// What someone has thrown in, for the next step.
    thrown: Vec<Disturbance>,
}

impl Lake {
    pub fn new(
        gpu: &Gpu,
        stage: &Stage,
        water: &WaterScene,
        plan: &WaterPlan,
        look: Look,
        (seed, stream): (u64, u64),
        ground_m: Option<&Buffer>,
    ) -> Result<Self, sim::Error> {
        let simulation = &plan.simulation;
        let (cells, cell_m, dt_s) = (simulation.cells(), simulation.cell_m(), simulation.dt_s());
        let basin = Basin::new(gpu, simulation)?;
        let surface = basin.surface();
        let (pitch, stride) = (surface.pitch, surface.stride);
        let depth_m = water.depth_m;
        let disturb = disturb_params(&basin, cells, cell_m, depth_m);
        let list = plan.is_disturbed.then(|| list_of(gpu, &basin, disturb)).transpose()?;
        let ripples = plan.splashes.iter().zip(&water.splashes).map(|(plan, scene)| {
            let ground_m = ground_m.expect("a scene whose drops land has a ground");
            let drops = Drops { water, plan, from: &scene.from, ground_m, seed };
            Ripples::new(gpu, &drops, basin.surfaces(), basin.velocities(), disturb)
        });
        let ripples = ripples.collect::<Result<_, _>>()?;
        let fleet = if plan.bodies.is_empty() {
            None
        } else {
            let params = BodyParams::new(&surface, cells, cell_m, plan.bodies.len() as u32);
            let [x, z] = water.size_m.map(|size| -0.5 * f64::from(size));
            Some(Fleet {
                bodies: plan.bodies.clone(),
                origin_m: dvec3(x, water.level_m.into(), z),
                list: Bodies::new(gpu)?.list(basin.surfaces(), params, plan.most_steps)?,
            })
        };
        let absorbing = match (plan.absorbing, simulation, basin.velocities()[0]) {
            (Some(borders), scene::Simulation::Level { model, .. }, Some(velocity)) => {
                Some(Absorb::new(gpu)?.borders(model, borders, basin.surfaces(), velocity)?)
            }
            _ => None,
        };
        let is_shore = !water.model.has_ground();
        let ordered: u64 = plan.splashes.iter().map(|it| u64::from(it.impacts).pow(2) / 8).sum();
        Ok(Self {
            work: cells.as_u64vec2().element_product() + ordered,
            name: plan.name.clone(),
            variant: water.variant().name(),
            fleet,
            absorbing,
            clock: FixedStep::new(dt_s, plan.most_steps),
            since_s: 0.0,
            falls: Falls::new(water, seed, stream, dt_s),
            list,
            ripples,
            draw: SurfaceDraw::new(gpu, stage, &basin.drawn(water.foam), look)?,
            surface: SurfaceParams {
                cells,
                pitch,
                stride,
                size_m: Vec2::from(water.size_m),
                level_m: water.level_m,
                // A model of a sea has neither its ripples nor its foam.
                ripple: RIPPLE * (cell_m / 0.05).min(1.0) as f32,
                foam_m: if is_shore { FOAM_M.min(0.4 * water.depth_m) as f32 } else { 0.0 },
                speeds: basin.speeds(water.depth_m).into(),
                white_mps: if water.foam { WHITE_MPS } else { f32::MAX },
            },
            basin,
            depth_m: water.depth_m,
            draws_ground: water.model.has_ground(),
            start_gain_m3: Basin::start_gain_m3(simulation),
            start_energy: Basin::start_energy(simulation),
            given_m3: 0.0,
            not_listed: 0,
            taken: 0,
            thrown: Vec::new(),
        })
    }

    /// Lets `frame_s` pass: [`Lake::record`] then records the steps that are due.
    pub fn advance(&mut self, frame_s: f64) {
        self.clock.advance(frame_s);
    }

    /// Whether one submission holds the steps that are due.
    pub fn is_nearly_due(&self) -> bool {
        self.clock.steps() - self.taken <= self.most_steps()
    }

    fn most_steps(&self) -> u64 {
        (COLUMN_STEPS / self.work).max(1)
    }

    /// Records due steps, as many as one submission should hold; `false` if more are due. A watchdog takes a device away
    /// that works on one submission for seconds.
    pub fn record(&mut self, rec: &mut Recorder<'_>) -> Result<bool, sim::Error> {
        let end = self.clock.steps().min(self.taken + self.most_steps());
        let first = self.taken;
        self.record_poses(rec, first, end)?;
        let mut step = first;
        while step < end {
            self.record_falls(rec, step)?;
            self.record_landings(rec, step);
            if let Some(fleet) = &self.fleet {
                fleet.list.record(rec, &self.basin.surface(), (step - first) as u32);
                rec.barrier(Bodies::EXIT, Access::ComputeReadWrite);
            }
            let next = self.next_touch(step, end);
            self.basin.record(rec, step, next);
            if let Some(absorbing) = &self.absorbing {
                absorbing.record(rec, &self.basin.surface());
                rec.barrier(Absorb::EXIT, Access::ComputeReadWrite);
            }
            step = next;
        }
        self.taken = end;
        rec.barrier(Access::ComputeReadWrite, SurfaceDraw::ENTRY);
        Ok(end == self.clock.steps())
    }

    /// The first step after `step` before which something touches the water, `end` at the latest.
    fn next_touch(&self, step: u64, end: u64) -> u64 {
        if self.fleet.is_some() || self.absorbing.is_some() || !self.ripples.is_empty() {
            return step + 1;
        }
        if self.list.is_none() {
            return end;
        }
        (step + 1..end).find(|&next| !self.falls.at_step(next).is_empty()).unwrap_or(end)
    }

    /// Where the bodies are before each of these steps and after the last one.
    fn record_poses(&mut self, rec: &mut Recorder<'_>, first: u64, end: u64) -> Result<(), sim::Error> {
        let Some(fleet) = self.fleet.as_mut().filter(|_| first < end) else { return Ok(()) };
        let dt_s = self.clock.dt_s();
        let pose = |step: u64, body: &Body| body.pose(step as f64 * dt_s, fleet.origin_m);
        let poses =
            (first..=end).flat_map(|step| fleet.bodies.iter().map(move |body| pose(step, body))).collect();
        let staging = fleet.list.staging(poses)?;
        rec.barrier(Bodies::EXIT, Access::CopyWrite);
        rec.copy(&staging, fleet.list.poses());
        rec.barrier(Access::CopyWrite, Bodies::ENTRY);
        fleet.list.record_draughts(rec, &self.basin.surface());
        rec.barrier(Bodies::EXIT, Access::ComputeReadWrite);
        Ok(())
    }

    fn record_falls(&mut self, rec: &mut Recorder<'_>, step: u64) -> Result<(), sim::Error> {
        let Some((list, params)) = &self.list else { return Ok(()) };
        let mut falling = self.falls.at_step(step);
        falling.append(&mut self.thrown);
        self.given_m3 += given_m3(&falling);
        let (taken, left) = falling.split_at(falling.len().min(FALLS_A_STEP));
        self.not_listed += left.len() as u64;
        for batch in taken.chunks(list.capacity() as usize) {
            let (staging, _) = list.staging(batch)?;
            rec.barrier(Disturb::EXIT, Access::CopyWrite);
            rec.copy(&staging, list.list());
            rec.barrier(Access::CopyWrite, Disturb::ENTRY);
            list.record(rec, &self.basin.surface(), params);
            rec.barrier(Disturb::EXIT, Access::ComputeReadWrite);
        }
        Ok(())
    }

    /// What lands in a step, on the clock of the scene: where the water has lost time, its steps are as much later.
    fn record_landings(&self, rec: &mut Recorder<'_>, step: u64) {
        let before_s = self.since_s + self.clock.lost_s();
        let end = |steps: u64| Moment::from_s(steps as f64 * self.clock.dt_s() + before_s);
        let after = (step > 0 || self.since_s > 0.0).then(|| end(step));
        for ripples in &self.ripples {
            ripples.record(rec, &self.basin.surface(), after, end(step + 1));
        }
    }

    /// What emitter number `emitter` throws comes from another place from now on.
    pub fn move_emitter(&mut self, emitter: usize, at_m: Vec3) {
        self.ripples.iter_mut().for_each(|it| it.move_emitter(emitter, at_m));
    }

    /// Throws something in before the next step, `at_m` from the corner of the grid: a push of `radius_m` where the
    /// surface has a velocity of its own, a displacement to the side elsewhere, and water over ground that may fall dry.
    pub fn throw(&mut self, gpu: &Gpu, at_m: Vec2, radius_m: f32) -> Result<(), sim::Error> {
        if self.list.is_none() {
            let params = disturb_params(&self.basin, self.surface.cells, self.cell_m().into(), self.depth_m);
            self.list = Some(list_of(gpu, &self.basin, params)?);
        }
        let area_m2 = std::f32::consts::PI * radius_m * radius_m;
        let depth_m = self.depth_m as f32;
        // As high as a wave of this size may be before it is one of another kind.
        let high_m = 0.1 * radius_m.min(depth_m);
        let one = Disturbance { at_m, radius_m, ..Disturbance::default() };
        if self.basin.velocities()[0].is_some() {
            let speed_mps = (9.81 * depth_m).sqrt();
            let push_m3ps = -high_m * area_m2 * speed_mps / radius_m;
            self.thrown.push(Disturbance { push_m3ps, ..one });
        } else if self.draws_ground {
            self.thrown.push(Disturbance { volume_m3: 0.5 * high_m * area_m2, ..one });
        } else {
            let volume_m3 = high_m * area_m2;
            self.thrown.push(Disturbance { volume_m3: -volume_m3, ..one });
            self.thrown.push(Disturbance { volume_m3, radius_m: 2.0 * radius_m, ..one });
        }
        Ok(())
    }

    /// The scene has been there for `time_s` when this water begins.
    pub fn begin_at(&mut self, time_s: f64) {
        self.since_s = time_s;
    }

    /// Goes on with the water of `old`, which is of the same start and kind of model.
    pub fn go_on_from(&mut self, gpu: &Gpu, old: &Self) -> Result<(), sim::Error> {
        // The clock goes on in steps of its own.
        let most = self.clock.max_steps_per_frame();
        let (mut clock, mut since_s) = (old.clock.clone(), old.since_s);
        let mut taken = clock.steps();
        if clock.dt_s() != self.clock.dt_s() || clock.max_steps_per_frame() != most {
            clock = FixedStep::new(self.clock.dt_s(), most);
            taken = (old.clock.simulated_s() / self.clock.dt_s()).round() as u64;
            while clock.steps() < taken {
                let steps = (taken - clock.steps()).min(most.into());
                clock.advance(steps as f64 * clock.dt_s());
            }
            since_s += old.clock.simulated_s() + old.clock.lost_s() - clock.simulated_s();
            clock.advance(old.clock.pending_s().max(0.0));
        }
        if self.basin.upload(gpu, &old.basin.download(gpu)?, taken)? {
            (self.clock, self.taken, self.since_s) = (clock, taken, since_s);
            (self.given_m3, self.not_listed) = (old.given_m3, old.not_listed);
        }
        Ok(())
    }

    /// Where the surface is in the world: level at rest, and half its extent (m).
    pub fn extent(&self) -> (f32, Vec2) {
        (self.surface.level_m, 0.5 * self.surface.size_m)
    }

    /// Edge of a column (m).
    pub fn cell_m(&self) -> f32 {
        self.surface.size_m.x / self.surface.cells.x as f32
    }

    /// Draws the surface; inside [`Stage::record`].
    pub fn draw(&self, rec: &mut Recorder<'_>) {
        self.draw.record(rec, &self.basin.surface(), &self.surface);
    }

    /// Steps so far.
    pub fn steps(&self) -> u64 {
        self.clock.steps()
    }

    /// As in the scene.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Columns of the grid.
    pub fn columns(&self) -> u64 {
        self.surface.cells.as_u64vec2().element_product()
    }

    /// Not simulated so far (s).
    pub fn lost_s(&self) -> f64 {
        self.clock.lost_s()
    }

    /// Disturbances that did not fit in the list.
    pub fn dropped(&self) -> u64 {
        self.not_listed
    }

    /// Gained since the start (m^3): reads the whole grid back.
    pub fn volume_gain_m3(&self, gpu: &Gpu) -> Result<f64, sim::Error> {
        Ok(self.basin.tally(gpu, self.depth_m)?.gain_m3 - self.start_gain_m3)
    }

    /// The whole state.
    pub fn state(&self, gpu: &Gpu) -> Result<Vec<f32>, sim::Error> {
        self.basin.download(gpu)
    }

    /// Goes on from `floats`, the state after `pictures` of `frame_s`. `false` if they are not of this grid.
    pub fn restore(
        &mut self,
        gpu: &Gpu,
        floats: &[f32],
        pictures: u32,
        frame_s: f64,
    ) -> Result<bool, sim::Error> {
        // The clock is a function of the frames that have passed, and so is what has fallen.
        self.clock = FixedStep::new(self.clock.dt_s(), self.clock.max_steps_per_frame());
        for _ in 0..pictures {
            self.clock.advance(frame_s);
        }
        self.taken = self.clock.steps();
        let fallen = |step| if self.list.is_some() { given_m3(&self.falls.at_step(step)) } else { 0.0 };
        self.given_m3 = (0..self.taken).map(fallen).sum();
        self.basin.upload(gpu, floats, self.taken)
    }

    pub fn counters(&self) -> Result<Counters, RunError> {
        let counts = self.list.as_ref().map_or(Ok(Counts::default()), |(list, _)| list.counts())?;
        let lost = (self.clock.lost_s() / self.clock.dt_s()).round() as u64;
        let mut list = vec![("steps", self.clock.steps()), ("steps lost", lost)];
        if self.list.is_some() {
            list.push(("disturbances", counts.applied.into()));
            list.push(("rejected", counts.rejected.into()));
            list.push(("missed", counts.missed.into()));
            list.push(("dropped", self.not_listed));
        }
        if !self.ripples.is_empty() {
            let all = self.ripples.iter().map(Ripples::stats).collect::<Result<Vec<_>, _>>()?;
            let sum = |of: fn(&SplashStats) -> u64| all.iter().map(of).sum();
            list.push(("rings", sum(|it| it.taken)));
            list.push(("drops missed", sum(|it| it.missed)));
            list.push(("drops dropped", sum(|it| it.dropped)));
        }
        Ok(Counters { name: self.name.clone(), counts: list })
    }

    /// Hash of the state, the same for the same scene, seed and device.
    pub fn hash(&self, gpu: &Gpu) -> Result<u64, sim::Error> {
        Ok(fnv(self.state(gpu)?.into_iter().flat_map(f32::to_le_bytes)))
    }

    /// What became of the water.
    pub fn stats(&self, gpu: &Gpu) -> Result<WaterStats, sim::Error> {
        let tally = self.basin.tally(gpu, self.depth_m)?;
        let counts = self.list.as_ref().map_or(Ok(Counts::default()), |(list, _)| list.counts())?;
        let splashes = self.ripples.iter().map(Ripples::stats).collect::<Result<Vec<_>, _>>()?;
        let splashed_m3: f64 = splashes.iter().map(|it| it.volume_m3).sum();
        let start_energy = self.start_energy.filter(|&energy| energy > 0.0);
        Ok(WaterStats {
            name: self.name.clone(),
            variant: self.variant.clone(),
            steps: self.clock.steps(),
            dt_s: self.clock.dt_s(),
            lost_s: self.clock.lost_s(),
            volume_at_rest_m3: tally.at_rest_m3,
            volume_gain_m3: tally.gain_m3 - self.start_gain_m3,
            volume_given_m3: self.given_m3 + self.basin.rained_m3() + splashed_m3,
            energy_relative: tally.energy.zip(start_energy).map(|(energy, start)| energy / start),
            lowest_m: tally.between_m.map(|[lowest, _]| lowest),
            highest_m: tally.between_m.map(|[_, highest]| highest),
            depths: tally.depths,
            disturbances_applied: counts.applied.into(),
            disturbances_rejected: counts.rejected.into(),
            disturbances_missed: counts.missed.into(),
            disturbances_dropped: self.not_listed,
            splashes,
            state_hash: format!("{:016x}", self.hash(gpu)?),
        })
    }
}

fn given_m3(falling: &[sim::Disturbance]) -> f64 {
    falling.iter().map(|fall| f64::from(fall.volume_m3)).sum()
}
