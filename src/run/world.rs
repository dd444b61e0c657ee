// SPDX-License-Identifier: MIT OR Apache-2.0
//! A scene on the GPU: what it holds, how time passes in it, and how a picture of it is recorded.

use super::{
    checkpoint::{scene_hash, Checkpoint},
    effects::{Around, Emitters},
    gas::Gas,
    lake::Lake,
    picture::Picture,
    room::Room,
    trace::Trace,
    RunError,
};
use crate::{
    draw::{shadow::Shadow, Camera, Layers, Stage, View},
    gpu::{self, Buffer, Gpu, HostTime, Recorder, Submitter},
    scene::{self, Plan, Scene},
    water::{self, draw::Look},
};
use glam::{UVec2, Vec3};
use std::time::Instant;

/// Columns of water that a picture counts for the trace: more are counted every so many pictures.
const COUNTED_COLUMNS: u64 = 1 << 18;

/// A scene on the GPU: waters, particles, and the stage that they are drawn on.
pub struct World {
    pub(super) stage: Stage,
    pub(super) lakes: Vec<Lake>,
    pub(super) emitters: Emitters,
    pub(super) gases: Vec<Gas>,
    pub(super) room: Option<(Room, Shadow)>,
    pub(super) lamp: Option<(Vec3, Vec3)>,
    pub(super) scene: Scene,
    pub(super) time_s: f64,
}

impl World {
    /// # Errors
    /// If the device has no room for the scene, or cannot draw.
    pub fn new(gpu: &Gpu, scene: &Scene, plan: &Plan) -> Result<Self, RunError> {
        Self::of_size(gpu, scene, plan, UVec2::from(scene.output.size))
    }

    /// [`World::new`] with pictures of another size than the scene's.
    ///
    /// # Errors
    /// As [`World::new`].
    pub fn of_size(gpu: &Gpu, scene: &Scene, plan: &Plan, size: UVec2) -> Result<Self, RunError> {
        let look = look_of(scene);
        let has_terrain = look == Look::Shaded && plan.has_ground();
        let mut stage = Stage::new(gpu, size, has_terrain.then(|| plan.terrain.clone()))?;
        stage.clear = match plan.has_ground() {
            true => [0.32, 0.32, 0.78, 1.0], // the book's (0.6, 0.6, 0.9), linear
            false if plan.has_shadow() => [0.016, 0.018, 0.023, 1.0],
            false if !scene.disks.is_empty() => [0.03, 0.03, 0.035, 1.0],
            false => [0.0, 0.0, 0.0, 1.0],
        };
        let room = match plan.has_shadow() {
            true => {
                let shadow = Shadow::new(gpu, scene::SHADOW_SIDE)?;
                let how = (scene.output.view, 1.0 / scene.output.fps);
                Some((Room::new(gpu, &stage, &shadow, plan, how)?, shadow))
            }
            false => None,
        };
        let ground_m = ground_of(gpu, &stage, plan)?;
        let lakes = scene.water.iter().zip(&plan.waters).zip(0..);
        let lakes = lakes
            .map(|((water, plan), stream)| {
                Lake::new(gpu, &stage, water, plan, look, (scene.seed, stream), ground_m.as_ref())
            })
            .collect::<Result<_, _>>()?;
        let emitters = emitters_of(gpu, &mut stage, scene, plan, ground_m.as_ref(), around(&room))?;
        let gases =
            scene.disks.iter().map(|it| Gas::new(gpu, &stage, it, scene)).collect::<Result<_, _>>()?;
        let lamp = lamp_of(plan);
        Ok(Self { stage, lakes, emitters, gases, room, lamp, scene: scene.clone(), time_s: 0.0 })
    }

    /// Lets `frame_s` pass, and draws a picture of what there is then.
    ///
    /// # Errors
    /// The device's.
    pub fn frame(
        &mut self,
        submitter: &mut Submitter,
        frame_s: f64,
    ) -> Result<(Picture, gpu::Times), RunError> {
        self.advance(frame_s);
        self.look(&self.camera());
        let mut times = gpu::Times::default();
        loop {
            let mut done = Ok(true);
            let part = submitter.run(|rec| {
                done = self.record(rec);
                if matches!(done, Ok(true)) {
                    self.stage.record_readback(rec);
                }
            })?;
            times.add(part);
            if done? {
                break;
            }
        }
        let [width, height] = self.stage.size().to_array();
        let start = Instant::now();
        let picture = Picture { width, height, rgba: self.stage.read() };
        times.host.push(HostTime::until_now("read back", start));
        Ok((picture, times))
    }

    /// Lets `frame_s` pass: [`World::record`] then records the steps that are due.
    pub fn advance(&mut self, frame_s: f64) {
        self.time_s += frame_s;
        if let Some((room, _)) = &mut self.room {
            room.advance(frame_s);
        }
        self.gases.iter_mut().for_each(|gas| gas.advance(frame_s));
        self.lakes.iter_mut().for_each(|lake| lake.advance(frame_s));
        self.emitters.advance(frame_s, self.time_s);
    }

