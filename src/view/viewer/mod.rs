// SPDX-License-Identifier: MIT OR Apache-2.0
//! One window: what it holds, and its frame.

mod capture;
mod edits;
mod hand;
mod keep;
mod scripted;

use super::{
    camera::{Held, Mode, Rig},
    document::{Document, Source},
    keys::Action,
    no_display,
    paint::{Painter, Triangles},
    panel::{Ask, Contents, Panel},
    script::{Command, Script},
    times::History,
    Shown, ViewError, ViewOptions,
};
use crate::{
    gpu::{
        files::Files,
        window::{Finished, Frames, Retired, Timing},
        Buffer, Gpu, RenderDoc, Submitter,
    },
    run::{trace::Trace, Counters, Left, World},
    scene::{Parameter, Plan},
};
use glam::{UVec2, Vec2};
use hand::Grasp;
use std::{
    collections::VecDeque,
    path::PathBuf,
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

/// How long a window that shows nothing is left alone.
const REST: Duration = Duration::from_millis(30);

/// What became of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Drawn {
    /// The window shows it.
    Shown,
    /// The window is covered or has no area: nothing is drawn, and no time passes.
    Hidden,
    /// The window is to be closed.
    Closed,
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
    files: Files,

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
    title: String,
    error: Option<String>,
    note: Option<String>,
    device: String,
    clock: &'static str,

    /// What is being traced, and for how many frames more.
    trace: Option<(Trace, u32)>,

    is_paused: bool,
    /// Another window hides this one, says the window system.
    is_covered: bool,
    has_focus: bool,
    /// What became of the last frame, and when it was tried.
    drawn: Drawn,
    tried: Instant,
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
    /// The script has minimised the window.
    is_minimised: bool,
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
        let title = format!("{title} - whitecap");
        let attributes =
            Window::default_attributes().with_title(&title).with_inner_size(PhysicalSize::new(width, height));
        let window = Arc::new(events.create_window(attributes).map_err(no_display)?);
        let (gpu, surface) = Gpu::for_window(&options.gpu, Box::new(window.clone()))?;
        if let Some(renderdoc) = RenderDoc::watching() {
            renderdoc.leave_keys(); // F12 is this window's
        }
        let size: [u32; 2] = window.inner_size().into();
        let frames = Frames::new(&gpu, surface, size)?;
        let world =
            World::of_size(&gpu, &scene, &plan, UVec2::from(frames.size().unwrap_or([width, height])))?;
        let painter = Painter::new(&gpu, &frames, &window)?;
        let clock = if options.has_times { gpu.clock()?.name() } else { "" };
        let panel = Panel {
            is_open: options.has_panel,
            has_times: options.has_times,
            has_counters: options.has_times,
            ..Panel::default()
        };
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
            title,
            error: None,
            note: Some("F1 hides the panel; its last section lists the keys.".into()),
            clock,
            trace: None,
            is_paused: false,
            is_covered: false,
            has_focus: true,
            drawn: Drawn::Shown,
            tried: now,
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
            is_minimised: false,
            asked: None,
        })
    }

    /// For whoever asks when the window is gone.
    pub fn shown(&self) -> Shown {
        Shown { messages: self.gpu.messages(), device: self.gpu.name().into() }
    }

    /// When the next frame is due: at once, and while nothing is shown now and then.
    pub fn wait(&self) -> ControlFlow {
        if self.drawn == Drawn::Hidden {
            return ControlFlow::WaitUntil(self.tried + REST);
        }
        self.window.request_redraw();
        ControlFlow::Poll
    }

    /// The wait is over.
    pub fn try_again(&self) {
        self.window.request_redraw();
    }

    /// Does what a key asks for. `false` if it is the end.
    fn act(&mut self, action: Action) -> Result<bool, ViewError> {
        match action {
            Action::Pause => self.is_paused = !self.is_paused,
            Action::Step => (self.is_paused, self.steps) = (true, self.steps + 1),
            Action::Restart => {
                let done = self.restart();
                self.pass(done)?;
            }
            Action::Home => self.rig.set_mode(Mode::Home),
            Action::Orbit => self.rig.set_mode(Mode::Orbit),
            Action::Fly => self.rig.set_mode(Mode::Fly),
            Action::Fit => self.rig.fit(self.world.scene()),
            Action::Panel => self.panel.is_open = !self.panel.is_open,
            Action::Screenshot => {
                let path = self.free_name("screenshot", "png");
                let done = self.keep_picture(&path);
                self.pass(done)?;
            }
            Action::Reload => self.reload(),
            Action::Trace => self.begin_trace(),
            Action::Capture => {
                let done = self.capture();
                self.pass(done)?;
            }
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
        Ok(self.draw(passes_s, None)? != Drawn::Closed)
    }

    /// Draws a frame, `passes_s` after the last; `copy` gets what the window shows.
    fn draw(&mut self, passes_s: Option<f64>, copy: Option<&Buffer>) -> Result<Drawn, ViewError> {
        self.tried = Instant::now();
        self.drawn = self.draw_shown(passes_s, copy)?;
        Ok(self.drawn)
    }

    /// Whether nobody can see it. X11 says that a window is covered, but that it is minimised only to who asks; one that
    /// has the focus is not.
    fn is_hidden(&self) -> bool {
        self.is_covered || (!self.has_focus && self.window.is_minimized() == Some(true))
    }

    fn draw_shown(&mut self, passes_s: Option<f64>, copy: Option<&Buffer>) -> Result<Drawn, ViewError> {
        if self.is_hidden() || !self.frames.begin()? {
            return Ok(Drawn::Hidden);
        }
        self.left.free_up_to(self.frames.done());
        let Some(size) = self.frames.size() else { return Ok(Drawn::Hidden) };
        if UVec2::from(size) != self.world.stage().size() {
            self.world.resize(&self.gpu, &self.plan, UVec2::from(size))?;
        }
        let timing = self.take_times()?;
        let counted = self.count();
        self.pass(counted)?;
        let mut asks = Vec::new();
        let triangles = self.lay_out(&mut asks);
        self.painter.upload(&mut self.frames)?;

        if let Some(passes_s) = passes_s {
            let reached = self.reach_in();
            self.pass(reached)?;
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
        let copy = copy.filter(|copy| copy.bytes() == 4 * u64::from(size[0]) * u64::from(size[1]));
        let (world, painter) = (&mut self.world, &mut self.painter);
        self.frames.finish::<ViewError>(
            timing,
            |rec| {
                world.record(rec)?;
                Ok(Finished { pixels: world.stage().pixels().clone(), size })
            },
            |cmd, size| painter.draw(cmd, size, &triangles),
            copy,
        )?;
        for ask in asks {
            if !self.answer(ask)? {
                return Ok(Drawn::Closed);
            }
        }
        self.follow()?;
        Ok(Drawn::Shown)
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

    /// What passes have taken, for the panel and the trace; and what is to be known of those of the next frame.
    fn take_times(&mut self) -> Result<Timing, ViewError> {
        let timed = self.frames.take_timed();
        let is_shown = self.panel.has_times && self.panel.is_open;
        if is_shown || self.trace.is_some() {
            self.clock = self.gpu.clock()?.name();
        }
        match &timed {
            Some(timed) if is_shown => self.history.push(&timed.times.spans),
            _ if !is_shown => self.history.clear(),
            _ => {}
        }
        let traced = self.trace_frame(timed);
        self.pass(traced)?;
        Ok(match (&self.trace, is_shown) {
            (Some(_), _) => Timing::Places,
            (None, true) => Timing::Lengths,
            (None, false) => Timing::Off,
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
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.frames.wait_for_all(); // not only as long as a frame may take: what is in flight is not freed
    }
}
