// SPDX-License-Identifier: MIT OR Apache-2.0
//! Edits of the scene, saving, starting again, and reading again. What cannot be used is said, and all stays as it is.

use super::{make_folder, Viewer};
use crate::{
    run::{atomic, RunError, World},
    scene::{Scene, SceneError},
    view::{document::Document, panel::Ask, ViewError},
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
                self.save(&path)?;
            }
            Ask::Pace(pace) => self.pace = pace,
        }
        Ok(true)
    }

    pub(super) fn save(&mut self, path: &Path) -> Result<(), ViewError> {
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
            Err(error) => self.error = Some(error),
        }
    }

    /// Lets the world follow the text. A drag changes numbers with every frame, and what takes long to make anew follows
    /// less often than that.
    pub(super) fn follow(&mut self) {
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

    pub(super) fn change_to(&mut self, scene: Scene, is_all: bool) -> Result<(), RunError> {
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
                if self.is_scripted {
                    println!("{error}");
                }
                self.error = Some(error);
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
        let lost = if is_new && self.is_edited { " Edits that were not saved are gone." } else { "" };
        self.is_edited &= !is_new;
        let shaders = if count == 1 { "shader differs" } else { "shaders differ" };
        Ok(format!("Read again: {count} {shaders} from the binary's.{lost}"))
    }
}
