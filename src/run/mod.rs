// SPDX-License-Identifier: MIT OR Apache-2.0
//! The headless runner: steps a scene, draws it, and writes pictures, a contact sheet, a clip and `stats.json`.

pub mod atomic;
mod basin;
mod brush;
pub mod checkpoint;
pub mod clip;
mod effects;
mod encoder;
mod falls;
mod gas;
mod lake;
mod live;
pub mod picture;
mod room;
pub mod stats;
pub mod swarm;
pub mod trace;
#[cfg(feature = "tracy")]
mod tracy;

pub use falls::Falls;
pub use live::{Counters, Left, Ray, Touched};

use crate::{
    ballistic::GroundGrid,
    draw::{shadow::Shadow, Camera, Layers, Stage, View},
    gpu::{self, Gpu, HostTime, Recorder, RenderDoc, Submitter, Zone},
    mesh::MeshesError,
    particles,
    scene::{self, Plan, Scene},
    water::{self, draw::Look},
};
use checkpoint::{scene_hash, Checkpoint, CheckpointError};
use effects::{Around, Emitters};
use encoder::{remove_pictures, Encoder};
use gas::Gas;
use glam::{UVec2, Vec3};
use lake::Lake;
use picture::Picture;
use room::Room;
use stats::Stats;
use std::{ffi::CString, fs, path::PathBuf, sync::mpsc, thread, time::Instant};
use trace::Trace;

/// What to write, and where.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Folder of the results; made if it is not there.
    pub out: PathBuf,
    /// Write every picture as a PNG, under `frames/`.
    pub has_frames: bool,
    /// Hash the state every so many frames; 0 only at the end.
    pub hash_every: u32,
    /// Write the state here, every so many pictures and after the last.
    pub checkpoint: Option<(PathBuf, u32)>,
    /// Go on from this state, with the picture after it.
    pub resume: Option<PathBuf>,
    /// How the run is watched.
    pub profile: Profile,
}

/// How a run is watched. It costs nothing where nothing is asked for.
#[derive(Clone, Debug, Default)]
pub struct Profile {
    /// Write what happens when.
    pub trace: Option<Trace>,
    /// Count what each pass makes the device do, for `stats.json` and the trace.
    pub statistics: bool,
    /// Have RenderDoc capture the picture of this number.
    pub captured: Option<u32>,
}

impl Profile {
    /// `body`, as a span of the trace.
    fn time<T>(&self, name: &str, body: impl FnOnce() -> T) -> T {
        let _zone = Zone::new(name);
        match &self.trace {
            Some(trace) => trace.time(name, body),
            None => body(),
        }
    }
}

