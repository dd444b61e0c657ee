// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{program::Bound, submit::Flush, Access, Buffer, Gpu, Image, StreamDraw};
use ash::vk;
use std::{ffi::CStr, slice};

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

/// Writes commands into a command buffer that someone else allocates, begins, ends and submits.
pub struct Recorder<'g> {
    pub(super) gpu: &'g Gpu,
    pub(super) cmd: vk::CommandBuffer,
    queries: vk::QueryPool,
    statistics: vk::QueryPool,
    room: usize,
    spans: Vec<&'static CStr>,
    untimed: usize,
    flush: Option<Box<dyn Flush + 'g>>,
    keep: Option<Vec<Kept>>,
}

/// What a recorder leaves.
pub(super) struct Recorded<'g> {
    /// Names of the timed spans.
    pub spans: Vec<&'static CStr>,
    /// Spans that there was no room to time.
    pub untimed: usize,
    pub flush: Option<Box<dyn Flush + 'g>>,
    /// What must live until the GPU is done.
    pub kept: Vec<Kept>,
}

/// What a submission uses.
#[allow(dead_code)] // held, never read
pub(super) enum Kept {
    Bound(Bound),
    Buffer(Buffer),
    Image(Image),
}

impl<'g> Recorder<'g> {
    /// # Safety
    /// `cmd` is recording, belongs to a queue family with compute (and graphics, if something is drawn), and outlives
    /// the recorder. Everything that is recorded lives until the GPU has run `cmd`. Draws are recorded inside
    /// [`Recorder::render`], and nothing else is.
    pub unsafe fn new(gpu: &'g Gpu, cmd: vk::CommandBuffer) -> Self {
        Self {
            gpu,
            cmd,
            queries: vk::QueryPool::null(),
            statistics: vk::QueryPool::null(),
            room: 0,
            spans: Vec::new(),
            untimed: 0,
            flush: None,
            keep: None,
        }
    }

    /// Times the first `room` spans by `2 * room` timestamps in `queries`: span `i` begins at query `2 i` and ends at
    /// `2 i + 1`.
    ///
    /// # Safety
    /// `queries` is of timestamps, has `2 * room` of them, and they are reset before.
    pub unsafe fn timed(mut self, queries: vk::QueryPool, room: usize) -> Self {
        (self.queries, self.room) = (queries, room);
        self
    }

    /// Counts what each timed span makes the device do, span `i` by query `i` of `statistics`, which are reset before.
    pub(super) fn counted(mut self, statistics: vk::QueryPool) -> Self {
        self.statistics = statistics;
        self
    }

    /// Ends, submits and waits at both ends of every span: the fence is the clock.
    pub(super) fn fenced(mut self, flush: Box<dyn Flush + 'g>, room: usize) -> Self {
        (self.flush, self.room) = (Some(flush), room);
        self
    }

    /// Keeps all that is recorded alive, until [`Recorder::finish`] hands it over.
    pub(super) fn keeping(mut self) -> Self {
        self.keep = Some(Vec::new());
        self
    }

    pub(super) fn keep(&mut self, used: impl FnOnce() -> Kept) {
        if let Some(keep) = &mut self.keep {
            keep.push(used());
        }
    }

    /// The spans timed so far.
    pub fn spans(&self) -> &[&'static CStr] {
        &self.spans
    }

