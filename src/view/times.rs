// SPDX-License-Identifier: MIT OR Apache-2.0
//! Times of the passes of the last frames.

use crate::gpu::SpanTime;
use std::{collections::VecDeque, ffi::CStr};

/// Frames that are remembered.
const FRAMES: usize = 120;

/// Times of passes, frame by frame.
#[derive(Default)]
pub struct History {
    /// Passes in the order in which they first came.
    names: Vec<&'static CStr>,
    /// Of each frame: milliseconds by pass.
    frames: VecDeque<Vec<f32>>,
}

impl History {
    /// One more frame.
    pub fn push(&mut self, spans: &[SpanTime]) {
        let mut row = vec![0.0; self.names.len()];
        for span in spans {
            let at = self.names.iter().position(|name| *name == span.name).unwrap_or_else(|| {
                self.names.push(span.name);
                row.push(0.0);
                self.names.len() - 1
            });
            row[at] += span.ms as f32;
        }
        self.frames.push_back(row);
        if self.frames.len() > FRAMES {
            self.frames.pop_front();
        }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        *self = Self::default();
    }

    /// Each pass with its mean over the frames that are remembered (ms).
    pub fn means(&self) -> Vec<(String, f32)> {
        let count = self.frames.len().max(1) as f32;
        let mean = |i: usize| self.frames.iter().filter_map(|row| row.get(i)).sum::<f32>() / count;
        self.names
            .iter()
            .enumerate()
            .map(|(i, name)| (name.to_string_lossy().into_owned(), mean(i)))
            .collect()
    }

    /// Milliseconds by pass, frame by frame, oldest first.
    pub fn frames(&self) -> impl ExactSizeIterator<Item = &[f32]> {
        self.frames.iter().map(Vec::as_slice)
    }

    /// The longest frame (ms).
    pub fn longest_ms(&self) -> f32 {
        self.frames.iter().map(|row| row.iter().sum()).fold(0.0, f32::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_of_one_name_add_up() {
        let span = |name, ms| SpanTime { name, ms, begin: None, statistics: Vec::new() };
        let mut history = History::default();
        history.push(&[span(c"a", 1.0), span(c"b", 2.0), span(c"a", 3.0)]);
        history.push(&[span(c"c", 5.0)]);
        let mean = |name: &str, ms| (name.to_owned(), ms);
        assert_eq!(history.means(), [mean("a", 2.0), mean("b", 1.0), mean("c", 2.5)]);
        assert_eq!(history.longest_ms(), 6.0);
        (0..1000).for_each(|_| history.push(&[]));
        assert_eq!(history.frames().len(), FRAMES);
    }
}
