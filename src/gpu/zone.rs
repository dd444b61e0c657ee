// SPDX-License-Identifier: MIT OR Apache-2.0
//! Zones of the host in the Tracy profiler (feature `tracy`), from their making until they are dropped. Without the
//! feature, or while nobody has started Tracy's client, they are nothing.

/// An open zone.
#[must_use = "a zone ends when it is dropped"]
pub struct Zone {
    #[cfg(feature = "tracy")]
    _span: Option<tracy_client::Span>,
}

impl Zone {
    /// Begins one.
    #[cfg(feature = "tracy")]
    #[track_caller]
    pub fn new(name: &str) -> Self {
        let place = std::panic::Location::caller();
        let client = tracy_client::Client::running();
        Self { _span: client.map(|it| it.span_alloc(Some(name), name, place.file(), place.line(), 0)) }
    }

    /// Begins one, which without the feature is nothing.
    #[cfg(not(feature = "tracy"))]
    pub fn new(_name: &str) -> Self {
        Self {}
    }

    /// Ends it, before its scope does.
    pub fn end(self) {}
}
