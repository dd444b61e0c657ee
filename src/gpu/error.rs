// SPDX-License-Identifier: MIT OR Apache-2.0
use ash::vk;

/// Result with [`enum@Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong at run time. Mistakes of the programmer are `assert!`s, and say so under `# Panics`.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A Vulkan call failed. `call` is its C name, to be looked up in the specification; `object` is what it was for,
    /// empty where there is only one.
    #[error("{call}{}: {code:?}", for_object(object))]
    Vulkan {
        /// C name of the function.
        call: &'static str,
        /// Name of the object.
        object: String,
        /// What it returned.
        code: vk::Result,
    },
    /// The allocator found no room.
    #[error("no room for `{name}`, {bytes} bytes: {source}")]
    Memory {
        /// Name of the resource.
        name: String,
        /// What it needs (bytes).
        bytes: u64,
        /// The allocator's reason.
        source: gpu_allocator::AllocationError,
    },
    /// Larger than a limit of the device.
    #[error("`{name}` needs {needed}, and {device} allows {allowed} ({limit})")]
    Limit {
        /// Name of the resource.
        name: String,
        /// What it needs, in the unit of the limit.
        needed: u64,
        /// Name of the device.
        device: String,
        /// Value of the limit.
        allowed: u64,
        /// Vulkan's name of the limit.
        limit: &'static str,
    },
    /// No device has what the crate needs: one entry a device, with what it lacks.
    #[error("no Vulkan device will do: {}", or_none(missing))]
    NoDevice {
        /// `name: what is missing`.
        missing: Vec<String>,
    },
    /// The device that was asked for is not there.
    #[error("no device `{wanted}` (a name, an index or a UUID); there are: {}", or_none(have))]
    NoSuchDevice {
        /// What was asked for.
        wanted: String,
        /// `index name uuid` of each device.
        have: Vec<String>,
    },
    /// Its queue cannot draw.
    #[error("{device}: the queue has no graphics, and `{name}` is drawn")]
    NoGraphics {
        /// Name of the device.
        device: String,
        /// What was to be drawn, or drawn to.
        name: String,
    },
    /// It cannot be timed that way.
    #[error("{device}: `{clock}` cannot be its clock: it has no timestamps, or another one is in use")]
    NoClock {
        /// Name of the device.
        device: String,
        /// Name of the clock.
        clock: &'static str,
    },
    /// The device lacks what a variant is made of.
    #[error("`{name}`: {device} has no {what}")]
    Lacks {
        /// What was asked for.
        name: String,
        /// Name of the device.
        device: String,
        /// The feature, by Vulkan's name where it has one.
        what: &'static str,
    },
    /// There is no Vulkan loader on this machine.
    #[error("no Vulkan loader (libvulkan1 in Debian): {0}")]
    Loader(#[from] ash::LoadingError),
    /// Validation was asked for and its layer is not installed.
    #[error("no VK_LAYER_KHRONOS_validation on this machine (vulkan-validationlayers in Debian)")]
    NoValidation,
    /// GLSL and Rust disagree. Found when a kernel is built, never while recording.
    #[error("kernel `{kernel}`: {what}")]
    Interface {
        /// Name of the kernel.
        kernel: String,
        /// The two sides.
        what: String,
    },
    /// There is no window system to show pictures in.
    #[error("no display: {reason}")]
    NoDisplay {
        /// What the window system said.
        reason: String,
    },
    /// The GPU did not finish in time.
    #[error("the GPU did not finish within {seconds} s")]
    Timeout {
        /// What was waited (s).
        seconds: u64,
    },
}

fn for_object(object: &str) -> String {
    if object.is_empty() {
        String::new()
    } else {
        format!(" for `{object}`")
    }
}

fn or_none(list: &[String]) -> String {
    if list.is_empty() {
        "none at all".into()
    } else {
        list.join("; ")
    }
}

impl Error {
    /// The device is gone: nothing that lives on it can be used again.
    pub fn is_device_lost(&self) -> bool {
        matches!(self, Self::Vulkan { code: vk::Result::ERROR_DEVICE_LOST, .. })
    }

    /// Memory ran out, on the device or on the host.
    pub fn is_out_of_memory(&self) -> bool {
        match self {
            Self::Vulkan { code, .. } => {
                [vk::Result::ERROR_OUT_OF_DEVICE_MEMORY, vk::Result::ERROR_OUT_OF_HOST_MEMORY].contains(code)
            }
            Self::Memory { source, .. } => matches!(source, gpu_allocator::AllocationError::OutOfMemory),
            _ => false,
        }
    }
}

/// `unsafe { device.create_fence(..) }.or_call("vkCreateFence")?`
pub(super) trait OrCall<T>: Sized {
    fn or_call(self, call: &'static str) -> Result<T> {
        self.or_call_for(call, "")
    }

    fn or_call_for(self, call: &'static str, object: &str) -> Result<T>;
}

impl<T> OrCall<T> for std::result::Result<T, vk::Result> {
    fn or_call_for(self, call: &'static str, object: &str) -> Result<T> {
        self.map_err(|code| Error::Vulkan { call, object: object.into(), code })
    }
}
