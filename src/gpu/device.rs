// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{
    adapter::{Adapter, Extensions13},
    cache::PipelineCache,
    calibrate::Calibrated,
    error::{Error, OrCall, Result},
    executables::Captured,
    instance::{Instance, Messages},
    timing::Clock,
};
use ash::{ext, khr, vk};
use gpu_allocator::vulkan as ga;
use std::{
    ffi::{CStr, CString},
    ops::Deref,
    path::PathBuf,
    sync::{Arc, Mutex, MutexGuard, OnceLock},
};

/// How to open a device.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// Index, UUID or part of the name; the fastest kind of device if `None`.
    pub device: Option<String>,
    /// Turns on the Khronos layer with synchronization validation; what it says is in [`Gpu::messages`].
    pub validate: bool,
    /// Folder of the pipeline cache; `None` keeps no file.
    pub cache: Option<PathBuf>,
}

/// Instance, device and queue that belong to a caller. See [`Gpu::from_external`].
pub struct External<'a> {
    /// The caller's instance, of Vulkan 1.3 or later.
    pub instance: &'a ash::Instance,
    /// The device that `device` was made from.
    pub physical: vk::PhysicalDevice,
    /// Made with the features `synchronization2`, `dynamicRendering` and `maintenance4`.
    pub device: &'a ash::Device,
    /// A queue with compute, and with graphics if something is to be drawn.
    pub queue: vk::Queue,
    /// Its family.
    pub family: u32,
    /// Whether `instance` has VK_EXT_debug_utils: then passes are labelled and objects are named.
    pub has_debug_utils: bool,
}

/// Device, one queue, allocator. Cheap to clone: every owner of a Vulkan handle holds one, so the device outlives them
/// all, whatever order they are dropped in.
#[derive(Clone)]
pub struct Gpu(pub(super) Arc<Inner>);

// Fields drop in the order they are declared, which is the order of destruction.
pub(super) struct Inner {
    pub cache: PipelineCache,
    allocator: Mutex<ga::Allocator>,
    pub debug: Option<ext::debug_utils::Device>,
    pub stream: Option<ext::transform_feedback::Device>,
    pub calibrated: Option<Calibrated>,
    pub captured: Option<Captured>,
    queue: Mutex<vk::Queue>, // submissions are the one thing that threads must take turns at
    pub adapter: Adapter,
    pub clock: OnceLock<Clock>,
    #[cfg(feature = "tools")]
    pub shaders: super::reload::Shaders,
    pub device: Device,
    instance: Option<Instance>, // `None` if it is the caller's
    messages: Arc<Messages>,
}

/// Destroys the device, unless it is the caller's.
pub(super) struct Device {
    raw: ash::Device,
    is_owned: bool,
}

impl Deref for Device {
    type Target = ash::Device;
    fn deref(&self) -> &ash::Device {
        &self.raw
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if self.is_owned {
            unsafe { self.raw.destroy_device(None) }
        }
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        // Runs before the fields drop. An error here is a lost device: there is nothing left to wait for.
        if self.device.is_owned && !self.adapter.is_null {
            let _ = unsafe { self.device.device_wait_idle() };
        }
    }
}

impl Gpu {
    /// A device of its own, without a window.
    ///
    /// # Errors
    /// [`Error::NoDevice`] says, device by device, what was missing.
    pub fn headless(options: &GpuOptions) -> Result<Self> {
        Self::without_window(options, false)
    }

    /// As [`Gpu::headless`], and what the driver makes of each pipeline is kept: [`Gpu::pipelines`]. Compiling takes longer.
    ///
    /// # Errors
    /// As [`Gpu::headless`].
    pub fn capturing(options: &GpuOptions) -> Result<Self> {
        Self::without_window(options, true)
    }

    fn without_window(options: &GpuOptions, captures: bool) -> Result<Self> {
        let instance = Instance::new(options.validate, &[])?;
        let adapter = Adapter::choose(Adapter::all(&instance.raw)?, options.device.as_deref())?;
        Self::open(options, instance, adapter, (captures, &[]))
    }

