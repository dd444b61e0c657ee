// SPDX-License-Identifier: MIT OR Apache-2.0
//! Paint maps of a scene on the GPU, and what a step leaves on them: its impacts, or its particles.

use super::{checkpoint::fnv, stats::PaintStats, RunError};
use crate::{
    draw::{
        map_view::{MapViews, Maps},
        Stage,
    },
    gpu::{Access, Buffer, Gpu, Recorder, Residence},
    impact::Stream,
    mesh::Meshes,
    paint::{self, Canvas, Drop, Format, Gather, Method, Paint, Splat, Take, TakeParams, Taken},
    particles::{Pool, PoolState},
    scene::{PaintPlan, PaintedBy, View},
};
use glam::Vec3;
use std::{mem::offset_of, ops::Range};

/// Halves: white on white stays white, and coats fainter than a thousandth are not asked for.
const FORMAT: Format = Format::Halves;

/// What paints.
enum Painter {
    Impacts(Splat),
    /// All that collide are drops, of which one in `share` takes part in a step.
    Particles {
        gather: Gather,
        most: u32,
        share: u32,
        radius_m: f32,
    },
}

/// Where particles become drops.
pub(super) struct Drops {
    paint: Paint,
    drops: Buffer,
    /// By emitter.
    places: Vec<Range<u32>>,
}

/// A pool whose particles become drops.
pub(super) struct Taker {
    /// For each of the two buffers between which the pool goes to and fro.
    takes: [(Buffer, Take); 2],
    params: TakeParams,
}

impl Drops {
    /// The pool of emitter `emitter` makes some of them.
    pub fn taker(&self, pool: &Pool, emitter: usize) -> Result<Taker, RunError> {
        let [one, other] = pool.both();
        let take = |particles: &Buffer| -> Result<_, RunError> {
            Ok((particles.clone(), self.paint.take(particles, pool.state(), &self.drops)?))
        };
        let own = self.places[emitter].clone();
        let source = self.places[..emitter].iter().filter(|it| !it.is_empty()).count() as u32;
        let params = TakeParams {
            most: own.len() as u32,
            // Seven planes of words.
            stride: (one.bytes() / 28) as u32,
            count_at: (offset_of!(PoolState, slots) / 4) as u32,
            source,
            to: own.start,
        };
        Ok(Taker { takes: [take(one)?, take(other)?], params })
    }
}

impl Taker {
    /// Of the pool's particles as they are in `now`.
    pub fn record(&self, rec: &mut Recorder<'_>, now: &Buffer) {
        let take = self.takes.iter().find(|(buffer, _)| buffer.is(now)).expect("one of the pool's two");
        take.1.record(rec, &self.params);
    }
}

pub(super) struct Brush {
    canvas: Canvas,
    painter: Painter,
    method: Method,
    names: Vec<String>,
    moving: Vec<usize>,
    still: Vec<usize>,
    charts: Vec<paint::Charts>,
}

impl Brush {
    /// `meshes` begin with those that are painted, which are called `names`. Where particles paint, they become drops first.
    pub fn new(
        gpu: &Gpu,
        plan: &PaintPlan,
        meshes: &Meshes,
        names: &[&str],
        stream: &Stream,
    ) -> Result<(Self, Option<Drops>), RunError> {
        let paint = Paint::new(gpu, FORMAT)?;
        let canvas = paint.canvas(&plan.atlas, meshes.places(), meshes.triangles())?;
        let (painter, drops) = match plan.scene.from {
            PaintedBy::Impacts => (Painter::Impacts(paint.splat(&canvas, stream, &plan.coats)?), None),
            PaintedBy::Particles => {
                let most = plan.most_drops(0);
                let bytes = size_of::<Drop>() as u64 * u64::from(most);
                let drops = Buffer::new(gpu, "paint.drops", bytes, Residence::Device)?;
                let gather = paint.gather(&canvas, &drops, &plan.coats)?;
                let (share, radius_m) = (plan.scene.share, plan.scene.radius_m);
                let places = plan.drops.clone();
                (Painter::Particles { gather, most, share, radius_m }, Some(Drops { paint, drops, places }))
            }
        };
        let all = 0..plan.atlas.maps.len();
        let (moving, still) = all.partition(|&i| meshes.parts()[i].moves);
        let names = names.iter().map(|name| (*name).to_owned()).collect();
        let charts = plan.atlas.charts.clone();
        let method = plan.scene.variant.method();
        Ok((Self { canvas, painter, method, names, moving, still, charts }, drops))
    }

