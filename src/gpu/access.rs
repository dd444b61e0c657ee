// SPDX-License-Identifier: MIT OR Apache-2.0
use ash::vk::{self, AccessFlags2 as A, PipelineStageFlags2 as S};

/// How a pass touches memory. This is the whole vocabulary of the crate: a barrier is a pair of these, and no other
/// place has stage and access bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// A compute shader reads buffers or images.
    ComputeRead,
    /// A compute shader writes them.
    ComputeWrite,
    /// A compute shader does both.
    ComputeReadWrite,
    /// Arguments of an indirect dispatch or draw.
    IndirectRead,
    /// Indices of a draw.
    IndexRead,
    /// A vertex, geometry or fragment shader reads buffers or images.
    GraphicsRead,
    /// A fragment shader reads and writes buffers.
    FragmentReadWrite,
    /// Colour attachment, written, blended or resolved.
    ColorWrite,
    /// Depth attachment, tested and written.
    DepthWrite,
    /// Transform feedback captures vertices, and counts them.
    StreamWrite,
    /// A draw takes its number of vertices from what was captured, and its shaders read that.
    StreamRead,
    /// Source of a copy.
    CopyRead,
    /// Destination of a copy.
    CopyWrite,
    /// `vkCmdFillBuffer` and `vkCmdUpdateBuffer`: a CLEAR, not a COPY, in synchronization2 terms. Older validation layers
    /// take it for a COPY, so the barrier names both.
    FillWrite,
    /// The host reads mapped memory.
    HostRead,
    /// The host wrote mapped memory.
    HostWrite,
}

impl Access {
    pub(super) const fn masks(self) -> (S, A) {
        match self {
            Self::ComputeRead => (S::COMPUTE_SHADER, both(A::SHADER_STORAGE_READ, A::UNIFORM_READ)),
            Self::ComputeWrite => (S::COMPUTE_SHADER, A::SHADER_STORAGE_WRITE),
            Self::ComputeReadWrite => {
                let reads = both(A::SHADER_STORAGE_READ, A::UNIFORM_READ);
                (S::COMPUTE_SHADER, both(reads, A::SHADER_STORAGE_WRITE))
            }
            Self::IndirectRead => (S::DRAW_INDIRECT, A::INDIRECT_COMMAND_READ),
            Self::IndexRead => (S::INDEX_INPUT, A::INDEX_READ),
            Self::GraphicsRead => {
                // Before rasterization: vertex and, where the device has it, geometry shaders.
                let stages = S::PRE_RASTERIZATION_SHADERS.as_raw() | S::FRAGMENT_SHADER.as_raw();
                (S::from_raw(stages), both(A::SHADER_STORAGE_READ, A::UNIFORM_READ))
            }
            Self::FragmentReadWrite => {
                let reads = both(A::SHADER_STORAGE_READ, A::UNIFORM_READ);
                (S::FRAGMENT_SHADER, both(reads, A::SHADER_STORAGE_WRITE))
            }
            Self::ColorWrite => {
                (S::COLOR_ATTACHMENT_OUTPUT, both(A::COLOR_ATTACHMENT_READ, A::COLOR_ATTACHMENT_WRITE))
            }
            Self::DepthWrite => (
                S::from_raw(S::EARLY_FRAGMENT_TESTS.as_raw() | S::LATE_FRAGMENT_TESTS.as_raw()),
                both(A::DEPTH_STENCIL_ATTACHMENT_READ, A::DEPTH_STENCIL_ATTACHMENT_WRITE),
            ),
            Self::StreamWrite => (
                S::TRANSFORM_FEEDBACK_EXT,
                both(A::TRANSFORM_FEEDBACK_WRITE_EXT, A::TRANSFORM_FEEDBACK_COUNTER_WRITE_EXT),
            ),
            Self::StreamRead => (
                S::from_raw(S::DRAW_INDIRECT.as_raw() | S::PRE_RASTERIZATION_SHADERS.as_raw()),
                both(
                    both(A::TRANSFORM_FEEDBACK_COUNTER_READ_EXT, A::INDIRECT_COMMAND_READ),
                    both(A::SHADER_STORAGE_READ, A::UNIFORM_READ),
                ),
            ),
            Self::CopyRead => (S::COPY, A::TRANSFER_READ),
            Self::CopyWrite => (S::COPY, A::TRANSFER_WRITE),
            Self::FillWrite => (S::from_raw(S::CLEAR.as_raw() | S::COPY.as_raw()), A::TRANSFER_WRITE),
            Self::HostRead => (S::HOST, A::HOST_READ),
            Self::HostWrite => (S::HOST, A::HOST_WRITE),
        }
    }

    pub(super) fn barrier(from: Self, to: Self) -> vk::MemoryBarrier2<'static> {
        let ((src_stage, src_access), (dst_stage, dst_access)) = (from.masks(), to.masks());
        vk::MemoryBarrier2::default()
            .src_stage_mask(src_stage)
            .src_access_mask(src_access)
            .dst_stage_mask(dst_stage)
            .dst_access_mask(dst_access)
    }
}

const fn both(one: A, other: A) -> A {
    A::from_raw(one.as_raw() | other.as_raw())
}