    /// What is left when all is recorded.
    pub(super) fn finish(self) -> Recorded<'g> {
        let (spans, untimed, flush) = (self.spans, self.untimed, self.flush);
        Recorded { spans, untimed, flush, kept: self.keep.unwrap_or_default() }
    }

    /// The command buffer, for what this crate does not record.
    pub fn raw(&self) -> vk::CommandBuffer {
        self.cmd
    }

    /// One pass: `body` between a debug label for the capture tools and, when timed, two stamps. Spans do not nest.
    pub fn span(&mut self, name: &'static CStr, body: impl FnOnce(&mut Self)) {
        let query = (self.spans.len() < self.room).then_some(2 * self.spans.len() as u32);
        if query.is_some() {
            self.spans.push(name);
            self.stamp(query);
        } else {
            self.untimed += 1;
        }
        let counter = query.filter(|_| self.statistics != vk::QueryPool::null()).map(|begin| begin / 2);
        if let Some(debug) = &self.gpu.0.debug {
            let label = vk::DebugUtilsLabelEXT::default().label_name(name);
            unsafe { debug.cmd_begin_debug_utils_label(self.cmd, &label) };
        }
        let device = self.gpu.device();
        if let Some(counter) = counter {
            let exactly = vk::QueryControlFlags::empty(); // precision is of occlusion only
            unsafe { device.cmd_begin_query(self.cmd, self.statistics, counter, exactly) };
        }
        body(self);
        if let Some(counter) = counter {
            unsafe { device.cmd_end_query(self.cmd, self.statistics, counter) };
        }
        if let Some(debug) = &self.gpu.0.debug {
            unsafe { debug.cmd_end_debug_utils_label(self.cmd) };
        }
        self.stamp(query.map(|begin| begin + 1));
    }

    fn stamp(&mut self, query: Option<u32>) {
        let Some(query) = query else { return };
        if let Some(flush) = &mut self.flush {
            flush.stamp(self.cmd);
        } else {
            // ALL_COMMANDS: taken when everything before has finished, so that a span starts where the last ends. Software
            // drivers wait for it only at a barrier. It orders execution, so a timed run hides a missing write-after-read
            // barrier: look for hazards in runs that are not timed.
            let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
            let wait = vk::MemoryBarrier2::default().src_stage_mask(stage).dst_stage_mask(stage);
            let info = vk::DependencyInfo::default().memory_barriers(slice::from_ref(&wait));
            unsafe {
                self.gpu.device().cmd_pipeline_barrier2(self.cmd, &info);
                self.gpu.device().cmd_write_timestamp2(self.cmd, stage, self.queries, query);
            }
        }
    }

    /// All that was done as `from` before this point is finished and visible to all that is done as `to` after it.
    pub fn barrier(&mut self, from: Access, to: Access) {
        let barrier = Access::barrier(from, to);
        let info = vk::DependencyInfo::default().memory_barriers(slice::from_ref(&barrier));
        unsafe { self.gpu.device().cmd_pipeline_barrier2(self.cmd, &info) };
    }

    /// All that was recorded before, in earlier submissions of the queue too, is finished and visible to all that comes.
    pub fn after_all(&mut self) {
        let all = vk::PipelineStageFlags2::ALL_COMMANDS;
        let (write, read) = (vk::AccessFlags2::MEMORY_WRITE, vk::AccessFlags2::MEMORY_READ);
        let barrier = vk::MemoryBarrier2::default()
            .src_stage_mask(all)
            .src_access_mask(write)
            .dst_stage_mask(all)
            .dst_access_mask(write | read);
        let info = vk::DependencyInfo::default().memory_barriers(slice::from_ref(&barrier));
        unsafe { self.gpu.device().cmd_pipeline_barrier2(self.cmd, &info) };
    }

    /// Runs a kernel over at least `threads` invocations; the kernel discards the surplus.
    ///
    /// # Panics
    /// If `bound` is no kernel, `params` is not of its size, or the device cannot count that many workgroups.
    pub fn dispatch<P: bytemuck::Pod>(&mut self, bound: &Bound, threads: [u32; 3], params: &P) {
        let program = bound.program();
        let local = program.interface.local_size.unwrap_or_else(|| panic!("{:?} is no kernel", program.name));
        let groups: [u32; 3] = std::array::from_fn(|axis| threads[axis].div_ceil(local[axis]));
        let most = self.gpu.limits().max_compute_work_group_count;
        assert!(
            groups.iter().zip(most).all(|(&n, most)| n <= most),
            "{:?}: {groups:?} workgroups, {most:?} allowed",
            program.name
        );
        self.bind(bound, params);
        unsafe { self.gpu.device().cmd_dispatch(self.cmd, groups[0], groups[1], groups[2]) };
    }

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

    /// Dispatches as many workgroups as three `u32` at `offset` of `groups` say when the GPU gets there: write them on the
    /// GPU, and barrier to [`Access::IndirectRead`].
    ///
    /// # Panics
    /// As [`Recorder::dispatch`], or if the words are not all in `groups`.
    pub fn dispatch_indirect<P: bytemuck::Pod>(
        &mut self,
        bound: &Bound,
        groups: &Buffer,
        offset: u64,
        params: &P,
    ) {
        let program = bound.program();
        assert!(program.interface.local_size.is_some(), "{:?} is no kernel", program.name);
        self.indirect(groups, offset, 12);
        self.bind(bound, params);
        unsafe { self.gpu.device().cmd_dispatch_indirect(self.cmd, groups.raw(), offset) };
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

    fn indirect(&mut self, words: &Buffer, offset: u64, bytes: u64) {
        let fits = offset.is_multiple_of(4) && offset + bytes <= words.bytes();
        assert!(fits, "{bytes} bytes at {offset} of `{}`, which has {}", words.name(), words.bytes());
        self.keep(|| Kept::Buffer(words.clone()));
    }

    fn bind<P: bytemuck::Pod>(&mut self, bound: &Bound, params: &P) {
        self.keep(|| Kept::Bound(bound.clone()));
        let program = bound.program();
        assert!(program.gpu.is_same(self.gpu), "{:?} is of another device", program.name);
        assert_eq!(size_of::<P>(), program.interface.push_bytes, "push constants of {:?}", program.name);
        let (device, cmd, point) = (self.gpu.device(), self.cmd, program.bind_point);
        unsafe {
            device.cmd_bind_pipeline(cmd, point, program.pipeline);
            if bound.set() != vk::DescriptorSet::null() {
                device.cmd_bind_descriptor_sets(cmd, point, program.layout, 0, &[bound.set()], &[]);
            }
            if size_of::<P>() > 0 {
                device.cmd_push_constants(cmd, program.layout, program.stages, 0, bytemuck::bytes_of(params));
            }
        }
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
    /// bytes in `counter`: as [`Access::StreamWrite`]. What a draw takes its number from must be visible as
    /// [`Access::StreamRead`].
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

    /// # Panics
    /// If the buffers differ in size.
    pub fn copy(&mut self, from: &Buffer, to: &Buffer) {
        assert_eq!(from.bytes(), to.bytes(), "copy of `{}` to `{}`", from.name(), to.name());
        self.keep(|| Kept::Buffer(from.clone()));
        self.keep(|| Kept::Buffer(to.clone()));
        let region = vk::BufferCopy { src_offset: 0, dst_offset: 0, size: from.bytes() };
        unsafe { self.gpu.device().cmd_copy_buffer(self.cmd, from.raw(), to.raw(), &[region]) };
    }

    /// Copies depth, one `f32` a pixel, row by row from the top.
    ///
    /// # Panics
    /// If `image` is not for that, or `to` is not of its size.
    pub fn copy_depth(&mut self, image: &Image, to: &Buffer) {
        let [width, height] = image.size();
        assert_eq!(image.purpose(), super::ImageUse::CopiedDepth, "`{}`", image.name());
        assert_eq!(4 * u64::from(width) * u64::from(height), to.bytes(), "`{}`", to.name());
        self.keep(|| Kept::Image(image.clone()));
        self.keep(|| Kept::Buffer(to.clone()));
        let region = vk::BufferImageCopy::default()
            .image_subresource(
                vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::DEPTH).layer_count(1),
            )
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        let layout = vk::ImageLayout::GENERAL;
        unsafe {
            self.gpu.device().cmd_copy_image_to_buffer(self.cmd, image.raw(), layout, to.raw(), &[region])
        };
    }

    /// Fills the whole buffer with one word, as [`Access::FillWrite`].
    pub fn fill(&mut self, buffer: &Buffer, word: u32) {
        self.keep(|| Kept::Buffer(buffer.clone()));
        unsafe { self.gpu.device().cmd_fill_buffer(self.cmd, buffer.raw(), 0, vk::WHOLE_SIZE, word) };
    }

    /// Writes `data` to the start of `buffer` when the GPU gets there, as [`Access::FillWrite`]: what was recorded before
    /// still reads the old words, so that several pictures can be on their way. It travels in the command buffer, so nothing
    /// is allocated that would have to live until the GPU has run it: for some kilobytes.
    ///
    /// # Panics
    /// If it does not fit, or is not of whole words.
    pub fn update<T: bytemuck::Pod>(&mut self, buffer: &Buffer, data: &[T]) {
        const MOST_AT_ONCE: usize = 65_536; // of `vkCmdUpdateBuffer`
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let fits = bytes.len() as u64 <= buffer.bytes() && bytes.len().is_multiple_of(4);
        assert!(fits, "{} bytes to `{}`, which has {}", bytes.len(), buffer.name(), buffer.bytes());
        self.keep(|| Kept::Buffer(buffer.clone()));
        for (i, part) in bytes.chunks(MOST_AT_ONCE).enumerate() {
            let offset = (MOST_AT_ONCE * i) as u64;
            unsafe { self.gpu.device().cmd_update_buffer(self.cmd, buffer.raw(), offset, part) };
        }
    }

    /// The one transition of an image: from UNDEFINED to GENERAL, before its first use.
    pub(super) fn first_use(&mut self, image: &Image, range: vk::ImageSubresourceRange) {
        let (stage, access) = image.first_access().masks();
        let barrier = vk::ImageMemoryBarrier2::default()
            .dst_stage_mask(stage)
            .dst_access_mask(access)
            .old_layout(vk::ImageLayout::UNDEFINED)
            .new_layout(vk::ImageLayout::GENERAL)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image.raw())
            .subresource_range(range);
        let info = vk::DependencyInfo::default().image_memory_barriers(slice::from_ref(&barrier));
        unsafe { self.gpu.device().cmd_pipeline_barrier2(self.cmd, &info) };
    }
}
