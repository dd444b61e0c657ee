// SPDX-License-Identifier: MIT OR Apache-2.0
//! What the driver made of each pipeline: registers, spills, shared memory (VK_KHR_pipeline_executable_properties).
//!
//! A device that is opened by [`Gpu::capturing`] builds every pipeline to be looked at, and keeps a list of them.

use super::{
    device::Gpu,
    error::{OrCall, Result},
    program::{Program, Shader},
    shared::shared_bytes,
};
use ash::{khr, vk};
use std::{ffi::CStr, sync::Mutex};

/// One pipeline, and what it became.
#[derive(Clone, Debug, PartialEq)]
pub struct PipelineReport {
    /// As the host names it.
    pub name: String,
    /// Files of its shaders, as [`shaders::ALL`](crate::shaders::ALL) names them; those compiled at run time have none.
    pub shaders: Vec<String>,
    /// Its specialization constants, by `constant_id`.
    pub constants: Vec<u32>,
    /// Workgroup size of a kernel.
    pub local_size: Option<[u32; 3]>,
    /// Shared memory of a workgroup as its SPIR-V declares it, without what a driver adds (bytes); `None` of what is drawn.
    pub shared_bytes: Option<u64>,
    /// What the driver made: none where it does not say.
    pub executables: Vec<Executable>,
}

/// One program on the device: a stage, or several.
#[derive(Clone, Debug, PartialEq)]
pub struct Executable {
    /// The driver's name of it.
    pub name: String,
    /// Its stages.
    pub stages: vk::ShaderStageFlags,
    /// Invocations of a subgroup; 0 if the driver does not say.
    pub subgroup: u32,
    /// The driver's names, and values.
    pub statistics: Vec<(String, Statistic)>,
}

/// A number of one of four kinds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Statistic {
    /// Yes or no.
    Flag(bool),
    /// A whole number.
    Signed(i64),
    /// A whole number that is not negative.
    Unsigned(u64),
    /// Another number.
    Float(f64),
}

impl Statistic {
    /// As a count, if it is one that can be true: some drivers leave the upper half of a word as it was.
    pub fn count(self) -> Option<u64> {
        let count = match self {
            Self::Flag(is) => u64::from(is),
            Self::Signed(n) => u64::try_from(n).ok()?,
            Self::Unsigned(n) => n,
            Self::Float(x) => (x >= 0.0).then_some(x as u64)?,
        };
        (count <= u64::from(u32::MAX)).then_some(count)
    }
}

/// The list of a device that captures.
pub(super) struct Captured {
    /// `None` where the device does not say what it made.
    pub api: Option<khr::pipeline_executable_properties::Device>,
    pub found: Mutex<Vec<PipelineReport>>,
}

impl Gpu {
    /// Every pipeline that was built so far, in that order; nothing unless the device was opened by [`Gpu::capturing`].
    pub fn pipelines(&self) -> Vec<PipelineReport> {
        let Some(captured) = &self.0.captured else { return Vec::new() };
        captured.found.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).clone()
    }

    /// Flags that every pipeline is built with.
    pub(super) fn pipeline_flags(&self) -> vk::PipelineCreateFlags {
        match &self.0.captured {
            Some(Captured { api: Some(_), .. }) => vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR,
            _ => vk::PipelineCreateFlags::empty(),
        }
    }

    /// Puts a pipeline on the list.
    pub(super) fn report(&self, program: &Program, shaders: &[Shader<'_>], constants: &[u32]) -> Result<()> {
        let Some(captured) = &self.0.captured else { return Ok(()) };
        let name = program.text();
        let file = |spv: &[u8]| {
            // Of two files that compile to the same, the one that is called so.
            let alike = crate::shaders::ALL.iter().filter(|(_, it)| *it == spv).map(|(file, _)| *file);
            alike.min_by_key(|file| file.rsplit_once('.').is_none_or(|(pass, _)| pass != name))
        };
        let is_kernel = program.interface.local_size.is_some();
        let shared = |shader: &Shader<'_>| shared_bytes(shader.spv, constants);
        let report = PipelineReport {
            name: name.clone(),
            shaders: shaders.iter().filter_map(|it| file(it.spv)).map(String::from).collect(),
            constants: constants.to_vec(),
            local_size: program.interface.local_size,
            shared_bytes: shaders.first().filter(|_| is_kernel).and_then(shared),
            executables: match &captured.api {
                Some(api) => executables(api, program)?,
                None => Vec::new(),
            },
        };
        captured.found.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push(report);
        Ok(())
    }
}

fn executables(
    api: &khr::pipeline_executable_properties::Device,
    program: &Program,
) -> Result<Vec<Executable>> {
    let info = vk::PipelineInfoKHR::default().pipeline(program.pipeline);
    let found = unsafe { api.get_pipeline_executable_properties(&info) }
        .or_call_for("vkGetPipelineExecutablePropertiesKHR", &program.text())?;
    let describe = |(index, it): (u32, &vk::PipelineExecutablePropertiesKHR<'_>)| {
        let info =
            vk::PipelineExecutableInfoKHR::default().pipeline(program.pipeline).executable_index(index);
        let statistics = unsafe { api.get_pipeline_executable_statistics(&info) }
            .or_call_for("vkGetPipelineExecutableStatisticsKHR", &program.text())?;
        Ok(Executable {
            name: text(it.name_as_c_str()),
            stages: it.stages,
            subgroup: it.subgroup_size,
            statistics: statistics.iter().map(|it| (text(it.name_as_c_str()), value(it))).collect(),
        })
    };
    (0..).zip(&found).map(describe).collect()
}

fn value(it: &vk::PipelineExecutableStatisticKHR<'_>) -> Statistic {
    use vk::PipelineExecutableStatisticFormatKHR as Format;
    // SAFETY: the format says which member of the union the driver has written.
    unsafe {
        match it.format {
            Format::BOOL32 => Statistic::Flag(it.value.b32 != vk::FALSE),
            Format::INT64 => Statistic::Signed(it.value.i64),
            Format::FLOAT64 => Statistic::Float(it.value.f64),
            _ => Statistic::Unsigned(it.value.u64),
        }
    }
}

fn text(name: Result<&CStr, std::ffi::FromBytesUntilNulError>) -> String {
    name.map_or_else(|_| "?".into(), |name| name.to_string_lossy().into_owned())
}
