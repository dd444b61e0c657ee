// SPDX-License-Identifier: MIT OR Apache-2.0
//! Reads typed values out of a TOML tree and notes every mistake, so that one run shows them all.
//!
//! A value that is missing or wrong is noted and replaced by a placeholder; [`Reader::finish`] then refuses the
//! whole, so that no placeholder gets out.

use std::{cell::RefCell, fmt};

use super::{
    error::{Problem, ProblemKind},
    node::{At, Node, Sources, Value},
    parameter::{Given, Parameter, Takes},
};

/// Which numbers a key takes.
#[derive(Clone, Copy)]
pub(super) enum Rule {
    Finite,
    AtLeastZero,
    Within(f64, f64),
}

impl Rule {
    fn allows(self, x: f64) -> bool {
        // Comparisons are false for NaN.
        x.abs() <= f64::MAX
            && match self {
                Self::Finite => true,
                Self::AtLeastZero => x >= 0.0,
                Self::Within(least, most) => least <= x && x <= most,
            }
    }
}

impl Rule {
    fn range(self) -> [f64; 2] {
        match self {
            Self::Finite => [-f64::MAX, f64::MAX],
            Self::AtLeastZero => [0.0, f64::MAX],
            Self::Within(least, most) => [least, most],
        }
    }
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Finite => write!(f, "finite"),
            Self::AtLeastZero => write!(f, "0 or more"),
            Self::Within(least, most) => write!(f, "{least} to {most}"),
        }
    }
}

/// What a [`Table`] can read: a number or a few of them.
pub(super) trait Read: Copy + Default {
    const WHAT: &str;
    const IS_WHOLE: bool;
    fn from_node(node: &Node) -> Option<Self>;
    /// The numbers of a value; what [`Rule`] applies to.
    fn numbers(&self) -> impl Iterator<Item = f64>;
}

macro_rules! read_number {
    ($type:ty, $whole:literal, $what:literal, $whats:literal, $($from:pat => $to:expr),*) => {
        impl Read for $type {
            const WHAT: &str = $what;
            const IS_WHOLE: bool = $whole;
            fn from_node(node: &Node) -> Option<Self> {
                match node.value {
                    $($from => $to,)*
                    _ => None,
                }
            }
            fn numbers(&self) -> impl Iterator<Item = f64> {
                std::iter::once(*self as f64)
            }
        }

        impl<const N: usize> Read for [$type; N]
        where
            Self: Default,
        {
            const WHAT: &str = match N {
                2 => concat!("two ", $whats, ", each"),
                3 => concat!("three ", $whats, ", each"),
                _ => concat!("four ", $whats, ", each"),
            };
            const IS_WHOLE: bool = $whole;
            fn from_node(node: &Node) -> Option<Self> {
                let Value::Array(items) = &node.value else { return None };
                let numbers: Option<Vec<$type>> = items.iter().map(<$type>::from_node).collect();
                numbers?.try_into().ok()
            }
            fn numbers(&self) -> impl Iterator<Item = f64> {
                self.iter().map(|&x| x as f64)
            }
        }
    };
}

// A number too large for f32 becomes infinite and is refused for that; a whole number that does not fit is refused
// by its type.
read_number!(f32, false, "a number,", "numbers", Value::Float(x) => Some(x as f32), Value::Integer(x) => Some(x as f32));
read_number!(f64, false, "a number,", "numbers", Value::Float(x) => Some(x), Value::Integer(x) => Some(x as f64));
read_number!(u32, true, "a whole number,", "whole numbers", Value::Integer(x) => x.try_into().ok());
read_number!(u64, true, "a whole number,", "whole numbers", Value::Integer(x) => x.try_into().ok());