/// What was written.
#[derive(Clone, Debug)]
pub struct Written {
    /// `stats.json` in memory.
    pub stats: Stats,
    /// Every file or folder, with what it is.
    pub files: Vec<(&'static str, PathBuf)>,
}

/// What can end a run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// Bad input.
    #[error(transparent)]
    Scene(#[from] scene::SceneError),
    /// The device's, or a parameter that only the device refuses.
    #[error(transparent)]
    Water(#[from] water::Error),
    /// The same of a box of disks.
    #[error(transparent)]
    Disks(#[from] crate::disks::Error),
    /// The same of a pool of particles.
    #[error(transparent)]
    Particles(#[from] particles::Error),
    /// A mesh that cannot be used.
    #[error(transparent)]
    Meshes(#[from] MeshesError),
    /// Paint that cannot be used.
    #[error(transparent)]
    Paint(#[from] crate::paint::Error),
    /// The device's.
    #[error(transparent)]
    Gpu(#[from] gpu::Error),
    /// A file that cannot be written.
    #[error(transparent)]
    File(#[from] atomic::FileError),
    /// A capture was asked for, and nobody is there to take it.
    #[error(
        "RenderDoc does not watch: run through `renderdoccmd capture -w whitecap run ...`, or with \
         ENABLE_VULKAN_RENDERDOC_CAPTURE=1 in the environment"
    )]
    NoRenderDoc,
    /// A file that is no state of this scene.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
}

/// Spans that are timed in one submission; further steps are not.
const SPANS: usize = 64;
/// The same where all of them are wanted.
const ALL_SPANS: usize = 4096;
/// Columns of water that a picture counts for the trace: more are counted every so many pictures.
const COUNTED_COLUMNS: u64 = 1 << 18;

/// A scene on the GPU: waters, particles, and the stage that they are drawn on.
pub struct World {
    stage: Stage,
    lakes: Vec<Lake>,
    emitters: Emitters,
    gases: Vec<Gas>,
    room: Option<(Room, Shadow)>,
    lamp: Option<(Vec3, Vec3)>,
    scene: Scene,
    time_s: f64,
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
        let lakes = scene.water.iter().zip(&plan.waters).zip(0..);
        let lakes = lakes
            .map(|((water, plan), stream)| Lake::new(gpu, &stage, water, plan, look, (scene.seed, stream)))
            .collect::<Result<_, _>>()?;
        let emitters = emitters_of(gpu, &mut stage, scene, plan, around(&room))?;
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
            room.record(rec, emitters)?;
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
        if let Some((room, shadow)) = &self.room {
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
    fn count(&self, gpu: &Gpu, picture: u32, trace: &Trace) -> Result<(), RunError> {
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

fn look_of(scene: &Scene) -> Look {
    match scene.output.view {
        scene::View::Wireframe => Look::Wireframe,
        _ => Look::Shaded,
    }
}

/// What emitters need of a room.
fn around(room: &Option<(Room, Shadow)>) -> Around<'_> {
    room.as_ref().map_or((None, None), |(room, shadow)| (Some(shadow), room.volume()))
}

/// Where the light of the first emitter that gives some comes from, and its colour.
fn lamp_of(plan: &Plan) -> Option<(Vec3, Vec3)> {
    plan.emitters.iter().find_map(|it| Some((it.at_m, it.light?)))
}

fn emitters_of(
    gpu: &Gpu,
    stage: &mut Stage,
    scene: &Scene,
    plan: &Plan,
    around: Around<'_>,
) -> Result<Emitters, RunError> {
    if plan.emitters.is_empty() {
        return Ok(Emitters::none());
    }
    let height = match stage.terrain() {
        Some(terrain) => terrain.height().clone(),
        None => gpu.upload("draw.terrain_m", &plan.terrain.height_m)?,
    };
    let water_m = scene.water.iter().map(|it| it.level_m).fold(f32::NEG_INFINITY, f32::max);
    let grid = GroundGrid { size_m: plan.terrain.size_m, cells: plan.terrain.cells, water_m };
    Emitters::new(gpu, stage, &plan.emitters, (&height, grid), around, scene.seed)
}

/// Runs `scene`, of which `plan` is, and writes what `options` ask for. `progress` is called with the number of each finished picture.
///
/// # Errors
/// Bad input before anything runs; a lost device or a full disk while it does.
pub fn run(
    gpu: &Gpu,
    scene: &Scene,
    plan: &Plan,
    options: &RunOptions,
    mut progress: impl FnMut(u32),
) -> Result<Written, RunError> {
    let start = Instant::now();
    let frames_dir = options.out.join("frames");
    let folder = if options.has_frames { &frames_dir } else { &options.out };
    fs::create_dir_all(folder).map_err(atomic::failed(folder, "make the folder"))?;

    if options.has_frames && options.resume.is_none() {
        remove_pictures(&frames_dir)?;
    }

    let mut stats = Stats {
        version: env!("CARGO_PKG_VERSION").into(),
        scene: scene.title.clone(),
        seed: scene.seed,
        device: gpu.name().into(),
        driver: gpu.adapter().driver.clone(),
        clock: gpu.clock()?.name().into(),
        frames: scene.output.frames,
        simulated_s: 0.0,
        wall_s: 0.0,
        passes: Vec::new(),
        untimed: 0,
        waters: Vec::new(),
        emitters: Vec::new(),
        disks: Vec::new(),
        volume: None,
        hashes: Vec::new(),
        warnings: plan.warnings.clone(),
    };
    let profile = &options.profile;
    let renderdoc = match profile.captured {
        Some(_) => Some(RenderDoc::watching().ok_or(RunError::NoRenderDoc)?),
        None => None,
    };
    let mut captured = None;
    if profile.statistics && !gpu.has_statistics() {
        stats.warnings.push(format!("{} has no pipeline statistics: no pass is counted", gpu.name()));
    }
    if let Some(trace) = &profile.trace {
        trace.describe(gpu.name(), about(&stats));
    }
    let mut world = profile.time("build", || World::new(gpu, scene, plan))?;
    #[cfg(feature = "tracy")]
    let tracy = tracy::Tracy::listening();
    let is_watched = profile.trace.is_some() || profile.statistics || cfg!(feature = "tracy");
    let mut submitter = Submitter::new(gpu, if profile.trace.is_some() { ALL_SPANS } else { SPANS })?;
    if is_watched {
        submitter = submitter.watching(profile.statistics)?;
    }

    // Encoding takes as long as drawing: it has a thread of its own, at most two pictures behind.
    let (sender, receiver) = mpsc::sync_channel::<Picture>(2);
    let encoder = Encoder::new(scene, options)?;
    let frame_s = 1.0 / scene.output.fps;
    let mut first = 0;
    if let Some(path) = &options.resume {
        let from = Checkpoint::read(path, scene)?;
        if !profile.time("restore", || world.restore(gpu, &from))? {
            return Err(CheckpointError::OtherScene { path: path.display().to_string() }.into());
        }
        first = from.picture + 1;
        if first >= scene.output.frames {
            return Err(
                CheckpointError::Complete { path: path.display().to_string(), pictures: first }.into()
            );
        }
    }
    let trace = profile.trace.clone();
    let encoder = thread::spawn(move || encoder.take(first, receiver, trace.as_ref()));
    for frame in first..scene.output.frames {
        let start = Instant::now();
        // The first picture is the start.
        let frame_s = if frame == 0 { 0.0 } else { frame_s };
        let zone = Zone::new("picture");
        let mut draw = || gpu.labelled(&label(frame), || world.frame(&mut submitter, frame_s));
        let (picture, times) = match &renderdoc {
            Some(renderdoc) if profile.captured == Some(frame) => {
                let (drawn, file) = renderdoc.capture(&options.out.join("renderdoc"), draw);
                captured = file;
                drawn?
            }
            _ => draw()?,
        };
        zone.end();
        #[cfg(feature = "tracy")]
        tracy.iter().for_each(|tracy| tracy.picture(&times));
        if let Some(trace) = &profile.trace {
            trace.picture(frame, &HostTime::until_now("", start), &times);
            trace.time("count", || world.count(gpu, frame, trace))?;
        }
        times.spans.iter().for_each(|span| stats.add(span));
        stats.untimed += times.untimed as u64;
        if options.hash_every > 0 && frame % options.hash_every == 0 {
            stats.hashes.push((frame, profile.time("hash", || world.hashes(gpu))?));
        }
        if let Some((path, every)) = &options.checkpoint {
            if frame % every == every - 1 || frame + 1 == scene.output.frames {
                profile
                    .time("checkpoint", || Ok::<_, RunError>(world.checkpoint(gpu, frame)?.write(path)?))?;
            }
        }
        if profile.time("wait for the encoder", || sender.send(picture)).is_err() {
            break; // the encoder has failed, and says why below
        }
        if let Some(trace) = &profile.trace {
            trace.flush()?;
        }
        progress(frame + 1);
    }
    drop(sender);
    let encoded = profile.time("finish the clip", || encoder.join());
    let (mut files, warnings) = encoded.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?;
    stats.warnings.extend(warnings);
    if let Some(picture) = profile.captured.filter(|_| captured.is_none()) {
        stats
            .warnings
            .push(format!("picture {picture} was not captured: it was not drawn, or RenderDoc could not"));
    }
    profile.time("statistics", || -> Result<(), RunError> {
        for lake in &world.lakes {
            stats.waters.push(lake.stats(gpu)?);
        }
        stats.emitters = world.emitters.stats()?;
        stats.disks = world.gases.iter().map(|gas| gas.stats(gpu)).collect::<Result<_, _>>()?;
        if let Some((room, _)) = &world.room {
            stats.volume = room.stats(gpu)?;
        }
        Ok(())
    })?;
    stats.simulated_s = frame_s * f64::from(scene.output.frames - 1);
    stats.wall_s = start.elapsed().as_secs_f64();
    let path = options.out.join("stats.json");
    let json = serde_json::to_string_pretty(&stats).expect("statistics are plain data");
    atomic::write_atomic(&path, |file| file.write_all(json.as_bytes()))?;
    files.push(("statistics", path));
    if let Some(trace) = &profile.trace {
        files.push(("trace", trace.finish()?));
    }
    files.extend(captured.map(|path| ("capture", path)));
    Ok(Written { stats, files })
}

/// The label on the queue around all that a picture submits.
fn label(picture: u32) -> CString {
    CString::new(format!("picture {picture}")).expect("no zero byte in it")
}

/// What a reader of the trace should know.
fn about(stats: &Stats) -> serde_json::Value {
    serde_json::json!({
        "version": stats.version, "scene": stats.scene, "seed": stats.seed, "device": stats.device,
        "driver": stats.driver, "clock": stats.clock,
    })
}
