// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{checkpoint::fnv, falls::Falls, stats::WaterStats};
use crate::{
    clock::FixedStep,
    draw::Stage,
    gpu::{Access, Gpu, Recorder},
    scene::{self, Model, WaterPlan, WaterScene},
    water::{
        self as sim,
        draw::{Look, SurfaceDraw, SurfaceParams},
        oracle, Absorb, Absorbing, Bodies, Body, BodyList, BodyParams, Book, BookState, Counts, Disturb,
        DisturbParams, Disturbances, Params, Surface, Tuning, Waves, WavesState, LAND_M,
    },
};
use glam::{dvec3, DVec3, Vec2};

/// Slope of the ripples that a grid is too coarse for, in the shaded look.
const RIPPLE: f32 = 0.035;
/// Depth below which there is foam, where the water is deep enough for some (m).
const FOAM_M: f64 = 0.22;

/// Columns times steps of a submission: a tenth of a second on a small GPU.
const COLUMN_STEPS: u64 = 1 << 28;
/// Disturbances that a step takes; what is more is counted as dropped.
const FALLS_A_STEP: usize = 4096;

enum State {
    Book(BookState),
    Waves(WavesState),
}

/// Bodies on their ways.
struct Fleet {
    bodies: Vec<Body>,
    /// Corner of the grid at the level of rest, in the world (m).
    origin_m: DVec3,
    list: BodyList,
}

/// One water of a scene, on the GPU.
pub(super) struct Lake {
    name: String,
    model: sim::Model,
    params: Params,
    state: State,
    clock: FixedStep,
    falls: Falls,
    list: Option<(Disturbances, DisturbParams)>,
    fleet: Option<Fleet>,
    absorbing: Option<Absorbing>,
    draw: SurfaceDraw,
    surface: SurfaceParams,
    depth_m: f64,
    start_volume: f64,
    start_energy: f64,
    not_listed: u64,
    /// Steps that are recorded.
    taken: u64,
}

impl Lake {
    pub fn new(
        gpu: &Gpu,
        stage: &Stage,
        water: &WaterScene,
        plan: &WaterPlan,
        look: Look,
        (seed, stream): (u64, u64),
    ) -> Result<Self, sim::Error> {
        let model = plan.model;
        let at_rest = vec![0.0; plan.height_m.len()];
        let state = match plan.kind {
            Model::Book => {
                let state = Book::new(gpu)?.state(model.cells)?;
                state.upload(gpu, &plan.height_m)?;
                State::Book(state)
            }
            Model::Waves => {
                let tuning = Tuning::for_grid(gpu, model.cells);
                let state = Waves::new(gpu, tuning, plan.has_land)?.state(model.cells)?;
                state.upload(gpu, &plan.height_m, &at_rest)?;
                State::Waves(state)
            }
        };
        let (pitch, stride, has_velocity) = match &state {
            State::Book(state) => (state.pitch(), 5, 0),
            State::Waves(state) => (state.pitch(), 1, 1),
        };
        let list = if plan.is_disturbed {
            let velocity = match &state {
                State::Book(_) => None,
                State::Waves(state) => Some(state.velocity()),
            };
            let list = Disturb::new(gpu)?.list(surfaces(&state), velocity, scene::DISTURBANCES)?;
            let params = DisturbParams {
                cells: model.cells,
                pitch,
                stride,
                cell_m: model.cell_m as f32,
                // A wave higher than the water is deep is beyond the model by far.
                limit_m: (4.0 * water.depth_m).max(10.0) as f32,
                has_velocity,
            };
            Some((list, params))
        } else {
            None
        };
        let fleet = if plan.bodies.is_empty() {
            None
        } else {
            let params =
                BodyParams::new(&surface(&state), model.cells, model.cell_m, plan.bodies.len() as u32);
            let [x, z] = water.size_m.map(|size| -0.5 * f64::from(size));
            Some(Fleet {
                bodies: plan.bodies.clone(),
                origin_m: dvec3(x, water.level_m.into(), z),
                list: Bodies::new(gpu)?.list(surfaces(&state), params, plan.most_steps)?,
            })
        };
        let absorbing = match (&state, plan.absorbing) {
            (State::Waves(state), Some(borders)) => {
                Some(Absorb::new(gpu)?.borders(&model, borders, state.surfaces(), state.velocity())?)
            }
            _ => None,
        };
        Ok(Self {
            name: plan.name.clone(),
            fleet,
            absorbing,
            params: model.params(pitch),
            clock: FixedStep::new(model.dt_s, plan.most_steps),
            falls: Falls::new(water, seed, stream, model.dt_s),
            list,
            draw: SurfaceDraw::new(gpu, stage, surfaces(&state), look)?,
            surface: SurfaceParams {
                cells: model.cells,
                pitch,
                stride,
                size_m: Vec2::from(water.size_m),
                level_m: water.level_m,
                // A model of a sea has neither its ripples nor its foam.
                ripple: RIPPLE * (model.cell_m / 0.05).min(1.0) as f32,
                foam_m: FOAM_M.min(0.4 * water.depth_m) as f32,
                reserved: 0,
            },
            state,
            depth_m: water.depth_m,
            start_volume: oracle::volume(&plan.height_m),
            start_energy: energy_from_rest(&model, &plan.height_m),
            not_listed: 0,
            taken: 0,
            model,
        })
    }