/// The scene being read and what is wrong with it so far.
pub(super) struct Reader<'a> {
    sources: Sources<'a>,
    problems: RefCell<Vec<(At, Problem)>>,
    parameters: RefCell<Vec<Parameter>>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(sources: Sources<'a>) -> Self {
        Self { sources, problems: RefCell::default(), parameters: RefCell::default() }
    }

    /// The tree's root as a table.
    pub(super) fn root<'r>(&'r self, root: &'r Node) -> Table<'r> {
        Table { reader: self, path: String::new(), node: root, known: Vec::new() }
    }

    /// Whether nothing wrong was found so far.
    pub(super) fn is_clean(&self) -> bool {
        self.problems.borrow().is_empty()
    }

    /// Every problem found, in the order of the texts, and every key that was asked for.
    pub(super) fn finish(self) -> (Vec<Problem>, Vec<Parameter>) {
        let mut problems = self.problems.into_inner();
        problems.sort_by_key(|(at, _)| (at.source, at.start));
        let problems = problems.into_iter().map(|(_, problem)| problem).collect();
        (problems, self.parameters.into_inner())
    }

    fn note(&self, at: At, key: &str, kind: ProblemKind, message: String) {
        let problem = self.sources.problem(at, key, kind, message);
        self.problems.borrow_mut().push((at, problem));
    }
}

/// A table of the tree, and which keys of it were asked for.
pub(super) struct Table<'r> {
    reader: &'r Reader<'r>,
    path: String,
    node: &'r Node,
    known: Vec<&'static str>,
}

impl<'r> Table<'r> {
    fn path_of(&self, key: &str) -> String {
        match (self.path.as_str(), key) {
            ("", key) => key.to_owned(),
            (path, "") => path.to_owned(),
            (path, key) => format!("{path}.{key}"),
        }
    }

    fn get(&mut self, key: &'static str) -> Option<&'r Node> {
        if !self.known.contains(&key) {
            self.known.push(key);
        }
        let Value::Table(entries) = &self.node.value else { return None };
        entries.iter().find(|entry| entry.key == key).map(|entry| &entry.node)
    }

    fn note(&self, at: At, key: &str, kind: ProblemKind, message: String) {
        self.reader.note(at, &self.path_of(key), kind, message);
    }

    fn refuse(&self, node: &Node, key: &str, kind: ProblemKind, allowed: fmt::Arguments<'_>) {
        let given = match node.value {
            // The text of a table is its header or an override's key path.
            Value::Table(_) => "a table".to_owned(),
            _ => self.reader.sources.excerpt(node.at),
        };
        self.note(node.at, key, kind, format!("is {given}; allowed: {allowed}"));
    }

    /// Whether nothing wrong was found so far, here or elsewhere.
    pub(super) fn is_clean(&self) -> bool {
        self.reader.is_clean()
    }

    /// Notes that the values in this table do not go together; `key` is the one pointed at, if it is there.
    pub(super) fn conflict(&self, key: &'static str, message: impl Into<String>) {
        self.blame(key, ProblemKind::Conflict, message.into());
    }

    /// Notes a problem with `key`'s value or, where there is none, with the table.
    pub(super) fn blame(&self, key: &'static str, kind: ProblemKind, message: String) {
        let entries = if let Value::Table(entries) = &self.node.value { entries.as_slice() } else { &[] };
        let at = entries.iter().find(|entry| entry.key == key).map_or(self.node.at, |entry| entry.node.at);
        self.note(at, key, kind, message);
    }

    /// Lists what a key takes, and what it has.
    fn list_as(&mut self, key: &'static str, takes: Takes) {
        let path = self.path_of(key);
        let mut parameters = self.reader.parameters.borrow_mut();
        if parameters.iter().all(|it| it.path != path) {
            let Value::Table(entries) = &self.node.value else { return };
            let node = entries.iter().find(|entry| entry.key == key).map(|entry| &entry.node);
            parameters.push(Parameter { path, takes, given: node.and_then(|node| Given::of(&node.value)) });
        }
    }

    /// A number or numbers, if the key is there.
    pub(super) fn maybe<T: Read>(&mut self, key: &'static str, rule: Rule) -> Option<T> {
        let (count, is_whole) = (T::default().numbers().count(), T::IS_WHOLE);
        self.list_as(key, Takes::Numbers { count, is_whole, range: rule.range() });
        let node = self.get(key)?;
        Some(self.read(node, key, rule))
    }

    fn read<T: Read>(&self, node: &Node, key: &str, rule: Rule) -> T {
        let Some(value) = T::from_node(node) else {
            // A whole number is of the right type for every key that takes one number.
            let is_range = matches!(node.value, Value::Integer(_)) && T::default().numbers().count() == 1;
            let kind = if is_range { ProblemKind::OutOfRange } else { ProblemKind::WrongType };
            self.refuse(node, key, kind, format_args!("{} {rule}", T::WHAT));
            return T::default();
        };
        for (i, x) in value.numbers().enumerate().filter(|(_, x)| !rule.allows(*x)) {
            let (node, key) = match &node.value {
                Value::Array(items) => (&items[i], format!("{key}.{i}")),
                _ => (node, key.to_owned()),
            };
            let finite = if x.is_finite() || matches!(rule, Rule::Finite) { "" } else { "finite, " };
            self.refuse(node, &key, ProblemKind::OutOfRange, format_args!("{finite}{rule}"));
        }
        value
    }

    /// An array of at least one of what [`Table::maybe`] reads, if the key is there.
    pub(super) fn list<T: Read>(&mut self, key: &'static str, rule: Rule) -> Option<Vec<T>> {
        let node = self.get(key)?;
        match &node.value {
            Value::Array(items) if !items.is_empty() => {
                let item = |(i, item)| self.read(item, &format!("{key}.{i}"), rule);
                return Some(items.iter().enumerate().map(item).collect());
            }
            _ => self.refuse(
                node,
                key,
                ProblemKind::WrongType,
                format_args!("one or more of {} {rule}", T::WHAT),
            ),
        }
        Some(Vec::new())
    }

    /// Whether the key is there and a table.
    pub(super) fn is_table(&mut self, key: &'static str) -> bool {
        self.get(key).is_some_and(|node| matches!(node.value, Value::Table(_)))
    }

    /// A number or numbers that the key must give.
    pub(super) fn number<T: Read>(&mut self, key: &'static str, rule: Rule) -> T {
        self.maybe(key, rule).unwrap_or_else(|| {
            self.missing(key, format_args!("{} {rule}", T::WHAT));
            T::default()
        })
    }

    /// Notes that a key without a default is not there.
    pub(super) fn missing(&self, key: &str, allowed: fmt::Arguments<'_>) {
        self.note(self.node.at, key, ProblemKind::MissingKey, format!("is missing; allowed: {allowed}"));
    }

    /// A text, if the key is there and `rule` allows it.
    pub(super) fn text(
        &mut self,
        key: &'static str,
        allowed: &str,
        rule: impl Fn(&str) -> bool,
    ) -> Option<&'r str> {
        self.list_as(key, Takes::Text);
        let node = self.get(key)?;
        match &node.value {
            Value::Text(text) if rule(text) => return Some(text),
            Value::Text(_) => self.refuse(node, key, ProblemKind::OutOfRange, format_args!("{allowed}")),
            _ => self.refuse(node, key, ProblemKind::WrongType, format_args!("{allowed}")),
        }
        None
    }

