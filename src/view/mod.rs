// SPDX-License-Identifier: MIT OR Apache-2.0
//! `whitecap view`: a scene in a window, with its numbers to be changed while it runs.
//!
//! The window drives the same [`World`](crate::run::World) as the headless runner: time passes ([`World::advance`]), a
//! camera looks ([`World::look`]), due steps and a picture are recorded ([`World::record`]). Told to show pictures of the
//! scene's own times and camera, it shows what a run writes, to the byte.
//!
//! | file       | is |
//! | ---------- | -- |
//! | `viewer`   | one window: its frame, its events, its edits |
//! | `camera`   | home, orbit, fly, fit |
//! | `keys`     | what keys do |
//! | `panel`    | the panel, generated from the keys of the scene |
//! | `document` | the scene as a text that is edited |
//! | `times`    | times of passes over frames |
//! | `script`   | a window without hands |
//! | `paint`    | the panel on the GPU |
//!
//! Left out: several windows, full screen, gamepads, touch screens, editing tables that a scene does not have yet (but
//! through its text: save, edit, F5).
//!
//! [`World::advance`]: crate::run::World::advance
//! [`World::look`]: crate::run::World::look
//! [`World::record`]: crate::run::World::record

mod camera;
mod document;
mod keys;
mod paint;
mod panel;
mod script;
mod times;
mod viewer;

pub use document::Source;
pub use script::{Script, COMMANDS};

use crate::{
    gpu::{self, GpuOptions, Messages},
    run::{atomic::FileError, RunError},
    scene::SceneError,
};
use std::{path::PathBuf, sync::Arc};
use viewer::Viewer;
use winit::{
    application::ApplicationHandler,
    event::{StartCause, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop},
    window::WindowId,
};

/// What to show, and how.
#[derive(Clone, Debug)]
pub struct ViewOptions {
    /// The scene.
    pub source: Source,
    /// The device.
    pub gpu: GpuOptions,
    /// Without hands; an interactive window has an empty one.
    pub script: Script,
    /// Where pictures and edited scenes go.
    pub out: PathBuf,
    /// GLSL of the crate, to be read again.
    pub glsl: PathBuf,
    /// Passes are timed and counters read from the start.
    pub has_times: bool,
    /// The panel is shown.
    pub has_panel: bool,
}

/// What can end a window.
#[derive(Debug, thiserror::Error)]
pub enum ViewError {
    /// The simulation's or the device's.
    #[error(transparent)]
    Run(#[from] RunError),
    /// No window, or a window that does not do as it is told.
    #[error("{0}")]
    Window(String),
    /// A script that cannot be followed.
    #[error("{0}")]
    Script(String),
    /// The panel's renderer.
    #[error("the panel cannot be drawn: {0}")]
    Panel(String),
}

impl From<gpu::Error> for ViewError {
    fn from(error: gpu::Error) -> Self {
        Self::Run(error.into())
    }
}

impl From<SceneError> for ViewError {
    fn from(error: SceneError) -> Self {
        Self::Run(error.into())
    }
}

impl From<FileError> for ViewError {
    fn from(error: FileError) -> Self {
        Self::Run(error.into())
    }
}

impl ViewError {
    /// Whether a window may go on after it: a file, a number or room that was missing, and not the device.
    fn can_go_on(&self) -> bool {
        match self {
            Self::Run(error) => error.gpu().is_none_or(|error| {
                error.is_out_of_memory()
                    || !matches!(error, gpu::Error::Vulkan { .. } | gpu::Error::Timeout { .. })
            }),
            Self::Window(_) => true,
            Self::Script(_) | Self::Panel(_) => false,
        }
    }
}

fn no_display(reason: impl std::fmt::Display) -> ViewError {
    // The window library says first where in its own source it noticed.
    let text = reason.to_string();
    let own = text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": "));
    gpu::Error::NoDisplay { reason: own.map_or(text.as_str(), |(_, said)| said).to_owned() }.into()
}

/// What was shown.
pub struct Shown {
    /// What validation said, also of the end.
    pub messages: Arc<Messages>,
    /// The device's name.
    pub device: String,
}

/// Opens a window and stays until it is closed.
///
/// # Errors
/// Bad input before a window opens; no display; a lost device, a full disk or a script that cannot be followed.
pub fn view(options: ViewOptions) -> Result<Shown, ViewError> {
    viewer::check(&options.source)?;
    let events = EventLoop::new().map_err(no_display)?;
    let mut app = App { options, viewer: None, failed: None, shown: None };
    events.run_app(&mut app).map_err(no_display)?;
    app.viewer = None; // its end may be what validation has something to say about
    match (app.failed, app.shown) {
        (Some(error), _) => Err(error),
        (None, Some(shown)) => Ok(shown),
        (None, None) => Err(no_display("the window was never opened")),
    }
}

struct App {
    options: ViewOptions,
    viewer: Option<Viewer>,
    failed: Option<ViewError>,
    shown: Option<Shown>,
}

impl App {
    fn end(&mut self, events: &ActiveEventLoop, outcome: Result<bool, ViewError>) {
        match outcome {
            Ok(true) => {}
            Ok(false) => events.exit(),
            Err(error) => {
                self.viewer.iter_mut().for_each(Viewer::rescue);
                self.failed.get_or_insert(error);
                events.exit();
            }
        }
    }
}

impl ApplicationHandler for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.viewer.is_some() {
            return;
        }
        events.set_control_flow(ControlFlow::Poll);
        match Viewer::new(events, &self.options) {
            Ok(viewer) => {
                self.shown = Some(viewer.shown());
                self.viewer = Some(viewer);
            }
            Err(error) => self.end(events, Err(error)),
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(viewer) = &mut self.viewer else { return };
        let outcome = viewer.on_event(&event);
        self.end(events, outcome);
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (Some(viewer), StartCause::ResumeTimeReached { .. }) = (&self.viewer, cause) {
            viewer.try_again();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        if let Some(viewer) = &self.viewer {
            events.set_control_flow(viewer.wait());
        }
    }
}
