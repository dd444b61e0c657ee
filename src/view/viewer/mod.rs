// SPDX-License-Identifier: MIT OR Apache-2.0
//! One window: what it holds, and its frame.

mod edits;
mod hand;
mod scripted;

use super::{
    camera::{Held, Mode, Rig},
    document::{Document, Source},
    keys::Action,
    no_display,
    paint::{Painter, Triangles},
    panel::{Ask, Contents, Panel},
    reload::Files,
    script::{Command, Script},
    times::History,
    Shown, ViewError, ViewOptions,
};
use crate::{
    gpu::{
        window::{Finished, Frames, Retired},
        Buffer, Gpu, Residence, Submitter,
    },
    run::{atomic, picture::Picture, Counters, Left, RunError, World},
    scene::{Parameter, Plan},
};
use glam::{UVec2, Vec2};
use hand::Grasp;
use std::{
    collections::VecDeque,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};
use winit::{
    dpi::PhysicalSize,
    event_loop::{ActiveEventLoop, ControlFlow},
    window::Window,
};

/// Longest time that one picture lets pass (s): a window that was held up does not catch up.
const LONGEST_S: f64 = 0.1;
/// From one reading of the counters to the next: it waits for the device.
const COUNT_EVERY: Duration = Duration::from_millis(500);

/// What is to be kept of the next picture.
enum Keep {
    /// The picture alone.
    Picture(PathBuf),
    /// All that is shown.
    Window(PathBuf),
}

/// Fields drop in this order: what uses the device first, the window last.
pub struct Viewer {
    painter: Painter,
    world: World,
    left: Retired<Left>,
    submitter: Submitter,
    frames: Frames,
    gpu: Gpu,
    window: Arc<Window>,

    source: Source,
    document: Document,
    plan: Plan,
    parameters: Vec<Parameter>,
    json: serde_json::Value,
    /// The text has changed, and the world has not followed yet.
    is_stale: bool,
    followed: Instant,
    cost: Duration,
    files: Result<Files, String>,

    rig: Rig,
    held: Held,
    pointer: Vec2,
    grasp: Option<Grasp>,
    turns: bool,
    pans: bool,

    panel: Panel,
    history: History,
    counters: Vec<Counters>,
    counted: Option<Instant>,
    error: Option<String>,
    note: Option<String>,
    device: String,
    clock: &'static str,

    is_paused: bool,
    steps: u32,
    pace: f64,
    frame_s: f64,
    last: Instant,
    pictures_per_s: f64,
    is_touched: bool,
    is_edited: bool,
    out: PathBuf,

    script: VecDeque<Command>,
    is_scripted: bool,
    has_begun: bool,
    asked: Option<Instant>,
}

/// What is wrong with a scene is said before a window opens.
pub fn check(source: &Source) -> Result<(), ViewError> {
    Document::new(source)?.read().0?.plan()?;
    Ok(())
}

impl Viewer {
    /// Opens a window of the size of the scene's pictures.
    ///
    /// # Errors
    /// No display, no device, or no room on it.
    pub fn new(events: &ActiveEventLoop, options: &ViewOptions) -> Result<Self, ViewError> {
        let document = Document::new(&options.source)?;
        let (scene, parameters) = document.read();
        let scene = scene?;
        let plan = scene.plan()?;
        let [width, height] = scene.output.size;
        let title = if scene.title.is_empty() { &options.source.name } else { &scene.title };
        let attributes = Window::default_attributes()
            .with_title(format!("{title} - whitecap"))
            .with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(events.create_window(attributes).map_err(no_display)?);
        let (gpu, surface) = Gpu::for_window(&options.gpu, Box::new(window.clone()))?;
        let size: [u32; 2] = window.inner_size().into();
        let frames = Frames::new(&gpu, surface, size)?;
        let world =
            World::of_size(&gpu, &scene, &plan, UVec2::from(frames.size().unwrap_or([width, height])))?;
        let painter = Painter::new(&gpu, &frames, &window)?;
        let clock = if options.has_times { gpu.clock()?.name() } else { "" };
        let mut panel = Panel::default();
        panel.is_open = options.has_panel;
        (panel.has_times, panel.has_counters) = (options.has_times, options.has_times);
        let home = world.camera();
        let json = serde_json::to_value(&scene).unwrap_or_default();
        let now = Instant::now();
        Ok(Self {
            painter,
            submitter: Submitter::new(&gpu, 0)?,
            device: format!("{} ({})", gpu.name(), gpu.adapter().driver),
            rig: Rig::new(&scene, home),
            frame_s: 1.0 / scene.output.fps,
            world,
            left: Retired::default(),
            frames,
            gpu,
            window,
            source: options.source.clone(),
            document,
            plan,
            parameters,
            json,
            is_stale: false,
            followed: now,
            cost: Duration::ZERO,
            files: Files::new(&options.glsl),
            held: Held::default(),
            pointer: Vec2::ZERO,
            grasp: None,
            turns: false,
            pans: false,
            panel,
            history: History::default(),
            counters: Vec::new(),
            counted: None,
            error: None,
            note: Some("F1 hides the panel; its last section lists the keys.".into()),
            clock,
            is_paused: false,
            steps: 0,
            pace: 1.0,
            last: now,
            pictures_per_s: 0.0,
            is_touched: false,
            is_edited: false,
            out: options.out.clone(),
            is_scripted: options.script != Script::default(),
            script: options.script.0.clone().into(),
            has_begun: false,
            asked: None,
        })
    }