    /// As [`Table::text`], for the path of a file, or a name that stands for one.
    pub(super) fn file(
        &mut self,
        key: &'static str,
        allowed: &str,
        rule: impl Fn(&str) -> bool,
    ) -> Option<&'r str> {
        self.list_as(key, Takes::File);
        self.text(key, allowed, rule)
    }

    /// An array of texts that `rule` allows, if the key is there.
    pub(super) fn texts(
        &mut self,
        key: &'static str,
        allowed: &str,
        rule: impl Fn(&str) -> bool,
    ) -> Option<Vec<String>> {
        let node = self.get(key)?;
        let Value::Array(items) = &node.value else {
            self.refuse(node, key, ProblemKind::WrongType, format_args!("a list of {allowed}"));
            return Some(Vec::new());
        };
        let mut texts = Vec::new();
        for (i, item) in items.iter().enumerate() {
            match &item.value {
                Value::Text(text) if rule(text) => texts.push(text.clone()),
                Value::Text(_) => self.refuse(
                    item,
                    &format!("{key}.{i}"),
                    ProblemKind::OutOfRange,
                    format_args!("{allowed}"),
                ),
                _ => self.refuse(
                    item,
                    &format!("{key}.{i}"),
                    ProblemKind::WrongType,
                    format_args!("{allowed}"),
                ),
            }
        }
        Some(texts)
    }

    /// One of `choices`, if the key is there.
    pub(super) fn choice<T: Copy>(&mut self, key: &'static str, choices: &[(&str, T)]) -> Option<T> {
        self.list_as(key, Takes::OneOf(choices.iter().map(|(name, _)| (*name).to_owned()).collect()));
        let names = quoted(choices.iter().map(|(name, _)| *name));
        let text = self.text(key, &names, |text| choices.iter().any(|(name, _)| *name == text))?;
        choices.iter().find(|(name, _)| *name == text).map(|(_, choice)| *choice)
    }

    /// One of `choices`, whole numbers, if the key is there.
    pub(super) fn choice_of(&mut self, key: &'static str, choices: &[u32]) -> Option<u32> {
        self.list_as(key, Takes::OneOfNumbers(choices.to_vec()));
        let node = self.get(key)?;
        let found = u32::from_node(node).filter(|found| choices.contains(found));
        if found.is_none() {
            let allowed: Vec<_> = choices.iter().map(u32::to_string).collect();
            let is_number = matches!(node.value, Value::Integer(_));
            let kind = if is_number { ProblemKind::OutOfRange } else { ProblemKind::WrongType };
            self.refuse(node, key, kind, format_args!("{}", allowed.join(" or ")));
        }
        found
    }

    /// `true` or `false`, if the key is there.
    pub(super) fn flag(&mut self, key: &'static str) -> Option<bool> {
        self.list_as(key, Takes::Flag);
        let node = self.get(key)?;
        if let Value::Flag(flag) = node.value {
            return Some(flag);
        }
        self.refuse(node, key, ProblemKind::WrongType, format_args!("true or false"));
        None
    }

    /// Whether the key is there, right or wrong.
    pub(super) fn has(&mut self, key: &'static str) -> bool {
        self.get(key).is_some()
    }

    /// A table in this one.
    pub(super) fn table(&mut self, key: &'static str) -> Option<Table<'r>> {
        let node = self.get(key)?;
        self.as_table(node, key)
    }

    /// A table in this one; an empty one if it is not there, so that its keys are listed all the same.
    pub(super) fn table_or_empty(&mut self, key: &'static str) -> Table<'r> {
        static EMPTY: Node = Node { at: At { source: 0, start: 0, end: 0 }, value: Value::Table(Vec::new()) };
        let empty = Table { reader: self.reader, path: self.path_of(key), node: &EMPTY, known: Vec::new() };
        self.table(key).unwrap_or(empty)
    }

    /// An array of tables in this one.
    pub(super) fn tables(&mut self, key: &'static str) -> Vec<Table<'r>> {
        match self.get(key) {
            None => Vec::new(),
            Some(Node { value: Value::Array(items), .. }) => {
                let table = |(i, item)| self.as_table(item, &format!("{key}.{i}"));
                items.iter().enumerate().filter_map(table).collect()
            }
            Some(node) => {
                let header = self.header(key);
                self.refuse(
                    node,
                    key,
                    ProblemKind::WrongType,
                    format_args!("tables, each headed [[{header}]]"),
                );
                Vec::new()
            }
        }
    }

    fn as_table(&self, node: &'r Node, key: &str) -> Option<Table<'r>> {
        if matches!(node.value, Value::Table(_)) {
            return Some(Table { reader: self.reader, path: self.path_of(key), node, known: Vec::new() });
        }
        let header = self.header(key);
        self.refuse(node, key, ProblemKind::WrongType, format_args!("a table, headed [{header}]"));
        None
    }

    /// A path as table headers have it, without indices.
    fn header(&self, key: &str) -> String {
        let path = self.path_of(key);
        path.split('.').filter(|part| part.parse::<usize>().is_err()).collect::<Vec<_>>().join(".")
    }

    /// Notes every key that nothing asked for.
    pub(super) fn finish(self) {
        let Value::Table(entries) = &self.node.value else { return };
        for entry in entries.iter().filter(|entry| !self.known.contains(&entry.key.as_str())) {
            let near = self.known.iter().map(|known| (distance(known, &entry.key), known)).min();
            let message = match near {
                Some((distance, known)) if distance <= 1 + known.len() / 4 => {
                    format!("is not a key; did you mean {known}?")
                }
                _ => format!("is not a key; allowed here: {}", self.known.join(", ")),
            };
            self.note(entry.at, &entry.key, ProblemKind::UnknownKey, message);
        }
    }
}

fn quoted<'s>(names: impl Iterator<Item = &'s str>) -> String {
    names.map(|name| format!("{name:?}")).collect::<Vec<_>>().join(" or ")
}

/// How many characters to insert, delete or replace to make `a` of `b` (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let mut row: Vec<usize> = (0..=b.chars().count()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, y) in b.chars().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[row.len() - 1]
}
