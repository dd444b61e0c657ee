// SPDX-License-Identifier: MIT OR Apache-2.0
//! What every simulation says of a parameter that it cannot run with.

use std::fmt;

/// A parameter out of its range: which, what it is, what is allowed.
#[derive(Clone, Debug, PartialEq)]
pub struct Invalid {
    /// Name of the field, as in the simulation's parameters and in scene files.
    pub key: &'static str,
    /// Its value.
    pub value: String,
    /// What is allowed.
    pub allowed: String,
}

impl fmt::Display for Invalid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {}: allowed is {}", self.key, self.value, self.allowed)
    }
}

impl std::error::Error for Invalid {}

/// Refuses `value` unless it is allowed.
pub(crate) fn hold(
    is_allowed: bool,
    key: &'static str,
    value: impl fmt::Display,
    allowed: impl Into<String>,
) -> Result<(), Invalid> {
    match is_allowed {
        true => Ok(()),
        false => Err(Invalid { key, value: value.to_string(), allowed: allowed.into() }),
    }
}

/// Refuses what is not above 0, or no number.
pub(crate) fn positive(key: &'static str, value: f64) -> Result<(), Invalid> {
    hold(value.is_finite() && value > 0.0, key, value, "a finite number above 0")
}
