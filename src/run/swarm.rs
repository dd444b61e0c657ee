// SPDX-License-Identifier: MIT OR Apache-2.0
//! A pool with a law, on the GPU, on the clock of the scene.

use super::{
    brush::Taker, checkpoint::fnv, live::Counters, room::Volume, source::Drawn, stats::EmitterStats, RunError,
};
use crate::{
    clock::FixedStep,
    draw::{
        shadow::Shadow,
        sprites::{Splats, Sprites},
        Stage,
    },
    gpu::{Access, Buffer, Gpu, Recorder, Residence},
    particles::{
        balls::{BallParams, BallsDraw},
        colliding::Colliding,
        Law, Options, Particle, Particles, Pool, PoolInfo, PoolState, Snapshot, Step,
    },
    random::{bits, direction_of, units},
    scene::{Attractor, CollidingScene, Draw, EmitterPlan, LawPlan, LawScene, PlannedThrows, MOST_CENTRES},
};
use glam::{Vec3, Vec4};
use std::{ffi::CStr, slice};

/// Mirrors `Glow` in `glsl/particles/glow.glsl`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Glow {
    /// Linear, premultiplied.
    pub near: Vec4,
    /// The same.
    pub far: Vec4,
    /// (m).
    pub half_m: f32,
    /// (s).
    pub exposure_s: f32,
    /// (m).
    pub far_m: f32,
    /// How many.
    pub centres: u32,
    /// xyz (m).
    pub centre_m: [Vec4; MOST_CENTRES],
}

/// A pool of one emitter.
pub(super) struct Swarm {
    name: String,
    pool: Pool,
    clock: FixedStep,
    /// Steps that are recorded.
    taken: u64,
    collides: bool,
    glow: Glow,
    glows: Buffer,
    centres: Vec<Attractor>,
    /// Where its emitter has been moved to, until that is recorded (m).
    moved_to: Option<Vec3>,
    /// For each of the two buffers between which the pool goes to and fro.
    drawn: Vec<(Buffer, Drawn)>,
    /// If its particles paint.
    taker: Option<Taker>,
}

/// For each of the two buffers between which the pool goes to and fro.
fn drawn(
    gpu: &Gpu,
    stage: &Stage,
    (splats, shadow): (Option<&Splats>, Option<&Shadow>),
    (plan, look): (&EmitterPlan, &LawScene),
    pool: &Pool,
    glows: &Buffer,
) -> Result<Vec<(Buffer, Drawn)>, RunError> {
    let drawn = pool.both().map(|particles| {
        if plan.draw == Draw::Balls {
            let shadow = shadow.expect("a scene of balls has shadows");
            let params = BallParams {
                color: Vec3::from(look.color).extend(look.half_m),
                far_color: Vec3::from(look.far_color).extend(look.mirrors),
            };
            let balls = BallsDraw::new(gpu, stage, shadow, (pool.state(), particles), params)?;
            return Ok((particles.clone(), Drawn::Balls(balls)));
        }
        let resources =
            [("Pool", pool.state().into()), ("Particles", particles.into()), ("Glows", glows.into())];
        let drawn = Drawn::new::<()>(gpu, stage, splats, plan, c"particles.glow", &resources)?;
        Ok((particles.clone(), drawn))
    });
    drawn.into_iter().collect()
}

fn name_of(law: &LawPlan) -> &'static CStr {
    match law.look.file.as_str() {
        "black_hole" => c"particles.black_hole",
        "drag" => c"particles.drag",
        _ => c"particles.user",
    }
}

/// Those who are there from the start, in a ball round the emitter, all places in it alike.
fn population(colliding: &CollidingScene, law: &LawPlan, seed: u32) -> Vec<Particle> {
    let of = |i: u32| {
        let (place, other) = (units(bits(seed, 1, i, 0)), units(bits(seed, 1, i, 1)));
        let far_m = colliding.spread_m * place[2].cbrt();
        Particle {
            at_m: law.emitter.at_m + far_m * direction_of([place[0], place[1]]),
            velocity_mps: law.emitter.velocity_mps
                + law.emitter.speed_mps * direction_of([other[0], other[1]]),
            // Told apart by their births, which are all before the start.
            born: 0u32.wrapping_sub(i % 65_536),
        }
    };
    (0..colliding.population).map(of).collect()
}

