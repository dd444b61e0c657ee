// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a pass makes the device do: pipeline statistics, one query a span.

use super::{
    device::Gpu,
    error::{OrCall, Result},
};
use ash::vk::{self, QueryPipelineStatisticFlags as F};

/// In the order of their bits, which is the order of the results.
const ALL: [(F, &str); 9] = [
    (F::INPUT_ASSEMBLY_VERTICES, "vertices"),
    (F::INPUT_ASSEMBLY_PRIMITIVES, "primitives"),
    (F::VERTEX_SHADER_INVOCATIONS, "vertex_invocations"),
    (F::GEOMETRY_SHADER_INVOCATIONS, "geometry_invocations"),
    (F::GEOMETRY_SHADER_PRIMITIVES, "geometry_primitives"),
    (F::CLIPPING_INVOCATIONS, "clipped_primitives_in"),
    (F::CLIPPING_PRIMITIVES, "clipped_primitives_out"),
    (F::FRAGMENT_SHADER_INVOCATIONS, "fragment_invocations"),
    (F::COMPUTE_SHADER_INVOCATIONS, "compute_invocations"),
];

/// Counters that are not zero, by name.
pub type Statistics = Vec<(&'static str, u64)>;

/// One query a span.
pub(super) struct StatisticsPool {
    pub raw: vk::QueryPool,
    counters: Vec<&'static str>,
    gpu: Gpu,
}

impl StatisticsPool {
    pub fn new(gpu: &Gpu, room: usize) -> Result<Self> {
        let is_counted = |flag: F| match flag {
            F::COMPUTE_SHADER_INVOCATIONS => true,
            F::GEOMETRY_SHADER_INVOCATIONS | F::GEOMETRY_SHADER_PRIMITIVES => gpu.has_geometry_shader(),
            _ => gpu.has_graphics(),
        };
        let counted = ALL.into_iter().filter(|(flag, _)| is_counted(*flag));
        let (flags, counters): (Vec<F>, Vec<_>) = counted.unzip();
        let info = vk::QueryPoolCreateInfo::default()
            .query_type(vk::QueryType::PIPELINE_STATISTICS)
            .pipeline_statistics(flags.into_iter().fold(F::empty(), |all, flag| all | flag))
            .query_count(room as u32);
        let raw = unsafe { gpu.device().create_query_pool(&info, None) }.or_call("vkCreateQueryPool")?;
        gpu.set_name(raw, "submitter.statistics");
        Ok(Self { raw, counters, gpu: gpu.clone() })
    }

    /// Of the first `spans` queries, once the device is done.
    pub fn read(&self, spans: usize) -> Result<Vec<Statistics>> {
        if spans == 0 {
            return Ok(Vec::new());
        }
        // Rows of as many counters as there can be: what is not counted leaves the end of each as it is.
        let mut rows = vec![[0u64; ALL.len()]; spans];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        unsafe { self.gpu.device().get_query_pool_results(self.raw, 0, &mut rows, flags) }
            .or_call("vkGetQueryPoolResults")?;
        let named = |row: &[u64; ALL.len()]| {
            let counters = self.counters.iter().copied().zip(row.iter().copied());
            counters.filter(|(_, count)| *count > 0).collect()
        };
        Ok(rows.iter().map(named).collect())
    }
}

impl Drop for StatisticsPool {
    fn drop(&mut self) {
        unsafe { self.gpu.device().destroy_query_pool(self.raw, None) };
    }
}
