// SPDX-License-Identifier: MIT OR Apache-2.0
//! The loop of frames: record one while the GPU is at the one before.
//!
//! A frame is [`Frames::begin`] (waits for the frame before last, takes an image), whatever the host does, and
//! [`Frames::finish`] (records, submits, presents). On the queue frames follow one another: each waits for all commands of
//! the last, so what one writes the next may read, and only the host has to know that two are on their way.

use super::{swapchain::Swapchain, Surface};
use crate::gpu::{
    error::{Error, OrCall, Result},
    recorder::{Kept, Recorded},
    submit::{begin, span_times, Fenced, SpanTime, Waits, TIMEOUT_S},
    Buffer, Clock, Gpu, Image, Recorder,
};
use ash::vk::{self, PipelineStageFlags2 as S};
use std::{collections::VecDeque, ffi::CStr, time::Instant};

/// Frames in flight.
pub const FRAMES: usize = 2;
/// A window that is covered may get no images for as long as it is: its events are seen to meanwhile.
const PATIENCE_NS: u64 = 100_000_000;
/// Spans that are timed in a frame; further steps are not.
const SPANS: usize = 512;

/// What a frame in flight may still use. It goes when that frame is done.
pub struct Retired<T>(VecDeque<(u64, T)>);

impl<T> Default for Retired<T> {
    fn default() -> Self {
        Self(VecDeque::new())
    }
}

impl<T> Retired<T> {
    /// `last_use` is the number of a frame, as [`Frames::number`] gives it.
    pub fn push(&mut self, last_use: u64, thing: T) {
        self.0.push_back((last_use, thing));
    }

    /// `done` as [`Frames::done`] gives it.
    pub fn free_up_to(&mut self, done: u64) {
        while self.0.front().is_some_and(|(last_use, _)| *last_use <= done) {
            self.0.pop_front();
        }
    }
}

/// One frame's commands, and what they use.
struct Slot {
    pool: vk::CommandPool,
    cmd: vk::CommandBuffer,
    done: vk::Fence,
    /// For the stamps of a clock that is the fence.
    stamped: vk::Fence,
    acquired: vk::Semaphore,
    queries: vk::QueryPool,
    /// Of the frame that was last submitted, 0 for none.
    number: u64,
    names: Vec<&'static CStr>,
    /// Of the host, two a span, where the clock is the fence.
    stamps: Vec<Instant>,
    kept: Vec<Kept>,
}

/// A finished picture: what a frame shows.
pub struct Finished {
    /// Four bytes a pixel, visible to [`Access::CopyRead`](crate::gpu::Access::CopyRead).
    pub pixels: Buffer,
    /// Of the picture; it is stretched where the window has another one.
    pub size: [u32; 2],
}

/// Frames of a window.
pub struct Frames {
    slots: Vec<Slot>,
    number: u64,
    done: u64,
    pub(super) canvas: Option<Image>,
    pub(super) chain: Option<Swapchain>,
    old: Retired<Swapchain>,
    surface: Surface,
    wanted: [u32; 2],
    is_stale: bool,
    is_hidden: bool,
    image: u32,
    times: Vec<SpanTime>,
    pub(super) gpu: Gpu,
}

