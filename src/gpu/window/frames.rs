// SPDX-License-Identifier: MIT OR Apache-2.0
//! The loop of frames: record one while the GPU is at the one before.
//!
//! A frame is [`Frames::begin`] (waits for the frame before last, takes an image), whatever the host does, and
//! [`Frames::finish`] (records, submits, presents). On the queue frames follow one another: each waits for all commands of
//! the last, so what one writes the next may read, and only the host has to know that two are on their way.

use super::{
    images::{is_stale_after, Retired},
    swapchain::Swapchain,
    Surface,
};
use crate::gpu::{
    calibrate::{place, Placed},
    error::{Error, OrCall, Result},
    recorder::Kept,
    submit::{begin, fenced_spans, stamped_spans, ticks, Fenced, Waits, TIMEOUT_S},
    Buffer, Clock, Gpu, HostTime, Image, Recorder, Times,
};
use ash::vk::{self, PipelineStageFlags2 as S};
use std::{ffi::CStr, time::Instant};

/// Frames in flight.
pub const FRAMES: usize = 2;
/// Spans that are timed in a frame; further steps are not.
const SPANS: usize = 512;

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
    untimed: usize,
    waits: Option<Waits>,
    begun: Instant,
    submitted: Instant,
    kept: Vec<Kept>,
}

/// What is to be known of the times of a frame's passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Timing {
    /// Nothing.
    Off,
    /// How long they took.
    Lengths,
    /// Also when, by the host's clock. On a device without calibrated timestamps the frame is waited for at once: it ends
    /// where the host sees its fence, and two frames later that would be late by as much.
    Places,
}

/// What a frame took that was timed.
pub struct Timed {
    /// Of the frame.
    pub number: u64,
    /// From when the host began to record it until it was submitted.
    pub whole: HostTime,
    /// What it took.
    pub times: Times,
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
    pub(super) old: Retired<Swapchain>,
    pub(super) surface: Surface,
    pub(super) wanted: [u32; 2],
    pub(super) is_stale: bool,
    /// As if the window system had said so of the next image.
    pub(super) is_lost: bool,
    is_hidden: bool,
    pub(super) image: u32,
    /// Passes are placed by when the host saw the fence.
    is_placed_by_end: bool,
    timed: Option<Timed>,
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
            is_lost: false,
            is_hidden: false,
            image: 0,
            is_placed_by_end: gpu.0.calibrated.is_none(),
            timed: None,
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
                untimed: 0,
                waits: None,
                begun: Instant::now(),
                submitted: Instant::now(),
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

    /// The next frame finds the surface lost, as a window system may lose it: for tests.
    pub fn lose_surface(&mut self) {
        self.is_lost = true;
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

    /// The last frame that was timed and is done, once.
    pub fn take_timed(&mut self) -> Option<Timed> {
        self.timed.take()
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

    /// Waits for all that was submitted, however long it takes: nothing is in use afterwards. A lost device uses nothing
    /// either.
    ///
    /// # Errors
    /// A lost device.
    pub fn wait_for_all(&self) -> Result<()> {
        let _queue = self.gpu.queue(); // nobody submits meanwhile
        unsafe { self.gpu.device().device_wait_idle() }.or_call("vkDeviceWaitIdle")
    }

    /// Signalled when the image of the frame that is being made can be drawn to.
    pub(super) fn acquired(&self) -> vk::Semaphore {
        self.slots[self.number as usize % FRAMES].acquired
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
            let done = Instant::now();
            let mut times = Times { untimed: slot.untimed, ..Times::default() };
            times.spans = match slot.waits.take() {
                Some(waits) => fenced_spans(&names, &waits.stamps),
                None => {
                    let ticks = ticks(&self.gpu, slot.queries, names.len())?;
                    let (begins, placed) = place(&self.gpu, &ticks, (slot.submitted, done));
                    times.placed = placed;
                    self.is_placed_by_end = placed == Placed::End;
                    stamped_spans(&self.gpu, &names, &ticks, begins.into_iter().map(Some).collect())
                }
            };
            times.wall_ms = (done - slot.submitted).as_secs_f64() * 1e3;
            let whole = HostTime { name: "frame", begin: slot.begun, end: slot.submitted };
            self.timed = Some(Timed { number: slot.number, whole, times });
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

    /// Records and submits a frame, and presents it. `record` leaves the picture that it gives back; `overlay` draws
    /// over it, in a rendering of one colour attachment of [`Frames::format`]; `copy` gets the bytes of what is shown, where
    /// the window allows it: [`Frames::rgba`] says what they are.
    ///
    /// # Errors
    /// A lost device, or those of `record` and `overlay`.
    pub fn finish<E: From<Error>>(
        &mut self,
        timing: Timing,
        record: impl FnOnce(&mut Recorder<'_>) -> Result<Finished, E>,
        overlay: impl FnOnce(vk::CommandBuffer, [u32; 2]) -> Result<(), E>,
        copy: Option<&Buffer>,
    ) -> Result<(), E> {
        let begun = Instant::now();
        let clock = (timing != Timing::Off).then(|| self.gpu.clock()).transpose()?;
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
        let recorded = rec.finish();
        let waits = recorded.flush.map(|mut flush| flush.waits()).transpose()?;
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
        let awaited = [vk::SemaphoreSubmitInfo::default().semaphore(acquired).stage_mask(S::BLIT)];
        let signals =
            [vk::SemaphoreSubmitInfo::default().semaphore(shown.finished).stage_mask(S::ALL_COMMANDS)];
        let submit = [vk::SubmitInfo2::default()
            .command_buffer_infos(&infos)
            .wait_semaphore_infos(&awaited)
            .signal_semaphore_infos(&signals)];
        unsafe { device.reset_fences(&[done]) }.or_call("vkResetFences")?;
        unsafe { device.queue_submit2(*gpu.queue(), &submit, done) }.or_call("vkQueueSubmit2")?;
        let submitted = Instant::now();
        self.number += 1;
        let (finished, chains, indices) = ([shown.finished], [chain.raw], [self.image]);
        let info = vk::PresentInfoKHR::default()
            .wait_semaphores(&finished)
            .swapchains(&chains)
            .image_indices(&indices);
        let presented = unsafe { chain.api.queue_present(*gpu.queue(), &info) };
        let slot = &mut self.slots[at];
        slot.number = self.number;
        (slot.names, slot.untimed, slot.waits) = (recorded.spans, recorded.untimed, waits);
        (slot.begun, slot.submitted, slot.kept) = (begun, submitted, recorded.kept);
        slot.kept.extend([Kept::Image(canvas), Kept::Buffer(picture.pixels)]);
        slot.kept.extend(copy.cloned().map(Kept::Buffer));
        let may_be_bettered = self.chain.as_ref().is_some_and(Swapchain::may_be_bettered);
        self.is_stale |= is_stale_after(presented, may_be_bettered)?;
        if timing == Timing::Places && clock == Some(Clock::Gpu) && self.is_placed_by_end {
            self.settle(at)?;
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
        let _ = self.wait_for_all();
        let device = self.gpu.device();
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