impl Swarm {
    pub fn new(
        gpu: &Gpu,
        stage: &Stage,
        (splats, shadow, volume): (Option<&Splats>, Option<&Shadow>, Option<&Volume>),
        plan: &EmitterPlan,
        law: &LawPlan,
        (seed, stream): (u32, u32),
    ) -> Result<Self, RunError> {
        let info = PoolInfo {
            capacity: plan.capacity,
            life_s: law.life_s,
            seed,
            start: 0,
            emitters: &[law.emitter],
            law: &law.numbers,
        };
        let pool = match (&law.look.colliding, volume) {
            (Some(colliding), Some(volume)) => {
                let kernel = Colliding::law(colliding.variant);
                let kernels = Particles::new(gpu, &kernel, Colliding::options(gpu))?;
                let mut pool = kernels.pool_with(&info, &volume.resources())?;
                if colliding.population > 0 {
                    pool.upload(&population(colliding, law, seed))?;
                }
                pool
            }
            _ => {
                let constants = &law.constants;
                let kernel = Law {
                    name: name_of(law),
                    spv: &law.spv,
                    subgroups: None,
                    deferred: None,
                    constants,
                    blocks: &[],
                };
                Particles::new(gpu, &kernel, Options::for_device(gpu))?.pool(&info)?
            }
        };
        let look = &law.look;
        let alpha = look.alpha;
        let premultiplied = |rgb: [f32; 3]| {
            let share = if alpha > 0.0 { alpha } else { 1.0 };
            Vec4::new(rgb[0] * share, rgb[1] * share, rgb[2] * share, alpha)
        };
        let glow = Glow {
            near: premultiplied(look.color),
            far: premultiplied(look.far_color),
            half_m: look.half_m,
            exposure_s: look.exposure_s,
            far_m: look.far_m,
            centres: law.centres.len() as u32,
            centre_m: [Vec4::ZERO; MOST_CENTRES],
        };
        let glows = Buffer::new(gpu, "particles.glow", size_of::<Glow>() as u64, Residence::Upload)?;
        let drawn = drawn(gpu, stage, (splats, shadow), (plan, look), &pool, &glows)?;
        let drops = volume.and_then(Volume::drops).filter(|_| look.colliding.is_some());
        let mut made = Self {
            taker: drops.map(|drops| drops.taker(&pool, stream as usize)).transpose()?,
            name: plan.name.clone(),
            clock: FixedStep::new(law.dt_s, u32::MAX),
            taken: 0,
            collides: look.colliding.is_some(),
            glow,
            glows,
            centres: law.centres.clone(),
            moved_to: None,
            drawn,
            pool,
        };
        made.look(0.0);
        Ok(made)
    }

    /// Draws to a stage whose targets are new.
    pub fn redraw(
        &mut self,
        gpu: &Gpu,
        stage: &Stage,
        drawing: (Option<&Splats>, Option<&Shadow>),
        plan: &EmitterPlan,
    ) -> Result<(), RunError> {
        let PlannedThrows::Law(law) = &plan.throws else { return Ok(()) };
        self.drawn = drawn(gpu, stage, drawing, (plan, &law.look), &self.pool, &self.glows)?;
        Ok(())
    }

    /// Goes on with the particles of `old`, where they fit: numbers of the law and of the emitter are this one's.
    pub fn go_on_from(&mut self, old: &Self) -> Result<(), RunError> {
        let is_alike = self.pool.capacity() == old.pool.capacity()
            && self.pool.life_ticks() == old.pool.life_ticks()
            && self.clock.dt_s() == old.clock.dt_s();
        if is_alike {
            let (mut state, here) = (old.pool.snapshot()?, self.pool.snapshot()?);
            (state.law, state.emitters) = (here.law, here.emitters);
            self.pool.restore(&state)?;
            (self.clock, self.taken) = (old.clock.clone(), old.taken);
        }
        Ok(())
    }

    /// Throws from `at_m` from the next step on.
    pub fn move_to(&mut self, at_m: Vec3) {
        self.moved_to = Some(at_m);
    }

    /// Lets `frame_s` pass, up to `time_s` of the scene.
    pub fn advance(&mut self, frame_s: f64, time_s: f64) {
        self.clock.advance(frame_s);
        self.look(time_s);
    }

    fn look(&mut self, time_s: f64) {
        for (to, from) in self.glow.centre_m.iter_mut().zip(&self.centres) {
            let [x, y, z] = from.at(time_s);
            *to = Vec4::new(x, y, z, 0.0);
        }
    }

    /// Brings what the glow is to where it is read. Nothing that was recorded before sees it.
    pub fn record_look(&self, rec: &mut Recorder<'_>) {
        rec.update(&self.glows, slice::from_ref(&self.glow));
    }

    /// Records the steps that are due.
    pub fn record(&mut self, rec: &mut Recorder<'_>) {
        while self.taken < self.clock.steps() {
            self.record_step(rec);
        }
    }

    /// Records one step.
    pub fn record_step(&mut self, rec: &mut Recorder<'_>) {
        if let Some(at_m) = self.moved_to.take() {
            rec.barrier(Particles::EXIT, Access::FillWrite);
            rec.update(self.pool.emitters(), slice::from_ref(&at_m)); // what `EmitterWords` begins with
            rec.barrier(Access::FillWrite, Particles::ENTRY);
        }
        rec.barrier(Particles::EXIT, Particles::ENTRY);
        // The arguments of the last step are read before this one writes them.
        rec.barrier(Access::IndirectRead, Access::ComputeWrite);
        self.pool.record(rec, &Step::nth(self.taken, self.clock.dt_s()));
        self.taken += 1;
    }