    /// Lets `frame_s` pass: [`Lake::record`] then records the steps that are due.
    pub fn advance(&mut self, frame_s: f64) {
        self.clock.advance(frame_s);
    }

    /// Records due steps, as many as one submission should hold; `false` if more are due. A watchdog takes a device away
    /// that works on one submission for seconds.
    pub fn record(&mut self, rec: &mut Recorder<'_>) -> Result<bool, sim::Error> {
        let columns = self.model.cells.as_u64vec2().element_product();
        let most = (COLUMN_STEPS / columns).max(1);
        let end = self.clock.steps().min(self.taken + most);
        let first = self.taken;
        self.record_poses(rec, first, end)?;
        for step in first..end {
            self.record_falls(rec, step)?;
            if let Some(fleet) = &self.fleet {
                fleet.list.record(rec, &surface(&self.state), (step - first) as u32);
                rec.barrier(Bodies::EXIT, Access::ComputeReadWrite);
            }
            // From rest the first flow is half a step's: second order from the start.
            let params = if step == 0 { self.params.first_from_rest() } else { self.params };
            match &mut self.state {
                State::Book(state) => state.record(rec, &params),
                State::Waves(state) => state.record(rec, &params),
            }
            rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
            if let Some(absorbing) = &self.absorbing {
                absorbing.record(rec, &surface(&self.state));
                rec.barrier(Absorb::EXIT, Access::ComputeReadWrite);
            }
        }
        self.taken = end;
        rec.barrier(Access::ComputeReadWrite, SurfaceDraw::ENTRY);
        Ok(end == self.clock.steps())
    }

    /// Where the bodies are before each of these steps and after the last one.
    fn record_poses(&mut self, rec: &mut Recorder<'_>, first: u64, end: u64) -> Result<(), sim::Error> {
        let Some(fleet) = self.fleet.as_mut().filter(|_| first < end) else { return Ok(()) };
        let pose = |step: u64, body: &Body| body.pose(step as f64 * self.model.dt_s, fleet.origin_m);
        let poses =
            (first..=end).flat_map(|step| fleet.bodies.iter().map(move |body| pose(step, body))).collect();
        let staging = fleet.list.staging(poses)?;
        rec.barrier(Bodies::EXIT, Access::CopyWrite);
        rec.copy(&staging, fleet.list.poses());
        rec.barrier(Access::CopyWrite, Bodies::ENTRY);
        fleet.list.record_draughts(rec, &surface(&self.state));
        rec.barrier(Bodies::EXIT, Access::ComputeReadWrite);
        Ok(())
    }

    fn record_falls(&mut self, rec: &mut Recorder<'_>, step: u64) -> Result<(), sim::Error> {
        let Some((list, params)) = &self.list else { return Ok(()) };
        let falling = self.falls.at_step(step);
        let (taken, left) = falling.split_at(falling.len().min(FALLS_A_STEP));
        self.not_listed += left.len() as u64;
        for batch in taken.chunks(list.capacity() as usize) {
            let (staging, _) = list.staging(batch)?;
            rec.barrier(Disturb::EXIT, Access::CopyWrite);
            rec.copy(&staging, list.list());
            rec.barrier(Access::CopyWrite, Disturb::ENTRY);
            list.record(rec, &surface(&self.state), params);
            rec.barrier(Disturb::EXIT, Access::ComputeReadWrite);
        }
        Ok(())
    }

    /// Draws the surface; inside [`Stage::record`].
    pub fn draw(&self, rec: &mut Recorder<'_>) {
        self.draw.record(rec, &surface(&self.state), &self.surface);
    }

    /// Steps so far.
    pub fn steps(&self) -> u64 {
        self.clock.steps()
    }

