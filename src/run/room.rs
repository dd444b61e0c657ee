// SPDX-License-Identifier: MIT OR Apache-2.0
//! The meshes of a scene on the GPU, on the clock of the scene: posed, put into cells, hit and painted.

use super::{
    brush::{Brush, Drops},
    effects::Emitters,
    stats::VolumeStats,
    RunError,
};
use crate::{
    cells::Cells,
    clock::FixedStep,
    draw::{
        map_view::MapViews,
        mesh::{Look, MeshesDraw},
        shadow::{Shadow, ShadowView},
        voxels::VoxelsDraw,
        Stage,
    },
    gpu::{Access, Gpu, Recorder, Resource},
    impact::{Stream, Surfaces},
    mesh::{Body, Meshes},
    particles::colliding::{Slabs, Surroundings},
    scene::{MeshPlan, Motion, Plan, View, VolumePlan, Voxeliser},
    volume::{Conservative, Counts, Layered, Once, Router},
};
use glam::Vec3;

/// Some of the meshes, in buffers of their own.
struct Group {
    meshes: Meshes,
    motions: Vec<Motion>,
    draw: MeshesDraw,
}

impl Group {
    fn meshes(gpu: &Gpu, plans: &[&MeshPlan]) -> Result<Meshes, RunError> {
        let body = |plan: &&MeshPlan| Body {
            mesh: plan.mesh.clone(),
            world: plan.motion.at(0.0),
            moves: plan.moves(),
        };
        Ok(Meshes::new(gpu, &plans.iter().map(body).collect::<Vec<_>>())?)
    }

    /// Poses what moves, at the end of a step.
    fn pose(&self, rec: &mut Recorder<'_>, time_s: f64, dt_s: f64) {
        let worlds: Vec<_> = self.motions.iter().map(|motion| motion.step(time_s, dt_s)).collect();
        self.meshes.record(rec, time_s, dt_s, &worlds);
    }
}

/// What fills the cells.
enum Filler {
    Conservative(Box<Conservative>),
    Layered(Box<Layered>),
    Once(Box<Once>),
}

/// The cells, and what is hit in them.
pub(super) struct Volume {
    surroundings: Surroundings,
    stream: Stream,
    filler: Filler,
    moves: bool,
    /// Where particles become drops, if they paint.
    drops: Option<Drops>,
}

/// What is drawn.
enum Seen {
    Meshes,
    Cells(VoxelsDraw),
    Maps(MapViews),
}

/// All meshes of a scene, and how they are seen.
pub(super) struct Room {
    /// What particles meet, those that are painted first; and the others.
    groups: Vec<Group>,
    volume: Option<Volume>,
    brush: Option<Brush>,
    seen: Seen,
    clock: FixedStep,
    /// Steps that are recorded.
    taken: u64,
    /// Meshes are where they are after these steps.
    is_placed: bool,
    /// A ball round what casts shadows (m).
    ball_m: (Vec3, f32),
}

impl Room {
    /// # Errors
    /// If the device has no room, or cannot draw.
    pub fn new(
        gpu: &Gpu,
        stage: &Stage,
        shadow: &Shadow,
        plan: &Plan,
        (view, frame_s): (View, f64),
    ) -> Result<Self, RunError> {
        let solid = plan.solid();
        let others: Vec<&MeshPlan> = plan.meshes.iter().filter(|it| !it.solid).collect();
        let (mut volume, mut brush, mut groups) = (None, None, Vec::new());
        for (plans, is_solid) in [(&solid, true), (&others, false)] {
            if plans.is_empty() {
                continue;
            }
            let meshes = Group::meshes(gpu, plans)?;
            if let (Some(of), true) = (&plan.volume, is_solid) {
                let mut made = Volume::new(gpu, of, &meshes)?;
                if let Some(paint) = &plan.paint {
                    let names: Vec<&str> =
                        plans.iter().filter(|it| it.map > 0).map(|it| it.name.as_str()).collect();
                    let (painter, drops) = Brush::new(gpu, paint, &meshes, &names, &made.stream)?;
                    (brush, made.drops) = (Some(painter), drops);
                }
                volume = Some(made);
            }
            let brush = brush.as_ref().filter(|_| is_solid);
            let look = |(i, plan): (usize, &&MeshPlan)| Look {
                color: plan.color,
                mirrors: plan.mirrors,
                tile_m: plan.tile_m,
                map: brush.and_then(|brush| brush.map(i)),
            };
            let looks: Vec<Look> = plans.iter().enumerate().map(look).collect();
            let draw = MeshesDraw::new(gpu, stage, shadow, &meshes, &looks, brush.map(Brush::paint))?;
            groups.push(Group { meshes, motions: plans.iter().map(|it| it.motion.clone()).collect(), draw });
        }
        let maps =
            brush.as_ref().map(|brush| brush.view(gpu, stage, view, plan.lit_m())).transpose()?.flatten();
        let seen = match (&volume, view, maps) {
            (Some(volume), View::Voxels | View::Planes, _) => {
                Seen::Cells(VoxelsDraw::new(gpu, stage, volume.cells(), view == View::Planes)?)
            }
            (_, _, Some(maps)) => Seen::Maps(maps),
            _ => Seen::Meshes,
        };
        let dt_s = plan.volume.as_ref().map_or(frame_s, |volume| volume.dt_s);
        let (low, high) = plan.lit_m();
        Ok(Self {
            groups,
            volume,
            brush,
            seen,
            clock: FixedStep::new(dt_s, u32::MAX),
            taken: 0,
            is_placed: false,
            ball_m: (0.5 * (low + high), 0.75 * low.distance(high)),
        })
    }

