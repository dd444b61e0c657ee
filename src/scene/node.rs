// SPDX-License-Identifier: MIT OR Apache-2.0
//! A TOML tree whose every node knows the text it came from: the scene file or one of the overrides laid over it.

use std::{fmt, ops::Range, str::FromStr};

use toml::{
    de::{DeTable, DeValue},
    Spanned,
};

use super::{
    error::{Place, Problem, ProblemKind},
    SceneError,
};

/// Deeper paths than any key has are refused, so that the tree cannot grow deeper than the stack.
const MAX_PATH: usize = 16;

/// Bytes of one of the texts of [`Sources`].
#[derive(Clone, Copy, Debug)]
pub(super) struct At {
    pub source: usize,
    pub start: usize,
    pub end: usize,
}

pub(super) struct Node {
    pub at: At,
    pub value: Value,
}

pub(super) enum Value {
    Table(Vec<Entry>),
    Array(Vec<Node>),
    Text(String),
    Integer(i128),
    Float(f64),
    Flag(bool),
    /// A date, which no key takes.
    Other,
}

pub(super) struct Entry {
    pub at: At,
    pub key: String,
    pub node: Node,
}

impl Node {
    fn new(value: Spanned<DeValue<'_>>, source: usize, offset: usize) -> Self {
        let at = At::new(source, value.span(), offset);
        let value = match value.into_inner() {
            DeValue::Table(table) => Value::table(table, source, offset),
            DeValue::Array(items) => {
                Value::Array(items.into_iter().map(|item| Self::new(item, source, offset)).collect())
            }
            DeValue::String(text) => Value::Text(text.into_owned()),
            DeValue::Integer(x) => {
                i128::from_str_radix(x.as_str(), x.radix()).map_or(Value::Other, Value::Integer)
            }
            DeValue::Float(x) => x.as_str().parse().map_or(Value::Other, Value::Float),
            DeValue::Boolean(flag) => Value::Flag(flag),
            DeValue::Datetime(_) => Value::Other,
        };
        Self { at, value }
    }

    fn name(&self) -> Option<&str> {
        let Value::Table(entries) = &self.value else { return None };
        match &entries.iter().find(|entry| entry.key == "name")?.node.value {
            Value::Text(name) => Some(name),
            _ => None,
        }
    }
}

impl Value {
    fn table(table: DeTable<'_>, source: usize, offset: usize) -> Self {
        let entry = |(key, value): (Spanned<std::borrow::Cow<'_, str>>, _)| Entry {
            at: At::new(source, key.span(), offset),
            key: key.into_inner().into_owned(),
            node: Node::new(value, source, offset),
        };
        Self::Table(table.into_iter().map(entry).collect())
    }
}

impl At {
    fn new(source: usize, span: Range<usize>, offset: usize) -> Self {
        Self { source, start: span.start + offset, end: span.end + offset }
    }
}

/// The texts of a scene: the file (source 0) and the overrides (source 1 and on).
pub(super) struct Sources<'a> {
    file_name: &'a str,
    texts: Vec<&'a str>,
}

impl<'a> Sources<'a> {
    /// Reads the file and lays the overrides over it.
    pub(super) fn read(
        text: &'a str,
        file_name: &'a str,
        overrides: &'a [Override],
    ) -> Result<(Self, Node), Vec<Problem>> {
        let texts = std::iter::once(text).chain(overrides.iter().map(|o| o.text.as_str())).collect();
        let sources = Self { file_name, texts };
        // The first error only: the others mostly follow from it.
        let table = DeTable::parse(text).map_err(|error| vec![sources.syntax(0, &error, 0)])?;
        let at = At { source: 0, start: 0, end: 0 };
        let mut root = Node { at, value: Value::table(table.into_inner(), 0, 0) };
        let problems: Vec<_> = overrides
            .iter()
            .enumerate()
            .filter_map(|(i, o)| o.apply(&mut root, &sources, i + 1).err())
            .flatten()
            .collect();
        if problems.is_empty() {
            Ok((sources, root))
        } else {
            Err(problems)
        }
    }

    /// A problem at a place of one of the texts.
    pub(super) fn problem(&self, at: At, key: &str, kind: ProblemKind, message: String) -> Problem {
        let (file, place) = match at.source {
            0 => (self.file_name.to_owned(), Some(Place::new(self.texts[0], at.start, at.end))),
            source => (format!("--set {}", self.texts[source]), None),
        };
        // The root has no text of its own.
        let place = place.filter(|_| at.end > 0);
        Problem { file, place, key: key.to_owned(), kind, message }
    }

