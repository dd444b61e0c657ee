// SPDX-License-Identifier: MIT OR Apache-2.0
//! What devices there are, what each lacks, and the choice among them.

use super::{
    calibrate::extension,
    error::{Error, OrCall, Result},
    RenderDoc,
};
use ash::{khr, vk};
use std::ffi::CStr;

/// One physical device, described.
#[derive(Clone, Debug)]
pub struct Adapter {
    /// Position in the loader's list.
    pub index: usize,
    /// `VkPhysicalDeviceProperties::deviceName`.
    pub name: String,
    /// 32 hexadecimal digits, the same on every start.
    pub uuid: String,
    /// Driver name and version text.
    pub driver: String,
    /// Vulkan version, `major.minor.patch`.
    pub api: String,
    /// Discrete, integrated, virtual, CPU or other.
    pub kind: &'static str,
    /// What the crate needs and the device has not: empty if it will do.
    pub missing: Vec<String>,
    /// What some variants use, and whether it is there.
    pub optional: Vec<(&'static str, bool)>,
    /// Invocations of a subgroup.
    pub subgroup: u32,
    /// The limits that decide sizes.
    pub limits: vk::PhysicalDeviceLimits,
    pub(super) physical: vk::PhysicalDevice,
    pub(super) family: u32,
    pub(super) has_graphics: bool,
    pub(super) timestamp_bits: u32,
    pub(super) is_portability_subset: bool,
    pub(super) is_null: bool,
    /// Has as extensions what is needed of Vulkan 1.3.
    pub(super) is_by_extensions: bool,
    /// Extension by which the GPU's clock can be told from the host's.
    pub(super) calibration: Option<&'static CStr>,
    rank: u32,
}

impl Adapter {
    pub(super) fn all(instance: &ash::Instance) -> Result<Vec<Self>> {
        let physical =
            unsafe { instance.enumerate_physical_devices() }.or_call("vkEnumeratePhysicalDevices")?;
        physical.into_iter().enumerate().map(|(index, it)| Self::describe(instance, index, it)).collect()
    }

    pub(super) fn describe(
        instance: &ash::Instance,
        index: usize,
        physical: vk::PhysicalDevice,
    ) -> Result<Self> {
        let props = unsafe { instance.get_physical_device_properties(physical) };
        let name = text(props.device_name_as_c_str().unwrap_or(c"?"));
        let mut missing = Vec::new();

        let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
        let find = |flags| families.iter().position(|f| f.queue_flags.contains(flags));
        let (compute, graphics) = (vk::QueueFlags::COMPUTE, vk::QueueFlags::GRAPHICS);
        let family = find(compute | graphics).or_else(|| find(compute));
        // RADV_FORCE_FAMILY gives a device without hardware, to see what kernels compile to. It makes no images, and
        // nothing can be submitted.
        let is_null = name.starts_with("Null hardware");
        let has_graphics = !is_null && family.is_some_and(|f| families[f].queue_flags.contains(graphics));
        if family.is_none() {
            missing.push("a compute queue".into());
        }

        let mut described = Self {
            index,
            name,
            uuid: String::new(),
            driver: String::new(),
            api: version(props.api_version),
            kind: kind(props.device_type),
            missing,
            optional: Vec::new(),
            subgroup: 0,
            limits: props.limits,
            physical,
            family: family.unwrap_or(0) as u32,
            has_graphics,
            timestamp_bits: family.map_or(0, |f| families[f].timestamp_valid_bits),
            is_portability_subset: false,
            is_null,
            is_by_extensions: false,
            calibration: None,
            rank: rank(props.device_type),
        };
        // Where buffers' addresses cannot be replayed, RenderDoc says 1.2 of a device of 1.3, and has what is needed here as
        // extensions. Lavapipe is one.
        described.is_by_extensions = props.api_version >= vk::API_VERSION_1_2
            && props.api_version < vk::API_VERSION_1_3
            && RenderDoc::watching().is_some();
        if props.api_version < vk::API_VERSION_1_3 && !described.is_by_extensions {
            described.missing.push(format!("Vulkan 1.3 (it has {})", version(props.api_version)));
            return Ok(described);
        }
        described.look_closer(instance)?;
        Ok(described)
    }

    /// Whether it has what [`Adapter::optional`] calls `name`.
    pub fn has(&self, name: &str) -> bool {
        self.optional.iter().any(|(it, has)| *has && *it == name)
    }

    /// Whether it is a driver that runs on the CPU.
    pub fn is_software(&self) -> bool {
        self.kind == kind(vk::PhysicalDeviceType::CPU)
    }