    /// The cells, if particles meet meshes in them.
    pub fn volume(&self) -> Option<&Volume> {
        self.volume.as_ref()
    }

    /// What the map of shadows shows, of a sun in this direction.
    pub fn shadow_view(&self, to_sun: Vec3, side: u32) -> ShadowView {
        ShadowView::new(self.ball_m.0, self.ball_m.1, to_sun, side)
    }

    /// Lets `frame_s` pass.
    pub fn advance(&mut self, frame_s: f64) {
        self.clock.advance(frame_s);
    }

    /// Goes on where `old` is, which is of the same meshes in the same cells. `false` if it takes other steps.
    ///
    /// # Errors
    /// The device's.
    pub fn go_on_from(&mut self, gpu: &Gpu, old: &Self) -> Result<bool, RunError> {
        if self.clock.dt_s() != old.clock.dt_s() {
            return Ok(false);
        }
        if let (Some(new), Some(old)) = (&self.brush, &old.brush) {
            new.restore(gpu, &old.state(gpu)?)?; // maps of another size are bare
        }
        (self.clock, self.taken, self.is_placed) = (old.clock.clone(), old.taken, false);
        Ok(true)
    }

    /// Goes on after `pictures` of `frame_s`, with what [`Room::state`] was. `false` if it is of other maps.
    pub fn restore(
        &mut self,
        gpu: &Gpu,
        state: Option<&Vec<f32>>,
        pictures: u32,
        frame_s: f64,
    ) -> Result<bool, RunError> {
        self.clock = FixedStep::new(self.clock.dt_s(), u32::MAX);
        for _ in 0..pictures {
            self.clock.advance(frame_s);
        }
        (self.taken, self.is_placed) = (self.clock.steps(), false);
        match (&self.brush, state) {
            (Some(brush), Some(state)) => brush.restore(gpu, state),
            (brush, state) => Ok(brush.is_none() && state.is_none()),
        }
    }

    /// Records the steps that are due, and leaves the meshes as they are drawn.
    ///
    /// pose --B-- cells, texels --B-- all that collides --B-- impacts --B-- paint, births
    pub fn record(&mut self, rec: &mut Recorder<'_>, emitters: &mut Emitters) {
        let dt_s = self.clock.dt_s();
        // The last picture may still be on its way.
        rec.barrier(Access::GraphicsRead, Access::ComputeWrite);
        rec.barrier(Access::GraphicsRead, Access::FillWrite);
        if !self.is_placed {
            // As it is at the start, or was when the state was stored.
            self.place(rec, self.taken as f64 * dt_s, dt_s, true);
            self.is_placed = true;
        }
        while self.taken < self.clock.steps() {
            self.taken += 1;
            self.place(rec, self.taken as f64 * dt_s, dt_s, false);
            match &self.volume {
                Some(volume) => {
                    volume.stream.record_begin(rec);
                    emitters.record_colliding(rec);
                    volume.stream.record_end(rec);
                    if let Some(brush) = &self.brush {
                        rec.barrier(Stream::EXIT, Access::ComputeReadWrite);
                        emitters.record_drops(rec);
                        brush.paint_step(rec, self.taken);
                    }
                    emitters.record_kindling(rec, self.taken as f64 * dt_s);
                }
                None => emitters.record_colliding(rec),
            }
        }
        rec.barrier(Access::ComputeReadWrite, MeshesDraw::ENTRY);
        rec.barrier(Access::FillWrite, MeshesDraw::ENTRY);
    }

    /// Poses what moves, and puts it into the cells; `all`: finds the texels of what does not as well.
    fn place(&self, rec: &mut Recorder<'_>, time_s: f64, dt_s: f64, all: bool) {
        rec.barrier(Access::ComputeReadWrite, Meshes::ENTRY);
        for group in &self.groups {
            group.pose(rec, time_s, dt_s);
        }
        rec.barrier(Meshes::EXIT, Conservative::ENTRY);
        if let Some(volume) = &self.volume {
            volume.record(rec, all);
        }
        if let Some(brush) = &self.brush {
            brush.place(rec, all);
        }
    }

    /// Hash of the paint, if there is any.
    pub fn hash(&self, gpu: &Gpu) -> Result<Option<String>, RunError> {
        self.brush.as_ref().map(|brush| brush.hash(gpu)).transpose()
    }

