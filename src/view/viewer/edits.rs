// SPDX-License-Identifier: MIT OR Apache-2.0
//! Edits of the scene, saving, starting again, and reading again. What cannot be used is said, and all stays as it is.

use super::{keep::make_folder, Viewer};
use crate::{
    run::{atomic, RunError, World},
    scene::{Scene, SceneError},
    view::{
        document::{Document, Source},
        panel::Ask,
        ViewError,
    },
};
use std::{path::Path, time::Instant};

impl Viewer {
    pub(super) fn answer(&mut self, ask: Ask) -> Result<bool, ViewError> {
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
                let done = self.save(&path);
                self.pass(done)?;
            }
            Ask::Pace(pace) => self.pace = pace,
        }
        Ok(true)
    }

    /// Writes the scene as it is edited; from now on the window is of that file, and F5 reads it.
    ///
    /// # Errors
    /// If it is no scene, or the file's.
    pub(super) fn save(&mut self, path: &Path) -> Result<(), ViewError> {
        self.document.read().0?; // what would not open again is said here
        make_folder(path)?;
        let failed = atomic::failed(path, "find the way to the files of the scene");
        let document = self.document.moved_to(path).map_err(failed)?;
        let text = document.text();
        atomic::write_atomic(path, |file| file.write_all(text.as_bytes()))?;
        let (name, file) = (path.display().to_string(), Some(path.to_owned()));
        (self.document, self.source) = (document, Source { text, name, file, changes: Vec::new() });
        self.is_edited = false;
        self.say(format!("{} is written, and read by F5.", path.display()));
        Ok(())
    }

    /// The window cannot go on: edits that were not saved are, whether or not they make a scene.
    pub fn rescue(&mut self) {
        if !self.is_edited {
            return;
        }
        let path = self.free_name("scene", "toml");
        let moved = make_folder(&path).ok().and_then(|()| self.document.moved_to(&path).ok());
        let text = moved.as_ref().unwrap_or(&self.document).text();
        match atomic::write_atomic(&path, |file| file.write_all(text.as_bytes())) {
            Ok(()) => eprintln!("edits that were not saved are in {}", path.display()),
            Err(error) => eprintln!("edits that were not saved are lost: {error}"),
        }
    }

    /// Changes the text; the world follows with the next frames.
    pub(super) fn edit(&mut self, change: impl FnOnce(&mut Document) -> Result<(), String>) {
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
            Err(error) => self.fail(error),
        }
    }

    /// Lets the world follow the text. A drag changes numbers with every frame, and what takes long to make anew follows
    /// less often than that.
    ///
    /// # Errors
    /// What ends the window.
    pub(super) fn follow(&mut self) -> Result<(), ViewError> {
        if self.is_stale && (self.is_scripted || self.followed.elapsed() > 3 * self.cost) {
            self.is_stale = false;
            let (read, _) = self.document.read();
            let start = Instant::now();
            let done = read.map_err(RunError::from).and_then(|scene| self.change_to(scene, false));
            if done.is_ok() {
                self.mend();
            }
            self.pass(done.map_err(ViewError::from))?;
            (self.followed, self.cost) = (Instant::now(), start.elapsed());
        }
        Ok(())
    }

    pub(super) fn change_to(&mut self, scene: Scene, is_all: bool) -> Result<(), RunError> {
        let (plan, time_s) = (scene.plan()?, self.world.time_s());
        let left = self.world.follow(&self.gpu, (&scene, &plan), &self.plan, is_all)?;
        self.left.push(self.frames.number(), left);
        self.plan = plan;
        self.frame_s = 1.0 / scene.output.fps;
        self.json = serde_json::to_value(&scene).unwrap_or_default();
        self.is_touched = true;
        if self.world.time_s() < time_s {
            self.note = Some("The scene begins anew: its meshes, its cells or its seed are others.".into());
        }
        Ok(())
    }

    /// From the start, with the same seed.
    pub(super) fn restart(&mut self) -> Result<(), ViewError> {
        let scene = self.world.scene().clone();
        let new = World::of_size(&self.gpu, &scene, &self.plan, self.world.stage().size())?;
        self.frames.wait()?;
        self.world = new;
        (self.is_touched, self.has_begun) = (false, false);
        self.history.clear();
        Ok(())
    }

    /// Reads scene and shaders again. What cannot be used is said, and all stays as it is.
    pub(super) fn reload(&mut self) {
        match self.try_reload() {
            Ok(note) => self.say(note),
            Err(error) => {
                self.fail(error);
            }
        }
    }

    pub(super) fn try_reload(&mut self) -> Result<String, String> {
        let say = |error: SceneError| error.to_string();
        let mut source = self.source.clone();
        if let Some(file) = &source.file {
            source.text =
                std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
        }
        // A file that is what it was has nothing to say, and edits stay.
        let is_new = source.text != self.source.text;
        let document = if is_new { Document::new(&source).map_err(say)? } else { self.document.clone() };
        let (scene, parameters) = document.read();
        let scene = scene.map_err(say)?;
        let compiled = self.files.compile(|spv| self.gpu.uses_shader(spv))?;
        let shaders = match compiled.as_ref().map(|it| it.names.len()) {
            Some(1) => "1 shader differs from the binary's".to_owned(),
            Some(count) => format!("{count} shaders differ from the binary's"),
            None => format!("no shaders, as there is no folder {} (--glsl)", self.files.dir().display()),
        };
        if compiled.is_none() && source.file.is_none() {
            return Err(format!("Nothing to read again: no file of the scene, and {shaders}."));
        }
        let before = compiled.map(|it| self.gpu.replace_shaders(it.replacements));
        if let Err(error) = self.change_to(scene, true) {
            if let Some(before) = before {
                self.gpu.replace_shaders(before);
            }
            return Err(error.to_string());
        }
        (self.document, self.parameters, self.source) = (document, parameters, source);
        let lost = if is_new && self.is_edited { " Edits that were not saved are gone." } else { "" };
        self.is_edited &= !is_new;
        Ok(format!("Read again: {shaders}.{lost}"))
    }
}
