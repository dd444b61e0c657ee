// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{
    device::Gpu,
    error::{Error, Result},
    program::{Bound, HostSide, Program, Resource, Shader},
    reflect::reflect,
    ImageUse,
};
use ash::vk;
use std::{ffi::CStr, sync::Arc};

/// What vertices form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topology {
    /// Three vertices a triangle.
    Triangles,
    /// Two vertices a line.
    Lines,
    /// One vertex a point: what a geometry shader takes apart.
    Points,
}

/// How colours meet what is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blend {
    /// Replace it.
    Opaque,
    /// Premultiplied alpha over it.
    Over,
    /// Add to it.
    Add,
}

/// How depth is used. Nearer is greater: reversed, so that floats are fine where distances are large.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Depth {
    /// Test and write.
    Write,
    /// Test and write; of what is as near, the first stays.
    WriteNearer,
    /// Test only.
    Test,
}

/// What a pipeline draws to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Attachments {
    /// [`ImageUse::Color`] and depth: [`Recorder::render`](super::Recorder::render).
    Picture,
    /// Depth alone: the same, of a target without colour.
    Depth,
    /// Two [`ImageUse::Volume`]s and their depth: [`Recorder::render_layers`](super::Recorder::render_layers).
    Volumes,
    /// Nothing: fragments write buffers, [`Recorder::render_nothing`](super::Recorder::render_nothing).
    Nothing,
}

/// A graphics pipeline: vertices are pulled from storage buffers by `gl_VertexIndex`, there are no vertex buffers.
pub struct RasterInfo<'a> {
    /// `module.pass`.
    pub name: &'a CStr,
    /// SPIR-V of the vertex shader.
    pub vertex: &'a [u8],
    /// SPIR-V of the geometry shader, if there is one: not every device takes it.
    pub geometry: Option<&'a [u8]>,
    /// SPIR-V of the fragment shader.
    pub fragment: &'a [u8],
    /// Names of the blocks of set 0 of all stages, by binding number.
    pub blocks: &'a [&'a str],
    /// Specialization constants of all stages, by `constant_id`.
    pub constants: &'a [u32],
    /// What vertices form.
    pub topology: Topology,
    /// How colours meet what is there.
    pub blend: Blend,
    /// How depth is used.
    pub depth: Depth,
    /// Samples a pixel of the target.
    pub samples: u32,
}

/// A graphics pipeline whose interface is known to match its host code.
#[derive(Clone)]
pub struct Raster(Arc<Program>);

impl Raster {
    /// A pipeline that draws pictures. `P` is the push-constant struct of all stages, `()` if there is none.
    ///
    /// # Errors
    /// As [`Raster::onto`].
    pub fn new<P>(gpu: &Gpu, info: &RasterInfo<'_>) -> Result<Self> {
        Self::onto::<P>(gpu, info, Attachments::Picture)
    }

