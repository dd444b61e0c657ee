// SPDX-License-Identifier: MIT OR Apache-2.0
//! Record, submit and wait: for tools, tests and set-up, not for a frame loop.

use super::{
    calibrate::{place, Placed},
    error::{Error, OrCall, Result},
    recorder::Kept,
    statistics::{Statistics, StatisticsPool},
    timing::Clock,
    Access, Buffer, Gpu, Recorder, Residence, Zone,
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
    /// When it began by the host's clock, as near as [`Times::placed`] says; `None` if nobody watches.
    pub begin: Option<Instant>,
    /// What it made the device do, if that was asked for.
    pub statistics: Statistics,
}

/// What the host did from one moment to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HostTime {
    /// `record`, `submit` or `wait`; where the fence is the clock, the others lie within `record` too.
    pub name: &'static str,
    /// When it began.
    pub begin: Instant,
    /// When it ended.
    pub end: Instant,
}

impl HostTime {
    /// From `begin` until now.
    pub fn until_now(name: &'static str, begin: Instant) -> Self {
        Self { name, begin, end: Instant::now() }
    }
}

/// What a submission took.
#[derive(Clone, Debug, Default)]
pub struct Times {
    /// Of the spans that were timed, in order.
    pub spans: Vec<SpanTime>,
    /// Spans that there was no room to time.
    pub untimed: usize,
    /// From submission to fence, by the host's clock (ms).
    pub wall_ms: f64,
    /// What the host did, by the end of each.
    pub host: Vec<HostTime>,
    /// How the spans' beginnings are placed.
    pub placed: Placed,
}

impl Times {
    /// Sum of all spans called `name` (ms).
    pub fn of(&self, name: &CStr) -> f64 {
        self.spans.iter().filter(|span| span.name == name).map(|span| span.ms).sum()
    }

    /// Adds what a later submission took. They are placed as the least certain of them is.
    pub fn add(&mut self, later: Self) {
        self.spans.extend(later.spans);
        self.untimed += later.untimed;
        self.wall_ms += later.wall_ms;
        self.host.extend(later.host);
        self.placed = self.placed.max(later.placed);
    }
}

/// Command pool, fence and queries, used again by every submission.
pub struct Submitter {
    pool: vk::CommandPool,
    cmd: vk::CommandBuffer,
    queries: vk::QueryPool,
    fence: vk::Fence,
    room: usize,
    is_watched: bool,
    statistics: Option<StatisticsPool>,
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
            is_watched: false,
            statistics: None,
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
        gpu.set_name(made.pool, "submitter.pool");
        gpu.set_name(made.cmd, "submitter.commands");
        gpu.set_name(made.fence, "submitter.done");
        if made.queries != vk::QueryPool::null() {
            gpu.set_name(made.queries, "submitter.times");
        }
        Ok(made)
    }

    /// From now on, also says when each span began, and with `statistics` what it made the device do, if the device counts
    /// that.
    ///
    /// # Errors
    /// [`Error::Vulkan`].
    pub fn watching(mut self, statistics: bool) -> Result<Self> {
        self.is_watched = true;
        let is_counted = statistics && self.room > 0 && self.gpu.has_statistics();
        self.statistics = is_counted.then(|| StatisticsPool::new(&self.gpu, self.room)).transpose()?;
        Ok(self)
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
        let (start, zone) = (Instant::now(), Zone::new("record"));
        begin(device, self.cmd)?;
        let mut rec = unsafe { Recorder::new(&gpu, self.cmd) }.keeping();
        if self.queries != vk::QueryPool::null() {
            unsafe { device.cmd_reset_query_pool(self.cmd, self.queries, 0, 2 * self.room as u32) };
            rec = unsafe { rec.timed(self.queries, self.room) };
        } else if self.room > 0 {
            rec = rec.fenced(Box::new(Fenced::new(&gpu, self.fence)), self.room);
        }
        if let Some(statistics) = &self.statistics {
            unsafe { device.cmd_reset_query_pool(self.cmd, statistics.raw, 0, self.room as u32) };
            rec = rec.counted(statistics.raw);
        }
        body(&mut rec);
        let recorded = rec.finish();
        self.kept = recorded.kept;
        let record = HostTime::until_now("record", start);
        zone.end();
        let fenced = recorded.flush.map_or(Ok(Waits::default()), |mut flush| flush.waits());
        let done = fenced.and_then(|mut waits| {
            waits.host.push(record);
            submit(&gpu, self.cmd, self.fence, &mut waits.host).map(|()| waits)
        });
        self.is_pending = matches!(done, Err(Error::Timeout { .. }));
        let waits = done?;
        self.kept.clear();
        let done = Instant::now();
        let mut times = Times {
            untimed: if self.room > 0 { recorded.untimed } else { 0 },
            wall_ms: (done - record.end).as_secs_f64() * 1e3,
            host: waits.host,
            ..Times::default()
        };
        let mut spans = if self.queries == vk::QueryPool::null() {
            fenced_spans(&recorded.spans, &waits.stamps)
        } else {
            let ticks = self.ticks(recorded.spans.len())?;
            let begins = if self.is_watched {
                let (begins, placed) = place(&gpu, &ticks, (record.end, done));
                times.placed = placed;
                begins.into_iter().map(Some).collect()
            } else {
                vec![None; ticks.len()]
            };
            stamped_spans(&gpu, &recorded.spans, &ticks, begins)
        };
        if let Some(statistics) = &self.statistics {
            for (span, counts) in spans.iter_mut().zip(statistics.read(recorded.spans.len())?) {
                span.statistics = counts;
            }
        }
        times.spans = spans;
        Ok(times)
    }

    /// Both stamps of each of the first `spans`.
    fn ticks(&self, spans: usize) -> Result<Vec<[u64; 2]>> {
        ticks(&self.gpu, self.queries, spans)
    }
}