    /// Heights (m above rest) and, where the model has them, velocities (m/s).
    fn download(&self, gpu: &Gpu) -> Result<(Vec<f32>, Option<Vec<f32>>), sim::Error> {
        Ok(match &self.state {
            State::Book(state) => (state.download(gpu)?.iter().map(|column| column.height_m).collect(), None),
            State::Waves(state) => {
                let (height, velocity) = state.download(gpu)?;
                (height, Some(velocity))
            }
        })
    }

    /// The whole state: columns, or heights and then velocities.
    pub fn state(&self, gpu: &Gpu) -> Result<Vec<f32>, sim::Error> {
        Ok(match &self.state {
            State::Book(state) => bytemuck::allocation::pod_collect_to_vec(&state.download(gpu)?),
            State::Waves(state) => {
                let (mut height, velocity) = state.download(gpu)?;
                height.extend(velocity);
                height
            }
        })
    }

    /// Goes on from `floats`, the state after `pictures` of `frame_s`. `false` if they are not of this grid.
    pub fn restore(
        &mut self,
        gpu: &Gpu,
        floats: &[f32],
        pictures: u32,
        frame_s: f64,
    ) -> Result<bool, sim::Error> {
        let cells = self.model.cells.as_usizevec2().element_product();
        match &self.state {
            State::Book(state) if floats.len() == 5 * cells => {
                state.upload_columns(gpu, bytemuck::cast_slice(floats))?
            }
            State::Waves(state) if floats.len() == 2 * cells => {
                state.upload(gpu, &floats[..cells], &floats[cells..])?;
            }
            _ => return Ok(false),
        }
        // The clock is a function of the frames that have passed.
        self.clock = FixedStep::new(self.clock.dt_s(), self.clock.max_steps_per_frame());
        for _ in 0..pictures {
            self.clock.advance(frame_s);
        }
        self.taken = self.clock.steps();
        Ok(true)
    }

    /// Hash of the state, the same for the same scene, seed and device.
    pub fn hash(&self, gpu: &Gpu) -> Result<u64, sim::Error> {
        Ok(fnv(self.state(gpu)?.into_iter().flat_map(f32::to_le_bytes)))
    }

    /// What became of the water.
    pub fn stats(&self, gpu: &Gpu) -> Result<WaterStats, sim::Error> {
        let (height, velocity) = self.download(gpu)?;
        let counts = self.list.as_ref().map_or(Ok(Counts::default()), |(list, _)| list.counts())?;
        let wet = height.iter().filter(|&&h| h != LAND_M);
        let area = self.model.cell_m.powi(2);
        let at_rest = self.depth_m * wet.clone().count() as f64;
        let volume = oracle::volume(&height);
        let energy = velocity.map(|velocity| oracle::energy(&self.model, &height, &velocity));
        Ok(WaterStats {
            name: self.name.clone(),
            steps: self.clock.steps(),
            dt_s: self.model.dt_s,
            lost_s: self.clock.lost_s(),
            volume_at_rest_m3: area * at_rest,
            volume_gain_m3: area * (volume - self.start_volume),
            energy_relative: energy
                .filter(|_| self.start_energy > 0.0)
                .map(|energy| energy / self.start_energy),
            lowest_m: wet.clone().fold(f32::MAX, |m, &h| m.min(h)),
            highest_m: wet.fold(f32::MIN, |m, &h| m.max(h)),
            disturbances_applied: counts.applied.into(),
            disturbances_rejected: counts.rejected.into(),
            disturbances_missed: counts.missed.into(),
            disturbances_dropped: self.not_listed,
            state_hash: format!("{:016x}", self.hash(gpu)?),
        })
    }
}

/// Energy of a start at rest. The energy is that of the surfaces on either side of a flow, and the flow half a step before
/// a start at rest is the mirror image of the one half a step after.
fn energy_from_rest(model: &sim::Model, height_m: &[f32]) -> f64 {
    let heights: Vec<f64> = height_m.iter().map(|&h| f64::from(h)).collect();
    let pulls = sim::cpu::laplacians(model, &heights);
    let velocity: Vec<f32> = pulls.iter().map(|pull| (-0.5 * model.pull() * pull) as f32).collect();
    oracle::energy(model, height_m, &velocity)
}

fn surface(state: &State) -> Surface<'_> {
    match state {
        State::Book(state) => state.surface(),
        State::Waves(state) => state.surface(),
    }
}

fn surfaces(state: &State) -> [Surface<'_>; 2] {
    match state {
        State::Book(state) => state.surfaces(),
        State::Waves(state) => state.surfaces(),
    }
}