    /// The paint, and how a texel of it is stored.
    pub fn paint(&self) -> (&Buffer, u32) {
        (self.canvas.paint(), FORMAT as u32)
    }

    /// Where the map of a painted mesh is.
    pub fn map(&self, mesh: usize) -> Option<[u32; 4]> {
        self.canvas.maps().get(mesh).map(|map| [map.width, map.height, map.first_block, map.blocks_x])
    }

    /// A debug view of all maps; positions go from black to white between the corners `box_m`.
    pub fn view(
        &self,
        gpu: &Gpu,
        stage: &Stage,
        view: View,
        box_m: (Vec3, Vec3),
    ) -> Result<Option<MapViews>, RunError> {
        let maps = match view {
            View::PositionMap => Maps::Positions(self.canvas.positions()),
            View::PaintMap => Maps::Paint(self.canvas.paint(), FORMAT as u32),
            _ => return Ok(None),
        };
        let list: Vec<_> = (0..self.names.len()).filter_map(|i| self.map(i)).collect();
        Ok(Some(MapViews::new(gpu, stage, maps, &list, box_m)?))
    }

    /// Finds the texels in the world again: of what moves, or of all.
    pub fn place(&self, rec: &mut Recorder<'_>, all: bool) {
        rec.barrier(Access::ComputeReadWrite, Paint::ENTRY);
        if all && !self.still.is_empty() {
            self.canvas.record_place(rec, &self.still);
            rec.barrier(Access::ComputeReadWrite, Paint::ENTRY);
        }
        if !self.moving.is_empty() {
            self.canvas.record_place(rec, &self.moving);
        }
        rec.barrier(Access::ComputeReadWrite, Access::ComputeReadWrite);
    }

    /// Paints from the impacts of a step, or from the drops of step number `step`.
    pub fn paint_step(&self, rec: &mut Recorder<'_>, step: u64) {
        match &self.painter {
            Painter::Impacts(splat) => splat.record_by(rec, self.method),
            Painter::Particles { gather, most, share, radius_m } => {
                let turn = (step % u64::from(*share)) as u32;
                gather.record(rec, self.method, &Taken::share(*most, turn, *share), *radius_m);
            }
        }
    }

    /// Words of all maps, floats in name only.
    pub fn state(&self, gpu: &Gpu) -> Result<Vec<f32>, RunError> {
        Ok(gpu.download(self.canvas.paint())?)
    }

    /// Goes on from a state. `false` if it is of other maps.
    pub fn restore(&self, gpu: &Gpu, state: &[f32]) -> Result<bool, RunError> {
        if 4 * state.len() as u64 != self.canvas.paint().bytes() {
            return Ok(false);
        }
        gpu.upload_to(self.canvas.paint(), state)?;
        Ok(true)
    }

    pub fn hash(&self, gpu: &Gpu) -> Result<String, RunError> {
        let words: Vec<u32> = gpu.download(self.canvas.paint())?;
        Ok(format!("{:016x}", fnv(bytemuck::cast_slice::<_, u8>(&words).iter().copied())))
    }

    /// What became of the paint of each mesh.
    pub fn stats(&self, gpu: &Gpu) -> Result<Vec<PaintStats>, RunError> {
        let all = self.names.iter().zip(&self.charts).zip(self.canvas.covers(gpu)?);
        let of = |((name, charts), cover): ((&String, &paint::Charts), paint::Cover)| PaintStats {
            name: name.clone(),
            texels: charts.covered,
            overlapping: charts.overlapping,
            painted: cover.painted,
            nowhere: cover.nowhere,
        };
        Ok(all.map(of).collect())
    }

    /// Impacts that could not paint, since the start.
    pub fn lost(&self, gpu: &Gpu) -> Result<u64, RunError> {
        let Painter::Impacts(splat) = &self.painter else { return Ok(0) };
        let work = splat.work(gpu)?;
        Ok(u64::from(work.lost) + u64::from(work.twice))
    }
}
