// SPDX-License-Identifier: MIT OR Apache-2.0
//! What keys a scene has and could have: for those who edit one.

use super::node::Value;

/// A key of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// As an override has it: `water.0.depth_m`.
    pub path: String,
    /// What it may be.
    pub takes: Takes,
    /// What it is; `None` if the scene leaves it to its default.
    pub given: Option<Given>,
}

/// What a key takes.
#[derive(Clone, Debug, PartialEq)]
pub enum Takes {
    /// One number or a few, all in a range.
    Numbers {
        /// How many.
        count: usize,
        /// Without a fraction.
        is_whole: bool,
        /// Least and most; `f64::MAX` is as good as none.
        range: [f64; 2],
    },
    /// One of these words.
    OneOf(Vec<String>),
    /// One of these numbers.
    OneOfNumbers(Vec<u32>),
    /// `true` or `false`.
    Flag,
    /// Any text, as far as the range of a name goes.
    Text,
    /// The path of a file, from the folder of the scene; or a name that stands for one of the crate's.
    File,
}

/// What a key has.
#[derive(Clone, Debug, PartialEq)]
pub enum Given {
    /// One number or a few.
    Numbers(Vec<f64>),
    /// A text.
    Text(String),
    /// `true` or `false`.
    Flag(bool),
}

impl Given {
    pub(super) fn of(value: &Value) -> Option<Self> {
        let number = |value: &Value| match *value {
            Value::Integer(x) => Some(x as f64),
            Value::Float(x) => Some(x),
            _ => None,
        };
        match value {
            Value::Text(text) => Some(Self::Text(text.clone())),
            Value::Flag(flag) => Some(Self::Flag(*flag)),
            Value::Array(items) => {
                items.iter().map(|item| number(&item.value)).collect::<Option<_>>().map(Self::Numbers)
            }
            value => number(value).map(|x| Self::Numbers(vec![x])),
        }
    }
}

/// Units by the end of a key's name, longest first.
const UNITS: [(&str, &str); 16] = [
    ("_m3ps2", "m³/s²"),
    ("_m3ps", "m³/s"),
    ("_mps2", "m/s²"),
    ("_mps", "m/s"),
    ("_m3", "m³"),
    ("deg_per_s", "°/s"),
    ("turns_per_s", "turns/s"),
    ("drops_per_s", "drops/s"),
    ("_per_s", "1/s"),
    ("mm_per_h", "mm/h"),
    ("_deg", "°"),
    ("_rad", "rad"),
    ("_kg", "kg"),
    ("_s", "s"),
    ("_m", "m"),
    ("fps", "1/s"),
];

impl Parameter {
    /// The last part of the path.
    pub fn key(&self) -> &str {
        self.path.rsplit('.').next().unwrap_or_default()
    }

    /// What is before it; empty at the top.
    pub fn table(&self) -> &str {
        self.path.rsplit_once('.').map_or("", |(table, _)| table)
    }

    /// Unit of its numbers, which is the end of its name; empty if there is none.
    pub fn unit(&self) -> &'static str {
        if self.path == "output.size" {
            return "px";
        }
        UNITS.iter().find(|(end, _)| self.key().ends_with(end)).map_or("", |(_, unit)| unit)
    }
}
