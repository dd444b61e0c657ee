// SPDX-License-Identifier: MIT OR Apache-2.0
//! Emitters of a scene on the GPU: drawn as the plan says, and effects in closed form, which are nothing but drawn.

use super::{
    kindled::Kindled,
    live::Counters,
    room::Volume,
    source::{seed_of, Drawn, Flow, Source},
    stats::EmitterStats,
    swarm::Swarm,
    RunError,
};
use crate::{
    ballistic::{Effect, GroundGrid, Moment, Params},
    draw::{shadow::Shadow, sprites::Splats, Stage},
    gpu::{Access, Buffer, Gpu, Recorder},
    particles::balls::BallsDraw,
    scene::{Draw, EmitterPlan, PlannedThrows},
};
use glam::Vec3;

/// What balls are shadowed by, and what those that collide meet; both belong to the room.
pub(super) type Around<'a> = (Option<&'a Shadow>, Option<&'a Volume>);

/// All emitters of a scene. Without any it holds nothing and records nothing.
pub(super) struct Emitters {
    sources: Vec<Source>,
    splats: Option<Splats>,
    draws: bool,
    ground: Option<(Buffer, GroundGrid)>,
    seed: u32,
}

impl Emitters {
    /// Of a scene without any.
    pub fn none() -> Self {
        Self { sources: Vec::new(), splats: None, draws: false, ground: None, seed: 0 }
    }

    /// # Errors
    /// The device's, or numbers that only it refuses.
    pub fn new(
        gpu: &Gpu,
        stage: &mut Stage,
        plans: &[EmitterPlan],
        ground: (&Buffer, GroundGrid),
        around: Around<'_>,
        seed: u64,
    ) -> Result<Self, RunError> {
        if plans.iter().any(EmitterPlan::needs_depth) {
            stage.copy_depth(gpu)?;
        }
        let splats =
            plans.iter().any(|it| it.draw == Draw::Splat).then(|| Splats::new(gpu, stage)).transpose()?;
        let mut made = Self {
            sources: Vec::new(),
            splats,
            draws: plans.iter().any(|it| matches!(it.draw, Draw::Quads | Draw::Geometry)),
            ground: Some((ground.0.clone(), ground.1)),
            seed: seed_of(seed),
        };
        for (plan, stream) in plans.iter().zip(0..) {
            made.sources.push(made.source(gpu, stage, around, plan, stream)?);
        }
        Ok(made)
    }

    fn source(
        &self,
        gpu: &Gpu,
        stage: &Stage,
        (shadow, volume): Around<'_>,
        plan: &EmitterPlan,
        stream: u32,
    ) -> Result<Source, RunError> {
        let seed = self.seed;
        Ok(match &plan.throws {
            PlannedThrows::Effect(effect) => {
                let grid = self.ground.as_ref().map_or(GroundGrid::FLAT, |(_, grid)| *grid);
                let grid = if effect.has_ground { grid } else { GroundGrid::FLAT };
                Source::Flow(Box::new(Flow {
                    name: plan.name.clone(),
                    effect: effect.clone(),
                    ground: grid,
                    seed,
                    stream,
                    capacity: plan.capacity,
                    drawn: self.flow_drawn(gpu, stage, plan, effect)?,
                    params: effect.params(Moment::default(), seed, stream, &grid, plan.capacity),
                }))
            }
            PlannedThrows::Kindled(kindled) => {
                let volume = volume.expect("a scene that impacts kindle has a volume");
                let ground = self.ground.as_ref().map(|(height, grid)| (height, *grid));
                let drawing = (stage, self.splats.as_ref(), ground);
                let of = (seed, stream);
                Source::Kindled(Box::new(Kindled::new(gpu, drawing, volume.impacts(), plan, kindled, of)?))
            }
            PlannedThrows::Law(law) => {
                let seed = seed.wrapping_add(stream.wrapping_mul(0x9e37_79b9));
                let drawing = (self.splats.as_ref(), shadow, volume);
                Source::Swarm(Box::new(Swarm::new(gpu, stage, drawing, plan, law, (seed, stream))?))
            }
        })
    }

