// SPDX-License-Identifier: MIT OR Apache-2.0
//! Transform feedback (VK_EXT_transform_feedback): the graphics pipeline up to its geometry shader, as a way to write lists.
//! It is there to be ported from and to: not every device has it, and a compute shader that appends is as good.

use super::{
    device::Gpu,
    error::{Error, Result},
    program::{Bound, HostSide, Program, Resource, Shader},
    reflect::reflect,
    Buffer,
};
use ash::vk;
use std::{ffi::CStr, sync::Arc};

/// A pipeline that captures what its geometry shader emits.
pub struct StreamInfo<'a> {
    /// `module.pass`.
    pub name: &'a CStr,
    /// SPIR-V of the vertex shader: vertices are pulled by `gl_VertexIndex`, one a point.
    pub vertex: &'a [u8],
    /// SPIR-V of the geometry shader, whose outputs have `xfb_buffer = 0`.
    pub geometry: &'a [u8],
    /// Names of the blocks of set 0 of both stages, by binding number.
    pub blocks: &'a [&'a str],
}

/// What a draw that is captured takes its vertices from.
#[derive(Clone, Copy)]
pub enum StreamDraw<'a> {
    /// So many.
    Points(u32),
    /// As many as were captured when `counter` was written, of `stride` bytes each (DrawAuto, in Direct3D).
    Captured {
        /// Bytes that were captured.
        counter: &'a Buffer,
        /// Of a vertex (bytes).
        stride: u32,
    },
}

/// A capturing pipeline whose interface is known to match its host code.
#[derive(Clone)]
pub struct Stream(Arc<Program>);

impl Stream {
    /// `P` is the push-constant struct of both stages.
    ///
    /// # Errors
    /// [`Error::Interface`] if blocks or the size of `P` differ from the SPIR-V, or the device lacks transform feedback.
    pub fn new<P>(gpu: &Gpu, info: &StreamInfo<'_>) -> Result<Self> {
        let mismatch = |what| Error::Interface { kernel: info.name.to_string_lossy().into_owned(), what };
        if gpu.0.stream.is_none() {
            return Err(mismatch(format!("{} has no transform feedback", gpu.name())));
        }
        let (vertex, geometry) = (vk::ShaderStageFlags::VERTEX, vk::ShaderStageFlags::GEOMETRY);
        let interface = reflect(info.vertex, &[]).map_err(mismatch)?;
        let interface = interface.merge(reflect(info.geometry, &[]).map_err(mismatch)?).map_err(mismatch)?;
        let host = HostSide { blocks: info.blocks, push_bytes: size_of::<P>(), constants: 0 };
        let program = Program::new(gpu, info.name, interface, vertex | geometry, &host)?;
        let shaders =
            [Shader { stage: vertex, spv: info.vertex }, Shader { stage: geometry, spv: info.geometry }];
        program.build(&shaders, &[], "vkCreateGraphicsPipelines", create).map(Self)
    }

    /// The pipeline with its resources, by block name and in binding order.
    ///
    /// # Errors
    /// [`Error::Interface`] if a name or a kind differs from the shaders'.
    pub fn bind(&self, resources: &[(&str, Resource<'_>)]) -> Result<Bound> {
        Bound::new(&self.0, resources)
    }
}

fn create(
    device: &ash::Device,
    cache: vk::PipelineCache,
    stages: &[vk::PipelineShaderStageCreateInfo<'_>],
    layout: vk::PipelineLayout,
    flags: vk::PipelineCreateFlags,
) -> Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)> {
    let vertices = vk::PipelineVertexInputStateCreateInfo::default();
    let points =
        vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::POINT_LIST);
    let discard =
        vk::PipelineRasterizationStateCreateInfo::default().rasterizer_discard_enable(true).line_width(1.0);
    let mut nothing = vk::PipelineRenderingCreateInfo::default();
    let pipeline = vk::GraphicsPipelineCreateInfo::default()
        .flags(flags)
        .stages(stages)
        .vertex_input_state(&vertices)
        .input_assembly_state(&points)
        .rasterization_state(&discard)
        .layout(layout)
        .push_next(&mut nothing);
    unsafe { device.create_graphics_pipelines(cache, &[pipeline], None) }
}