    /// For whoever asks when the window is gone.
    pub fn shown(&self) -> Shown {
        Shown { messages: self.gpu.messages(), device: self.gpu.name().into() }
    }

    /// When the next frame is due: at once, and while there is no area now and then.
    pub fn wait(&self) -> ControlFlow {
        self.window.request_redraw();
        match self.frames.size() {
            Some(_) => ControlFlow::Poll,
            None => ControlFlow::WaitUntil(Instant::now() + Duration::from_millis(30)),
        }
    }

    /// Does what a key asks for. `false` if it is the end.
    fn act(&mut self, action: Action) -> Result<bool, ViewError> {
        match action {
            Action::Pause => self.is_paused = !self.is_paused,
            Action::Step => (self.is_paused, self.steps) = (true, self.steps + 1),
            Action::Restart => self.restart()?,
            Action::Home => self.rig.set_mode(Mode::Home),
            Action::Orbit => self.rig.set_mode(Mode::Orbit),
            Action::Fly => self.rig.set_mode(Mode::Fly),
            Action::Fit => self.rig.fit(self.world.scene()),
            Action::Panel => self.panel.is_open = !self.panel.is_open,
            Action::Screenshot => {
                let path = self.free_name("screenshot", "png");
                self.draw(None, Some(Keep::Picture(path)))?;
            }
            Action::Reload => self.reload(),
            Action::Trace => {
                self.note = Some("No trace is written from a window: `whitecap run --trace`.".into())
            }
            Action::Capture => self.note = Some("RenderDoc is not attached.".into()),
            Action::Quit => return Ok(false),
        }
        Ok(true)
    }

    /// A frame: what the script says, or what the clock does.
    fn redraw(&mut self) -> Result<bool, ViewError> {
        if self.is_scripted {
            return self.follow_script();
        }
        let now = Instant::now();
        let elapsed_s = (now - self.last).as_secs_f64();
        self.last = now;
        self.pictures_per_s += (1.0 / elapsed_s.max(1e-4) - self.pictures_per_s) * (2.0 * elapsed_s).min(1.0);
        self.rig.fly(&self.held, elapsed_s.min(LONGEST_S) as f32);
        let passes_s = match (self.steps, self.is_paused) {
            (1.., _) => {
                self.steps -= 1;
                Some(self.frame_s)
            }
            (0, true) => None,
            (0, false) => Some(self.pace * elapsed_s.min(LONGEST_S)),
        };
        self.draw(passes_s, None)
    }

