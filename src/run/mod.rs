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
mod kindled;
mod lake;
mod live;
pub mod picture;
mod room;
mod source;
mod splashes;
pub mod stats;
pub mod swarm;
pub mod trace;
#[cfg(feature = "tracy")]
mod tracy;
mod world;

pub use falls::Falls;
pub use live::{Counters, Left, Ray, Touched};
pub use world::World;

use crate::{
    gpu::{self, Gpu, HostTime, RenderDoc, Submitter, Zone},
    mesh::MeshesError,
    particles,
    scene::{self, Plan, Scene},
    water,
};
use checkpoint::{Checkpoint, CheckpointError};
use encoder::{remove_pictures, Encoder};
use picture::Picture;
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

impl RunError {
    /// What the device said, if it was the device.
    pub fn gpu(&self) -> Option<&gpu::Error> {
        match self {
            Self::Gpu(error)
            | Self::Water(water::Error::Gpu(error))
            | Self::Disks(crate::disks::Error::Gpu(error))
            | Self::Particles(particles::Error::Gpu(error))
            | Self::Meshes(MeshesError::Gpu(error))
            | Self::Paint(crate::paint::Error::Gpu(error)) => Some(error),
            _ => None,
        }
    }
}

/// Spans that are timed in one submission; further steps are not.
const SPANS: usize = 64;
/// The same where all of them are wanted.
const ALL_SPANS: usize = 4096;

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
