// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a run did and when, in the Trace Event Format, which Perfetto (ui.perfetto.dev) and chrome://tracing open.
//!
//! One process `whitecap` with a track for each thread of the host and with counters, one process for the device with a
//! track for its queue. The file is an array of events, one a line, and whole lines are written after every picture. The
//! closing bracket may be missing, says the format, so the file of a run that was killed can be opened as well.
//!
//! Format: "Trace Event Format" (Google, 2016): complete events `X`, counters `C`, metadata `M`, instants `i`; times in
//! microseconds. Here they have three decimals, and an event that lies within another does so to the nanosecond.

use super::atomic::{failed, FileError};
use crate::gpu::{HostTime, Placed, SpanTime, Times};
use serde_json::{json, Map, Value};
use std::{
    fs::File,
    io::Write,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, MutexGuard},
    time::{Duration, Instant},
};

/// A line of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Track {
    /// What the main thread does.
    Host,
    /// What the thread does that writes pictures and the clip.
    Encoder,
    /// Passes on the device.
    Queue,
}

impl Track {
    /// Process and thread.
    fn ids(self) -> (u32, u32) {
        match self {
            Self::Host => (1, 1),
            Self::Encoder => (1, 2),
            Self::Queue => (2, 1),
        }
    }
}

/// A trace that is being written. Clones write to the same file.
#[derive(Clone, Debug)]
pub struct Trace(Arc<Mutex<Sink>>);

#[derive(Debug)]
struct Sink {
    file: File,
    path: PathBuf,
    start: Instant,
    /// Lines that are not written yet.
    lines: String,
    has_events: bool,
    is_finished: bool,
    /// The end of what is on the queue's track (ns).
    queue_ns: u64,
    placed: Option<Placed>,
}

impl Trace {
    /// Time 0 is now.
    ///
    /// # Errors
    /// If the file cannot be made.
    pub fn create(path: &Path) -> Result<Self, FileError> {
        let file = File::create(path).map_err(failed(path, "make the trace"))?;
        let sink = Sink {
            file,
            path: path.to_owned(),
            start: Instant::now(),
            lines: String::new(),
            has_events: false,
            is_finished: false,
            queue_ns: 0,
            placed: None,
        };
        let trace = Self(Arc::new(Mutex::new(sink)));
        trace.name(1, None, "whitecap");
        trace.name(1, Some(1), "host");
        trace.name(1, Some(2), "encoder");
        Ok(trace)
    }

    /// What ran: the name of the device, and whatever a reader of the trace should know.
    pub fn describe(&self, device: &str, mut about: Value) {
        self.name(2, None, &format!("GPU: {device}"));
        let mut sink = self.sink();
        if let Some(now_ns) = monotonic_ns() {
            about["time_0_monotonic_ns"] = (now_ns - sink.ns(Instant::now())).into();
        }
        let ts = sink.us(Instant::now());
        sink.line(json!({"ph": "i", "s": "g", "pid": 1, "tid": 1, "ts": ts, "name": "about", "args": about}));
    }

    /// `body`, as a span of the main thread.
    pub fn time<T>(&self, name: &str, body: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let made = body();
        self.span(Track::Host, &HostTime::until_now("", begin), name, json!({}));
        made
    }

    /// A span from `time`'s beginning to its end, whatever its name.
    pub fn span(&self, track: Track, time: &HostTime, name: &str, args: Value) {
        let mut sink = self.sink();
        let (begin, end) = (sink.ns(time.begin), sink.ns(time.end));
        sink.complete(track, name, (begin, end.saturating_sub(begin)), args);
    }

    /// Everything that one picture took.
    pub fn picture(&self, picture: u32, whole: &HostTime, times: &Times) {
        for it in &times.host {
            self.span(Track::Host, it, it.name, json!({ "picture": picture }));
        }
        let mut args = json!({ "placed": times.placed.name(), "untimed": times.untimed });
        if let Placed::Calibrated { within_ns } = times.placed {
            args["within_ns"] = within_ns.into();
        }
        self.span(Track::Host, whole, &format!("picture {picture}"), args);
        self.place(times.placed);
        times.spans.iter().for_each(|span| self.pass(picture, span));
    }