    /// Draws a frame, `passes_s` after the last. `false` if it is the end.
    fn draw(&mut self, passes_s: Option<f64>, keep: Option<Keep>) -> Result<bool, ViewError> {
        if !self.frames.begin()? {
            return Ok(true); // nothing is shown, and no time passes
        }
        self.left.free_up_to(self.frames.done());
        let Some(size) = self.frames.size() else { return Ok(true) };
        if UVec2::from(size) != self.world.stage().size() {
            self.world.resize(&self.gpu, &self.plan, UVec2::from(size))?;
        }
        if self.panel.has_times && self.panel.is_open {
            self.clock = self.gpu.clock()?.name();
            if !self.frames.times().is_empty() {
                self.history.push(self.frames.times());
            }
        } else {
            self.history.clear();
        }
        self.count()?;
        let mut asks = Vec::new();
        let triangles = self.lay_out(&mut asks);
        self.painter.upload(&mut self.frames)?;

        if let Some(passes_s) = passes_s {
            self.reach_in()?;
            self.world.advance(passes_s);
        }
        self.world.look(&self.rig.camera(self.world.camera()));
        // More steps than one submission should hold come before the frame.
        while !self.world.is_nearly_due() {
            let mut recorded = Ok(false);
            self.submitter.run(|rec| {
                rec.after_all();
                recorded = self.world.record(rec);
            })?;
            recorded?;
        }
        let copy = match &keep {
            Some(Keep::Window(_)) => {
                let bytes = 4 * u64::from(size[0]) * u64::from(size[1]);
                Some(Buffer::new(&self.gpu, "view.copy", bytes, Residence::Readback)?)
            }
            _ => None,
        };
        let (world, painter) = (&mut self.world, &mut self.painter);
        let reads = matches!(keep, Some(Keep::Picture(_)));
        self.frames.finish::<ViewError>(
            self.panel.has_times && self.panel.is_open,
            |rec| {
                world.record(rec)?;
                if reads {
                    world.stage().record_readback(rec);
                }
                Ok(Finished { pixels: world.stage().pixels().clone(), size })
            },
            |cmd, size| painter.draw(cmd, size, &triangles),
            copy.as_ref(),
        )?;
        if let Some(keep) = keep {
            self.write(keep, size, copy)?;
        }
        for ask in asks {
            if !self.answer(ask)? {
                return Ok(false);
            }
        }
        self.follow();
        Ok(true)
    }

    fn lay_out(&mut self, asks: &mut Vec<Ask>) -> Triangles {
        let (panel, scene) = (&mut self.panel, self.world.scene());
        let contents = Contents {
            title: if scene.title.is_empty() { &self.source.name } else { &scene.title },
            device: &self.device,
            time_s: self.world.time_s(),
            frames_per_s: self.pictures_per_s,
            is_paused: self.is_paused,
            pace: self.pace,
            mode: self.rig.mode(),
            is_touched: self.is_touched,
            is_edited: self.is_edited,
            times: &self.history,
            clock: self.clock,
            counters: &self.counters,
            parameters: &self.parameters,
            scene: &self.json,
            error: self.error.as_deref(),
            note: self.note.as_deref(),
        };
        self.painter.run(&self.window, |ui| {
            if panel.is_open {
                panel.show(ui, &contents, asks);
            }
        })
    }

    fn count(&mut self) -> Result<(), ViewError> {
        if !(self.panel.has_counters && self.panel.is_open) {
            return Ok(());
        }
        if self.counted.is_none_or(|at| at.elapsed() >= COUNT_EVERY) {
            self.counters = self.world.counters()?;
            self.counted = Some(Instant::now());
        }
        Ok(())
    }

    fn write(
        &mut self,
        keep: Keep,
        [width, height]: [u32; 2],
        copy: Option<Buffer>,
    ) -> Result<(), ViewError> {
        self.frames.wait()?;
        let (path, rgba) = match keep {
            Keep::Picture(path) => (path, self.world.stage().read()),
            Keep::Window(path) => {
                let copy = copy.filter(|_| self.frames.is_readable());
                let copy =
                    copy.ok_or_else(|| ViewError::Window("what the window shows cannot be read".into()))?;
                (path, self.frames.rgba(copy.read()))
            }
        };
        make_folder(&path)?;
        match (Picture { width, height, rgba }).write_png(&path) {
            Ok(()) => self.say(format!("{} is written.", path.display())),
            Err(error) if self.is_scripted => return Err(error.into()),
            Err(error) => self.error = Some(error.to_string()),
        }
        Ok(())
    }

    fn say(&mut self, note: String) {
        if self.is_scripted {
            println!("{note}");
        }
        (self.note, self.error) = (Some(note), None);
    }

    fn free_name(&self, stem: &str, extension: &str) -> PathBuf {
        let name = |n: u32| self.out.join(format!("{stem}_{n:03}.{extension}"));
        (1..10_000).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(10_000))
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.frames.wait(); // a lost device uses nothing any more
    }
}

fn make_folder(path: &Path) -> Result<(), RunError> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.map_or(Ok(()), |folder| {
        std::fs::create_dir_all(folder)
            .map_err(atomic::failed(folder, "make the folder"))
            .map_err(RunError::from)
    })
}