    /// The paint, if there is any: meshes and cells go by time alone.
    pub fn state(&self, gpu: &Gpu) -> Result<Option<Vec<f32>>, RunError> {
        self.brush.as_ref().map(|brush| brush.state(gpu)).transpose()
    }

    /// What became of it all, if particles meet meshes.
    pub fn stats(&self, gpu: &Gpu) -> Result<Option<VolumeStats>, RunError> {
        let Some(volume) = &self.volume else { return Ok(None) };
        let impacts = volume.stream.counts()?;
        // What is drawn does not say what it left out.
        let counts = match &volume.filler {
            Filler::Conservative(filler) => filler.counts(gpu)?,
            Filler::Layered(_) | Filler::Once(_) => Counts::default(),
        };
        let occupied: Vec<u32> = gpu.download(volume.cells().occupied())?;
        Ok(Some(VolumeStats {
            triangles: self.groups.first().map_or(0, |group| group.meshes.count()),
            cells: volume.cells().grid().count() as u64,
            occupied: occupied.iter().map(|word| u64::from(word.count_ones())).sum(),
            without_area: counts.no_area,
            not_finite: counts.not_finite,
            steps: self.clock.steps(),
            dt_s: self.clock.dt_s(),
            impacts: impacts.stored(),
            impacts_dropped: impacts.dropped(),
            impacts_without_paint: self.brush.as_ref().map_or(Ok(0), |brush| brush.lost(gpu))?,
            paint: self.brush.as_ref().map_or(Ok(Vec::new()), |brush| brush.stats(gpu))?,
            paint_hash: self.hash(gpu)?,
        }))
    }

    /// Draws all meshes, the cells that they are in, or the maps of their paint.
    pub fn draw(&self, rec: &mut Recorder<'_>) {
        match &self.seen {
            Seen::Cells(cells) => cells.record(rec),
            Seen::Maps(maps) => maps.record(rec),
            Seen::Meshes => self.groups.iter().for_each(|group| group.draw.record(rec)),
        }
    }

    /// Whether the picture is of maps, where particles have no place.
    pub fn is_flat(&self) -> bool {
        matches!(self.seen, Seen::Maps(_))
    }

    /// Draws them as the sun sees them.
    pub fn draw_shadow(&self, rec: &mut Recorder<'_>) {
        self.groups.iter().for_each(|group| group.draw.record_shadow(rec));
    }
}

impl Volume {
    fn new(gpu: &Gpu, plan: &VolumePlan, meshes: &Meshes) -> Result<Self, RunError> {
        let cells = Cells::new(gpu, plan.scene.grid())?;
        let way = plan.scene.way;
        let filler = match plan.scene.variant {
            Voxeliser::Conservative => {
                Filler::Conservative(Box::new(Conservative::new(gpu, meshes, &cells)?))
            }
            Voxeliser::Layered => {
                let router = Router::of(gpu)?;
                Filler::Layered(Box::new(Layered::new(gpu, meshes, &cells, way, router)?))
            }
            Voxeliser::OnePass => Filler::Once(Box::new(Once::new(gpu, meshes, &cells, way)?)),
        };
        let mut stream = Stream::new(gpu, plan.scene.impacts)?;
        let mut firsts: Vec<u32> = meshes.parts().iter().map(|part| part.triangles.start).collect();
        firsts.push(meshes.count());
        stream.locate_on(&Surfaces {
            places: meshes.places(),
            triangles: meshes.triangles(),
            uvs: meshes.uvs(),
            first_triangle: &gpu.upload("impact.firsts", &firsts)?,
        })?;
        let moves = meshes.parts().iter().any(|part| part.moves);
        let surroundings = Surroundings::new(gpu, &cells, plan.reach, Slabs::of(moves))?;
        Ok(Self { surroundings, stream, filler, moves, drops: None })
    }

    /// What pools of the law bind.
    pub fn resources(&self) -> [(&'static str, Resource<'_>); 5] {
        self.surroundings.resources(&self.stream)
    }

    /// What was hit in the last step.
    pub fn impacts(&self) -> &Stream {
        &self.stream
    }

    /// Where particles become drops, if they paint.
    pub fn drops(&self) -> Option<&Drops> {
        self.drops.as_ref()
    }

    fn cells(&self) -> &Cells {
        self.surroundings.cells()
    }

    /// Fills the cells from meshes that have just been posed; `first`: with those that do not move as well.
    fn record(&self, rec: &mut Recorder<'_>, first: bool) {
        if !(self.moves || first) {
            return;
        }
        match &self.filler {
            Filler::Conservative(filler) => filler.record(rec),
            Filler::Layered(filler) => {
                rec.barrier(Meshes::EXIT, Layered::ENTRY);
                filler.record(rec);
            }
            Filler::Once(filler) => {
                rec.barrier(Meshes::EXIT, Access::GraphicsRead);
                filler.record(rec);
            }
        }
        rec.barrier(Conservative::EXIT, Surroundings::ENTRY);
        self.surroundings.record(rec);
        rec.barrier(Surroundings::EXIT, Access::ComputeReadWrite);
    }
}