    /// Whether it meets meshes: it steps when they do.
    pub fn collides(&self) -> bool {
        self.collides
    }

    /// Whether its particles become drops.
    pub fn paints(&self) -> bool {
        self.taker.is_some()
    }

    /// Records the drops that its particles are now.
    pub fn record_drops(&self, rec: &mut Recorder<'_>) {
        if let Some(taker) = &self.taker {
            taker.record(rec, self.pool.particles());
        }
    }

    fn drawn(&self) -> &Drawn {
        let now = self.pool.particles();
        &self.drawn.iter().find(|(buffer, _)| buffer.is(now)).expect("one of the pool's two").1
    }

    pub fn is_triangles(&self) -> bool {
        matches!(self.drawn(), Drawn::Triangles(_))
    }

    pub fn draw(&self, rec: &mut Recorder<'_>) {
        if let Drawn::Triangles(sprites) = self.drawn() {
            let at =
                if sprites.vertices() == Sprites::VERTICES { PoolState::QUADS } else { PoolState::POINTS };
            sprites.record_indirect(rec, self.pool.state(), at, &());
        }
    }

    pub fn splat(&self, rec: &mut Recorder<'_>) {
        if let Drawn::Splat(sprites) = self.drawn() {
            sprites.record(rec, self.pool.capacity(), &());
        }
    }

    /// If it is drawn as such.
    pub fn balls(&self) -> Option<&BallsDraw> {
        match self.drawn() {
            Drawn::Balls(balls) => Some(balls),
            _ => None,
        }
    }

    /// All words of the pool, each part after its length; floats in name only.
    pub fn state(&self) -> Result<Vec<f32>, RunError> {
        let it = self.pool.snapshot()?;
        let mut words = vec![it.now];
        for part in [&it.particles, &it.state, &it.emitters, &it.births, &it.law, &it.places] {
            words.push(part.len() as u32);
            words.extend(part);
        }
        Ok(words.into_iter().map(f32::from_bits).collect())
    }

    /// Goes on from a state after `pictures` of `frame_s`. `false` if it is of another pool.
    pub fn restore(&mut self, state: &[f32], pictures: u32, frame_s: f64) -> Result<bool, RunError> {
        let here = self.pool.snapshot()?;
        let mut rest = state.iter().skip(1).map(|x| x.to_bits());
        let mut take = |length: usize| -> Option<Vec<u32>> {
            let stored = rest.next()? as usize;
            let part: Vec<u32> = rest.by_ref().take(stored).collect();
            (stored == length && part.len() == length).then_some(part)
        };
        // The tick comes first, without a length.
        let Some(now) = state.first().map(|x| x.to_bits()) else { return Ok(false) };
        let mut parts = || -> Option<Snapshot> {
            Some(Snapshot {
                particles: take(here.particles.len())?,
                state: take(here.state.len())?,
                emitters: take(here.emitters.len())?,
                births: take(here.births.len())?,
                law: take(here.law.len())?,
                places: take(here.places.len())?,
                now,
            })
        };
        let Some(snapshot) = parts() else { return Ok(false) };
        self.pool.restore(&snapshot)?;
        // The clock is a function of the frames that have passed.
        self.clock = FixedStep::new(self.clock.dt_s(), self.clock.max_steps_per_frame());
        for _ in 0..pictures {
            self.clock.advance(frame_s);
        }
        self.taken = self.clock.steps();
        Ok(true)
    }

    /// Of all that lives, in its order.
    pub fn hash(&self) -> Result<u64, RunError> {
        let living = self.pool.living()?;
        Ok(fnv(bytemuck::cast_slice::<_, u8>(&living).iter().copied()))
    }

    pub fn counters(&self) -> Result<Counters, RunError> {
        let counts = self.pool.counts()?;
        let list = vec![
            ("steps", self.clock.steps()),
            ("alive", counts.alive()),
            ("born", counts.born),
            ("dropped", counts.dropped),
            ("aged", counts.aged),
            ("ended", counts.ended),
            ("spoiled", counts.spoiled),
        ];
        Ok(Counters { name: self.name.clone(), counts: list })
    }

    /// What became of the particles so far, without the hash of what lives.
    pub fn counts(&self) -> Result<EmitterStats, RunError> {
        let counts = self.pool.counts()?;
        Ok(EmitterStats {
            name: self.name.clone(),
            born: counts.born,
            alive: counts.alive(),
            dropped: counts.dropped,
            aged: counts.aged,
            ended: counts.ended,
            spoiled: counts.spoiled,
            steps: Some(self.clock.steps()),
            dt_s: Some(self.clock.dt_s()),
            state_hash: None,
            kindled: None,
        })
    }

    pub fn stats(&self) -> Result<EmitterStats, RunError> {
        Ok(EmitterStats { state_hash: Some(format!("{:016x}", self.hash()?)), ..self.counts()? })
    }
}