    /// `more` are extensions of the device; `captures` keeps what becomes of pipelines.
    pub(super) fn open(
        options: &GpuOptions,
        instance: Instance,
        adapter: Adapter,
        (captures, more): (bool, &[&CStr]),
    ) -> Result<Self> {
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(adapter.family)
            .queue_priorities(&[1.0])];
        let has_stream = adapter.has("transform feedback");
        let says_executables = captures && adapter.has("pipeline executable properties");
        let wanted = [
            (adapter.is_portability_subset, khr::portability_subset::NAME),
            (has_stream, ext::transform_feedback::NAME),
            (says_executables, khr::pipeline_executable_properties::NAME),
        ];
        let wanted = wanted.into_iter().filter_map(|(is_wanted, name)| is_wanted.then_some(name));
        let three: &[&CStr] = if adapter.is_by_extensions { &Extensions13::NAMES } else { &[] };
        let wanted =
            wanted.chain(adapter.calibration).chain(three.iter().copied()).chain(more.iter().copied());
        let extensions: Vec<_> = wanted.map(CStr::as_ptr).collect();
        let mut v13 = vk::PhysicalDeviceVulkan13Features::default()
            .synchronization2(true)
            .dynamic_rendering(true)
            .maintenance4(true);
        // What only some variants use is switched on where it is there.
        let has_wide_atomics = adapter.has("atomics of 64 bits");
        let features = vk::PhysicalDeviceFeatures::default()
            .geometry_shader(adapter.has("geometryShader"))
            .shader_clip_distance(adapter.has("shaderClipDistance"))
            .fragment_stores_and_atomics(adapter.has("fragmentStoresAndAtomics"))
            .pipeline_statistics_query(adapter.has("pipelineStatisticsQuery"))
            .shader_int64(has_wide_atomics);
        let has_layers = adapter.has("shaderOutputLayer");
        let mut v12 = vk::PhysicalDeviceVulkan12Features::default()
            .shader_buffer_int64_atomics(has_wide_atomics)
            .shader_output_layer(has_layers)
            .shader_output_viewport_index(has_layers);
        let mut stream = vk::PhysicalDeviceTransformFeedbackFeaturesEXT::default().transform_feedback(true);
        let mut info = vk::DeviceCreateInfo::default()
            .enabled_features(&features)
            .queue_create_infos(&queues)
            .enabled_extension_names(&extensions)
            .push_next(&mut v12);
        let mut three = Extensions13::on();
        info = if adapter.is_by_extensions { three.push_on(info) } else { info.push_next(&mut v13) };
        if has_stream {
            info = info.push_next(&mut stream);
        }
        let mut executables = vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
            .pipeline_executable_info(true);
        if says_executables {
            info = info.push_next(&mut executables);
        }
        let raw = unsafe { instance.raw.create_device(adapter.physical, &info, None) }
            .or_call_for("vkCreateDevice", &adapter.name)?;
        let raw = if adapter.is_by_extensions { by_extensions(&instance.raw, raw.handle()) } else { raw };
        let device = Device { raw, is_owned: true };
        let queue = unsafe { device.get_device_queue(adapter.family, 0) };
        let (raw_instance, has_debug_utils) = (instance.raw.clone(), instance.has_debug_utils);
        let messages = instance.messages.clone();
        Self::assemble(Assembly {
            raw_instance: &raw_instance,
            has_debug_utils,
            device,
            queue,
            adapter,
            instance: Some(instance),
            messages,
            cache: options.cache.clone(),
            captures,
        })
    }

    /// Works on a device that the caller made and goes on owning. Recording into the caller's own command buffers is
    /// [`Recorder::new`](super::Recorder::new): it submits nothing. What submits to `queue`, and waits, is set-up and
    /// reading back: uploads and downloads, [`Image::new`](super::Image::new), [`Gpu::once`], [`Gpu::clock`] and
    /// [`Submitter`](super::Submitter).
    ///
    /// # Safety
    /// The handles belong together, `device` has the features that [`External::device`] names, and all of it outlives
    /// the `Gpu` and everything made from it. The queue is not used by another thread while a function that submits
    /// runs. Before anything made from this `Gpu` is dropped, the device has finished with it.
    ///
    /// # Errors
    /// [`Error::NoDevice`] if the physical device lacks what the crate needs.
    pub unsafe fn from_external(external: &External<'_>) -> Result<Self> {
        let mut adapter = Adapter::describe(external.instance, 0, external.physical)?;
        if !adapter.missing.is_empty() {
            return Err(Error::NoDevice {
                missing: vec![format!("{}: {}", adapter.name, adapter.missing.join(", "))],
            });
        }
        adapter.use_family(external.instance, external.family);
        Self::assemble(Assembly {
            raw_instance: external.instance,
            has_debug_utils: external.has_debug_utils,
            device: Device { raw: external.device.clone(), is_owned: false },
            queue: external.queue,
            adapter,
            instance: None,
            messages: Arc::default(),
            cache: None,
            captures: false,
        })
    }

    fn assemble(parts: Assembly<'_>) -> Result<Self> {
        let allocator = ga::Allocator::new(&ga::AllocatorCreateDesc {
            instance: parts.raw_instance.clone(),
            device: parts.device.clone(),
            physical_device: parts.adapter.physical,
            debug_settings: Default::default(),
            buffer_device_address: false,
            allocation_sizes: Default::default(),
        })
        .map_err(|source| Error::Memory { name: "allocator".into(), bytes: 0, source })?;
        let debug =
            parts.has_debug_utils.then(|| ext::debug_utils::Device::new(parts.raw_instance, &parts.device));
        let stream = (parts.device.is_owned && parts.adapter.has("transform feedback"))
            .then(|| ext::transform_feedback::Device::new(parts.raw_instance, &parts.device));
        let calibrated = if parts.device.is_owned {
            Calibrated::load(parts.raw_instance, &parts.device, &parts.adapter)
        } else {
            None // which extensions a caller's device has cannot be asked
        };
        let captured = parts.captures.then(|| Captured {
            api: (parts.adapter.has("pipeline executable properties"))
                .then(|| khr::pipeline_executable_properties::Device::new(parts.raw_instance, &parts.device)),
            found: Mutex::default(),
        });
        let cache = PipelineCache::open(&parts.device, &parts.adapter, parts.cache)?;
        let gpu = Self(Arc::new(Inner {
            cache,
            allocator: Mutex::new(allocator),
            debug,
            stream,
            calibrated,
            captured,
            queue: Mutex::new(parts.queue),
            adapter: parts.adapter,
            clock: OnceLock::new(),
            #[cfg(feature = "tools")]
            shaders: Default::default(),
            device: parts.device,
            instance: parts.instance,
            messages: parts.messages,
        }));
        if gpu.0.instance.is_some() {
            gpu.set_name(gpu.device().handle(), "whitecap.device");
            gpu.set_name(*gpu.queue(), "whitecap.queue");
            gpu.set_name(gpu.0.cache.raw, "whitecap.pipelines");
        }
        Ok(gpu)
    }

    /// What the chosen device is and can do.
    pub fn adapter(&self) -> &Adapter {
        &self.0.adapter
    }

    /// Every device on this machine, also those that will not do.
    ///
    /// # Errors
    /// If there is no Vulkan at all.
    pub fn adapters() -> Result<Vec<Adapter>> {
        Adapter::all(&Instance::new(false, &[])?.raw)
    }

    /// Name of the device.
    pub fn name(&self) -> &str {
        &self.0.adapter.name
    }

    /// For whoever records beside this crate, on the same device.
    pub fn device(&self) -> &ash::Device {
        &self.0.device
    }

    /// The queue that [`Gpu::once`] submits to, held against other threads' submissions as long as the guard lives.
    pub fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.0.queue.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Whether two are one device.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Whether the queue can draw.
    pub fn has_graphics(&self) -> bool {
        self.0.adapter.has_graphics
    }

    /// Whether pipelines can have geometry shaders; on a caller's device never, as which features it has cannot be asked.
    pub fn has_geometry_shader(&self) -> bool {
        self.0.device.is_owned && self.0.adapter.has("geometryShader")
    }

    /// Whether buffers have atomics of 64 bits; on a caller's device never, as [`Gpu::has_geometry_shader`].
    pub fn has_wide_atomics(&self) -> bool {
        self.0.device.is_owned && self.0.adapter.has("atomics of 64 bits")
    }

    /// Asks for what only some variants use, by the name in [`Adapter::optional`]; a caller's device has none of it, as
    /// which features it has cannot be asked.
    ///
    /// # Errors
    /// [`Error::Lacks`], in the name of `who`.
    pub fn require(&self, who: &str, what: &'static str) -> Result<()> {
        match self.0.device.is_owned && self.0.adapter.has(what) {
            true => Ok(()),
            false => Err(Error::Lacks { name: who.into(), device: self.name().into(), what }),
        }
    }

    /// Whether vertices can be captured: [`Stream`](super::Stream); on a caller's device never.
    pub fn has_transform_feedback(&self) -> bool {
        self.0.stream.is_some()
    }

    /// Whether passes can be counted: [`Submitter::watching`](super::Submitter::watching); on a caller's device never.
    pub fn has_statistics(&self) -> bool {
        self.0.device.is_owned && self.0.adapter.has("pipelineStatisticsQuery")
    }

    /// Samples a pixel that pictures are drawn with: 4 where the device has them for colour and depth, else 1.
    pub fn samples(&self) -> u32 {
        let limits = self.limits();
        let allowed = limits.framebuffer_color_sample_counts & limits.framebuffer_depth_sample_counts;
        if allowed.contains(vk::SampleCountFlags::TYPE_4) {
            4
        } else {
            1
        }
    }

    /// Family of [`Gpu::queue`].
    pub fn family(&self) -> u32 {
        self.0.adapter.family
    }

    /// Limits of the device.
    pub fn limits(&self) -> &vk::PhysicalDeviceLimits {
        &self.0.adapter.limits
    }

    /// Where validation messages go. It outlives the device, so that what was leaked can be read too.
    pub fn messages(&self) -> Arc<Messages> {
        self.0.messages.clone()
    }

    /// Writes the pipeline cache to its file, if it has one. Also done when the last clone is dropped.
    pub fn save_pipeline_cache(&self) {
        self.0.cache.save(&self.0.device);
    }

    pub(super) fn set_name(&self, handle: impl vk::Handle, name: &str) {
        if let (Some(debug), Ok(name)) = (&self.0.debug, CString::new(name)) {
            self.set_c_name(debug, handle, &name);
        }
    }

    fn set_c_name(&self, debug: &ext::debug_utils::Device, handle: impl vk::Handle, name: &CStr) {
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(handle).object_name(name);
        let _ = unsafe { debug.set_debug_utils_object_name(&info) }; // names are a courtesy, never an error
    }

    /// What a pipeline is built from where `spv` is asked for: a library without a compiler replaces none.
    #[cfg(not(feature = "tools"))]
    pub(super) fn current<'s>(&self, spv: &'s [u8]) -> std::borrow::Cow<'s, [u8]> {
        spv.into()
    }

    #[cfg(feature = "viewer")]
    pub(super) fn instance(&self) -> Option<&Instance> {
        self.0.instance.as_ref()
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, ga::Allocator> {
        self.0.allocator.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }
}

/// The device with the functions of its extensions where it has not those of Vulkan 1.3: they are the same.
fn by_extensions(instance: &ash::Instance, device: vk::Device) -> ash::Device {
    // SAFETY: names end in a zero, and what is found is the function of that name.
    let find = |name: &CStr| unsafe {
        let found = (instance.fp_v1_0().get_device_proc_addr)(device, name.as_ptr());
        found.or_else(|| {
            let khr = CString::new([name.to_bytes(), b"KHR"].concat()).ok()?;
            (instance.fp_v1_0().get_device_proc_addr)(device, khr.as_ptr())
        })
    };
    let find = |name: &CStr| find(name).map_or(std::ptr::null(), |it| it as *const std::ffi::c_void);
    unsafe { ash::Device::load_with(find, device) }
}

struct Assembly<'a> {
    raw_instance: &'a ash::Instance,
    has_debug_utils: bool,
    device: Device,
    queue: vk::Queue,
    adapter: Adapter,
    instance: Option<Instance>,
    messages: Arc<Messages>,
    cache: Option<PathBuf>,
    captures: bool,
}