    fn flow_drawn(
        &self,
        gpu: &Gpu,
        stage: &Stage,
        plan: &EmitterPlan,
        effect: &Effect,
    ) -> Result<Drawn, RunError> {
        let ground = self.ground.as_ref().map(|(height, _)| ("Ground", height.into()));
        let resources: Vec<_> = ground.into_iter().filter(|_| effect.has_ground).collect();
        Drawn::new::<Params>(gpu, stage, self.splats.as_ref(), plan, c"ballistic.sprites", &resources)
    }

    /// Draws to a stage whose targets are new, and copies depth where it did.
    ///
    /// # Errors
    /// The device's.
    pub fn redraw(
        &mut self,
        gpu: &Gpu,
        stage: &Stage,
        shadow: Option<&Shadow>,
        plans: &[EmitterPlan],
    ) -> Result<(), RunError> {
        if self.splats.is_some() {
            self.splats = Some(Splats::new(gpu, stage)?);
        }
        for (i, plan) in plans.iter().enumerate().filter(|(_, plan)| plan.needs_depth()) {
            let drawn = match &self.sources[i] {
                Source::Flow(flow) => Some(self.flow_drawn(gpu, stage, plan, &flow.effect)?),
                Source::Kindled(_) | Source::Swarm(_) => None,
            };
            let ground = self.ground.as_ref().map(|(height, grid)| (height, *grid));
            match (&mut self.sources[i], drawn) {
                (Source::Flow(flow), Some(drawn)) => flow.drawn = drawn,
                (Source::Kindled(kindled), _) => {
                    kindled.redraw(gpu, (stage, self.splats.as_ref(), ground), plan)?;
                }
                (Source::Swarm(swarm), _) => {
                    swarm.redraw(gpu, stage, (self.splats.as_ref(), shadow), plan)?;
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Sources for those of `plans` that differ from `old`, on the same stage and ground; the others are `None`.
    ///
    /// # Errors
    /// The device's.
    pub fn changed(
        &self,
        gpu: &Gpu,
        stage: &Stage,
        around: Around<'_>,
        plans: &[EmitterPlan],
        old: &[EmitterPlan],
    ) -> Result<Vec<Option<Source>>, RunError> {
        let one = |(stream, plan): (u32, &EmitterPlan)| {
            let is_same = old.get(stream as usize) == Some(plan);
            if is_same {
                Ok(None)
            } else {
                self.source(gpu, stage, around, plan, stream).map(Some)
            }
        };
        (0..).zip(plans).map(one).collect()
    }

    /// Takes over what [`Emitters::changed`] gave, and gives back what it replaces.
    ///
    /// # Errors
    /// The device's.
    pub fn replace(&mut self, mut changed: Vec<Option<Source>>) -> Result<Vec<Source>, RunError> {
        // All that can fail has failed before anything is replaced.
        for (new, old) in changed.iter_mut().zip(&self.sources) {
            new.iter_mut().try_for_each(|new| new.go_on_from(old))?;
        }
        let mut left: Vec<Source> = self.sources.drain(changed.len().min(self.sources.len())..).collect();
        for (i, new) in changed.into_iter().enumerate() {
            let Some(new) = new else { continue };
            match self.sources.get_mut(i) {
                Some(old) => left.push(std::mem::replace(old, new)),
                None => self.sources.push(new),
            }
        }
        self.draws = self.sources.iter().any(Source::is_triangles);
        Ok(left)
    }

    /// Goes on with the particles of sources of the same place in the list.
    ///
    /// # Errors
    /// The device's.
    pub fn go_on_from(&mut self, old: &Self) -> Result<(), RunError> {
        self.sources.iter_mut().zip(&old.sources).try_for_each(|(new, old)| new.go_on_from(old))
    }

    /// Throws from `at_m` from now on.
    pub fn move_to(&mut self, emitter: usize, at_m: Vec3) {
        match self.sources.get_mut(emitter) {
            Some(Source::Flow(flow)) => flow.effect.emitter.at_m = at_m,
            Some(Source::Swarm(swarm)) => swarm.move_to(at_m),
            Some(Source::Kindled(_)) | None => {}
        }
    }

    /// Lets `frame_s` pass, up to `time_s` of the scene.
    pub fn advance(&mut self, frame_s: f64, time_s: f64) {
        for source in &mut self.sources {
            match source {
                Source::Flow(flow) => flow.at(time_s),
                Source::Kindled(kindled) => kindled.at(time_s),
                Source::Swarm(swarm) => swarm.advance(frame_s, time_s),
            }
        }
    }

    /// Records a step of those that meet meshes.
    pub fn record_colliding(&mut self, rec: &mut Recorder<'_>) {
        self.swarms_mut().filter(|it| it.collides()).for_each(|swarm| swarm.record_step(rec));
    }

    /// Records the births that the impacts of a step make, which ends at `time_s`.
    pub fn record_kindling(&mut self, rec: &mut Recorder<'_>, time_s: f64) {
        for source in &mut self.sources {
            if let Source::Kindled(kindled) = source {
                kindled.record_step(rec, time_s);
            }
        }
    }

    /// Records the drops that those who paint make, where particles and not impacts do. Barriers stand on both sides.
    pub fn record_drops(&self, rec: &mut Recorder<'_>) {
        if self.swarms().any(Swarm::paints) {
            rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
            self.swarms().for_each(|swarm| swarm.record_drops(rec));
            rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
        }
    }

    /// Records the steps of the others that are due: all of them, they are few.
    pub fn record(&mut self, rec: &mut Recorder<'_>) {
        if self.swarms().next().is_some() {
            for reader in [Access::GraphicsRead, Access::ComputeRead] {
                rec.barrier(reader, Access::FillWrite); // of the picture before this one
            }
        }
        for swarm in self.swarms_mut() {
            if !swarm.collides() {
                swarm.record(rec);
            }
            swarm.record_look(rec);
        }
        for source in &self.sources {
            if let Source::Kindled(kindled) = source {
                kindled.record_living(rec);
            }
        }
        if self.sources.iter().any(|it| matches!(it, Source::Swarm(_))) {
            rec.barrier(Access::ComputeReadWrite, Access::IndirectRead);
            rec.barrier(Access::ComputeReadWrite, Access::GraphicsRead);
            rec.barrier(Access::ComputeReadWrite, Access::ComputeRead);
            rec.barrier(Access::FillWrite, Access::GraphicsRead);
            rec.barrier(Access::FillWrite, Access::ComputeRead);
        }
    }

    /// Some are drawn as triangles.
    pub fn draws(&self) -> bool {
        self.draws
    }

    /// Some are splatted.
    pub fn splats(&self) -> bool {
        self.splats.is_some()
    }

    /// Draws those that are triangles.
    pub fn draw(&self, rec: &mut Recorder<'_>) {
        for source in &self.sources {
            match source {
                Source::Flow(flow) => {
                    if let Drawn::Triangles(sprites) = &flow.drawn {
                        sprites.record(rec, flow.count(), &flow.params);
                    }
                }
                Source::Kindled(kindled) => kindled.draw(rec),
                Source::Swarm(swarm) => swarm.draw(rec),
            }
        }
    }

    /// Splats the others.
    pub fn splat(&self, rec: &mut Recorder<'_>) {
        let Some(splats) = &self.splats else { return };
        for source in &self.sources {
            match source {
                Source::Flow(flow) => {
                    if let Drawn::Splat(sprites) = &flow.drawn {
                        sprites.record(rec, flow.count(), &flow.params);
                    }
                }
                Source::Kindled(kindled) => kindled.splat(rec),
                Source::Swarm(swarm) => swarm.splat(rec),
            }
        }
        splats.record_over(rec);
    }

    /// Draws those that are balls: they hide what is behind them.
    pub fn draw_balls(&self, rec: &mut Recorder<'_>) {
        self.balls().for_each(|balls| balls.record(rec));
    }

    /// Draws them as the sun sees them.
    pub fn draw_shadow(&self, rec: &mut Recorder<'_>) {
        self.balls().for_each(|balls| balls.record_shadow(rec));
    }

    fn balls(&self) -> impl Iterator<Item = &BallsDraw> {
        self.swarms().filter_map(Swarm::balls)
    }

    fn swarms(&self) -> impl Iterator<Item = &Swarm> {
        self.sources.iter().filter_map(|it| match it {
            Source::Swarm(swarm) => Some(&**swarm),
            Source::Flow(_) | Source::Kindled(_) => None,
        })
    }

    fn swarms_mut(&mut self) -> impl Iterator<Item = &mut Swarm> {
        self.sources.iter_mut().filter_map(|it| match it {
            Source::Swarm(swarm) => Some(&mut **swarm),
            Source::Flow(_) | Source::Kindled(_) => None,
        })
    }

    /// Of every pool and every ring: what is not stored has no state.
    ///
    /// # Errors
    /// The device's.
    pub fn states(&self) -> Result<Vec<Vec<f32>>, RunError> {
        self.sources.iter().filter_map(|it| it.state().transpose()).collect()
    }

    /// Goes on from `states`, after `pictures` of `frame_s`. `false` if they are of other pools or rings.
    ///
    /// # Errors
    /// The device's.
    pub fn restore(&mut self, states: &[Vec<f32>], pictures: u32, frame_s: f64) -> Result<bool, RunError> {
        let mut stored: Vec<&mut Source> = self.sources.iter_mut().filter(|it| it.is_stored()).collect();
        if stored.len() != states.len() {
            return Ok(false);
        }
        for (source, state) in stored.iter_mut().zip(states) {
            if !source.restore(state, pictures, frame_s)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Of every pool and every ring.
    ///
    /// # Errors
    /// The device's.
    pub fn hashes(&self) -> Result<Vec<String>, RunError> {
        let hash = |it: &Source| it.hash().map(|hash| hash.map(|hash| format!("{hash:016x}"))).transpose();
        self.sources.iter().filter_map(hash).collect()
    }

    /// Of every emitter.
    ///
    /// # Errors
    /// The device's.
    pub fn counters(&self) -> Result<Vec<Counters>, RunError> {
        let of = |source: &Source| match source {
            Source::Flow(flow) => {
                let alive = u64::from(flow.params.births) * u64::from(flow.params.burst);
                let drawn = u64::from(flow.count());
                let counts = vec![("alive", alive), ("drawn", drawn), ("dropped", alive - drawn)];
                Ok(Counters { name: flow.name.clone(), counts })
            }
            Source::Kindled(kindled) => kindled.counters(),
            Source::Swarm(swarm) => swarm.counters(),
        };
        self.sources.iter().map(of).collect()
    }

    /// What became of the particles so far, without the hash of what lives.
    ///
    /// # Errors
    /// The device's.
    pub fn counts(&self) -> Result<Vec<EmitterStats>, RunError> {
        let of = |source: &Source| match source {
            Source::Flow(flow) => Ok(flow.counts()),
            Source::Kindled(kindled) => kindled.counts(),
            Source::Swarm(swarm) => swarm.counts(),
        };
        self.sources.iter().map(of).collect()
    }

    /// What became of the particles.
    ///
    /// # Errors
    /// The device's.
    pub fn stats(&self) -> Result<Vec<EmitterStats>, RunError> {
        let of = |source: &Source| match source {
            Source::Flow(flow) => Ok(flow.counts()),
            Source::Kindled(kindled) => kindled.stats(),
            Source::Swarm(swarm) => swarm.stats(),
        };
        self.sources.iter().map(of).collect()
    }
}