/// Both stamps of each of the first `spans` of `queries`, which are finished.
pub(super) fn ticks(gpu: &Gpu, queries: vk::QueryPool, spans: usize) -> Result<Vec<[u64; 2]>> {
    let mut ticks = vec![[0u64; 2]; spans];
    if spans > 0 {
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        let flat = ticks.as_flattened_mut();
        unsafe { gpu.device().get_query_pool_results(queries, 0, flat, flags) }
            .or_call("vkGetQueryPoolResults")?;
    }
    Ok(ticks)
}

pub(super) fn stamped_spans(
    gpu: &Gpu,
    names: &[&'static CStr],
    ticks: &[[u64; 2]],
    begins: Vec<Option<Instant>>,
) -> Vec<SpanTime> {
    let tick_ms = f64::from(gpu.limits().timestamp_period) * 1e-6;
    // Only so many bits count; they wrap.
    let mask = u64::MAX >> (64 - gpu.0.adapter.timestamp_bits.clamp(1, 64));
    let ms = |[begin, end]: &[u64; 2]| (end.wrapping_sub(*begin) & mask) as f64 * tick_ms;
    let span = |((&name, ticks), begin)| SpanTime { name, ms: ms(ticks), begin, statistics: Vec::new() };
    names.iter().zip(ticks).zip(begins).map(span).collect()
}

pub(super) fn fenced_spans(names: &[&'static CStr], stamps: &[Instant]) -> Vec<SpanTime> {
    let span = |(&name, stamps): (&&'static CStr, &[Instant])| SpanTime {
        name,
        ms: (stamps[1] - stamps[0]).as_secs_f64() * 1e3,
        begin: Some(stamps[0]),
        statistics: Vec::new(),
    };
    names.iter().zip(stamps.chunks_exact(2)).map(span).collect()
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

/// Ends and submits `cmd`, and waits for `fence`, which is unsignalled again afterwards; `host` gets both times.
fn submit(gpu: &Gpu, cmd: vk::CommandBuffer, fence: vk::Fence, host: &mut Vec<HostTime>) -> Result<()> {
    let device = gpu.device();
    let (start, zone) = (Instant::now(), Zone::new("submit"));
    unsafe { device.end_command_buffer(cmd) }.or_call("vkEndCommandBuffer")?;
    let infos = [vk::CommandBufferSubmitInfo::default().command_buffer(cmd)];
    let submit = [vk::SubmitInfo2::default().command_buffer_infos(&infos)];
    unsafe { device.queue_submit2(*gpu.queue(), &submit, fence) }.or_call("vkQueueSubmit2")?;
    let submitted = HostTime::until_now("submit", start);
    host.push(submitted);
    zone.end();
    let _zone = Zone::new("wait");
    match unsafe { device.wait_for_fences(&[fence], true, TIMEOUT_S * 1_000_000_000) } {
        Err(vk::Result::TIMEOUT) => return Err(Error::Timeout { seconds: TIMEOUT_S }),
        other => other.or_call("vkWaitForFences")?,
    }
    host.push(HostTime::until_now("wait", submitted.end));
    unsafe { device.reset_fences(&[fence]) }.or_call("vkResetFences")
}

/// Both ends of a span where the GPU's timestamps cannot be believed.
pub(super) trait Flush {
    /// Submits what is recorded, waits, notes the time and begins anew.
    fn stamp(&mut self, cmd: vk::CommandBuffer);
    /// All stamps so far, or the first error.
    fn waits(&mut self) -> Result<Waits>;
}

/// What a host that waits at both ends of every span knows of them.
#[derive(Default)]
pub(super) struct Waits {
    /// Two a span.
    pub stamps: Vec<Instant>,
    pub host: Vec<HostTime>,
}

pub(super) struct Fenced<'g> {
    gpu: &'g Gpu,
    fence: vk::Fence,
    so_far: Waits,
    failed: Option<Error>,
}

impl<'g> Fenced<'g> {
    pub fn new(gpu: &'g Gpu, fence: vk::Fence) -> Self {
        Self { gpu, fence, so_far: Waits::default(), failed: None }
    }
}

impl Flush for Fenced<'_> {
    fn stamp(&mut self, cmd: vk::CommandBuffer) {
        if self.failed.is_none() {
            let done = submit(self.gpu, cmd, self.fence, &mut self.so_far.host);
            self.so_far.stamps.push(Instant::now());
            if done.is_err() {
                // Nothing that is on its way is begun anew, or dropped by whoever gave up. Where the device is lost, nothing is.
                let _ = unsafe { self.gpu.device().queue_wait_idle(*self.gpu.queue()) };
            }
            let (done, begun) = (done.err(), begin(self.gpu.device(), cmd)); // what follows a failure is thrown away
            self.failed = done.or(begun.err());
        }
    }

    fn waits(&mut self) -> Result<Waits> {
        match self.failed.take() {
            Some(error) => Err(error),
            None => Ok(std::mem::take(&mut self.so_far)),
        }
    }
}

impl Gpu {
    /// A debug label on the queue around all that `body` submits: one for a picture, say.
    pub fn labelled<T>(&self, name: &CStr, body: impl FnOnce() -> T) -> T {
        let Some(debug) = &self.0.debug else { return body() };
        let label = vk::DebugUtilsLabelEXT::default().label_name(name);
        unsafe { debug.queue_begin_debug_utils_label(*self.queue(), &label) };
        let made = body();
        unsafe { debug.queue_end_debug_utils_label(*self.queue()) };
        made
    }

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
