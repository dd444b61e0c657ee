// SPDX-License-Identifier: MIT OR Apache-2.0
//! What a recorder draws: passes, draws inside them, and what draws capture.

use super::{program::Bound, recorder::Kept, Buffer, Image, Recorder, StreamDraw};
use ash::vk;

/// What a pass draws to.
#[derive(Clone, Copy)]
pub struct Target<'a> {
    /// Colour of every sample; `None`: depth alone.
    pub color: Option<&'a Image>,
    /// Depth of every sample.
    pub depth: &'a Image,
    /// Where the samples of a pixel are averaged when the pass ends, if there are several.
    pub resolved: Option<&'a Image>,
    /// Where depth of the first sample goes when the pass ends.
    pub resolved_depth: Option<&'a Image>,
    /// Colour before anything is drawn; `None` goes on with what an earlier pass left.
    pub clear: Option<[f32; 4]>,
    /// Another pass goes on with colour and depth.
    pub goes_on: bool,
}

impl Recorder<'_> {
    /// Draws `vertices` of each of `instances`. Inside [`Recorder::render`] only.
    ///
    /// # Panics
    /// If `bound` is a kernel, or `params` is not of its size.
    pub fn draw<P: bytemuck::Pod>(&mut self, bound: &Bound, vertices: u32, instances: u32, params: &P) {
        assert!(bound.program().interface.local_size.is_none(), "{:?} is a kernel", bound.program().name);
        self.bind(bound, params);
        unsafe { self.gpu.device().cmd_draw(self.cmd, vertices, instances, 0, 0) };
    }

    /// Draws the 16-bit `indices` once for each of `instances`. Inside [`Recorder::render`] only.
    ///
    /// # Panics
    /// If `bound` is a kernel, or `params` is not of its size.
    pub fn draw_indexed<P: bytemuck::Pod>(
        &mut self,
        bound: &Bound,
        indices: &Buffer,
        instances: u32,
        params: &P,
    ) {
        assert!(bound.program().interface.local_size.is_none(), "{:?} is a kernel", bound.program().name);
        self.bind(bound, params);
        self.keep(|| Kept::Buffer(indices.clone()));
        let (device, count) = (self.gpu.device(), (indices.bytes() / 2) as u32);
        unsafe {
            device.cmd_bind_index_buffer(self.cmd, indices.raw(), 0, vk::IndexType::UINT16);
            device.cmd_draw_indexed(self.cmd, count, instances, 0, 0, 0);
        }
    }

    /// Draws as four `u32` at `offset` of `args` say when the GPU gets there: vertices, instances, first vertex, first
    /// instance; inside [`Recorder::render`].
    ///
    /// # Panics
    /// As [`Recorder::draw`], or if the words are not all in `args`.
    pub fn draw_indirect<P: bytemuck::Pod>(&mut self, bound: &Bound, args: &Buffer, offset: u64, params: &P) {
        assert!(bound.program().interface.local_size.is_none(), "{:?} is a kernel", bound.program().name);
        self.indirect(args, offset, 16);
        self.bind(bound, params);
        unsafe { self.gpu.device().cmd_draw_indirect(self.cmd, args.raw(), offset, 1, 16) };
    }

    /// Clears `target`, or goes on with it, and draws what `body` draws to it.
    pub fn render(&mut self, target: &Target<'_>, body: impl FnOnce(&mut Self)) {
        let depth = target.depth;
        if let Some(color) = target.color {
            assert!(
                color.size() == depth.size() && color.samples() == depth.samples(),
                "`{}` and `{}` differ in size or samples",
                color.name(),
                depth.name()
            );
        }
        let resolved = target.resolved.into_iter().chain(target.resolved_depth);
        for image in resolved.clone() {
            assert!(image.size() == depth.size() && image.samples() == 1, "`{}`", image.name());
        }
        for image in target.color.into_iter().chain([depth]).chain(resolved) {
            self.keep(|| Kept::Image(image.clone()));
        }
        let general = vk::ImageLayout::GENERAL;
        let attachment = |image: &Image| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.view())
                .image_layout(general)
                .load_op(match target.clear {
                    Some(_) => vk::AttachmentLoadOp::CLEAR,
                    None => vk::AttachmentLoadOp::LOAD,
                })
                .store_op(match target.goes_on {
                    true => vk::AttachmentStoreOp::STORE,
                    false => vk::AttachmentStoreOp::DONT_CARE,
                })
        };
        let clear =
            vk::ClearValue { color: vk::ClearColorValue { float32: target.clear.unwrap_or_default() } };
        let colors: Vec<_> = target
            .color
            .map(|color| {
                let color = attachment(color).clear_value(clear);
                match target.resolved {
                    Some(resolved) => color
                        .resolve_mode(vk::ResolveModeFlags::AVERAGE)
                        .resolve_image_view(resolved.view())
                        .resolve_image_layout(general),
                    None => color.store_op(vk::AttachmentStoreOp::STORE),
                }
            })
            .into_iter()
            .collect();
        // Depth is reversed: 0 is the far end.
        let mut depth = attachment(target.depth).clear_value(vk::ClearValue::default());
        if let Some(resolved) = target.resolved_depth {
            depth = depth
                .resolve_mode(vk::ResolveModeFlags::SAMPLE_ZERO) // the one mode that every device has
                .resolve_image_view(resolved.view())
                .resolve_image_layout(general);
        }
        let [width, height] = target.depth.size();
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: vk::Extent2D { width, height } };
        let info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&colors)
            .depth_attachment(&depth);
        // Vulkan's y points down; a negative height turns it up, as in the rest of the crate.
        let viewport = vk::Viewport {
            x: 0.0,
            y: height as f32,
            width: width as f32,
            height: -(height as f32),
            min_depth: 0.0,
            max_depth: 1.0,
        };
        let (device, cmd) = (self.gpu.device(), self.cmd);
        unsafe {
            device.cmd_begin_rendering(cmd, &info);
            device.cmd_set_viewport(cmd, 0, &[viewport]);
            device.cmd_set_scissor(cmd, 0, &[area]);
        }
        body(self);
        unsafe { device.cmd_end_rendering(cmd) };
    }

    /// Captures what `draws` emit in `to`, one after the other from its start, as long as there is room, and counts the
    /// bytes in `counter`: as [`Access::StreamWrite`](super::Access::StreamWrite). What a draw takes its number
    /// from must be visible as [`Access::StreamRead`](super::Access::StreamRead).
    ///
    /// # Panics
    /// If `bound` is no [`Stream`](super::Stream), or params are not of its size.
    pub fn stream<P: bytemuck::Pod>(
        &mut self,
        bound: &Bound,
        to: &Buffer,
        counter: &Buffer,
        draws: &[(StreamDraw<'_>, P)],
    ) {
        let program = bound.program();
        assert!(program.interface.local_size.is_none(), "{:?} is a kernel", program.name);
        let gpu = self.gpu;
        let feedback = gpu.0.stream.as_ref().unwrap_or_else(|| panic!("{} cannot capture", gpu.name())).fp();
        let Some((_, first)) = draws.first() else { return };
        let (device, cmd) = (gpu.device(), self.cmd);
        for buffer in [to, counter] {
            self.keep(|| Kept::Buffer(buffer.clone()));
        }
        let area = vk::Rect2D { extent: vk::Extent2D { width: 1, height: 1 }, ..Default::default() };
        let info = vk::RenderingInfo::default().render_area(area).layer_count(1);
        unsafe { device.cmd_begin_rendering(cmd, &info) };
        self.bind(bound, first);
        let (offset, bytes) = (0, to.bytes());
        unsafe {
            (feedback.cmd_bind_transform_feedback_buffers_ext)(cmd, 0, 1, &to.raw(), &offset, &bytes);
            (feedback.cmd_begin_transform_feedback_ext)(cmd, 0, 0, std::ptr::null(), std::ptr::null());
        }
        for (draw, params) in draws {
            let bytes = bytemuck::bytes_of(params);
            assert_eq!(bytes.len(), program.interface.push_bytes, "push constants of {:?}", program.name);
            unsafe { device.cmd_push_constants(cmd, program.layout, program.stages, 0, bytes) };
            match draw {
                StreamDraw::Points(count) => unsafe { device.cmd_draw(cmd, *count, 1, 0, 0) },
                StreamDraw::Captured { counter, stride } => {
                    self.keep(|| Kept::Buffer((*counter).clone()));
                    let raw = counter.raw();
                    unsafe { (feedback.cmd_draw_indirect_byte_count_ext)(cmd, 1, 0, raw, 0, 0, *stride) };
                }
            }
        }
        unsafe {
            (feedback.cmd_end_transform_feedback_ext)(cmd, 0, 1, &counter.raw(), &0);
            device.cmd_end_rendering(cmd);
        }
    }
}