    /// A queue family that the caller has chosen.
    pub(super) fn use_family(&mut self, instance: &ash::Instance, family: u32) {
        let families = unsafe { instance.get_physical_device_queue_family_properties(self.physical) };
        let chosen = families.get(family as usize).copied().unwrap_or_default();
        self.family = family;
        self.has_graphics = chosen.queue_flags.contains(vk::QueueFlags::GRAPHICS);
        self.timestamp_bits = chosen.timestamp_valid_bits;
    }

    /// What only a device of Vulkan 1.3 can be asked.
    fn look_closer(&mut self, instance: &ash::Instance) -> Result<()> {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut ids = vk::PhysicalDeviceIDProperties::default();
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut props = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut driver)
            .push_next(&mut ids)
            .push_next(&mut subgroup);
        unsafe { instance.get_physical_device_properties2(self.physical, &mut props) };
        self.subgroup = subgroup.subgroup_size;
        let in_compute = subgroup.supported_stages.contains(vk::ShaderStageFlags::COMPUTE);
        let operations = subgroup.supported_operations;
        let has_subgroup = |operation| in_compute && operations.contains(operation);
        self.uuid = ids.device_uuid.iter().map(|byte| format!("{byte:02x}")).collect();
        let words = [driver.driver_name_as_c_str(), driver.driver_info_as_c_str()];
        let words: Vec<String> =
            words.into_iter().flatten().map(text).filter(|word| !word.is_empty()).collect();
        self.driver = words.join(" ");

        let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut v13 = vk::PhysicalDeviceVulkan13Features::default();
        let mut three = Extensions13::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut v12);
        features = if self.is_by_extensions { three.push(features) } else { features.push_next(&mut v13) };
        unsafe { instance.get_physical_device_features2(self.physical, &mut features) };
        let base = features.features;
        let needed = [
            ("synchronization2", v13.synchronization2 | three.synchronization2.synchronization2),
            ("dynamicRendering", v13.dynamic_rendering | three.dynamic_rendering.dynamic_rendering),
            ("maintenance4", v13.maintenance4 | three.maintenance4.maintenance4),
        ];
        self.missing
            .extend(needed.iter().filter(|(_, has)| *has == vk::FALSE).map(|(name, _)| name.to_string()));
        let extensions = unsafe { instance.enumerate_device_extension_properties(self.physical) }
            .or_call("vkEnumerateDeviceExtensionProperties")?;
        let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        let mut capture = vk::PhysicalDeviceTransformFeedbackFeaturesEXT::default();
        let mut capture_limits = vk::PhysicalDeviceTransformFeedbackPropertiesEXT::default();
        if has(ash::ext::transform_feedback::NAME) {
            let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut capture);
            unsafe { instance.get_physical_device_features2(self.physical, &mut features) };
            let mut props = vk::PhysicalDeviceProperties2::default().push_next(&mut capture_limits);
            unsafe { instance.get_physical_device_properties2(self.physical, &mut props) };
        }
        let volume = super::ImageUse::Volume;
        let has_volumes = unsafe {
            instance.get_physical_device_image_format_properties(
                self.physical,
                volume.format(),
                vk::ImageType::TYPE_3D,
                vk::ImageTiling::OPTIMAL,
                volume.usage(),
                vk::ImageCreateFlags::TYPE_2D_ARRAY_COMPATIBLE,
            )
        };
        let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default();
        if has(khr::pipeline_executable_properties::NAME) {
            let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut executables);
            unsafe { instance.get_physical_device_features2(self.physical, &mut features) };
        }
        self.is_portability_subset = has(khr::portability_subset::NAME);
        self.calibration = extension(has);
        self.optional = vec![
            ("graphics queue", self.has_graphics),
            ("geometryShader", base.geometry_shader == vk::TRUE),
            (
                "atomics of 64 bits",
                base.shader_int64 == vk::TRUE && v12.shader_buffer_int64_atomics == vk::TRUE,
            ),
            (
                "shaderOutputLayer", // its capability in SPIR-V names the other as well
                v12.shader_output_layer == vk::TRUE && v12.shader_output_viewport_index == vk::TRUE,
            ),
            // Subsets have a feature of their own for it, which is not asked for.
            ("volumes as layers", self.has_graphics && has_volumes.is_ok() && !self.is_portability_subset),
            ("shaderClipDistance", base.shader_clip_distance == vk::TRUE),
            ("fragmentStoresAndAtomics", base.fragment_stores_and_atomics == vk::TRUE),
            (
                "transform feedback",
                capture.transform_feedback == vk::TRUE
                    && capture_limits.transform_feedback_draw == vk::TRUE
                    && base.geometry_shader == vk::TRUE,
            ),
            ("fillModeNonSolid", base.fill_mode_non_solid == vk::TRUE),
            ("pipelineStatisticsQuery", base.pipeline_statistics_query == vk::TRUE),
            ("pipeline executable properties", executables.pipeline_executable_info == vk::TRUE),
            ("calibrated timestamps", self.calibration.is_some()),
            ("shaderFloat16", v12.shader_float16 == vk::TRUE),
            ("subgroup ballot", has_subgroup(vk::SubgroupFeatureFlags::BALLOT)),
            ("subgroup arithmetic", has_subgroup(vk::SubgroupFeatureFlags::ARITHMETIC)),
            ("float atomics", has(ash::ext::shader_atomic_float::NAME)),
        ];
        Ok(())
    }

    /// The device `wanted` (index, UUID, or part of the name), or the fastest kind there is.
    pub(super) fn choose(all: Vec<Self>, wanted: Option<&str>) -> Result<Self> {
        let describe = |a: &Self| format!("{} {} {}", a.index, a.name, a.uuid);
        let unfit = |a: &Self| format!("{}: it lacks {}", a.name, a.missing.join(", "));
        if let Some(wanted) = wanted {
            let have = all.iter().map(describe).collect();
            // Of several that fit the name, one that will do.
            let found = all.iter().filter(|a| a.is(wanted, all.len())).min_by_key(|a| !a.missing.is_empty());
            let found = found.cloned();
            let found = found.ok_or_else(|| Error::NoSuchDevice { wanted: wanted.into(), have })?;
            return if found.missing.is_empty() {
                Ok(found)
            } else {
                Err(Error::NoDevice { missing: vec![unfit(&found)] })
            };
        }
        let missing = all.iter().map(unfit).collect();
        all.into_iter()
            .filter(|a| a.missing.is_empty())
            .min_by_key(|a| (a.rank, a.index))
            .ok_or(Error::NoDevice { missing })
    }

    /// By index where there are so many devices, else by UUID or part of the name.
    fn is(&self, wanted: &str, devices: usize) -> bool {
        let wanted = wanted.trim().to_lowercase();
        match wanted.parse::<usize>() {
            Ok(index) if index < devices => index == self.index,
            _ if wanted.is_empty() => false,
            _ => wanted.replace('-', "") == self.uuid || self.name.to_lowercase().contains(&wanted),
        }
    }
}

