// SPDX-License-Identifier: MIT OR Apache-2.0
//! A window without hands.

use super::{hand::Grasp, Drawn, Viewer};
use crate::{
    run::Counters,
    view::{keys::Action, script::Command, ViewError},
};
use std::time::{Duration, Instant};
use winit::dpi::PhysicalSize;

/// How long a script waits for the window system to give a window its size, or its images.
const PATIENCE: Duration = Duration::from_secs(10);
/// How long it waits for a file, which others take their time to write.
const FILE_PATIENCE: Duration = Duration::from_secs(60);

impl Viewer {
    pub(super) fn follow_script(&mut self) -> Result<bool, ViewError> {
        let Some(command) = self.script.front().cloned() else { return Ok(false) };
        let mut is_done = true;
        match command {
            Command::Frames(0) => {}
            Command::Frames(n) => {
                is_done = false;
                if self.picture()? {
                    self.script[0] = Command::Frames(n - 1);
                }
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
                self.is_minimised = true;
                self.frames.resize([0, 0]);
                self.draw(None, None)?;
            }
            Command::Restore => {
                self.is_minimised = false;
                self.frames.resize(self.window.inner_size().into());
                self.draw(None, None)?;
            }
            Command::Renew => {
                self.frames.lose_surface();
                self.draw(None, None)?;
            }
            Command::Key(action) => return self.end_of(true, action),
            Command::Set(text) => {
                let (path, value) = text.split_once('=').unwrap_or((&text, ""));
                self.edit(|document| document.set(path.trim(), value));
                self.follow()?;
            }
            Command::Find(text) => self.panel.filter = text,
            Command::Touch(_, 0) => self.grasp = None,
            Command::Touch(at, n) => {
                is_done = false;
                (self.pointer, self.grasp) = (at, Some(Grasp::Touch));
                if self.picture()? {
                    self.script[0] = Command::Touch(at, n - 1);
                }
            }
            Command::Drag(from, to) => {
                self.grasp = Some(self.grasp_at(from));
                for at in [from, to] {
                    self.pointer = at;
                    self.picture()?;
                }
                self.let_go();
                self.follow()?;
            }
            Command::Screenshot(path) => {
                self.keep_picture(&path)?;
            }
            Command::Window(path) => self.keep_window(&path)?,
            Command::Save(path) => self.save(&path)?,
            Command::Wait(path) => {
                let since = *self.asked.get_or_insert_with(Instant::now);
                self.draw(None, None)?;
                is_done = path.exists();
                if !is_done && since.elapsed() > FILE_PATIENCE {
                    return Err(ViewError::Script(format!("{} does not come", path.display())));
                }
            }
            Command::Say => {
                let counters = self.world.counters()?;
                println!("time {:.6} s, camera {:?}", self.world.time_s(), self.rig.mode());
                for Counters { name, counts } in counters {
                    let counts: Vec<_> = counts.iter().map(|(what, n)| format!("{what} {n}")).collect();
                    println!("{name}: {}", counts.join(", "));
                }
                println!("hashes {}", self.world.hashes(&self.gpu)?.join(" "));
            }
            Command::Exit => {
                self.end_trace()?;
                return Ok(false);
            }
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

    /// The next picture as a run has it: the first is the start. `false` if it is still to come: the window is covered, and
    /// not by the script.
    fn picture(&mut self) -> Result<bool, ViewError> {
        let passes_s = if self.has_begun { self.frame_s } else { 0.0 };
        if self.draw(Some(passes_s), None)? == Drawn::Hidden {
            let since = *self.asked.get_or_insert_with(Instant::now);
            if !self.is_minimised && since.elapsed() > PATIENCE {
                return Err(ViewError::Window(
                    "the window shows no pictures: it is covered, or has no area".into(),
                ));
            }
            return Ok(self.is_minimised);
        }
        (self.has_begun, self.asked) = (true, None);
        Ok(true)
    }
}
