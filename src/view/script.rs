// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a window is told to do without hands: for tests, and for pictures of documentation.

use super::keys::{Action, KEYS};
use glam::Vec2;
use std::{path::PathBuf, str::FromStr};

/// One thing to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// So many pictures, each a picture's time after the last; the first is the start, as in a run.
    Frames(u32),
    /// The window gets another size (pixels), and is waited for.
    Resize([u32; 2]),
    /// The window has no area, as when it is minimised.
    Minimise,
    /// It has one again.
    Restore,
    /// The window system has lost its surface, which is made anew.
    Renew,
    /// What a key does.
    Key(Action),
    /// A change of the scene, as the panel makes it: `key.path=value`.
    Set(String),
    /// A finger at a pixel for so many pictures.
    Touch(Vec2, u32),
    /// An emitter is dragged from one pixel to another.
    Drag(Vec2, Vec2),
    /// Keys with this text in their path are shown in the panel.
    Find(String),
    /// The picture, without the panel.
    Screenshot(PathBuf),
    /// All that is shown, with the panel.
    Window(PathBuf),
    /// The edited scene.
    Save(PathBuf),
    /// Until a file is there, which someone else writes.
    Wait(PathBuf),
    /// Time, counters and hashes are printed.
    Say,
    /// The end.
    Exit,
}

/// Commands in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Script(pub Vec<Command>);

impl Script {
    /// Then writes the picture.
    pub fn keep(&mut self, path: &std::path::Path) {
        self.0.push(Command::Screenshot(path.to_owned()));
    }
}

/// How commands are written, for `--help`.
pub const COMMANDS: &str =
    "frames N; resize WxH; minimise; restore; renew; key NAME; set KEY.PATH=VALUE; find TEXT; touch X,Y N; \
                            drag X,Y X,Y; screenshot FILE; window FILE; save FILE; wait FILE; say; exit";

fn size(text: &str) -> Option<[u32; 2]> {
    let (w, h) = text.split_once('x')?;
    Some([w.parse().ok()?, h.parse().ok()?])
}

fn point(text: &str) -> Option<Vec2> {
    let (x, y) = text.split_once(',')?;
    Some(Vec2::new(x.parse().ok()?, y.parse().ok()?))
}

fn command(text: &str) -> Result<Command, String> {
    let (word, rest) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
    let rest = rest.trim();
    let two = || rest.split_once(char::is_whitespace).map(|(a, b)| (a, b.trim()));
    let read = match word {
        "frames" => rest.parse().ok().map(Command::Frames),
        "resize" => size(rest).map(Command::Resize),
        "minimise" if rest.is_empty() => Some(Command::Minimise),
        "restore" if rest.is_empty() => Some(Command::Restore),
        "renew" if rest.is_empty() => Some(Command::Renew),
        "key" => {
            let names: Vec<&str> = KEYS.iter().map(|key| key.name).collect();
            let action = Action::named(rest);
            return action
                .map(Command::Key)
                .ok_or_else(|| format!("`{text}`: no such key; there are: {}", names.join(" ")));
        }
        "set" => rest.contains('=').then(|| Command::Set(rest.into())),
        "find" => Some(Command::Find(rest.into())),
        "touch" => two().and_then(|(at, n)| Some(Command::Touch(point(at)?, n.parse().ok()?))),
        "drag" => two().and_then(|(from, to)| Some(Command::Drag(point(from)?, point(to)?))),
        "screenshot" => (!rest.is_empty()).then(|| Command::Screenshot(rest.into())),
        "window" => (!rest.is_empty()).then(|| Command::Window(rest.into())),
        "save" => (!rest.is_empty()).then(|| Command::Save(rest.into())),
        "wait" => (!rest.is_empty()).then(|| Command::Wait(rest.into())),
        "say" if rest.is_empty() => Some(Command::Say),
        "exit" if rest.is_empty() => Some(Command::Exit),
        _ => None,
    };
    read.ok_or_else(|| format!("`{text}` is no command; allowed: {COMMANDS}"))
}

impl FromStr for Script {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let lines = text.split([';', '\n']).map(str::trim).filter(|line| !line.is_empty());
        lines.map(command).collect::<Result<_, _>>().map(Self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scripts_are_read() {
        let script: Script = "frames 3; resize 640x400; key f1;touch 10,20.5 4; screenshot a b.png; exit"
            .parse()
            .expect("a script");
        assert_eq!(
            script.0,
            [
                Command::Frames(3),
                Command::Resize([640, 400]),
                Command::Key(Action::Panel),
                Command::Touch(Vec2::new(10.0, 20.5), 4),
                Command::Screenshot("a b.png".into()),
                Command::Exit,
            ]
        );
    }

    #[test]
    fn what_is_no_command_is_named_with_what_is() {
        for wrong in ["frames", "frames x", "resize 3", "key F77", "jump", "exit now", "set a"] {
            let error = wrong.parse::<Script>().expect_err(wrong);
            assert!(
                error.contains(&format!("`{wrong}`")) && error.contains("F1") | error.contains("resize"),
                "{error}"
            );
        }
    }
}
