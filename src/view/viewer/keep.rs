// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures that are kept, where files go, and what is said of it. What can go wrong and leave the window as it was is said
//! in it: nobody loses an edit to a full disk.

use super::{Drawn, Viewer};
use crate::{
    gpu::{Buffer, Residence},
    run::{atomic, picture::Picture, RunError},
    view::ViewError,
};
use std::path::{Path, PathBuf};

impl Viewer {
    /// Writes the picture as it is now, without the panel. The window is not asked: it may be covered or minimised.
    ///
    /// # Errors
    /// The file's, or the device's.
    pub(super) fn keep_picture(&mut self, path: &Path) -> Result<(), ViewError> {
        self.world.look(&self.rig.camera(self.world.camera()));
        let world = &mut self.world;
        loop {
            let mut recorded = Ok(false);
            self.submitter.run(|rec| {
                rec.after_all(); // frames that are on their way
                recorded = world.record(rec);
                if matches!(recorded, Ok(true)) {
                    world.stage().record_readback(rec);
                }
            })?;
            if recorded? {
                break;
            }
        }
        let [width, height] = self.world.stage().size().to_array();
        self.write(path, Picture { width, height, rgba: self.world.stage().read() })
    }

    /// Writes all that the window shows.
    ///
    /// # Errors
    /// [`ViewError::Window`] if it shows nothing, or nothing that can be read; the file's or the device's.
    pub(super) fn keep_window(&mut self, path: &Path) -> Result<(), ViewError> {
        let nothing = |why: &str| ViewError::Window(format!("{}: {why}", path.display()));
        self.draw(None, None)?; // once for what egui has to measure first
        let Some([width, height]) = self.frames.size() else {
            return Err(nothing("the window shows nothing: it is covered, or has no area"));
        };
        let bytes = 4 * u64::from(width) * u64::from(height);
        let copy = Buffer::new(&self.gpu, "view.copy", bytes, Residence::Readback)?;
        match self.draw(None, Some(&copy))? {
            Drawn::Shown if self.frames.size() != Some([width, height]) => {
                return Err(nothing("the window has become another size meanwhile"))
            }
            Drawn::Shown if self.frames.is_readable() => {}
            Drawn::Shown => return Err(nothing("the device cannot read what its windows show")),
            _ => return Err(nothing("the window shows nothing: it is covered, or has no area")),
        }
        self.frames.wait()?;
        let rgba = self.frames.rgba(copy.read());
        self.write(path, Picture { width, height, rgba })
    }

    fn write(&mut self, path: &Path, picture: Picture) -> Result<(), ViewError> {
        make_folder(path)?;
        picture.write_png(path).map_err(RunError::from)?;
        self.say(format!("{} is written.", path.display()));
        Ok(())
    }

    /// What a hand asked for: where it failed and the window can go on, that is said in it.
    ///
    /// # Errors
    /// What ends the window.
    pub(super) fn pass(&mut self, done: Result<(), ViewError>) -> Result<(), ViewError> {
        match done {
            Err(error) if error.can_go_on() => {
                self.fail(error.to_string());
                Ok(())
            }
            other => other,
        }
    }

    /// Says what went well.
    pub(super) fn say(&mut self, note: String) {
        if self.is_scripted {
            println!("{note}");
        }
        self.note = Some(note);
        self.mend();
    }

    /// Says what went wrong; also in the title, as the panel may be hidden.
    pub(super) fn fail(&mut self, error: String) {
        if self.is_scripted {
            println!("{error}");
        }
        let first = error.lines().next().unwrap_or_default();
        self.window.set_title(&format!("{first} - {}", self.title));
        self.error = Some(error);
    }

    /// What went wrong is no more.
    pub(super) fn mend(&mut self) {
        if self.error.take().is_some() {
            self.window.set_title(&self.title);
        }
    }

    pub(super) fn free_name(&self, stem: &str, extension: &str) -> PathBuf {
        let name = |n: u32| self.out.join(format!("{stem}_{n:03}.{extension}"));
        (1..10_000).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(10_000))
    }
}

pub(super) fn make_folder(path: &Path) -> Result<(), RunError> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.map_or(Ok(()), |folder| {
        std::fs::create_dir_all(folder)
            .map_err(atomic::failed(folder, "make the folder"))
            .map_err(RunError::from)
    })
}