    /// The text of a value, shortened if it is long.
    pub(super) fn excerpt(&self, at: At) -> String {
        let text = self.texts[at.source].get(at.start..at.end).unwrap_or_default();
        let mut line = text.chars().map(|c| if c.is_control() { ' ' } else { c });
        let short: String = line.by_ref().take(40).collect();
        if line.next().is_some() {
            short + "…"
        } else {
            short
        }
    }

    fn syntax(&self, source: usize, error: &toml::de::Error, offset: usize) -> Problem {
        let length = self.texts[source].len();
        let span = error.span().unwrap_or(length..length);
        // An error at the very start still has a place, unlike the root.
        let at = At::new(source, span.start..span.end.max(span.start + 1), offset);
        self.problem(at, "", ProblemKind::Syntax, format!("not TOML: {}", error.message()))
    }
}

/// A change to a scene, `key.path=value`, as `--set` takes it.
///
/// The path goes through tables by key and through arrays by index or, for waters, by name:
/// `water.0.cells=[64, 64]`, `water.lake.depth_m=1`. The value is TOML; a bare word is a string.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Override {
    text: String,
    equals: usize,
}

impl FromStr for Override {
    type Err = SceneError;

    fn from_str(text: &str) -> Result<Self, SceneError> {
        let sources = Sources { file_name: "", texts: vec!["", text] };
        let wrong = |message: &str| {
            let at = At { source: 1, start: 0, end: text.len() };
            SceneError::Invalid(vec![sources.problem(at, "", ProblemKind::Syntax, message.to_owned())])
        };
        let equals = text.find('=').ok_or_else(|| wrong("not of the form key.path=value"))?;
        let parsed = Self { text: text.to_owned(), equals };
        let parts = parsed.path().count();
        if parts > MAX_PATH {
            return Err(wrong("no key is nested so deep"));
        }
        if parsed.path().any(str::is_empty) {
            return Err(wrong("a part of the key path is empty"));
        }
        parsed.value(&sources, 1).map_err(SceneError::Invalid)?;
        Ok(parsed)
    }
}

impl fmt::Display for Override {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Override {
    /// Key path and value, as they were written.
    pub fn parts(&self) -> (&str, &str) {
        (self.text[..self.equals].trim(), self.text[self.equals + 1..].trim())
    }

    fn path(&self) -> impl Iterator<Item = &str> {
        self.text[..self.equals].split('.').map(str::trim)
    }

    fn value(&self, sources: &Sources<'_>, source: usize) -> Result<Node, Vec<Problem>> {
        let after = &self.text[self.equals + 1..];
        let text = after.trim();
        let offset = self.text.len() - after.trim_start().len();
        match DeValue::parse(text) {
            Ok(value) => Ok(Node::new(value, source, offset)),
            Err(_) if !text.is_empty() && !text.contains(['"', '\'', '[', ']', '{', '}', ',', '=', '\n']) => {
                let at = At::new(source, 0..text.len(), offset);
                Ok(Node { at, value: Value::Text(text.to_owned()) })
            }
            Err(error) => Err(vec![sources.syntax(source, &error, offset)]),
        }
    }

    fn apply(&self, root: &mut Node, sources: &Sources<'_>, source: usize) -> Result<(), Vec<Problem>> {
        let value = self.value(sources, source)?;
        let mut node = root;
        let mut key = String::new();
        let at = At { source, start: 0, end: self.equals };
        for part in self.path() {
            let wrong = |message| Err(vec![sources.problem(at, &key, ProblemKind::UnknownKey, message)]);
            node = match &mut node.value {
                Value::Table(entries) => {
                    let index = entries.iter().position(|entry| entry.key == part).unwrap_or_else(|| {
                        let node = Node { at, value: Value::Table(Vec::new()) };
                        entries.push(Entry { at, key: part.to_owned(), node });
                        entries.len() - 1
                    });
                    &mut entries[index].node
                }
                Value::Array(items) => {
                    let default = (key == "water").then_some(super::water_table::DEFAULT_NAME);
                    let by_name = |item: &Node| item.name().or(default) == Some(part);
                    let index = part.parse().ok().or_else(|| items.iter().position(by_name));
                    let count = items.len();
                    match index.and_then(|index: usize| items.get_mut(index)) {
                        Some(item) => item,
                        None => return wrong(format!("has no {part}; its length is {count}")),
                    }
                }
                _ => return wrong(format!("is a value, it has no {part}")),
            };
            if !key.is_empty() {
                key.push('.');
            }
            key.push_str(part);
        }
        *node = value;
        Ok(())
    }
}
