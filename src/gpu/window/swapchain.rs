// SPDX-License-Identifier: MIT OR Apache-2.0
//! The images of a window.

use super::Surface;
use crate::gpu::{
    error::{Error, OrCall, Result},
    Gpu,
};
use ash::{khr, vk};
use std::time::{Duration, Instant};

/// A window system that finds every set of images suboptimal gets no new one with every frame.
const SETTLED: Duration = Duration::from_secs(1);

/// Plain bytes: pictures come with their sRGB curve applied.
pub(super) fn format(offered: &[vk::SurfaceFormatKHR]) -> Option<vk::SurfaceFormatKHR> {
    let wanted = [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM];
    let is_srgb = |it: &&vk::SurfaceFormatKHR| it.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR;
    wanted.iter().find_map(|&wanted| offered.iter().filter(is_srgb).find(|it| it.format == wanted).copied())
}

/// One image, and what is signalled when its picture is finished.
pub(super) struct Shown {
    pub image: vk::Image,
    pub view: vk::ImageView,
    /// Belongs to the image, not to the frame: it is free again when the image is.
    pub finished: vk::Semaphore,
}

/// The images of a window at one size.
pub(super) struct Swapchain {
    pub raw: vk::SwapchainKHR,
    pub api: khr::swapchain::Device,
    pub images: Vec<Shown>,
    pub format: vk::Format,
    pub extent: vk::Extent2D,
    /// Images can be copied from.
    pub is_readable: bool,
    made: Instant,
    gpu: Gpu,
}

impl Swapchain {
    /// Of the window's size, or of `wanted` where the window goes by its images. `None` where the window has no area, as
    /// when it is minimised. `old` hands its images over, and is of no use afterwards.
    ///
    /// # Errors
    /// [`Error::Vulkan`], a lost surface among them.
    pub fn new(gpu: &Gpu, surface: &Surface, wanted: [u32; 2], old: Option<&Self>) -> Result<Option<Self>> {
        let (physical, api) = (gpu.adapter().physical, &surface.api);
        let caps = unsafe { api.get_physical_device_surface_capabilities(physical, surface.raw) }
            .or_call("vkGetPhysicalDeviceSurfaceCapabilitiesKHR")?;
        let (least, most) = (caps.min_image_extent, caps.max_image_extent);
        let extent = match caps.current_extent {
            vk::Extent2D { width: u32::MAX, .. } => vk::Extent2D {
                width: wanted[0].clamp(least.width, most.width),
                height: wanted[1].clamp(least.height, most.height),
            },
            extent => extent,
        };
        if extent.width == 0 || extent.height == 0 || wanted.contains(&0) {
            return Ok(None);
        }
        let formats = unsafe { api.get_physical_device_surface_formats(physical, surface.raw) }
            .or_call("vkGetPhysicalDeviceSurfaceFormatsKHR")?;
        let format = format(&formats).ok_or_else(|| Error::NoDisplay {
            reason: format!("the window has no format of 8 bits a channel, only {formats:?}"),
        })?;
        let most = if caps.max_image_count == 0 { u32::MAX } else { caps.max_image_count };
        let is_readable = caps.supported_usage_flags.contains(vk::ImageUsageFlags::TRANSFER_SRC);
        let mut usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST;
        if is_readable {
            usage |= vk::ImageUsageFlags::TRANSFER_SRC;
        }
        let alpha = [vk::CompositeAlphaFlagsKHR::OPAQUE, vk::CompositeAlphaFlagsKHR::INHERIT];
        let alpha = alpha.into_iter().find(|&it| caps.supported_composite_alpha.contains(it));
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw)
            .min_image_count((caps.min_image_count + 1).min(most))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(usage)
            .image_sharing_mode(vk::SharingMode::EXCLUSIVE)
            .pre_transform(caps.current_transform)
            .composite_alpha(alpha.unwrap_or(vk::CompositeAlphaFlagsKHR::OPAQUE))
            .present_mode(vk::PresentModeKHR::FIFO) // the one that every device has
            .clipped(false) // what another window covers is still in a screenshot
            .old_swapchain(old.map_or(vk::SwapchainKHR::null(), |old| old.raw));
        let instance = gpu.instance().expect("a device of its own");
        // Built in place, as buffers are.
        let mut made = Self {
            raw: vk::SwapchainKHR::null(),
            api: khr::swapchain::Device::new(&instance.raw, gpu.device()),
            images: Vec::new(),
            format: format.format,
            extent,
            is_readable,
            made: Instant::now(),
            gpu: gpu.clone(),
        };
        made.raw = unsafe { made.api.create_swapchain(&info, None) }.or_call("vkCreateSwapchainKHR")?;
        let images = unsafe { made.api.get_swapchain_images(made.raw) }.or_call("vkGetSwapchainImagesKHR")?;
        for image in images {
            made.images.push(Shown { image, view: vk::ImageView::null(), finished: vk::Semaphore::null() });
            let last = made.images.last_mut().expect("the one just added");
            gpu.set_name(image, "view.window");
            let view = vk::ImageViewCreateInfo::default()
                .image(image)
                .view_type(vk::ImageViewType::TYPE_2D)
                .format(format.format)
                .subresource_range(whole());
            last.view = unsafe { gpu.device().create_image_view(&view, None) }
                .or_call_for("vkCreateImageView", "view.window")?;
            last.finished = unsafe { gpu.device().create_semaphore(&Default::default(), None) }
                .or_call_for("vkCreateSemaphore", "view.finished")?;
        }
        Ok(Some(made))
    }

    /// Whether others may do better, where the window system finds these suboptimal: not if they have just been made.
    pub fn may_be_bettered(&self) -> bool {
        self.made.elapsed() > SETTLED
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        let device = self.gpu.device();
        unsafe {
            for shown in &self.images {
                device.destroy_semaphore(shown.finished, None);
                device.destroy_image_view(shown.view, None);
            }
            self.api.destroy_swapchain(self.raw, None);
        }
    }
}

/// All of a colour image.
pub(super) fn whole() -> vk::ImageSubresourceRange {
    vk::ImageSubresourceRange::default()
        .aspect_mask(vk::ImageAspectFlags::COLOR)
        .level_count(1)
        .layer_count(1)
}