impl Frames {
    /// For a window of `size` pixels.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn new(gpu: &Gpu, surface: Surface, size: [u32; 2]) -> Result<Self> {
        let mut made = Self {
            slots: Vec::new(),
            number: 0,
            done: 0,
            canvas: None,
            chain: None,
            old: Retired::default(),
            surface,
            wanted: size,
            is_stale: true,
            is_hidden: false,
            image: 0,
            times: Vec::new(),
            gpu: gpu.clone(),
        };
        let device = gpu.device();
        for _ in 0..FRAMES {
            // Built in place, as buffers are.
            made.slots.push(Slot {
                pool: vk::CommandPool::null(),
                cmd: vk::CommandBuffer::null(),
                done: vk::Fence::null(),
                stamped: vk::Fence::null(),
                acquired: vk::Semaphore::null(),
                queries: vk::QueryPool::null(),
                number: 0,
                names: Vec::new(),
                stamps: Vec::new(),
                kept: Vec::new(),
            });
            let slot = made.slots.last_mut().expect("the one just added");
            let pool = vk::CommandPoolCreateInfo::default()
                .queue_family_index(gpu.family())
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
            slot.pool = unsafe { device.create_command_pool(&pool, None) }.or_call("vkCreateCommandPool")?;
            let cmd =
                vk::CommandBufferAllocateInfo::default().command_pool(slot.pool).command_buffer_count(1);
            slot.cmd =
                unsafe { device.allocate_command_buffers(&cmd) }.or_call("vkAllocateCommandBuffers")?[0];
            let signalled = vk::FenceCreateInfo::default().flags(vk::FenceCreateFlags::SIGNALED);
            slot.done = unsafe { device.create_fence(&signalled, None) }.or_call("vkCreateFence")?;
            slot.stamped =
                unsafe { device.create_fence(&Default::default(), None) }.or_call("vkCreateFence")?;
            slot.acquired =
                unsafe { device.create_semaphore(&Default::default(), None) }.or_call("vkCreateSemaphore")?;
            let queries = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(2 * SPANS as u32);
            slot.queries =
                unsafe { device.create_query_pool(&queries, None) }.or_call("vkCreateQueryPool")?;
        }
        made.ready()?;
        Ok(made)
    }

    /// The window has another size (pixels).
    pub fn resize(&mut self, size: [u32; 2]) {
        self.is_stale |= size != self.wanted;
        self.wanted = size;
    }

    /// Size of what is shown (pixels); `None` while the window has no area, or is covered.
    pub fn size(&self) -> Option<[u32; 2]> {
        let chain = self.chain.as_ref().filter(|_| !self.is_hidden);
        chain.map(|chain| [chain.extent.width, chain.extent.height])
    }

    /// Format of what an overlay draws to.
    pub fn format(&self) -> vk::Format {
        self.chain.as_ref().map_or(vk::Format::B8G8R8A8_UNORM, |chain| chain.format)
    }

    /// Of the frame that is being made, from 1.
    pub fn number(&self) -> u64 {
        self.number + 1
    }

    /// The last frame that the GPU has finished.
    pub fn done(&self) -> u64 {
        self.done
    }

    /// Of the passes of the last frame that was timed and is done.
    pub fn times(&self) -> &[SpanTime] {
        &self.times
    }

    /// For what draws over pictures on its own.
    pub fn vulkan(&self) -> (&ash::Instance, vk::PhysicalDevice) {
        let instance = self.gpu.instance().expect("a device of its own");
        (&instance.raw, self.gpu.adapter().physical)
    }

    /// A pool for commands that are not a frame's.
    pub fn pool(&self) -> vk::CommandPool {
        self.slots[0].pool
    }

    /// Waits for all frames.
    ///
    /// # Errors
    /// A lost device.
    pub fn wait(&mut self) -> Result<()> {
        (0..FRAMES).try_for_each(|slot| self.settle(slot))
    }

    /// Waits for the frame that used this slot, and reads its times.
    fn settle(&mut self, at: usize) -> Result<()> {
        let slot = &mut self.slots[at];
        let wait_ns = TIMEOUT_S * 1_000_000_000;
        match unsafe { self.gpu.device().wait_for_fences(&[slot.done], true, wait_ns) } {
            Err(vk::Result::TIMEOUT) => return Err(Error::Timeout { seconds: TIMEOUT_S }),
            other => other.or_call("vkWaitForFences")?,
        }
        self.done = self.done.max(slot.number);
        slot.kept.clear();
        let names = std::mem::take(&mut slot.names);
        if !names.is_empty() {
            let stamps = std::mem::take(&mut slot.stamps);
            self.times = span_times(&self.gpu, slot.queries, &names, &stamps, None)?.0;
        }
        self.old.free_up_to(self.done);
        Ok(())
    }

    /// Waits until a frame can be recorded and has an image. `false` while the window has no area or is covered: then
    /// there is nothing to record.
    ///
    /// # Errors
    /// A lost device, or a window that is gone.
    pub fn begin(&mut self) -> Result<bool> {
        self.settle(self.number as usize % FRAMES)?;
        self.is_hidden = !self.acquire()?;
        Ok(!self.is_hidden)
    }

    fn acquire(&mut self) -> Result<bool> {
        // A window that is being dragged may be stale again at once; the next call goes on.
        for _ in 0..8 {
            if !self.ready()? {
                return Ok(false);
            }
            let Some(chain) = &self.chain else { return Ok(false) };
            let acquired = self.slots[self.number as usize % FRAMES].acquired;
            let none = vk::Fence::null();
            let taken = unsafe { chain.api.acquire_next_image(chain.raw, PATIENCE_NS, acquired, none) };
            match taken {
                Ok((image, is_suboptimal)) => {
                    self.image = image;
                    self.is_stale |= is_suboptimal; // it still can be presented to
                    return Ok(true);
                }
                Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => return Ok(false),
                Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => self.is_stale = true,
                Err(vk::Result::ERROR_SURFACE_LOST_KHR) => self.renew_surface()?,
                Err(code) => return Err(code).or_call("vkAcquireNextImageKHR"),
            }
        }
        Ok(false)
    }

    /// Makes the images anew where they are stale. `false` if there are none.
    fn ready(&mut self) -> Result<bool> {
        if !self.is_stale && self.chain.is_some() {
            return Ok(true);
        }
        let made = match Swapchain::new(&self.gpu, &self.surface, self.wanted, self.chain.as_ref()) {
            Err(Error::Vulkan { code: vk::Result::ERROR_SURFACE_LOST_KHR, .. }) => {
                self.renew_surface()?;
                Swapchain::new(&self.gpu, &self.surface, self.wanted, None)?
            }
            other => other?,
        };
        let Some(made) = made else { return Ok(false) };
        self.is_stale = false;
        if let Some(old) = self.chain.replace(made) {
            // Its last image may be on the way to the screen: as long as the next frames take.
            self.old.push(self.number + FRAMES as u64, old);
        }
        Ok(true)
    }

    fn renew_surface(&mut self) -> Result<()> {
        unsafe { self.gpu.device().device_wait_idle() }.or_call("vkDeviceWaitIdle")?;
        (self.chain, self.old, self.is_stale) = (None, Retired::default(), true);
        self.surface.renew()
    }

    /// Records and submits a frame, and presents it. `record` leaves the picture that it gives back; `overlay` draws
    /// over it, in a rendering of one colour attachment of [`Frames::format`]; `copy` gets the bytes of what is shown, where
    /// the window allows it: [`Frames::rgba`] says what they are.
    ///
    /// # Errors
    /// A lost device, or those of `record` and `overlay`.
    pub fn finish<E: From<Error>>(
        &mut self,
        is_timed: bool,
        record: impl FnOnce(&mut Recorder<'_>) -> Result<Finished, E>,
        overlay: impl FnOnce(vk::CommandBuffer, [u32; 2]) -> Result<(), E>,
        copy: Option<&Buffer>,
    ) -> Result<(), E> {
        let clock = if is_timed { Some(self.gpu.clock()?) } else { None };
        let (gpu, at) = (self.gpu.clone(), self.number as usize % FRAMES);
        let (device, slot) = (gpu.device(), &self.slots[at]);
        let (cmd, done, acquired) = (slot.cmd, slot.done, slot.acquired);
        begin(device, cmd)?;
        // SAFETY: what is recorded is kept until the slot is used again.
        let mut rec = unsafe { Recorder::new(&gpu, cmd) }.keeping();
        match clock {
            Some(Clock::Gpu) => {
                unsafe { device.cmd_reset_query_pool(cmd, slot.queries, 0, 2 * SPANS as u32) };
                // SAFETY: just reset, and as many as that.
                rec = unsafe { rec.timed(slot.queries, SPANS) };
            }
            Some(Clock::Fence) => rec = rec.fenced(Box::new(Fenced::new(&gpu, slot.stamped)), SPANS),
            None => {}
        }
        rec.after_all();
        let picture = record(&mut rec)?;
        let Recorded { spans, flush, kept, .. } = rec.finish();
        let stamps = flush.map_or(Ok(Waits::default()), |mut flush| flush.waits())?.stamps;
        let canvas = self.canvas(picture.size)?;
        let chain = self.chain.as_ref().expect("begun");
        let shown = &chain.images[self.image as usize];
        self.record_canvas(cmd, &canvas, &picture, shown);
        let attachment = [vk::RenderingAttachmentInfo::default()
            .image_view(shown.view)
            .image_layout(vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL)
            .load_op(vk::AttachmentLoadOp::LOAD)
            .store_op(vk::AttachmentStoreOp::STORE)];
        let area = vk::Rect2D { offset: vk::Offset2D::default(), extent: chain.extent };
        let info =
            vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&attachment);
        unsafe { device.cmd_begin_rendering(cmd, &info) };
        let drawn = overlay(cmd, [chain.extent.width, chain.extent.height]);
        unsafe { device.cmd_end_rendering(cmd) };
        drawn?;
        self.record_end(cmd, shown, copy);
        unsafe { device.end_command_buffer(cmd) }.or_call("vkEndCommandBuffer")?;

        let infos = [vk::CommandBufferSubmitInfo::default().command_buffer(cmd)];
        // The image is not touched before the blit.
        let waits = [vk::SemaphoreSubmitInfo::default().semaphore(acquired).stage_mask(S::BLIT)];
        let signals =
            [vk::SemaphoreSubmitInfo::default().semaphore(shown.finished).stage_mask(S::ALL_COMMANDS)];
        let submit = [vk::SubmitInfo2::default()
            .command_buffer_infos(&infos)
            .wait_semaphore_infos(&waits)
            .signal_semaphore_infos(&signals)];
        unsafe { device.reset_fences(&[done]) }.or_call("vkResetFences")?;
        unsafe { device.queue_submit2(*gpu.queue(), &submit, done) }.or_call("vkQueueSubmit2")?;
        self.number += 1;
        let (finished, chains, indices) = ([shown.finished], [chain.raw], [self.image]);
        let info = vk::PresentInfoKHR::default()
            .wait_semaphores(&finished)
            .swapchains(&chains)
            .image_indices(&indices);
        let presented = unsafe { chain.api.queue_present(*gpu.queue(), &info) };
        let slot = &mut self.slots[at];
        slot.number = self.number;
        (slot.names, slot.stamps, slot.kept) = (spans, stamps, kept);
        slot.kept.extend([Kept::Image(canvas), Kept::Buffer(picture.pixels)]);
        slot.kept.extend(copy.cloned().map(Kept::Buffer));
        match presented {
            Ok(is_suboptimal) => self.is_stale |= is_suboptimal,
            // The next frame makes it anew.
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR | vk::Result::ERROR_SURFACE_LOST_KHR) => {
                self.is_stale = true
            }
            Err(code) => return Err(code).or_call("vkQueuePresentKHR").map_err(E::from),
        }
        Ok(())
    }

    /// Whether what is shown can be copied.
    pub fn is_readable(&self) -> bool {
        self.chain.as_ref().is_some_and(|chain| chain.is_readable)
    }

    /// Red, green, blue and opaque alpha of bytes that the last [`Frames::finish`] copied.
    pub fn rgba(&self, mut bytes: Vec<u8>) -> Vec<u8> {
        for pixel in bytes.chunks_exact_mut(4) {
            if self.format() == vk::Format::B8G8R8A8_UNORM {
                pixel.swap(0, 2);
            }
            pixel[3] = 255;
        }
        bytes
    }
}

impl Drop for Frames {
    fn drop(&mut self) {
        let device = self.gpu.device();
        // An error here is a lost device: it uses nothing any more.
        let _ = unsafe { device.device_wait_idle() };
        (self.chain, self.old) = (None, Retired::default()); // before their surface
        for slot in &mut self.slots {
            slot.kept.clear();
            unsafe {
                device.destroy_query_pool(slot.queries, None);
                device.destroy_semaphore(slot.acquired, None);
                device.destroy_fence(slot.stamped, None);
                device.destroy_fence(slot.done, None);
                device.destroy_command_pool(slot.pool, None);
            }
        }
    }
}