    /// Records due steps, as many as one submission should hold, and, if none are left then, the picture up to its bytes:
    /// then it is `true`. Submits nothing, waits for nothing. Nothing recorded earlier is disturbed, so that several
    /// pictures can be on their way; each must be visible to the next.
    ///
    /// # Errors
    /// If there is no room for what falls into water.
    pub fn record(&mut self, rec: &mut Recorder<'_>) -> Result<bool, RunError> {
        let (stage, lakes, emitters) = (&mut self.stage, &mut self.lakes, &mut self.emitters);
        let (gases, room) = (&mut self.gases, &mut self.room);
        let mut done: Result<bool, water::Error> = Ok(true);
        for lake in lakes.iter_mut() {
            done = match (std::mem::replace(&mut done, Ok(true)), lake.record(rec)) {
                (Ok(others), Ok(this)) => Ok(others && this),
                (Err(error), _) | (_, Err(error)) => Err(error),
            };
        }
        for gas in gases.iter_mut() {
            let is_done = gas.record(rec);
            if let Ok(others) = &mut done {
                *others &= is_done;
            }
        }
        if !done? {
            return Ok(false);
        }
        if let Some((room, _)) = room {
            room.record(rec, emitters);
        }
        emitters.record(rec);
        if let Some((room, shadow)) = room {
            shadow.record(rec, |rec| {
                room.draw_shadow(rec);
                emitters.draw_shadow(rec);
            });
        }
        gases.iter().for_each(|gas| gas.before_drawing(rec));
        let is_flat = room.as_ref().is_some_and(|(room, _)| room.is_flat());
        let mut opaque = |rec: &mut Recorder<'_>| {
            lakes.iter().for_each(|lake| lake.draw(rec));
            gases.iter().for_each(|gas| gas.draw(rec));
            if let Some((room, _)) = room {
                room.draw(rec);
            }
            if !is_flat {
                emitters.draw_balls(rec);
            }
        };
        let mut draw = |rec: &mut Recorder<'_>| emitters.draw(rec);
        let mut splat = |rec: &mut Recorder<'_>| emitters.splat(rec);
        let layers = Layers {
            opaque: &mut opaque,
            sprites: if emitters.draws() && !is_flat { Some(&mut draw) } else { None },
            splats: if emitters.splats() && !is_flat { Some(&mut splat) } else { None },
        };
        stage.record_picture(rec, layers);
        Ok(true)
    }

    /// Whether the next [`World::record`] comes to the picture.
    pub fn is_nearly_due(&self) -> bool {
        self.lakes.iter().all(Lake::is_nearly_due) && self.gases.iter().all(Gas::is_nearly_due)
    }

    /// The scene's camera, where it is now.
    pub fn camera(&self) -> Camera {
        let camera = self.scene.camera();
        Camera {
            eye_m: Vec3::from(camera.eye_at(self.time_s)),
            target_m: Vec3::from(camera.target_m),
            fov_rad: camera.fov_deg.to_radians(),
        }
    }

    /// Time of the scene (s).
    pub fn time_s(&self) -> f64 {
        self.time_s
    }

    /// What pictures are drawn on.
    pub fn stage(&self) -> &Stage {
        &self.stage
    }

    /// The next picture is taken from `place`.
    pub fn look(&mut self, place: &Camera) {
        let sun = Vec3::from(self.scene.sun.direction());
        let size = self.stage.size();
        let mut view = View::new(place, size, self.time_s as f32, sun, 0.62);
        view.daylight = self.scene.sun.brightness;
        if let Some((at_m, light)) = self.lamp {
            // A flame: two slow waves that never meet again.
            let t = self.time_s;
            let flicker = 1.0 + 0.12 * (11.3 * t).sin() + 0.08 * (17.9 * t + 1.0).sin();
            view.lamp_m = at_m.extend(0.0);
            view.lamp = (light * flicker as f32).extend(0.0);
        }
        self.stage.set_view(&view);
        if let Some((room, shadow)) = &mut self.room {
            shadow.set_view(&room.shadow_view(sun, shadow.side()));
        }
    }

    /// Hash of every water's state, and of every pool's.
    ///
    /// # Errors
    /// The device's.
    pub fn hashes(&self, gpu: &Gpu) -> Result<Vec<String>, RunError> {
        let lakes = self.lakes.iter().map(|lake| Ok(format!("{:016x}", lake.hash(gpu)?)));
        let mut hashes = lakes.collect::<Result<Vec<_>, RunError>>()?;
        hashes.extend(self.emitters.hashes()?);
        for gas in &self.gases {
            hashes.push(gas.hash(gpu)?);
        }
        if let Some((room, _)) = &self.room {
            hashes.extend(room.hash(gpu)?);
        }
        Ok(hashes)
    }

    /// What there is now, for the trace of the picture of this number.
    pub(super) fn count(&self, gpu: &Gpu, picture: u32, trace: &Trace) -> Result<(), RunError> {
        for lake in &self.lakes {
            let every = lake.columns().div_ceil(COUNTED_COLUMNS).max(1);
            let mut values = vec![("lost_s", lake.lost_s()), ("dropped", lake.dropped() as f64)];
            if u64::from(picture).is_multiple_of(every) {
                values.push(("volume_gain_m3", lake.volume_gain_m3(gpu)?));
            }
            trace.counter(&format!("water {}", lake.name()), &values);
        }
        for it in self.emitters.counts()? {
            let values = [("alive", it.alive), ("born", it.born), ("dropped", it.dropped)];
            trace.counter(&format!("particles {}", it.name), &values.map(|(key, n)| (key, n as f64)));
        }
        for gas in &self.gases {
            trace.counter(&format!("disks {}", gas.name()), &[("steps", gas.steps() as f64)]);
        }
        Ok(())
    }

    /// The state after the picture of this number.
    ///
    /// # Errors
    /// The device's.
    pub fn checkpoint(&self, gpu: &Gpu, picture: u32) -> Result<Checkpoint, RunError> {
        let mut states = self.lakes.iter().map(|lake| lake.state(gpu)).collect::<Result<Vec<_>, _>>()?;
        states.extend(self.emitters.states()?);
        for gas in &self.gases {
            states.push(gas.state(gpu)?);
        }
        if let Some((room, _)) = &self.room {
            states.extend(room.state(gpu)?);
        }
        Ok(Checkpoint { scene: scene_hash(&self.scene), picture, states })
    }

    /// Goes on from `from`. `false` if it is of other grids.
    ///
    /// # Errors
    /// The device's, or numbers that are not finite.
    pub fn restore(&mut self, gpu: &Gpu, from: &Checkpoint) -> Result<bool, RunError> {
        let frame_s = 1.0 / self.scene.output.fps;
        for (lake, state) in self.lakes.iter_mut().zip(&from.states) {
            if !lake.restore(gpu, state, from.picture, frame_s)? {
                return Ok(false);
            }
        }
        let others = &from.states[self.lakes.len().min(from.states.len())..];
        let (others, paint) =
            others.split_at(others.len().saturating_sub(usize::from(self.scene.paint.is_some())));
        let (pools, boxes) = others.split_at(others.len().saturating_sub(self.gases.len()));
        for (gas, state) in self.gases.iter_mut().zip(boxes) {
            if !gas.restore(gpu, state, from.picture, frame_s)? {
                return Ok(false);
            }
        }
        if !self.emitters.restore(pools, from.picture, frame_s)? {
            return Ok(false);
        }
        if let Some((room, _)) = &mut self.room {
            if !room.restore(gpu, paint.first(), from.picture, frame_s)? {
                return Ok(false);
            }
        }
        self.time_s = (0..from.picture).fold(0.0, |time_s, _| time_s + frame_s);
        Ok(true)
    }

    /// Steps of the water that has taken most.
    pub fn steps(&self) -> u64 {
        self.lakes.iter().map(Lake::steps).max().unwrap_or(0)
    }
}

