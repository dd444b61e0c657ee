// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures as files: frames, contact sheet, clip, on a thread of their own.

use super::{
    atomic,
    clip::{Clip, ClipOptions},
    picture::{contact_sheet, Picture},
    trace::{Trace, Track},
    RunError, RunOptions,
};
use crate::{
    gpu::{HostTime, Zone},
    scene::Scene,
};
use std::{
    fs,
    path::{Path, PathBuf},
    sync::mpsc,
    time::Instant,
};

/// Pictures on a contact sheet.
const SHEET: u32 = 12;

/// Writes pictures as they come.
pub(super) struct Encoder {
    frames_dir: Option<PathBuf>,
    sheet_path: PathBuf,
    sheet_every: u32,
    clip: Clip,
}

/// What was written, and warnings.
type Files = (Vec<(&'static str, PathBuf)>, Vec<String>);

impl Encoder {
    pub fn new(scene: &Scene, options: &RunOptions) -> Result<Self, RunError> {
        let [width, height] = scene.output.size;
        let settings = ClipOptions { fps: scene.output.fps, ..ClipOptions::default() };
        Ok(Self {
            frames_dir: options.has_frames.then(|| options.out.join("frames")),
            sheet_path: options.out.join("contact.png"),
            sheet_every: scene.output.frames.div_ceil(SHEET).max(1),
            clip: Clip::new(&options.out.join("clip"), width, height, settings)?,
        })
    }

    pub fn take(
        mut self,
        first: u32,
        pictures: mpsc::Receiver<Picture>,
        trace: Option<&Trace>,
    ) -> Result<Files, RunError> {
        let mut sheet = Vec::new();
        for (frame, picture) in (first..).zip(pictures) {
            let (start, _zone) = (Instant::now(), Zone::new("encode"));
            if let Some(dir) = &self.frames_dir {
                picture.write_png(&numbered(dir, frame))?;
            }
            if frame % self.sheet_every == self.sheet_every / 2 || self.sheet_every == 1 {
                sheet.push(picture.downscale(TILE));
            }
            self.clip.push(&picture)?;
            if let Some(trace) = trace {
                let time = HostTime::until_now("encode", start);
                trace.span(Track::Encoder, &time, time.name, serde_json::json!({ "picture": frame }));
            }
        }
        contact_sheet(&sheet, 3, TILE).write_png(&self.sheet_path)?;
        let clip = self.clip.finish()?;
        let mut files = vec![("contact sheet", self.sheet_path), ("clip", clip.apng)];
        files.extend(clip.mp4.map(|path| ("clip, mp4", path)));
        files.extend(self.frames_dir.map(|path| ("pictures", path)));
        Ok((files, clip.warnings))
    }
}

/// Width of a picture on the contact sheet (pixels).
const TILE: u32 = 480;

/// Pictures of an earlier run would pass for this one's.
pub(super) fn remove_pictures(dir: &Path) -> Result<(), atomic::FileError> {
    let listed = fs::read_dir(dir).map_err(atomic::failed(dir, "list the pictures of an earlier run"))?;
    for path in listed.flatten().map(|entry| entry.path()) {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        if name.starts_with("frame_") && name.ends_with(".png") {
            fs::remove_file(&path).map_err(atomic::failed(&path, "remove a picture of an earlier run"))?;
        }
    }
    Ok(())
}

fn numbered(dir: &Path, frame: u32) -> PathBuf {
    dir.join(format!("frame_{frame:05}.png"))
}
