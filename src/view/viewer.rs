// SPDX-License-Identifier: MIT OR Apache-2.0
//! One window: its frame, its events, its edits.

use super::{
    camera::{Held, Mode, Rig},
    document::{Document, Source},
    keys::Action,
    no_display,
    paint::Painter,
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
    run::{atomic, picture::Picture, Counters, Left, Ray, RunError, World},
    scene::{Parameter, Plan, Scene, SceneError},
};
use glam::{UVec2, Vec2};
use std::{
    collections::VecDeque,
    path::{Path, PathBuf},
    sync::Arc,
    time::{Duration, Instant},
};
use winit::{
    dpi::PhysicalSize,
    event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow},
    keyboard::{KeyCode, PhysicalKey},
    window::Window,
};

/// Longest time that one picture lets pass (s): a window that was held up does not catch up.
const LONGEST_S: f64 = 0.1;
/// From one reading of the counters to the next: it waits for the device.
const COUNT_EVERY: Duration = Duration::from_millis(500);
/// How long a script waits for the window system to give a window its size.
const PATIENCE: Duration = Duration::from_secs(10);
/// Angle within which an emitter is under the pointer (rad).
const GRASP: f32 = 0.04;

/// What is to be kept of the next picture.
enum Keep {
    /// The picture alone.
    Picture(PathBuf),
    /// All that is shown.
    Window(PathBuf),
}

/// What the left button holds.
enum Grasp {
    /// Water and disks.
    Touch,
    /// An emitter by its number, at a height (m).
    Emitter(usize, f32),
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
        (panel.is_open, panel.has_times) = (options.has_panel, options.has_times);
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

    /// Something has happened to the window. `false` if it is the end.
    ///
    /// # Errors
    /// As [`Viewer::new`].
    pub fn on_event(&mut self, event: &WindowEvent) -> Result<bool, ViewError> {
        let is_taken = self.painter.on_event(&self.window, event);
        match event {
            WindowEvent::CloseRequested => return Ok(false),
            WindowEvent::Resized(size) => self.frames.resize((*size).into()),
            WindowEvent::RedrawRequested => return self.redraw(),
            WindowEvent::KeyboardInput { event, .. } => {
                let PhysicalKey::Code(code) = event.physical_key else { return Ok(true) };
                let is_down = event.state == ElementState::Pressed;
                if is_down && (is_taken || self.painter.wants_keys()) {
                    return Ok(true);
                }
                self.hold(code, is_down);
                let flies = self.rig.mode() == Mode::Fly && matches!(code, KeyCode::KeyA | KeyCode::KeyD);
                if is_down && !event.repeat && !flies {
                    return Action::of(code).map_or(Ok(true), |action| self.act(action));
                }
            }
            WindowEvent::Focused(false) => (self.held, self.grasp) = (Held::default(), None),
            WindowEvent::CursorMoved { position, .. } => {
                let at = Vec2::new(position.x as f32, position.y as f32);
                let by = at - self.pointer;
                self.pointer = at;
                if self.turns {
                    self.rig.turn(by);
                }
                if self.pans {
                    self.rig.pan(by, self.height());
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                let is_down = *state == ElementState::Pressed;
                if is_down && (is_taken || self.painter.wants_pointer()) {
                    return Ok(true);
                }
                match button {
                    MouseButton::Left if is_down => self.grasp = Some(self.grasp_at(self.pointer)),
                    MouseButton::Left => self.let_go(),
                    MouseButton::Right => self.turns = is_down,
                    MouseButton::Middle => self.pans = is_down,
                    _ => {}
                }
            }
            WindowEvent::MouseWheel { delta, .. } if !is_taken && !self.painter.wants_pointer() => {
                self.rig.zoom(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => *lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
                });
            }
            _ => {}
        }
        Ok(true)
    }

    fn height(&self) -> f32 {
        self.frames.size().map_or(1.0, |[_, height]| height as f32)
    }