pub(super) fn look_of(scene: &Scene) -> Look {
    match scene.output.view {
        scene::View::Wireframe => Look::Wireframe,
        _ => Look::Shaded,
    }
}

/// What emitters need of a room.
pub(super) fn around(room: &Option<(Room, Shadow)>) -> Around<'_> {
    room.as_ref().map_or((None, None), |(room, shadow)| (Some(shadow), room.volume()))
}

/// Where the light of the first emitter that gives some comes from, and its colour.
pub(super) fn lamp_of(plan: &Plan) -> Option<(Vec3, Vec3)> {
    plan.emitters.iter().find_map(|it| Some((it.at_m, it.light?)))
}

/// Samples of what drops fall on; `None` if nothing is thrown.
pub(super) fn ground_of(gpu: &Gpu, stage: &Stage, plan: &Plan) -> Result<Option<Buffer>, RunError> {
    if plan.emitters.is_empty() {
        return Ok(None);
    }
    Ok(Some(match stage.terrain() {
        Some(terrain) => terrain.height().clone(),
        None => gpu.upload("draw.terrain_m", &plan.terrain.height_m)?,
    }))
}

pub(super) fn emitters_of(
    gpu: &Gpu,
    stage: &mut Stage,
    scene: &Scene,
    plan: &Plan,
    ground_m: Option<&Buffer>,
    around: Around<'_>,
) -> Result<Emitters, RunError> {
    let Some(ground_m) = ground_m else { return Ok(Emitters::none()) };
    Emitters::new(gpu, stage, &plan.emitters, (ground_m, plan.grid), around, scene.seed)
}