/// What is needed of Vulkan 1.3, as extensions.
#[derive(Default)]
pub(super) struct Extensions13 {
    synchronization2: vk::PhysicalDeviceSynchronization2Features<'static>,
    dynamic_rendering: vk::PhysicalDeviceDynamicRenderingFeatures<'static>,
    maintenance4: vk::PhysicalDeviceMaintenance4Features<'static>,
}

impl Extensions13 {
    pub const NAMES: [&'static CStr; 3] =
        [khr::synchronization2::NAME, khr::dynamic_rendering::NAME, khr::maintenance4::NAME];

    /// All of them switched on.
    pub fn on() -> Self {
        Self {
            synchronization2: vk::PhysicalDeviceSynchronization2Features::default().synchronization2(true),
            dynamic_rendering: vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true),
            maintenance4: vk::PhysicalDeviceMaintenance4Features::default().maintenance4(true),
        }
    }

    fn push<'a>(&'a mut self, to: vk::PhysicalDeviceFeatures2<'a>) -> vk::PhysicalDeviceFeatures2<'a> {
        to.push_next(&mut self.synchronization2)
            .push_next(&mut self.dynamic_rendering)
            .push_next(&mut self.maintenance4)
    }

    pub fn push_on<'a>(&'a mut self, to: vk::DeviceCreateInfo<'a>) -> vk::DeviceCreateInfo<'a> {
        to.push_next(&mut self.synchronization2)
            .push_next(&mut self.dynamic_rendering)
            .push_next(&mut self.maintenance4)
    }
}

fn kind(kind: vk::PhysicalDeviceType) -> &'static str {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => "discrete GPU",
        vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated GPU",
        vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual GPU",
        vk::PhysicalDeviceType::CPU => "CPU",
        _ => "other",
    }
}

/// Smaller is faster.
fn rank(kind: vk::PhysicalDeviceType) -> u32 {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => 0,
        vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
        vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
        vk::PhysicalDeviceType::CPU => 4,
        _ => 3,
    }
}

fn version(v: u32) -> String {
    format!("{}.{}.{}", vk::api_version_major(v), vk::api_version_minor(v), vk::api_version_patch(v))
}

fn text(name: &CStr) -> String {
    name.to_string_lossy().into_owned()
}
