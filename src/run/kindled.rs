// SPDX-License-Identifier: MIT OR Apache-2.0
//! An effect that impacts throw: its ring, on the clock of those who collide, and how it is drawn.

use super::{
    checkpoint::fnv,
    live::Counters,
    source::Drawn,
    stats::{EmitterStats, KindledStats},
    RunError,
};
use crate::{
    ballistic::{kindled::Ring, Effect, GroundGrid, Kindling, Moment, Params},
    draw::{
        sprites::{Splats, Sprites},
        Stage,
    },
    gpu::{Buffer, Gpu, Recorder},
    impact::Stream,
    scene::{EmitterPlan, KindledPlan},
};

/// What it is drawn on: the heights are for effects that end on the ground.
type Drawing<'a> = (&'a Stage, Option<&'a Splats>, Option<(&'a Buffer, GroundGrid)>);

pub(super) struct Kindled {
    name: String,
    effect: Effect,
    kindling: Kindling,
    drawn: Drawn,
    params: Params,
    /// End of the last step.
    stepped: Moment,
    /// Of the picture. The clock lends a step a millionth of its length: no birth is later than this.
    now: Moment,
}

fn drawn(
    gpu: &Gpu,
    (stage, splats, ground): Drawing<'_>,
    plan: &EmitterPlan,
    effect: &Effect,
    kindling: &Kindling,
) -> Result<Drawn, RunError> {
    let mut resources = kindling.resources().to_vec();
    resources.extend(ground.filter(|_| effect.has_ground).map(|(height, _)| ("Ground", height.into())));
    Drawn::new::<Params>(gpu, stage, splats, plan, c"ballistic.sprites", &resources)
}

impl Kindled {
    pub fn new(
        gpu: &Gpu,
        drawing: Drawing<'_>,
        stream: &Stream,
        plan: &EmitterPlan,
        kindled: &KindledPlan,
        (seed, number): (u32, u32),
    ) -> Result<Self, RunError> {
        let effect = kindled.effect.clone();
        let kindling = Kindling::new(gpu, stream, &kindled.info)?;
        let grid = drawing.2.filter(|_| effect.has_ground).map_or(GroundGrid::FLAT, |(_, grid)| grid);
        Ok(Self {
            name: plan.name.clone(),
            drawn: drawn(gpu, drawing, plan, &effect, &kindling)?,
            params: effect.kindled_params(seed, number, &grid, kindled.info.most),
            effect,
            kindling,
            stepped: Moment::default(),
            now: Moment::default(),
        })
    }

    /// Draws to a stage whose targets are new.
    pub fn redraw(&mut self, gpu: &Gpu, drawing: Drawing<'_>, plan: &EmitterPlan) -> Result<(), RunError> {
        self.drawn = drawn(gpu, drawing, plan, &self.effect, &self.kindling)?;
        Ok(())
    }

    /// Goes on with the births of `old`, if its ring is as large.
    pub fn go_on_from(&mut self, old: &Self) -> Result<(), RunError> {
        if self.kindling.restore(&old.kindling.state()?)? {
            (self.stepped, self.now) = (old.stepped, old.now);
        }
        Ok(())
    }

    /// The picture is of `time_s`.
    pub fn at(&mut self, time_s: f64) {
        self.now = Moment::from_s(time_s);
    }

    /// Records the births of a step that ends at `time_s`.
    pub fn record_step(&mut self, rec: &mut Recorder<'_>, time_s: f64) {
        self.stepped = Moment::from_s(time_s);
        self.kindling.record(rec, self.stepped);
    }

    /// Records who lives in the picture.
    pub fn record_living(&self, rec: &mut Recorder<'_>) {
        self.kindling.record_living(rec, self.now.max(self.stepped));
    }

    pub fn is_triangles(&self) -> bool {
        matches!(self.drawn, Drawn::Triangles(_))
    }

    pub fn draw(&self, rec: &mut Recorder<'_>) {
        if let Drawn::Triangles(sprites) = &self.drawn {
            let at = if sprites.vertices() == Sprites::VERTICES { Ring::QUADS } else { Ring::POINTS };
            sprites.record_indirect(rec, self.kindling.ring(), at, &self.params);
        }
    }

    pub fn splat(&self, rec: &mut Recorder<'_>) {
        if let Drawn::Splat(sprites) = &self.drawn {
            sprites.record_indirect(rec, self.kindling.ring(), Ring::SPLATS, &self.params);
        }
    }

    /// All words of the ring, floats in name only.
    pub fn state(&self) -> Result<Vec<f32>, RunError> {
        Ok(self.kindling.state()?.into_iter().map(f32::from_bits).collect())
    }

    /// Goes on from a state. `false` if it is of another ring.
    pub fn restore(&mut self, state: &[f32]) -> Result<bool, RunError> {
        let words: Vec<u32> = state.iter().map(|x| x.to_bits()).collect();
        Ok(self.kindling.restore(&words)?)
    }

    /// Of the births that are kept, oldest first, and how many there have been.
    pub fn hash(&self) -> Result<u64, RunError> {
        let (ring, strikes) = self.kindling.download()?;
        let counts = [ring.births(), ring.overwritten()].into_iter().flat_map(u64::to_le_bytes);
        Ok(fnv(counts.chain(bytemuck::cast_slice::<_, u8>(&strikes).iter().copied())))
    }

    pub fn counters(&self) -> Result<Counters, RunError> {
        let it = self.counts()?;
        let more = it.kindled.unwrap_or_default();
        let counts = vec![
            ("impacts", more.impacts),
            ("alive", it.alive),
            ("born", it.born),
            ("overwritten", more.overwritten),
            ("lost", more.lost),
        ];
        Ok(Counters { name: self.name.clone(), counts })
    }

    /// What became of the particles so far, without the hash.
    pub fn counts(&self) -> Result<EmitterStats, RunError> {
        let (ring, burst) = (self.kindling.counts()?, u64::from(self.params.burst));
        let (born, alive) = (ring.births() * burst, u64::from(ring.living) * burst);
        let overwritten = ring.overwritten() * burst;
        Ok(EmitterStats {
            name: self.name.clone(),
            born,
            alive,
            aged: born - alive - overwritten,
            kindled: Some(KindledStats { impacts: ring.births(), overwritten, lost: ring.lost() }),
            ..EmitterStats::default()
        })
    }

    pub fn stats(&self) -> Result<EmitterStats, RunError> {
        Ok(EmitterStats { state_hash: Some(format!("{:016x}", self.hash()?)), ..self.counts()? })
    }
}
