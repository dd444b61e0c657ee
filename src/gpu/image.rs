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
    /// Drawn to layer by layer, and read by compute shaders in three dimensions: RGBA in 32-bit floats.
    Volume,
    /// Depth test of each layer of a volume: 32-bit float, an array of layers, since there is no depth in three dimensions.
    LayeredDepth,
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
            Self::Volume => vk::Format::R32G32B32A32_SFLOAT,
            Self::Depth | Self::CopiedDepth | Self::LayeredDepth => vk::Format::D32_SFLOAT,
            Self::Canvas => vk::Format::R8G8B8A8_UNORM,
        }
    }

    pub(super) fn usage(self) -> vk::ImageUsageFlags {
        use vk::ImageUsageFlags as U;
        match self {
            Self::Color => U::COLOR_ATTACHMENT | U::STORAGE | U::TRANSFER_SRC,
            Self::SampledColor => U::COLOR_ATTACHMENT,
            Self::Volume => U::COLOR_ATTACHMENT | U::STORAGE,
            Self::Depth | Self::LayeredDepth => U::DEPTH_STENCIL_ATTACHMENT,
            Self::CopiedDepth => U::DEPTH_STENCIL_ATTACHMENT | U::TRANSFER_SRC,
            Self::Canvas => U::STORAGE | U::TRANSFER_SRC | U::TRANSFER_DST,
        }
    }

    fn aspect(self) -> vk::ImageAspectFlags {
        match self {
            Self::Color | Self::SampledColor | Self::Volume | Self::Canvas => vk::ImageAspectFlags::COLOR,
            Self::Depth | Self::CopiedDepth | Self::LayeredDepth => vk::ImageAspectFlags::DEPTH,
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
    layers_view: vk::ImageView, // null where the image is flat
    memory: ga::Allocation,
    name: String,
    extent: vk::Extent3D,
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
        assert!(
            !matches!(purpose, ImageUse::Volume | ImageUse::LayeredDepth),
            "`{name}`: {purpose:?} has layers"
        );
        Self::make(gpu, name, [width, height, 1], purpose, samples)
    }

    /// An image of layers, each to be drawn to: [`ImageUse::Volume`] or [`ImageUse::LayeredDepth`].
    ///
    /// # Errors
    /// As [`Image::new`]; [`Error::Lacks`] if the device cannot draw to layers of such an image.
    ///
    /// # Panics
    /// If `purpose` is another.
    pub fn layered(gpu: &Gpu, name: &str, size: [u32; 3], purpose: ImageUse) -> Result<Self> {
        assert!(
            matches!(purpose, ImageUse::Volume | ImageUse::LayeredDepth),
            "`{name}`: {purpose:?} has no layers"
        );
        let limits = gpu.limits();
        let most = limits.max_image_dimension3_d;
        let layers = limits.max_framebuffer_layers.min(limits.max_image_array_layers);
        for (needed, allowed, limit) in [
            (size[0].max(size[1]).max(size[2]), most, "maxImageDimension3D, cells"),
            (size[2], layers, "maxFramebufferLayers and maxImageArrayLayers"),
        ] {
            if needed > allowed {
                let (name, device) = (name.into(), gpu.name().into());
                return Err(Error::Limit {
                    name,
                    needed: needed.into(),
                    device,
                    allowed: allowed.into(),
                    limit,
                });
            }
        }
        if purpose == ImageUse::Volume && !gpu.draws_to_volumes() {
            let (name, device) = (name.into(), gpu.name().into());
            return Err(Error::Lacks { name, device, what: "volumes of RGBA32F to draw to and to store to" });
        }
        Self::make(gpu, name, size, purpose, 1)
    }

    fn make(
        gpu: &Gpu,
        name: &str,
        [width, height, depth]: [u32; 3],
        purpose: ImageUse,
        samples: u32,
    ) -> Result<Self> {
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
        let extent = vk::Extent3D { width, height, depth };
        let is_volume = purpose == ImageUse::Volume;
        let (kind, flags, deep, layers) = match is_volume {
            true => (vk::ImageType::TYPE_3D, VOLUME_FLAGS, depth, 1),
            false => (vk::ImageType::TYPE_2D, vk::ImageCreateFlags::empty(), 1, depth),
        };
        let info = vk::ImageCreateInfo::default()
            .flags(flags)
            .image_type(kind)
            .format(purpose.format())
            .extent(vk::Extent3D { width, height, depth: deep })
            .mip_levels(1)
            .array_layers(layers)
            .samples(vk::SampleCountFlags::from_raw(samples))
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(purpose.usage());
        let device = gpu.device();
        // Built in place, as buffers are.
        let mut image = Inner {
            raw: vk::Image::null(),
            view: vk::ImageView::null(),
            layers_view: vk::ImageView::null(),
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
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(purpose.aspect())
            .level_count(1)
            .layer_count(layers);
        let view = |kind, range| {
            let info = vk::ImageViewCreateInfo::default()
                .image(image.raw)
                .view_type(kind)
                .format(purpose.format())
                .subresource_range(range);
            unsafe { device.create_image_view(&info, None) }.or_call_for("vkCreateImageView", name)
        };
        // What shaders see, and what is drawn to: of a volume its slices, as layers of an array.
        let layers = vk::ImageViewType::TYPE_2D_ARRAY;
        let (whole, drawn) = match purpose {
            ImageUse::Volume => {
                (view(vk::ImageViewType::TYPE_3D, range), Some(view(layers, range.layer_count(depth))))
            }
            ImageUse::LayeredDepth => (view(layers, range), None),
            _ => (view(vk::ImageViewType::TYPE_2D, range), None),
        };
        // Both are kept before either may fail, so that `Drop` frees what was made.
        image.view = whole.as_ref().copied().unwrap_or_default();
        image.layers_view =
            drawn.as_ref().map_or(image.view, |drawn| drawn.as_ref().copied().unwrap_or_default());
        whole?;
        drawn.transpose()?;
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

    /// What is drawn to, in layers or not.
    pub(super) fn drawn_view(&self) -> vk::ImageView {
        self.0.layers_view
    }

    /// As captures and validation show it.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Width and height (pixels).
    pub fn size(&self) -> [u32; 2] {
        [self.0.extent.width, self.0.extent.height]
    }

    /// Layers: slices of a volume.
    pub fn layers(&self) -> u32 {
        self.0.extent.depth
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
            ImageUse::Color | ImageUse::SampledColor | ImageUse::Volume => Access::ColorWrite,
            ImageUse::Depth | ImageUse::CopiedDepth | ImageUse::LayeredDepth => Access::DepthWrite,
            ImageUse::Canvas => Access::CopyWrite,
        }
    }
}

/// Slices of a volume as layers that can be drawn to.
const VOLUME_FLAGS: vk::ImageCreateFlags = vk::ImageCreateFlags::TYPE_2D_ARRAY_COMPATIBLE;

impl Gpu {
    /// Whether slices of a volume can be drawn to: Vulkan's "2D array compatible" 3D images, of the format and uses of
    /// [`ImageUse::Volume`]. Portability subsets may not have them.
    pub fn draws_to_volumes(&self) -> bool {
        self.0.adapter.has("volumes as layers")
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        unsafe {
            if self.layers_view != self.view {
                self.gpu.device().destroy_image_view(self.layers_view, None);
            }
            self.gpu.device().destroy_image_view(self.view, None);
            self.gpu.device().destroy_image(self.raw, None);
        }
        let _ = self.gpu.allocator().free(std::mem::take(&mut self.memory));
    }
}
