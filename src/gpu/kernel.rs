// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{
    device::Gpu,
    error::{Error, Result},
    program::{Bound, HostSide, Program, Resource, Shader},
    reflect::{reflect, Interface},
};
use ash::vk;
use std::{ffi::CStr, sync::Arc};

/// What a kernel is, said once on the host and checked against the SPIR-V when it is built.
pub struct KernelInfo<'a> {
    /// `module.pass`: also the GLSL file, the CPU twin, the debug label and the row of the bench.
    pub name: &'a CStr,
    /// SPIR-V of the compute shader.
    pub spv: &'a [u8],
    /// Names of the blocks of set 0, by binding number.
    pub blocks: &'a [&'a str],
    /// Specialization constants, by `constant_id`.
    pub constants: &'a [u32],
}

/// A compute pipeline whose interface is known to match its host code.
#[derive(Clone)]
pub struct Kernel(Arc<Program>);

impl Kernel {
    /// `P` is the push-constant struct, `()` if there is none.
    ///
    /// # Errors
    /// [`Error::Interface`] if the blocks, the constants or the size of `P` differ from the SPIR-V, or the workgroup is
    /// larger than the device allows.
    pub fn new<P>(gpu: &Gpu, info: &KernelInfo<'_>) -> Result<Self> {
        let mismatch = |what| Error::Interface { kernel: info.name.to_string_lossy().into_owned(), what };
        let spv = gpu.current(info.spv);
        let interface = reflect(&spv, info.constants).map_err(mismatch)?;
        let size =
            interface.local_size.ok_or_else(|| mismatch("no workgroup size: not a compute shader".into()))?;
        let limits = gpu.limits();
        let allowed = limits.max_compute_work_group_invocations;
        let fits =
            size.iter().zip(limits.max_compute_work_group_size).all(|(&n, most)| (1..=most).contains(&n));
        if !fits || size.iter().map(|&n| u64::from(n)).product::<u64>() > u64::from(allowed) {
            return Err(mismatch(format!(
                "workgroup {size:?}, and {} allows {allowed} invocations",
                gpu.name()
            )));
        }
        let host =
            HostSide { blocks: info.blocks, push_bytes: size_of::<P>(), constants: info.constants.len() };
        let stage = vk::ShaderStageFlags::COMPUTE;
        let program = Program::new(gpu, info.name, interface, stage, &host)?;
        let shader = Shader { stage, spv: &spv };
        let built = program.build(
            &[shader],
            info.constants,
            "vkCreateComputePipelines",
            |device, cache, stages, layout, flags| {
                let pipeline =
                    vk::ComputePipelineCreateInfo::default().flags(flags).stage(stages[0]).layout(layout);
                unsafe { device.create_compute_pipelines(cache, &[pipeline], None) }
            },
        )?;
        Ok(Self(built))
    }

    /// The kernel with its resources, by block name and in binding order.
    ///
    /// # Errors
    /// [`Error::Interface`] if a name or a kind differs from the shader's.
    pub fn bind(&self, resources: &[(&str, Resource<'_>)]) -> Result<Bound> {
        Bound::new(&self.0, resources)
    }

    /// What the SPIR-V says.
    pub fn interface(&self) -> &Interface {
        &self.0.interface
    }
}
