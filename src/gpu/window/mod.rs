// SPDX-License-Identifier: MIT OR Apache-2.0
//! Pictures in a window: the surface of a window, a device that can present to it, and the loop of frames. Compiled with
//! the feature `viewer` only.
//!
//! | type | is |
//! | ---- | -- |
//! | [`Surface`] | what a window is to Vulkan; holds the window, and is made anew where the window system has lost it |
//! | [`Frames`]  | two frames in flight, each with its commands, fence and times, and the images that they end in |
//!
//! Left out: full screen modes, HDR formats, several windows.

mod frames;
mod images;
mod picture;
mod swapchain;

pub use frames::{Finished, Frames, Timed, Timing, FRAMES};
pub use images::Retired;

use super::{
    adapter::Adapter,
    error::{Error, OrCall, Result},
    instance::Instance,
    Gpu, GpuOptions,
};
use ash::{khr, vk};
use raw_window_handle::{HandleError, HasDisplayHandle, HasWindowHandle};

/// A window of any library.
pub trait Handles: HasDisplayHandle + HasWindowHandle {}
impl<W: HasDisplayHandle + HasWindowHandle> Handles for W {}

/// What a window is to Vulkan.
pub struct Surface {
    raw: vk::SurfaceKHR,
    api: khr::surface::Instance,
    gpu: Gpu,
    window: Box<dyn Handles>, // last: the surface goes before its window
}

impl Surface {
    fn new(gpu: &Gpu, window: Box<dyn Handles>) -> Result<Self> {
        let instance = gpu.instance().expect("a device of its own");
        let (api, raw) = create(instance, &*window)?;
        Ok(Self { raw, api, gpu: gpu.clone(), window })
    }

    /// Where the window system has lost it. Its swapchains are gone by then.
    fn renew(&mut self) -> Result<()> {
        unsafe { self.api.destroy_surface(self.raw, None) };
        self.raw = vk::SurfaceKHR::null();
        let instance = self.gpu.instance().expect("a device of its own");
        (self.api, self.raw) = create(instance, &*self.window)?;
        Ok(())
    }
}

impl Drop for Surface {
    fn drop(&mut self) {
        unsafe { self.api.destroy_surface(self.raw, None) };
    }
}

fn no_display(error: HandleError) -> Error {
    Error::NoDisplay { reason: error.to_string() }
}

fn create(instance: &Instance, window: &dyn Handles) -> Result<(khr::surface::Instance, vk::SurfaceKHR)> {
    let display = window.display_handle().map_err(no_display)?.as_raw();
    let handle = window.window_handle().map_err(no_display)?.as_raw();
    // SAFETY: the window is held by the surface, or lives as long as the one that is made to ask.
    let raw = unsafe { ash_window::create_surface(&instance.loader, &instance.raw, display, handle, None) }
        .or_call("vkCreateSurfaceKHR")?;
    Ok((khr::surface::Instance::new(&instance.loader, &instance.raw), raw))
}

impl Gpu {
    /// A device of its own that can present to `window`, and the window's surface.
    ///
    /// # Errors
    /// [`Error::NoDisplay`] if there is nothing to present to; [`Error::NoDevice`] says, device by device, what was
    /// missing, presentation among it.
    pub fn for_window(options: &GpuOptions, window: Box<dyn Handles>) -> Result<(Self, Surface)> {
        let display = window.display_handle().map_err(no_display)?.as_raw();
        let extensions = ash_window::enumerate_required_extensions(display)
            .map_err(|code| Error::NoDisplay { reason: format!("{display:?}: {code:?}") })?;
        let instance = Instance::new(options.validate, extensions).map_err(|error| match error {
            Error::Vulkan { code: vk::Result::ERROR_EXTENSION_NOT_PRESENT, .. } => {
                Error::NoDisplay { reason: "the Vulkan loader has no surfaces for this window system".into() }
            }
            other => other,
        })?;
        let mut adapters = Adapter::all(&instance.raw)?;
        // A surface to ask with: one that is kept would have to go before the instance whatever fails below.
        let (api, raw) = create(&instance, &*window)?;
        for adapter in adapters.iter_mut().filter(|adapter| adapter.missing.is_empty()) {
            adapter.missing.extend(lacks(&instance, adapter, &api, raw));
        }
        unsafe { api.destroy_surface(raw, None) };
        let adapter = Adapter::choose(adapters, options.device.as_deref())?;
        let gpu = Self::open(options, instance, adapter, (false, &[khr::swapchain::NAME]))?;
        let surface = Surface::new(&gpu, window)?;
        Ok((gpu, surface))
    }
}

/// What keeps a device from presenting to a surface.
fn lacks(
    instance: &Instance,
    adapter: &Adapter,
    api: &khr::surface::Instance,
    surface: vk::SurfaceKHR,
) -> Option<String> {
    let physical = adapter.physical;
    let extensions =
        unsafe { instance.raw.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    if !extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(khr::swapchain::NAME)) {
        return Some("VK_KHR_swapchain".into());
    }
    if !adapter.has_graphics {
        return Some("a queue that draws".into());
    }
    let presents = unsafe { api.get_physical_device_surface_support(physical, adapter.family, surface) };
    if !presents.unwrap_or(false) {
        return Some("presentation to this window".into());
    }
    let formats = unsafe { api.get_physical_device_surface_formats(physical, surface) }.unwrap_or_default();
    swapchain::format(&formats).is_none().then(|| "a format of 8 bits a channel for this window".into())
}
