// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{falls::Falls, stats::WaterStats};
use crate::{
    clock::FixedStep,
    draw::Stage,
    gpu::{Access, Buffer, Gpu, Recorder},
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
                let state = Waves::new(gpu, tuning, plan.has_land)?.state(model.cells, tuning.rows)?;
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
            start_energy: oracle::energy(&model, &plan.height_m, &at_rest),
            not_listed: 0,
            model,
        })
    }

    /// Records the steps of a frame of `frame_s`; returns what must live until they are done.
    pub fn record(&mut self, rec: &mut Recorder<'_>, frame_s: f64) -> Result<Vec<Buffer>, sim::Error> {
        let first = self.clock.steps();
        let steps = self.clock.advance(frame_s).steps;
        let mut staged = Vec::new();
        if let Some(fleet) = self.fleet.as_mut().filter(|_| steps > 0) {
            let pose = |step: u64, body: &Body| body.pose(step as f64 * self.model.dt_s, fleet.origin_m);
            let times = first..=first + u64::from(steps);
            let poses =
                times.flat_map(|step| fleet.bodies.iter().map(move |body| pose(step, body))).collect();
            let staging = fleet.list.staging(poses)?;
            rec.barrier(Bodies::EXIT, Access::CopyWrite);
            rec.copy(&staging, fleet.list.poses());
            rec.barrier(Access::CopyWrite, Bodies::ENTRY);
            fleet.list.record_draughts(rec, &surface(&self.state));
            rec.barrier(Bodies::EXIT, Access::ComputeReadWrite);
            staged.push(staging);
        }
        for step in first..first + u64::from(steps) {
            self.record_falls(rec, step, &mut staged)?;
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
        rec.barrier(Access::ComputeReadWrite, SurfaceDraw::ENTRY);
        Ok(staged)
    }

    fn record_falls(
        &mut self,
        rec: &mut Recorder<'_>,
        step: u64,
        staged: &mut Vec<Buffer>,
    ) -> Result<(), sim::Error> {
        let Some((list, params)) = &self.list else { return Ok(()) };
        let falling = self.falls.at_step(step);
        for batch in falling.chunks(list.capacity() as usize) {
            let (staging, left) = list.staging(batch)?;
            self.not_listed += left as u64;
            rec.barrier(Disturb::EXIT, Access::CopyWrite);
            rec.copy(&staging, list.list());
            rec.barrier(Access::CopyWrite, Disturb::ENTRY);
            list.record(rec, &surface(&self.state), params);
            rec.barrier(Disturb::EXIT, Access::ComputeReadWrite);
            staged.push(staging);
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

    /// Hash of the state (FNV-1a, 64 bits), the same for the same scene, seed and device.
    pub fn hash(&self, gpu: &Gpu) -> Result<u64, sim::Error> {
        let (height, velocity) = self.download(gpu)?;
        let numbers = height.iter().chain(velocity.iter().flatten());
        Ok(numbers.flat_map(|number| number.to_le_bytes()).fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        }))
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