    /// A pass. Those of one queue follow each other: what rounding, or another placing, lets overlap is moved back.
    fn pass(&self, picture: u32, span: &SpanTime) {
        let mut sink = self.sink();
        let begin = span.begin.map_or(sink.queue_ns, |begin| sink.ns(begin)).max(sink.queue_ns);
        let length = Duration::from_secs_f64(1e-3 * span.ms.max(0.0)).as_nanos() as u64;
        sink.queue_ns = begin + length;
        let mut args = Map::from_iter([("picture".to_string(), picture.into())]);
        args.extend(span.statistics.iter().map(|(name, count)| (name.to_string(), (*count).into())));
        sink.complete(Track::Queue, &span.name.to_string_lossy(), (begin, length), args.into());
    }

    /// How the queue's track is placed, said in its name.
    fn place(&self, placed: Placed) {
        let is_new = {
            let mut sink = self.sink();
            let kind = |it: Placed| std::mem::discriminant(&it);
            let is_new = sink.placed.map(kind) != Some(kind(placed));
            sink.placed = Some(placed);
            is_new
        };
        if is_new {
            self.name(2, Some(1), &format!("queue (placed by: {})", placed.name()));
        }
    }

    /// Values from now on, one line of the picture each.
    pub fn counter(&self, name: &str, values: &[(&str, f64)]) {
        let mut sink = self.sink();
        let ts = sink.us(Instant::now());
        let values: Map<String, Value> =
            values.iter().map(|(key, value)| (key.to_string(), (*value).into())).collect();
        sink.line(json!({"ph": "C", "pid": 1, "ts": ts, "name": name, "args": values}));
    }

    /// Writes what is not written yet: whole lines, in one call.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn flush(&self) -> Result<(), FileError> {
        self.sink().flush()
    }

    /// Closes the array; also done when the last clone is dropped. What is written after that is lost.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(&self) -> Result<PathBuf, FileError> {
        let mut sink = self.sink();
        sink.finish()?;
        Ok(sink.path.clone())
    }

    fn name(&self, process: u32, thread: Option<u32>, name: &str) {
        let what = if thread.is_some() { "thread_name" } else { "process_name" };
        let tid = thread.unwrap_or(0);
        self.sink()
            .line(json!({"ph": "M", "pid": process, "tid": tid, "name": what, "args": {"name": name}}));
    }

    fn sink(&self) -> MutexGuard<'_, Sink> {
        self.0.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

impl Sink {
    fn ns(&self, at: Instant) -> u64 {
        at.saturating_duration_since(self.start).as_nanos() as u64
    }

    fn us(&self, at: Instant) -> f64 {
        us(self.ns(at))
    }

    fn complete(&mut self, track: Track, name: &str, (begin_ns, length_ns): (u64, u64), args: Value) {
        let (pid, tid) = track.ids();
        let cat = if track == Track::Queue { "gpu" } else { "host" };
        let (ts, dur) = (us(begin_ns), us(length_ns));
        self.line(json!({
            "ph": "X", "cat": cat, "pid": pid, "tid": tid, "ts": ts, "dur": dur, "name": name, "args": args,
        }));
    }

    fn line(&mut self, event: Value) {
        if self.is_finished {
            return;
        }
        self.lines.push_str(if self.has_events { ",\n" } else { "[\n" });
        self.lines.push_str(&event.to_string());
        self.has_events = true;
    }

    fn finish(&mut self) -> Result<(), FileError> {
        if !std::mem::replace(&mut self.is_finished, true) {
            self.lines.push_str("\n]\n");
        }
        self.flush()
    }

    fn flush(&mut self) -> Result<(), FileError> {
        let written = self.file.write_all(self.lines.as_bytes());
        self.lines.clear();
        written.map_err(failed(&self.path, "write the trace"))
    }
}

impl Drop for Sink {
    fn drop(&mut self) {
        let _ = self.finish(); // a run that fails says why by itself
    }
}

/// CLOCK_MONOTONIC, which other tools stamp with, too.
fn monotonic_ns() -> Option<u64> {
    #[cfg(unix)]
    {
        let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        Some(now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64)
    }
    #[cfg(not(unix))]
    None
}

/// Microseconds, with nanoseconds as decimals.
fn us(ns: u64) -> f64 {
    ns as f64 / 1e3
}
