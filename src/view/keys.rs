// SPDX-License-Identifier: MIT OR Apache-2.0
//! What keys do. Scripts and the panel name the same actions.

use winit::keyboard::KeyCode;

/// What can be asked of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Time stops, or goes on.
    Pause,
    /// One picture further, and stop.
    Step,
    /// From the start, with the same seed.
    Restart,
    /// The scene's own camera.
    Home,
    /// A camera round a point.
    Orbit,
    /// A camera that flies.
    Fly,
    /// All of the scene in the picture.
    Fit,
    /// Shows the panel, or hides it.
    Panel,
    /// Writes the picture to a file.
    Screenshot,
    /// Reads scene and shaders again.
    Reload,
    /// Writes a trace of the frames to come.
    Trace,
    /// Has RenderDoc capture the next frame.
    Capture,
    /// Leaves.
    Quit,
}

/// Key, its name, and what it does.
pub struct Key {
    /// Where it is on the keyboard.
    pub code: KeyCode,
    /// As it is written on it.
    pub name: &'static str,
    /// What it does.
    pub action: Action,
    /// The same for people.
    pub about: &'static str,
}

const fn key(code: KeyCode, name: &'static str, action: Action, about: &'static str) -> Key {
    Key { code, name, action, about }
}

/// All of them.
pub const KEYS: [Key; 14] = [
    key(KeyCode::Space, "Space", Action::Pause, "pause, go on"),
    key(KeyCode::Period, ".", Action::Step, "one picture further, and stop"),
    key(KeyCode::KeyR, "R", Action::Restart, "start again with the same seed"),
    key(KeyCode::KeyH, "H", Action::Home, "the scene's camera"),
    key(KeyCode::KeyO, "O", Action::Orbit, "orbit: right button turns, middle button pans, wheel zooms"),
    key(KeyCode::KeyF, "F", Action::Fly, "fly: W A S D, E up, Q down, Shift faster, right button looks"),
    key(KeyCode::KeyV, "V", Action::Fit, "view all of the scene"),
    key(KeyCode::F1, "F1", Action::Panel, "show or hide the panel"),
    key(KeyCode::F2, "F2", Action::Screenshot, "write the picture to a file"),
    key(KeyCode::F5, "F5", Action::Reload, "read scene and shaders again"),
    key(KeyCode::F9, "F9", Action::Trace, "write a trace of the next frames"),
    key(KeyCode::F12, "F12", Action::Capture, "capture a frame with RenderDoc"),
    key(KeyCode::Home, "Home", Action::Home, "the scene's camera"),
    key(KeyCode::Escape, "Esc", Action::Quit, "leave"),
];

impl Action {
    /// Of a key that was pressed.
    pub fn of(code: KeyCode) -> Option<Self> {
        KEYS.iter().find(|key| key.code == code).map(|key| key.action)
    }

    /// Of a key by its name, as scripts have it.
    pub fn named(name: &str) -> Option<Self> {
        KEYS.iter().find(|key| key.name.eq_ignore_ascii_case(name)).map(|key| key.action)
    }
}
