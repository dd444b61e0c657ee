// SPDX-License-Identifier: MIT OR Apache-2.0
//! Passes in the Tracy profiler (feature `tracy`): a GPU context whose clock is the host's, so that passes lie where
//! [`SpanTime::begin`](crate::gpu::SpanTime) places them. Zones of the host are [`Zone`](crate::gpu::Zone)s.

use crate::gpu::Times;
use std::time::Instant;
use tracy_client::{Client, GpuContext, GpuContextType};

/// Tracy, listening.
pub struct Tracy {
    client: Client,
    queue: Option<GpuContext>,
    /// Time 0 of the context.
    start: Instant,
}

impl Tracy {
    /// `None` unless the program has started Tracy's client.
    pub fn listening() -> Option<Self> {
        let client = Client::running()?;
        let start = Instant::now();
        // A tick is a nanosecond, and the first is now.
        let queue = client.clone().new_gpu_context(Some("queue"), GpuContextType::Vulkan, 0, 1.0).ok();
        Some(Self { client, queue, start })
    }

    /// The passes of a picture, and its end.
    pub fn picture(&self, times: &Times) {
        let ns = |at: Instant| at.saturating_duration_since(self.start).as_nanos() as i64;
        for span in &times.spans {
            let (Some(queue), Some(begin)) = (&self.queue, span.begin) else { continue };
            let name = span.name.to_string_lossy();
            let Ok(mut zone) = queue.span_alloc(&name, &name, "", 0) else { continue };
            zone.end_zone();
            zone.upload_timestamp_start(ns(begin));
            zone.upload_timestamp_end(ns(begin) + (1e6 * span.ms) as i64);
        }
        self.client.frame_mark();
    }
}
