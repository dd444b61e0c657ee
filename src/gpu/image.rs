// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{
    device::Gpu,
    error::{Error, OrCall, Result},
    Access,
};
use ash::vk;
use gpu_allocator::{vulkan as ga, MemoryLocation};
use std::sync::Arc;

/// What an image is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageUse {
    /// Drawn to, and read by compute shaders: RGBA in half floats.
    Color,
    /// Drawn to with several samples a pixel, and resolved: RGBA in half floats.
    SampledColor,
    /// Depth test: 32-bit float.
    Depth,
    /// Depth, one sample a pixel, that is copied to a buffer: drawn to, or resolved to.
    CopiedDepth,
    /// A finished picture on its way to a window: bytes, copied to and from.
    Canvas,
}

impl ImageUse {
    /// Its format.
    pub fn format(self) -> vk::Format {
        match self {
            Self::Color | Self::SampledColor => vk::Format::R16G16B16A16_SFLOAT,
            Self::Depth | Self::CopiedDepth => vk::Format::D32_SFLOAT,
            Self::Canvas => vk::Format::R8G8B8A8_UNORM,
        }
    }

    fn usage(self) -> vk::ImageUsageFlags {
        use vk::ImageUsageFlags as U;
        match self {
            Self::Color => U::COLOR_ATTACHMENT | U::STORAGE | U::TRANSFER_SRC,
            Self::SampledColor => U::COLOR_ATTACHMENT,
            Self::Depth => U::DEPTH_STENCIL_ATTACHMENT,
            Self::CopiedDepth => U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_SRC,
            Self::Canvas => U::STORAGE | U::TRANSFER_SRC | U::TRANSFER_DST,
        }
    }

    fn aspect(self) -> vk::ImageAspectFlags {
        match self {
            Self::Color | Self::SampledColor | Self::Canvas => vk::ImageAspectFlags::COLOR,
            Self::Depth | Self::CopiedDepth => vk::ImageAspectFlags::DEPTH,
        }
    }
}

/// A named image, its memory and its view. It is in the layout GENERAL for life: one transition when it is made, and no
/// layout in any other barrier.
#[derive(Clone)]
pub struct Image(Arc<Inner>);

struct Inner {
    raw: vk::Image,
    view: vk::ImageView,
    memory: ga::Allocation,
    name: String,
    extent: vk::Extent2D,
    purpose: ImageUse,
    samples: u32,
    gpu: Gpu,
}

impl Image {
    /// Makes the image, and submits the transition to its layout.
    ///
    /// # Errors
    /// [`Error::Limit`], [`Error::Memory`] or [`Error::Vulkan`], each with `name`.
    ///
    /// # Panics
    /// If `samples` is not a power of two.
    pub fn new(
        gpu: &Gpu,
        name: &str,
        [width, height]: [u32; 2],
        purpose: ImageUse,
        samples: u32,
    ) -> Result<Self> {
        assert!(samples.is_power_of_two(), "`{name}`: {samples} samples");
        let limits = gpu.limits();
        let framebuffer = limits.max_framebuffer_width.min(limits.max_framebuffer_height);
        let allowed = limits.max_image_dimension2_d.min(framebuffer);
        if width.max(height) > allowed {
            return Err(Error::Limit {
                name: name.into(),
                needed: width.max(height).into(),
                device: gpu.name().into(),
                allowed: allowed.into(),
                limit: "maxImageDimension2D and maxFramebufferWidth, pixels",
            });
        }
        if !gpu.has_graphics() {
            return Err(Error::NoGraphics { device: gpu.name().into(), name: name.into() });
        }
        let extent = vk::Extent2D { width, height };
        let info = vk::ImageCreateInfo::default()
            .image_type(vk::ImageType::TYPE_2D)
            .format(purpose.format())
            .extent(vk::Extent3D { width, height, depth: 1 })
            .mip_levels(1)
            .array_layers(1)
            .samples(vk::SampleCountFlags::from_raw(samples))
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(purpose.usage());
        let device = gpu.device();
        // Built in place, as buffers are.
        let mut image = Inner {
            raw: vk::Image::null(),
            view: vk::ImageView::null(),
            memory: ga::Allocation::default(),
            name: name.into(),
            extent,
            purpose,
            samples,
            gpu: gpu.clone(),
        };
        image.raw = unsafe { device.create_image(&info, None) }.or_call_for("vkCreateImage", name)?;
        let requirements = unsafe { device.get_image_memory_requirements(image.raw) };
        image.memory = gpu
            .allocator()
            .allocate(&ga::AllocationCreateDesc {
                name,
                requirements,
                location: MemoryLocation::GpuOnly,
                linear: false,
                allocation_scheme: ga::AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|source| Error::Memory { name: name.into(), bytes: requirements.size, source })?;
        let (memory, offset) = unsafe { (image.memory.memory(), image.memory.offset()) };
        unsafe { device.bind_image_memory(image.raw, memory, offset) }
            .or_call_for("vkBindImageMemory", name)?;
        let range =
            vk::ImageSubresourceRange::default().aspect_mask(purpose.aspect()).level_count(1).layer_count(1);
        let view = vk::ImageViewCreateInfo::default()
            .image(image.raw)
            .view_type(vk::ImageViewType::TYPE_2D)
            .format(purpose.format())
            .subresource_range(range);
        image.view =
            unsafe { device.create_image_view(&view, None) }.or_call_for("vkCreateImageView", name)?;
        gpu.set_name(image.raw, name);
        gpu.set_name(image.view, name);
        let image = Self(Arc::new(image));
        gpu.once(|rec| rec.first_use(&image, range))?;
        Ok(image)
    }

    pub(super) fn raw(&self) -> vk::Image {
        self.0.raw
    }

    pub(super) fn view(&self) -> vk::ImageView {
        self.0.view
    }

    /// As captures and validation show it.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Width and height (pixels).
    pub fn size(&self) -> [u32; 2] {
        [self.0.extent.width, self.0.extent.height]
    }

    /// What it is for.
    pub fn purpose(&self) -> ImageUse {
        self.0.purpose
    }

    /// Samples a pixel.
    pub fn samples(&self) -> u32 {
        self.0.samples
    }

    /// The access that its first use waits for.
    pub(super) fn first_access(&self) -> Access {
        match self.0.purpose {
            ImageUse::Color | ImageUse::SampledColor => Access::ColorWrite,
            ImageUse::Depth | ImageUse::CopiedDepth => Access::DepthWrite,
            ImageUse::Canvas => Access::CopyWrite,
        }
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        unsafe {
            self.gpu.device().destroy_image_view(self.view, None);
            self.gpu.device().destroy_image(self.raw, None);
        }
        let _ = self.gpu.allocator().free(std::mem::take(&mut self.memory));
    }
}
