// SPDX-License-Identifier: MIT OR Apache-2.0
//! Traces of frames, and captures by RenderDoc.

use super::{keep::make_folder, Drawn, Viewer};
use crate::{
    gpu::{window::Timed, RenderDoc},
    run::{trace::Trace, RunError},
    view::ViewError,
};
use serde_json::json;

/// Frames of a trace.
const TRACED: u32 = 120;

impl Viewer {
    /// Begins a trace of the frames to come. Their passes are timed, and do not overlap.
    pub(super) fn begin_trace(&mut self) {
        if self.trace.is_some() {
            return;
        }
        let path = self.free_name("trace", "json");
        let made = make_folder(&path).and_then(|()| Trace::create(&path).map_err(RunError::from));
        match made {
            Ok(trace) => {
                let about = json!({ "scene": self.world.scene().title, "device": self.device });
                trace.describe(self.gpu.name(), about);
                self.trace = Some((trace, TRACED));
                self.note = Some(format!("{TRACED} frames are traced."));
            }
            Err(error) => self.fail(error.to_string()),
        }
    }

    /// One more frame, if there is a trace and it was timed. A trace that cannot be written ends.
    ///
    /// # Errors
    /// The file's.
    pub(super) fn trace_frame(&mut self, timed: Option<Timed>) -> Result<(), ViewError> {
        let Some(timed) = timed else { return Ok(()) };
        let Some((trace, left)) = self.trace.take() else { return Ok(()) };
        trace.picture(timed.number as u32, &timed.whole, &timed.times);
        trace.flush().map_err(RunError::from)?;
        self.trace = Some((trace, left - 1));
        match left {
            1 => self.end_trace(),
            _ => Ok(()),
        }
    }

    /// Closes the trace.
    pub(super) fn end_trace(&mut self) -> Result<(), ViewError> {
        if let Some((trace, _)) = self.trace.take() {
            let path = trace.finish().map_err(RunError::from)?;
            self.say(format!("{} is written.", path.display()));
        }
        Ok(())
    }

    /// Has RenderDoc capture a frame, if it watches.
    pub(super) fn capture(&mut self) -> Result<(), ViewError> {
        let Some(renderdoc) = RenderDoc::watching() else {
            self.note = Some("RenderDoc does not watch: `renderdoccmd capture -w whitecap view ...`.".into());
            return Ok(());
        };
        if self.draw(None, None)? == Drawn::Hidden {
            self.fail("Nothing is captured: the window shows nothing.".into());
            return Ok(());
        }
        let template = self.out.join("renderdoc");
        make_folder(&template)?;
        self.frames.wait()?;
        let (drawn, file) = renderdoc.capture(&template, || {
            let drawn = self.draw(None, None)?;
            self.frames.wait()?;
            Ok::<_, ViewError>(drawn)
        });
        match (drawn?, file) {
            (Drawn::Shown, Some(file)) => self.say(format!("{} is captured.", file.display())),
            _ => self.fail("RenderDoc did not capture the frame.".into()),
        }
        Ok(())
    }
}
