// SPDX-License-Identifier: MIT OR Apache-2.0
//! Record, submit and wait: for tools, tests and set-up, not for a frame loop.

use super::{
    error::{Error, OrCall, Result},
    recorder::Kept,
    timing::Clock,
    Access, Buffer, Gpu, Recorder, Residence,
};
use ash::vk;
use std::{ffi::CStr, time::Instant};

pub(super) const TIMEOUT_S: u64 = 300;

/// Time of one span.
#[derive(Clone, Debug, PartialEq)]
pub struct SpanTime {
    /// Name of the pass.
    pub name: &'static CStr,
    /// By [`Gpu::clock`] (ms).
    pub ms: f64,
}

/// What a submission took.
#[derive(Clone, Debug, Default)]
pub struct Times {
    /// Of the spans that were timed, in order.
    pub spans: Vec<SpanTime>,
    /// From submission to fence, by the host's clock (ms).
    pub wall_ms: f64,
}

impl Times {
    /// Sum of all spans called `name` (ms).
    pub fn of(&self, name: &CStr) -> f64 {
        self.spans.iter().filter(|span| span.name == name).map(|span| span.ms).sum()
    }
}

/// Command pool, fence and queries, used again by every submission.
pub struct Submitter {
    pool: vk::CommandPool,
    cmd: vk::CommandBuffer,
    queries: vk::QueryPool,
    fence: vk::Fence,
    room: usize,
    /// A submission was given up on: nothing that it uses may go.
    is_pending: bool,
    kept: Vec<Kept>,
    gpu: Gpu,
}

impl Submitter {
    /// Times the first `room` spans of each submission.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn new(gpu: &Gpu, room: usize) -> Result<Self> {
        let clock = if room > 0 { gpu.clock()? } else { Clock::Fence };
        Self::with_clock(gpu, room, clock)
    }

    pub(super) fn with_clock(gpu: &Gpu, room: usize, clock: Clock) -> Result<Self> {
        let device = gpu.device();
        let mut made = Self {
            pool: vk::CommandPool::null(),
            cmd: vk::CommandBuffer::null(),
            queries: vk::QueryPool::null(),
            fence: vk::Fence::null(),
            room,
            is_pending: false,
            kept: Vec::new(),
            gpu: gpu.clone(),
        };
        let pool = vk::CommandPoolCreateInfo::default()
            .queue_family_index(gpu.family())
            .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER);
        made.pool = unsafe { device.create_command_pool(&pool, None) }.or_call("vkCreateCommandPool")?;
        let cmd = vk::CommandBufferAllocateInfo::default().command_pool(made.pool).command_buffer_count(1);
        made.cmd = unsafe { device.allocate_command_buffers(&cmd) }.or_call("vkAllocateCommandBuffers")?[0];
        if room > 0 && clock == Clock::Gpu {
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(2 * room as u32);
            made.queries = unsafe { device.create_query_pool(&info, None) }.or_call("vkCreateQueryPool")?;
        }
        made.fence = unsafe { device.create_fence(&Default::default(), None) }.or_call("vkCreateFence")?;
        Ok(made)
    }

    /// Runs what `body` records, and waits for it. All that it uses lives until then.
    ///
    /// # Errors
    /// [`Error::Vulkan`], a lost device among them, or [`Error::Timeout`], also of an earlier run.
    pub fn run(&mut self, body: impl FnOnce(&mut Recorder<'_>)) -> Result<Times> {
        if self.is_pending {
            return Err(Error::Timeout { seconds: TIMEOUT_S });
        }
        let gpu = self.gpu.clone();
        let device = gpu.device();
        begin(device, self.cmd)?;
        let mut rec = unsafe { Recorder::new(&gpu, self.cmd) }.keeping();
        if self.queries != vk::QueryPool::null() {
            unsafe { device.cmd_reset_query_pool(self.cmd, self.queries, 0, 2 * self.room as u32) };
            rec = unsafe { rec.timed(self.queries, self.room) };
        } else if self.room > 0 {
            rec = rec.fenced(Box::new(Fenced::new(&gpu, self.fence)), self.room);
        }
        body(&mut rec);
        let (names, fenced, kept) = rec.finish();
        self.kept = kept;
        let start = Instant::now();
        let done = fenced.and_then(|fenced| submit(&gpu, self.cmd, self.fence).map(|()| fenced));
        self.is_pending = matches!(done, Err(Error::Timeout { .. }));
        let fenced = done?;
        self.kept.clear();
        let wall_ms = start.elapsed().as_secs_f64() * 1e3;

        Ok(Times { spans: span_times(&gpu, self.queries, names, fenced)?, wall_ms })
    }
}

/// Times of finished spans: by the fence, or where there are none, from `queries`.
pub(super) fn span_times(
    gpu: &Gpu,
    queries: vk::QueryPool,
    names: Vec<&'static CStr>,
    fenced: Vec<f64>,
) -> Result<Vec<SpanTime>> {
    let mut ticks = vec![[0u64; 2]; if fenced.is_empty() { names.len() } else { 0 }];
    if !ticks.is_empty() {
        let (flat, flags) =
            (ticks.as_flattened_mut(), vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT);
        unsafe { gpu.device().get_query_pool_results(queries, 0, flat, flags) }
            .or_call("vkGetQueryPoolResults")?;
    }
    let tick_ms = f64::from(gpu.limits().timestamp_period) * 1e-6;
    // Only so many bits count; they wrap.
    let mask = u64::MAX >> (64 - gpu.0.adapter.timestamp_bits.clamp(1, 64));
    let stamped = ticks.iter().map(|[begin, end]| (end.wrapping_sub(*begin) & mask) as f64 * tick_ms);
    Ok(names.into_iter().zip(stamped.chain(fenced)).map(|(name, ms)| SpanTime { name, ms }).collect())
}

