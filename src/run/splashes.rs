// SPDX-License-Identifier: MIT OR Apache-2.0
//! Rain that makes its own ripples: what an effect throws lands in the steps of a water, and ripples it where it does. All on
//! the GPU: the host says from when to when a step is.

use super::{source::seed_of, stats::SplashStats};
use crate::{
    ballistic::{Land, Moment},
    gpu::{Access, Buffer, Gpu, Recorder},
    impact::Stream,
    scene::{SplashPlan, WaterScene},
    water::{self, Disturb, DisturbParams, Disturbances, Splash, SplashParams, Splashing, Surface},
};
use glam::{Vec2, Vec3};

/// What a scene has of a water, and the drops of one emitter that fall into it.
pub(super) struct Drops<'a> {
    pub water: &'a WaterScene,
    pub plan: &'a SplashPlan,
    pub from: &'a str,
    /// Samples of what they fall on, if the scene has any.
    pub ground_m: &'a Buffer,
    pub seed: u64,
}

/// The drops of one emitter on their way into one water.
pub(super) struct Ripples {
    from: String,
    land: Land,
    stream: Stream,
    splashing: Splashing,
    params: SplashParams,
    disturb: DisturbParams,
    emitter: usize,
}

impl Ripples {
    /// Into `surfaces`, by a list with room for all that a step can bring.
    pub fn new(
        gpu: &Gpu,
        drops: &Drops<'_>,
        surfaces: [Surface<'_>; 2],
        velocities: [Option<&Buffer>; 2],
        disturb: DisturbParams,
    ) -> Result<Self, water::Error> {
        let plan = drops.plan;
        let stream = Stream::new(gpu, plan.impacts)?;
        let land = Land::new(
            gpu,
            (c"ballistic.land", &plan.spv),
            plan.landing.clone(),
            (seed_of(drops.seed), plan.landing.source),
            (drops.ground_m, &plan.grid),
            &stream,
        )?;
        let corner_m = -0.5 * Vec2::from(drops.water.size_m);
        let params = SplashParams::new(&surfaces[0], disturb.cell_m.into(), corner_m, &plan.hit);
        let list: Disturbances =
            Disturb::new(gpu)?.list_of(surfaces, velocities, plan.items() * plan.impacts)?;
        let splashing = Splash::new(gpu)?.bind(&stream, surfaces, list, plan.items())?;
        let (from, emitter) = (drops.from.to_owned(), plan.emitter());
        Ok(Self { from, land, stream, splashing, params, disturb, emitter })
    }

    /// Records what lands in a step, after `after`, or from the start, and up to `by`; barriers stand on both sides.
    ///
    /// land --B-- close --B-- splash --B-- weigh --B-- disturb
    pub fn record(&self, rec: &mut Recorder<'_>, surface: &Surface<'_>, after: Option<Moment>, by: Moment) {
        self.stream.record_begin(rec);
        self.land.record(rec, after, by);
        self.stream.record_end(rec);
        rec.barrier(Stream::EXIT, Splash::ENTRY);
        rec.barrier(Stream::EXIT, Access::IndirectRead);
        self.splashing.record(rec, surface, &self.params, &self.disturb);
        rec.barrier(Splash::EXIT, Access::ComputeReadWrite);
    }

    /// Drops come from `at_m` from now on, if they are of this emitter.
    pub fn move_emitter(&mut self, emitter: usize, at_m: Vec3) {
        if self.emitter == emitter {
            self.land.landing_mut().effect.emitter.at_m = at_m;
        }
    }

    /// What became of the drops.
    pub fn stats(&self) -> Result<SplashStats, water::Error> {
        let (impacts, counts) = (self.stream.counts()?, self.splashing.counts()?);
        Ok(SplashStats {
            from: self.from.clone(),
            landed: impacts.stored() + impacts.dropped(),
            taken: counts.taken(),
            missed: counts.missed(),
            dropped: impacts.dropped(),
            rejected: self.splashing.list().counts()?.rejected.into(),
            volume_m3: counts.taken() as f64 * f64::from(self.params.volume_m3),
        })
    }
}
