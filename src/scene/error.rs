// SPDX-License-Identifier: MIT OR Apache-2.0
//! What can be wrong with a scene, said as a compiler would: place, key, value given, what is allowed.

use std::fmt;

use super::HeightmapError;

/// Why a scene cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The scene file or an override is wrong: every problem that was found, in the order of the text.
    #[error("{}", lines(.0))]
    Invalid(Vec<Problem>),
    /// The scene file cannot be read.
    #[error("{path}: {source}")]
    Read {
        /// The scene file.
        path: String,
        /// Why not.
        source: std::io::Error,
    },
    /// The heightmap cannot be used.
    #[error("{file}: {reason}")]
    Heightmap {
        /// The heightmap's file or `builtin/NAME`.
        file: String,
        /// Why not.
        reason: HeightmapError,
    },
    /// A water and its ground do not go together.
    #[error("water `{name}`: {message}")]
    Water {
        /// Name of the water.
        name: String,
        /// Key, value and what is allowed.
        message: String,
    },
    /// A shader, an effect, a texture or a mesh cannot be used.
    #[error("{file}: {reason}")]
    Shader {
        /// The file.
        file: String,
        /// Why not, with line and excerpt where there are some.
        reason: String,
    },
    /// There is no built-in scene of this name.
    #[error("no built-in scene is called {name:?}; there are: {}", super::builtin::names())]
    NoBuiltin {
        /// The name asked for.
        name: String,
    },
}

/// One mistake in a scene file or an override.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The scene file, or the override as it stands on a command line.
    pub file: String,
    /// Where in the file; `None` for an override, and for a mistake of the whole file.
    pub place: Option<Place>,
    /// The key's path, `water.0.depth_m`; empty for the whole file.
    pub key: String,
    /// What kind of mistake it is.
    pub kind: ProblemKind,
    /// What is wrong with the key, as the rest of a sentence: the value given, if any, and what is allowed.
    pub message: String,
}

/// A place in a text file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Line, counted from 1.
    pub line: usize,
    /// Column (characters), counted from 1.
    pub column: usize,
    /// Length of what is meant (characters), at least 1, within the line.
    pub length: usize,
    /// The line.
    pub excerpt: String,
}

/// Kinds of mistakes in a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProblemKind {
    /// Not TOML.
    Syntax,
    /// A key that nothing reads.
    UnknownKey,
    /// A key that has no default is not there.
    MissingKey,
    /// A value of another type than the key's.
    WrongType,
    /// A value that is not allowed.
    OutOfRange,
    /// Values that are allowed alone but not together.
    Conflict,
    /// A file named in the scene that cannot be used.
    Asset,
}

impl Place {
    /// The place of the bytes `start..end` of `text`.
    pub(super) fn new(text: &str, start: usize, end: usize) -> Self {
        let floor = |byte: usize| {
            (0..=byte.min(text.len())).rev().find(|byte| text.is_char_boundary(*byte)).unwrap_or(0)
        };
        let start = floor(start);
        let line_start = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let line_end = text[start..].find('\n').map_or(text.len(), |length| start + length);
        let end = floor(end).clamp(start, line_end);
        Self {
            line: text[..start].matches('\n').count() + 1,
            column: text[line_start..start].chars().count() + 1,
            length: text[start..end].chars().count().max(1),
            // A tab or an escape sequence would move the caret, or do worse to a terminal.
            excerpt: text[line_start..line_end].trim_end().replace(char::is_control, " "),
        }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(place) = &self.place {
            write!(f, ":{}:{}", place.line, place.column)?;
        }
        f.write_str(": ")?;
        if !self.key.is_empty() {
            write!(f, "{} ", self.key)?;
        }
        f.write_str(&self.message)?;
        match &self.place {
            Some(Place { line, column, length, excerpt }) if excerpt.chars().count() <= 160 => {
                let gutter = line.to_string().len();
                let indent = column - 1;
                write!(f, "\n{line} | {excerpt}\n{:gutter$} | {:indent$}{:^<length$}", "", "", "")
            }
            _ => Ok(()),
        }
    }
}

fn lines(problems: &[Problem]) -> String {
    problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("\n")
}