impl Drop for Submitter {
    fn drop(&mut self) {
        let device = self.gpu.device();
        if self.is_pending {
            // An error here is a lost device: it uses nothing any more.
            let _ = unsafe { device.queue_wait_idle(*self.gpu.queue()) };
        }
        unsafe {
            device.destroy_fence(self.fence, None);
            device.destroy_query_pool(self.queries, None);
            device.destroy_command_pool(self.pool, None);
        }
    }
}

pub(super) fn begin(device: &ash::Device, cmd: vk::CommandBuffer) -> Result<()> {
    let info = vk::CommandBufferBeginInfo::default().flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
    unsafe { device.begin_command_buffer(cmd, &info) }.or_call("vkBeginCommandBuffer")
}

/// Ends and submits `cmd`, and waits for `fence`, which is unsignalled again afterwards.
fn submit(gpu: &Gpu, cmd: vk::CommandBuffer, fence: vk::Fence) -> Result<()> {
    let device = gpu.device();
    unsafe { device.end_command_buffer(cmd) }.or_call("vkEndCommandBuffer")?;
    let infos = [vk::CommandBufferSubmitInfo::default().command_buffer(cmd)];
    let submit = [vk::SubmitInfo2::default().command_buffer_infos(&infos)];
    unsafe { device.queue_submit2(*gpu.queue(), &submit, fence) }.or_call("vkQueueSubmit2")?;
    match unsafe { device.wait_for_fences(&[fence], true, TIMEOUT_S * 1_000_000_000) } {
        Err(vk::Result::TIMEOUT) => return Err(Error::Timeout { seconds: TIMEOUT_S }),
        other => other.or_call("vkWaitForFences")?,
    }
    unsafe { device.reset_fences(&[fence]) }.or_call("vkResetFences")
}

/// Both ends of a span where the GPU's timestamps cannot be believed.
pub(super) trait Flush {
    /// Submits what is recorded, waits, notes the time and begins anew.
    fn stamp(&mut self, cmd: vk::CommandBuffer);
    /// Milliseconds between each pair of stamps, or the first error.
    fn times(&mut self) -> Result<Vec<f64>>;
}

pub(super) struct Fenced<'g> {
    gpu: &'g Gpu,
    fence: vk::Fence,
    stamps: Vec<Instant>,
    failed: Option<Error>,
}

impl<'g> Fenced<'g> {
    pub fn new(gpu: &'g Gpu, fence: vk::Fence) -> Self {
        Self { gpu, fence, stamps: Vec::new(), failed: None }
    }
}

impl Flush for Fenced<'_> {
    fn stamp(&mut self, cmd: vk::CommandBuffer) {
        if self.failed.is_none() {
            let done = submit(self.gpu, cmd, self.fence);
            self.stamps.push(Instant::now());
            let (done, begun) = (done.err(), begin(self.gpu.device(), cmd)); // what follows a failure is thrown away
            self.failed = done.or(begun.err());
        }
    }

    fn times(&mut self) -> Result<Vec<f64>> {
        match self.failed.take() {
            Some(error) => Err(error),
            None => Ok(self.stamps.chunks_exact(2).map(|s| (s[1] - s[0]).as_secs_f64() * 1e3).collect()),
        }
    }
}

impl Gpu {
    /// Runs what `body` records, and waits for it.
    ///
    /// # Errors
    /// [`Error::Vulkan`], a lost device among them, or [`Error::Timeout`].
    pub fn once(&self, body: impl FnOnce(&mut Recorder<'_>)) -> Result<()> {
        Submitter::with_clock(self, 0, Clock::Fence)?.run(body).map(drop)
    }

    /// A device buffer with a copy of `data`, visible to whatever reads it. Submits to the queue and waits.
    ///
    /// # Errors
    /// As [`Buffer::new`] and [`Gpu::once`].
    pub fn upload<T: bytemuck::Pod>(&self, name: &str, data: &[T]) -> Result<Buffer> {
        let buffer = Buffer::new(self, name, size_of_val(data) as u64, Residence::Device)?;
        self.upload_to(&buffer, data)?;
        Ok(buffer)
    }

    /// Writes `data` over the whole of `buffer`. Submits to the queue and waits.
    ///
    /// # Errors
    /// As [`Buffer::new`] and [`Gpu::once`].
    ///
    /// # Panics
    /// If the sizes differ.
    pub fn upload_to<T: bytemuck::Pod>(&self, buffer: &Buffer, data: &[T]) -> Result<()> {
        let staging = Buffer::staging(self, &format!("{}.upload", buffer.name()), data)?;
        self.once(|rec| {
            rec.barrier(Access::ComputeReadWrite, Access::CopyWrite);
            rec.copy(&staging, buffer);
            for reader in
                [Access::ComputeReadWrite, Access::GraphicsRead, Access::IndexRead, Access::IndirectRead]
            {
                rec.barrier(Access::CopyWrite, reader);
            }
        })
    }

    /// What `buffer` holds now, last written by [`Access::ComputeWrite`]. Submits to the queue and waits.
    ///
    /// # Errors
    /// As [`Buffer::new`] and [`Gpu::once`].
    pub fn download<T: bytemuck::Pod>(&self, buffer: &Buffer) -> Result<Vec<T>> {
        let name = format!("{}.readback", buffer.name());
        let staging = Buffer::new(self, &name, buffer.bytes(), Residence::Readback)?;
        self.once(|rec| {
            rec.barrier(Access::ComputeWrite, Access::CopyRead);
            rec.copy(buffer, &staging);
            rec.barrier(Access::CopyWrite, Access::HostRead);
        })?;
        Ok(staging.read())
    }
}
