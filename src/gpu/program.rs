// SPDX-License-Identifier: MIT OR Apache-2.0
//! What compute kernels and graphics pipelines share: a pipeline whose interface is known to match its host code, and
//! the binding of resources to it.

use super::{
    device::Gpu,
    error::{Error, OrCall, Result},
    reflect::{Block, Interface},
    Buffer, Image,
};
use ash::vk;
use std::{
    ffi::{CStr, CString},
    slice,
    sync::Arc,
};

/// Pipeline, layouts and what they were checked against.
pub(super) struct Program {
    pub pipeline: vk::Pipeline,
    pub layout: vk::PipelineLayout,
    pub bind_point: vk::PipelineBindPoint,
    pub stages: vk::ShaderStageFlags,
    pub interface: Interface,
    pub name: CString,
    set_layout: vk::DescriptorSetLayout,
    modules: Vec<vk::ShaderModule>,
    pub gpu: Gpu,
}

/// One shader of a program.
pub(super) struct Shader<'a> {
    pub stage: vk::ShaderStageFlags,
    pub spv: &'a [u8],
}

impl Program {
    /// Checks `interface` against the host's side and makes all but the pipeline.
    pub fn new(
        gpu: &Gpu,
        name: &CStr,
        interface: Interface,
        stages: vk::ShaderStageFlags,
        host: &HostSide<'_>,
    ) -> Result<Self> {
        check(&interface, host).map_err(|what| Error::Interface { kernel: text(name), what })?;
        let is_compute = stages == vk::ShaderStageFlags::COMPUTE;
        // Built in place: whatever fails below, `Drop` frees what exists by then. Null handles are ignored.
        let mut program = Self {
            pipeline: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            bind_point: if is_compute {
                vk::PipelineBindPoint::COMPUTE
            } else {
                vk::PipelineBindPoint::GRAPHICS
            },
            stages,
            interface,
            name: name.into(),
            set_layout: vk::DescriptorSetLayout::null(),
            modules: Vec::new(),
            gpu: gpu.clone(),
        };
        let slots: Vec<_> = program
            .interface
            .blocks
            .iter()
            .map(|(&binding, block)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(binding)
                    .descriptor_type(block.kind)
                    .descriptor_count(1)
                    .stage_flags(stages)
            })
            .collect();
        let set = vk::DescriptorSetLayoutCreateInfo::default().bindings(&slots);
        program.set_layout = unsafe { gpu.device().create_descriptor_set_layout(&set, None) }
            .or_call_for("vkCreateDescriptorSetLayout", &program.text())?;
        gpu.set_name(program.set_layout, &program.text());
        let sets = [program.set_layout];
        let push = [vk::PushConstantRange { stage_flags: stages, offset: 0, size: host.push_bytes as u32 }];
        let push = if host.push_bytes > 0 { &push[..] } else { &[] };
        let layout = vk::PipelineLayoutCreateInfo::default().set_layouts(&sets).push_constant_ranges(push);
        program.layout = unsafe { gpu.device().create_pipeline_layout(&layout, None) }
            .or_call_for("vkCreatePipelineLayout", &program.text())?;
        gpu.set_name(program.layout, &program.text());
        Ok(program)
    }

    /// Makes the modules; `create` makes the pipeline from their stages.
    pub fn build(
        mut self,
        shaders: &[Shader<'_>],
        constants: &[u32],
        call: &'static str,
        create: impl FnOnce(
            &ash::Device,
            vk::PipelineCache,
            &[vk::PipelineShaderStageCreateInfo<'_>],
            vk::PipelineLayout,
            vk::PipelineCreateFlags,
        ) -> Result<Vec<vk::Pipeline>, (Vec<vk::Pipeline>, vk::Result)>,
    ) -> Result<Arc<Self>> {
        let gpu = self.gpu.clone();
        for shader in shaders {
            let words: Vec<u32> = bytemuck::allocation::pod_collect_to_vec(shader.spv);
            let info = vk::ShaderModuleCreateInfo::default().code(&words);
            let module = unsafe { gpu.device().create_shader_module(&info, None) }
                .or_call_for("vkCreateShaderModule", &self.text())?;
            gpu.set_name(module, &format!("{} ({:?})", self.text(), shader.stage));
            self.modules.push(module);
        }
        let entries: Vec<_> = (0..constants.len() as u32)
            .map(|id| vk::SpecializationMapEntry { constant_id: id, offset: 4 * id, size: 4 })
            .collect();
        let specialization =
            vk::SpecializationInfo::default().map_entries(&entries).data(bytemuck::cast_slice(constants));
        let stages: Vec<_> = shaders
            .iter()
            .zip(&self.modules)
            .map(|(shader, &module)| {
                vk::PipelineShaderStageCreateInfo::default()
                    .stage(shader.stage)
                    .module(module)
                    .name(c"main")
                    .specialization_info(&specialization)
            })
            .collect();
        let made = create(gpu.device(), gpu.0.cache.raw, &stages, self.layout, gpu.pipeline_flags());
        self.pipeline = made.map_err(|(_, code)| code).or_call_for(call, &self.text())?[0];
        gpu.0.cache.is_stale.store(true, std::sync::atomic::Ordering::Relaxed);
        gpu.set_name(self.pipeline, &self.text());
        gpu.report(&self, shaders, constants)?;
        Ok(Arc::new(self))
    }

    pub fn text(&self) -> String {
        text(&self.name)
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let device = self.gpu.device();
        unsafe {
            device.destroy_pipeline(self.pipeline, None);
            self.modules.iter().for_each(|&module| device.destroy_shader_module(module, None));
            device.destroy_pipeline_layout(self.layout, None);
            device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// What the host believes of a program.
pub(super) struct HostSide<'a> {
    pub blocks: &'a [&'a str],
    pub push_bytes: usize,
    pub constants: usize,
}

fn check(spv: &Interface, host: &HostSide<'_>) -> Result<(), String> {
    let in_spv: Vec<&str> = spv.blocks.values().map(|block| block.name.as_str()).collect();
    if in_spv != host.blocks {
        return Err(format!("bindings are {in_spv:?} in GLSL, {:?} in Rust", host.blocks));
    }
    if spv.push_bytes != host.push_bytes {
        return Err(format!("push constants: {} bytes in GLSL, {} in Rust", spv.push_bytes, host.push_bytes));
    }
    let ids: Vec<u32> = spv.constants.keys().copied().collect();
    if ids != (0..host.constants as u32).collect::<Vec<_>>() {
        return Err(format!("constant_ids {ids:?} in GLSL, {} constants in Rust", host.constants));
    }
    Ok(())
}

/// What a binding can hold.
#[derive(Clone, Copy)]
pub enum Resource<'a> {
    /// The whole of a buffer.
    Buffer(&'a Buffer),
    /// A storage image.
    Image(&'a Image),
}

impl<'a> From<&'a Buffer> for Resource<'a> {
    fn from(buffer: &'a Buffer) -> Self {
        Self::Buffer(buffer)
    }
}

impl<'a> From<&'a Image> for Resource<'a> {
    fn from(image: &'a Image) -> Self {
        Self::Image(image)
    }
}

/// A program with its resources: what a recorder dispatches or draws. It keeps both alive.
///
/// The descriptor set is written once, when resources are bound, so recording allocates nothing and needs no extension
/// of the device.
#[derive(Clone)]
pub struct Bound(Arc<BoundInner>);

struct BoundInner {
    program: Arc<Program>,
    pool: vk::DescriptorPool,
    set: vk::DescriptorSet,
    _buffers: Vec<Buffer>,
    _images: Vec<Image>,
}

impl Bound {
    pub(super) fn new(program: &Arc<Program>, resources: &[(&str, Resource<'_>)]) -> Result<Self> {
        let mismatch = |what| Error::Interface { kernel: program.text(), what };
        let blocks: Vec<(&u32, &Block)> = program.interface.blocks.iter().collect();
        let names: Vec<&str> = blocks.iter().map(|(_, block)| block.name.as_str()).collect();
        let given: Vec<&str> = resources.iter().map(|(name, _)| *name).collect();
        if names != given {
            return Err(mismatch(format!("bindings are {names:?}, bound are {given:?}")));
        }

        let mut bound = BoundInner {
            program: program.clone(),
            pool: vk::DescriptorPool::null(),
            set: vk::DescriptorSet::null(),
            _buffers: Vec::new(),
            _images: Vec::new(),
        };
        if blocks.is_empty() {
            return Ok(Self(Arc::new(bound)));
        }
        let device = program.gpu.device();
        let kinds = [
            vk::DescriptorType::STORAGE_BUFFER,
            vk::DescriptorType::UNIFORM_BUFFER,
            vk::DescriptorType::STORAGE_IMAGE,
        ];
        let sizes = kinds.map(|ty| {
            let count = blocks.iter().filter(|(_, block)| block.kind == ty).count() as u32;
            vk::DescriptorPoolSize { ty, descriptor_count: count }
        });
        let sizes: Vec<_> = sizes.into_iter().filter(|size| size.descriptor_count > 0).collect();
        let pool = vk::DescriptorPoolCreateInfo::default().max_sets(1).pool_sizes(&sizes);
        bound.pool = unsafe { device.create_descriptor_pool(&pool, None) }
            .or_call_for("vkCreateDescriptorPool", &program.text())?;
        program.gpu.set_name(bound.pool, &program.text());
        let layouts = [program.set_layout];
        let set = vk::DescriptorSetAllocateInfo::default().descriptor_pool(bound.pool).set_layouts(&layouts);
        bound.set = unsafe { device.allocate_descriptor_sets(&set) }
            .or_call_for("vkAllocateDescriptorSets", &program.text())?[0];
        program.gpu.set_name(bound.set, &program.text());

        for ((&binding, block), (name, resource)) in blocks.into_iter().zip(resources) {
            let write = vk::WriteDescriptorSet::default()
                .dst_set(bound.set)
                .dst_binding(binding)
                .descriptor_type(block.kind);
            match (resource, block.kind) {
                (
                    Resource::Buffer(buffer),
                    kind @ (vk::DescriptorType::STORAGE_BUFFER | vk::DescriptorType::UNIFORM_BUFFER),
                ) => {
                    let limits = program.gpu.limits();
                    let (allowed, limit) = if kind == vk::DescriptorType::UNIFORM_BUFFER {
                        (limits.max_uniform_buffer_range, "maxUniformBufferRange, bytes")
                    } else {
                        (limits.max_storage_buffer_range, "maxStorageBufferRange, bytes")
                    };
                    let allowed = u64::from(allowed);
                    if buffer.bytes() > allowed {
                        return Err(Error::Limit {
                            name: buffer.name().into(),
                            needed: buffer.bytes(),
                            device: program.gpu.name().into(),
                            allowed,
                            limit,
                        });
                    }
                    let whole =
                        vk::DescriptorBufferInfo { buffer: buffer.raw(), offset: 0, range: vk::WHOLE_SIZE };
                    let write = write.buffer_info(slice::from_ref(&whole));
                    unsafe { device.update_descriptor_sets(&[write], &[]) };
                    bound._buffers.push((*buffer).clone());
                }
                (Resource::Image(image), vk::DescriptorType::STORAGE_IMAGE) => {
                    let view = vk::DescriptorImageInfo::default()
                        .image_view(image.view())
                        .image_layout(vk::ImageLayout::GENERAL);
                    let write = write.image_info(slice::from_ref(&view));
                    unsafe { device.update_descriptor_sets(&[write], &[]) };
                    bound._images.push((*image).clone());
                }
                _ => return Err(mismatch(format!("`{name}` is {:?} in GLSL", block.kind))),
            }
        }
        Ok(Self(Arc::new(bound)))
    }

    pub(super) fn program(&self) -> &Program {
        &self.0.program
    }

    pub(super) fn set(&self) -> vk::DescriptorSet {
        self.0.set
    }
}

impl Drop for BoundInner {
    fn drop(&mut self) {
        unsafe { self.program.gpu.device().destroy_descriptor_pool(self.pool, None) };
    }
}

fn text(name: &CStr) -> String {
    name.to_string_lossy().into_owned()
}
