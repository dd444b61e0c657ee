// SPDX-License-Identifier: MIT OR Apache-2.0
//! Drawing to the slices of volumes, and to no image at all.

use super::{recorder::Kept, Image, ImageUse, Recorder};
use ash::vk;

/// What a pass over the slices of volumes draws to; the shaders say which slice.
#[derive(Clone, Copy)]
pub struct LayersTarget<'a> {
    /// Two [`ImageUse::Volume`]s, written together. Cleared to 0.
    pub volumes: [&'a Image; 2],
    /// [`ImageUse::LayeredDepth`] of the same size. Cleared to 0, the far end.
    pub depth: &'a Image,
}

impl Recorder<'_> {
    /// Clears `target`, and draws what `body` draws to it. A texel of column `x` and row `y` covers `x` to `x + 1` and `y` to
    /// `y + 1`: here y is not turned up, as in pictures.
    ///
    /// # Panics
    /// If the images are of other uses, or differ in size.
    pub fn render_layers(&mut self, target: &LayersTarget<'_>, body: impl FnOnce(&mut Self)) {
        let [first, second] = target.volumes;
        for (image, purpose) in
            [(first, ImageUse::Volume), (second, ImageUse::Volume), (target.depth, ImageUse::LayeredDepth)]
        {
            assert_eq!(image.purpose(), purpose, "`{}`", image.name());
            assert_eq!((image.size(), image.layers()), (first.size(), first.layers()), "`{}`", image.name());
            self.keep(|| Kept::Image(image.clone()));
        }
        let attachment = |image: &Image, store| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.drawn_view())
                .image_layout(vk::ImageLayout::GENERAL)
                .load_op(vk::AttachmentLoadOp::CLEAR)
                .store_op(store)
        };
        let colors = target.volumes.map(|image| attachment(image, vk::AttachmentStoreOp::STORE));
        let depth = attachment(target.depth, vk::AttachmentStoreOp::DONT_CARE);
        let info = vk::RenderingInfo::default()
            .layer_count(first.layers())
            .color_attachments(&colors)
            .depth_attachment(&depth);
        self.render_flat(first.size(), info, body);
    }

    /// Runs the fragments of what `body` draws over `size` pixels, without an image: what they find they write to buffers. As
    /// in [`Recorder::render_layers`] y is not turned up.
    pub fn render_nothing(&mut self, size: [u32; 2], body: impl FnOnce(&mut Self)) {
        self.render_flat(size, vk::RenderingInfo::default().layer_count(1), body);
    }

    fn render_flat(
        &mut self,
        [width, height]: [u32; 2],
        info: vk::RenderingInfo<'_>,
        body: impl FnOnce(&mut Self),
    ) {
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let viewport = vk::Viewport {
            width: width as f32,
            height: height as f32,
            max_depth: 1.0,
            ..vk::Viewport::default()
        };
        let (device, cmd) = (self.gpu.device(), self.cmd);
        unsafe {
            device.cmd_begin_rendering(cmd, &info.render_area(area));
            device.cmd_set_viewport(cmd, 0, &[viewport]);
            device.cmd_set_scissor(cmd, 0, &[area]);
        }
        body(self);
        unsafe { device.cmd_end_rendering(cmd) };
    }
}