    fn hold(&mut self, code: KeyCode, is_down: bool) {
        let x = if is_down { 1.0 } else { 0.0 };
        match code {
            KeyCode::KeyW => self.held.forward = x,
            KeyCode::KeyS => self.held.forward = -x,
            KeyCode::KeyD => self.held.right = x,
            KeyCode::KeyA => self.held.right = -x,
            KeyCode::KeyE => self.held.up = x,
            KeyCode::KeyQ => self.held.up = -x,
            KeyCode::ShiftLeft | KeyCode::ShiftRight => self.held.is_fast = is_down,
            _ => {}
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

    // -----------------------------------------------------------------------------------------------------------------
    // Frames

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

    fn lay_out(&mut self, asks: &mut Vec<Ask>) -> super::paint::Triangles {
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

    // -----------------------------------------------------------------------------------------------------------------
    // The hand

    fn ray(&mut self, at: Vec2) -> Ray {
        let size = Vec2::from(self.frames.size().unwrap_or([1, 1]).map(|n| n as f32));
        let camera = self.rig.camera(self.world.camera());
        let at = Vec2::new(2.0 * at.x / size.x - 1.0, 1.0 - 2.0 * at.y / size.y);
        Ray::new(&camera, size.as_uvec2(), at)
    }

    /// The emitter under the pointer, or else whatever can be touched.
    fn grasp_at(&mut self, at: Vec2) -> Grasp {
        let ray = self.ray(at);
        let angles =
            self.plan.emitters.iter().enumerate().map(|(i, it)| (ray.angle_to(it.at_m), i, it.at_m.y));
        match angles.min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((angle, emitter, height_m)) if angle < GRASP => Grasp::Emitter(emitter, height_m),
            _ => Grasp::Touch,
        }
    }

    /// What is held follows the pointer.
    fn reach_in(&mut self) -> Result<(), ViewError> {
        let ray = self.ray(self.pointer);
        match self.grasp {
            None => self.world.let_go(),
            Some(Grasp::Touch) => {
                self.world.let_go();
                self.is_touched |= self.world.touch(&self.gpu, &ray)?.is_some();
            }
            Some(Grasp::Emitter(emitter, height_m)) => {
                if let Some(at_m) = ray.at_height(height_m) {
                    self.world.move_emitter(emitter, at_m);
                    self.is_touched = true;
                }
            }
        }
        Ok(())
    }

    /// Where an emitter was let go goes into the scene.
    fn let_go(&mut self) {
        if let Some(Grasp::Emitter(emitter, height_m)) = self.grasp.take() {
            let ray = self.ray(self.pointer);
            if let Some(at_m) = ray.at_height(height_m) {
                let numbers = at_m.to_array().map(|x| f64::from((x * 1e3).round() * 1e-3));
                self.edit(|document| {
                    document.set_numbers(&format!("emitter.{emitter}.at_m"), &numbers, false)
                });
            }
        }
        self.world.let_go();
    }

    // -----------------------------------------------------------------------------------------------------------------
    // Edits

    fn answer(&mut self, ask: Ask) -> Result<bool, ViewError> {
        match ask {
            Ask::Do(action) => return self.act(action),
            Ask::Numbers(path, numbers, is_whole) => {
                self.edit(|document| document.set_numbers(&path, &numbers, is_whole));
            }
            Ask::Text(path, text) => self.edit(|document| document.put(&path, text.into())),
            Ask::Flag(path, flag) => self.edit(|document| document.put(&path, flag.into())),
            Ask::Remove(path) => self.edit(|document| {
                document.remove(&path);
                Ok(())
            }),
            Ask::Save => {
                let path = self.free_name("scene", "toml");
                self.save(&path)?;
            }
            Ask::Pace(pace) => self.pace = pace,
        }
        Ok(true)
    }

    fn save(&mut self, path: &Path) -> Result<(), ViewError> {
        let text = self.document.text();
        let saved = make_folder(path).and_then(|()| {
            atomic::write_atomic(path, |file| file.write_all(text.as_bytes())).map_err(RunError::from)
        });
        match saved {
            Ok(()) => {
                self.is_edited = false;
                self.say(format!("{} is written.", path.display()));
            }
            Err(error) if self.is_scripted => return Err(error.into()),
            Err(error) => self.error = Some(error.to_string()),
        }
        Ok(())
    }

    /// Changes the text; the world follows with the next frames.
    fn edit(&mut self, change: impl FnOnce(&mut Document) -> Result<(), String>) {
        let mut document = self.document.clone();
        match change(&mut document) {
            Ok(()) => {
                (self.document, self.is_stale, self.is_edited) = (document, true, true);
                let (read, parameters) = self.document.read();
                // What is listed of a scene that is wrong may end in the middle.
                if read.is_ok() || parameters.len() >= self.parameters.len() {
                    self.parameters = parameters;
                }
            }
            Err(error) => self.error = Some(error),
        }
    }

    /// Lets the world follow the text. A drag changes numbers with every frame, and what takes long to make anew follows
    /// less often than that.
    fn follow(&mut self) {
        if self.is_stale && (self.is_scripted || self.followed.elapsed() > 3 * self.cost) {
            self.is_stale = false;
            let (read, _) = self.document.read();
            let start = Instant::now();
            match read.map_err(RunError::from).and_then(|scene| self.change_to(scene, false)) {
                Ok(()) => self.error = None,
                Err(error) => self.error = Some(error.to_string()),
            }
            (self.followed, self.cost) = (Instant::now(), start.elapsed());
        }
    }

    fn change_to(&mut self, scene: Scene, is_all: bool) -> Result<(), RunError> {
        let plan = scene.plan()?;
        let left = self.world.follow(&self.gpu, (&scene, &plan), &self.plan, is_all)?;
        self.left.push(self.frames.number(), left);
        self.plan = plan;
        self.frame_s = 1.0 / scene.output.fps;
        self.json = serde_json::to_value(&scene).unwrap_or_default();
        self.is_touched = true;
        Ok(())
    }

    /// From the start, with the same seed.
    fn restart(&mut self) -> Result<(), ViewError> {
        let scene = self.world.scene().clone();
        let new = World::of_size(&self.gpu, &scene, &self.plan, self.world.stage().size())?;
        self.frames.wait()?;
        self.world = new;
        (self.is_touched, self.has_begun) = (false, false);
        self.history.clear();
        Ok(())
    }

    /// Reads scene and shaders again. What cannot be used is said, and all stays as it is.
    fn reload(&mut self) {
        match self.try_reload() {
            Ok(note) => self.say(note),
            Err(error) => {
                if self.is_scripted {
                    println!("{error}");
                }
                self.error = Some(error);
            }
        }
    }

    fn try_reload(&mut self) -> Result<String, String> {
        let say = |error: SceneError| error.to_string();
        let mut source = self.source.clone();
        if let Some(file) = &source.file {
            source.text =
                std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
        }
        // Without a file there is nothing to read but the shaders, and edits stay.
        let document = match &source.file {
            Some(_) if source.text != self.source.text => Document::new(&source).map_err(say)?,
            _ => self.document.clone(),
        };
        let (scene, parameters) = document.read();
        let scene = scene.map_err(say)?;
        let files = self.files.as_ref().map_err(|error| format!("no shaders to read: {error}"));
        let compiled = match (files, &source.file) {
            (Ok(files), _) => Some(files.compile(&self.gpu)?),
            (Err(_), Some(_)) => None,
            (Err(error), None) => return Err(error),
        };
        let count = compiled.as_ref().map_or(0, |it| it.names.len());
        let before = compiled.map(|it| self.gpu.replace_shaders(it.replacements));
        if let Err(error) = self.change_to(scene, true) {
            if let Some(before) = before {
                self.gpu.replace_shaders(before);
            }
            return Err(error.to_string());
        }
        (self.document, self.parameters, self.source) = (document, parameters, source);
        let shaders = if count == 1 { "shader differs" } else { "shaders differ" };
        Ok(format!("Read again: {count} {shaders} from the binary's."))
    }

    // -----------------------------------------------------------------------------------------------------------------
    // Without hands

    fn follow_script(&mut self) -> Result<bool, ViewError> {
        let Some(command) = self.script.front().cloned() else { return Ok(false) };
        let mut is_done = true;
        match command {
            Command::Frames(0) => {}
            Command::Frames(n) => {
                is_done = false;
                self.script[0] = Command::Frames(n - 1);
                self.picture()?;
            }
            Command::Resize(size) => {
                if self.asked.is_none() {
                    let asked = PhysicalSize::new(size[0], size[1]);
                    if let Some(now) = self.window.request_inner_size(asked) {
                        self.frames.resize(now.into());
                    }
                }
                let since = *self.asked.get_or_insert_with(Instant::now);
                self.draw(None, None)?;
                is_done = self.frames.size() == Some(size);
                if !is_done && since.elapsed() > PATIENCE {
                    let has = self.frames.size();
                    let text = format!("the window did not become {} x {}: it is {has:?}", size[0], size[1]);
                    return Err(ViewError::Window(text));
                }
            }
            Command::Minimise => {
                self.frames.resize([0, 0]);
                self.draw(None, None)?;
            }
            Command::Restore => {
                self.frames.resize(self.window.inner_size().into());
                self.draw(None, None)?;
            }
            Command::Key(action) => return self.end_of(true, action),
            Command::Set(text) => {
                let (path, value) = text.split_once('=').unwrap_or((&text, ""));
                self.edit(|document| document.set(path.trim(), value));
                self.follow();
                if let Some(error) = &self.error {
                    println!("{error}");
                }
            }
            Command::Touch(_, 0) => self.grasp = None,
            Command::Touch(at, n) => {
                is_done = false;
                self.script[0] = Command::Touch(at, n - 1);
                (self.pointer, self.grasp) = (at, Some(Grasp::Touch));
                self.picture()?;
            }
            Command::Drag(from, to) => {
                self.grasp = Some(self.grasp_at(from));
                for at in [from, to] {
                    self.pointer = at;
                    self.picture()?;
                }
                self.let_go();
                self.follow();
            }
            Command::Screenshot(path) => {
                self.draw(None, Some(Keep::Picture(path)))?;
            }
            Command::Window(path) => {
                // Once for what egui has to measure first.
                self.draw(None, None)?;
                self.draw(None, Some(Keep::Window(path)))?;
            }
            Command::Save(path) => self.save(&path)?,
            Command::Say => {
                let counters = self.world.counters()?;
                println!("time {:.6} s, camera {:?}", self.world.time_s(), self.rig.mode());
                for Counters { name, counts } in counters {
                    let counts: Vec<_> = counts.iter().map(|(what, n)| format!("{what} {n}")).collect();
                    println!("{name}: {}", counts.join(", "));
                }
                println!("hashes {}", self.world.hashes(&self.gpu)?.join(" "));
            }
            Command::Exit => return Ok(false),
        }
        if is_done {
            self.script.pop_front();
            self.asked = None;
        }
        Ok(true)
    }

    fn end_of(&mut self, is_done: bool, action: Action) -> Result<bool, ViewError> {
        if is_done {
            self.script.pop_front();
        }
        self.act(action)
    }

    /// The next picture as a run has it: the first is the start.
    fn picture(&mut self) -> Result<(), ViewError> {
        let passes_s = if self.has_begun { self.frame_s } else { 0.0 };
        self.has_begun = true;
        self.draw(Some(passes_s), None).map(drop)
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