    /// A pipeline that draws to `attachments`.
    ///
    /// # Errors
    /// [`Error::Interface`] if the blocks, the constants or the size of `P` differ from the SPIR-V, or the device lacks the
    /// stage.
    pub fn onto<P>(gpu: &Gpu, info: &RasterInfo<'_>, attachments: Attachments) -> Result<Self> {
        let name = || info.name.to_string_lossy().into_owned();
        if !gpu.has_graphics() {
            return Err(Error::NoGraphics { device: gpu.name().into(), name: name() });
        }
        let mismatch = |what| Error::Interface { kernel: name(), what };
        let (vertex_spv, fragment_spv) = (gpu.current(info.vertex), gpu.current(info.fragment));
        let geometry_spv = info.geometry.map(|spv| gpu.current(spv));
        let vertex = reflect(&vertex_spv, info.constants).map_err(mismatch)?;
        let fragment = reflect(&fragment_spv, info.constants).map_err(mismatch)?;
        let mut interface = vertex.merge(fragment).map_err(mismatch)?;
        let (vertex, fragment) = (vk::ShaderStageFlags::VERTEX, vk::ShaderStageFlags::FRAGMENT);
        let mut stages = vertex | fragment;
        let mut shaders =
            vec![Shader { stage: vertex, spv: &vertex_spv }, Shader { stage: fragment, spv: &fragment_spv }];
        if let Some(spv) = geometry_spv.as_deref() {
            if !gpu.has_geometry_shader() {
                return Err(mismatch(format!("{} has no geometry shaders", gpu.name())));
            }
            interface = interface.merge(reflect(spv, info.constants).map_err(mismatch)?).map_err(mismatch)?;
            stages |= vk::ShaderStageFlags::GEOMETRY;
            shaders.push(Shader { stage: vk::ShaderStageFlags::GEOMETRY, spv });
        }
        let host =
            HostSide { blocks: info.blocks, push_bytes: size_of::<P>(), constants: info.constants.len() };
        let program = Program::new(gpu, info.name, interface, stages, &host)?;
        program
            .build(
                &shaders,
                info.constants,
                "vkCreateGraphicsPipelines",
                |device, cache, stages, layout, flags| {
                    create(device, cache, stages, (layout, flags), info, attachments)
                },
            )
            .map(Self)
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
    (layout, flags): (vk::PipelineLayout, vk::PipelineCreateFlags),
    info: &RasterInfo<'_>,
    onto: Attachments,
) -> Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)> {
    let vertices = vk::PipelineVertexInputStateCreateInfo::default();
    let assembly = vk::PipelineInputAssemblyStateCreateInfo::default().topology(match info.topology {
        Topology::Triangles => vk::PrimitiveTopology::TRIANGLE_LIST,
        Topology::Lines => vk::PrimitiveTopology::LINE_LIST,
        Topology::Points => vk::PrimitiveTopology::POINT_LIST,
    });
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(vk::PolygonMode::FILL)
        .cull_mode(vk::CullModeFlags::NONE)
        .line_width(1.0);
    let samples = vk::PipelineMultisampleStateCreateInfo::default()
        .rasterization_samples(vk::SampleCountFlags::from_raw(info.samples));
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(onto != Attachments::Nothing)
        .depth_write_enable(onto != Attachments::Nothing && info.depth != Depth::Test)
        .depth_compare_op(match info.depth {
            Depth::WriteNearer => vk::CompareOp::GREATER,
            Depth::Write | Depth::Test => vk::CompareOp::GREATER_OR_EQUAL,
        });
    let (one, zero) = (vk::BlendFactor::ONE, vk::BlendFactor::ZERO);
    let (source, target) = match info.blend {
        Blend::Opaque => (one, zero),
        Blend::Over => (one, vk::BlendFactor::ONE_MINUS_SRC_ALPHA),
        Blend::Add => (one, one),
    };
    let formats: &[vk::Format] = match onto {
        Attachments::Picture => &[ImageUse::Color.format()],
        Attachments::Volumes => &[ImageUse::Volume.format(); 2],
        Attachments::Depth | Attachments::Nothing => &[],
    };
    let blended = vk::PipelineColorBlendAttachmentState::default()
        .color_write_mask(vk::ColorComponentFlags::RGBA)
        .blend_enable(info.blend != Blend::Opaque)
        .src_color_blend_factor(source)
        .dst_color_blend_factor(target)
        .src_alpha_blend_factor(source)
        .dst_alpha_blend_factor(target);
    let attachments = vec![blended; formats.len()];
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&attachments);
    let dynamic = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic);
    let depth_format = match onto {
        Attachments::Nothing => vk::Format::UNDEFINED,
        Attachments::Picture | Attachments::Depth | Attachments::Volumes => ImageUse::Depth.format(),
    };
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(formats)
        .depth_attachment_format(depth_format);
    let pipeline = vk::GraphicsPipelineCreateInfo::default()
        .flags(flags)
        .stages(stages)
        .vertex_input_state(&vertices)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering);
    unsafe { device.create_graphics_pipelines(cache, &[pipeline], None) }
}
