// SPDX-License-Identifier: MIT OR Apache-2.0
//! Water inside a renderer that has Vulkan already: its instance, its device, its queue, its command buffer.
//!
//! `whitecap` is given the handles, makes its kernels and buffers from them, and records steps between the commands of
//! the caller, who submits. What the caller must provide is short: Vulkan 1.3 with `synchronization2`,
//! `dynamicRendering` and `maintenance4`, and a queue with compute. No extension is needed.
//!
//! Run it with `cargo run --release --example embed`. Built without the feature `tools`, the crate brings no
//! GLSL compiler, scene files or command line.

#![allow(unsafe_op_in_unsafe_fn)] // almost every line is a Vulkan call

use ash::vk;
use glam::uvec2;
use std::error::Error;
use whitecap::{
    gpu::{Access, Buffer, External, Gpu, Recorder, Residence},
    water::{Disturb, DisturbParams, Disturbance, Model, Tuning, Walls, Waves},
};

fn main() -> Result<(), Box<dyn Error>> {
    println!("highest wave after 2 s: {:.3} m", run()?);
    Ok(())
}

/// The height of the highest wave after 120 frames (m).
pub fn run() -> Result<f32, Box<dyn Error>> {
    // SAFETY: everything made from the engine's device is dropped inside `simulate`, before the engine goes.
    unsafe {
        let engine = Engine::new()?;
        let highest = simulate(&engine);
        engine.destroy();
        highest
    }
}

/// What the caller has of its own.
struct Engine {
    _loader: ash::Entry,
    instance: ash::Instance,
    physical: vk::PhysicalDevice,
    device: ash::Device,
    queue: vk::Queue,
    family: u32,
    pool: vk::CommandPool,
}

impl Engine {
    unsafe fn new() -> Result<Self, Box<dyn Error>> {
        let loader = ash::Entry::load()?;
        let app = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let instance =
            loader.create_instance(&vk::InstanceCreateInfo::default().application_info(&app), None)?;
        let physical = instance.enumerate_physical_devices()?.into_iter().next().ok_or("no Vulkan device")?;
        let families = instance.get_physical_device_queue_family_properties(physical);
        let compute = families.iter().position(|f| f.queue_flags.contains(vk::QueueFlags::COMPUTE));
        let family = compute.ok_or("no compute queue")? as u32;
        let queues =
            [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let mut features = vk::PhysicalDeviceVulkan13Features::default()
            .synchronization2(true)
            .dynamic_rendering(true)
            .maintenance4(true);
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).push_next(&mut features);
        let device = instance.create_device(physical, &info, None)?;
        let queue = device.get_device_queue(family, 0);
        let pool = device.create_command_pool(
            &vk::CommandPoolCreateInfo::default()
                .queue_family_index(family)
                .flags(vk::CommandPoolCreateFlags::RESET_COMMAND_BUFFER),
            None,
        )?;
        Ok(Self { _loader: loader, instance, physical, device, queue, family, pool })
    }

    /// One frame: the engine begins, `body` records, the engine submits and waits.
    unsafe fn frame(
        &self,
        cmd: vk::CommandBuffer,
        body: impl FnOnce(vk::CommandBuffer),
    ) -> Result<(), vk::Result> {
        self.device.begin_command_buffer(cmd, &vk::CommandBufferBeginInfo::default())?;
        body(cmd);
        self.device.end_command_buffer(cmd)?;
        let buffers = [cmd];
        let submit = [vk::SubmitInfo::default().command_buffers(&buffers)];
        self.device.queue_submit(self.queue, &submit, vk::Fence::null())?;
        self.device.queue_wait_idle(self.queue)
    }

    unsafe fn destroy(self) {
        self.device.destroy_command_pool(self.pool, None);
        self.device.destroy_device(None);
        self.instance.destroy_instance(None);
    }
}

/// A basin of 48 by 32 m, a drop in every tenth frame, 60 frames a second; the height of the highest wave (m).
unsafe fn simulate(engine: &Engine) -> Result<f32, Box<dyn Error>> {
    let gpu = Gpu::from_external(&External {
        instance: &engine.instance,
        physical: engine.physical,
        device: &engine.device,
        queue: engine.queue,
        family: engine.family,
        has_debug_utils: false,
    })?;

    // What to simulate, in physical units. `check` refuses an unstable step, and says the limit.
    let cells = uvec2(192, 128);
    let model = Model {
        cells,
        cell_m: 0.25,
        speed_mps: (9.81f64 * 1.5).sqrt(),
        damping_per_s: 0.1,
        diagonal: 0.25,
        walls: Walls::Folded,
        dt_s: 1.0 / 60.0,
    };
    model.check()?;

    // Kernels, state and parameters are three things.
    let tuning = Tuning::for_grid(&gpu, cells);
    let mut state = Waves::new(&gpu, tuning, false)?.state(cells)?;
    let params = model.params(state.pitch());
    let drops = Disturb::new(&gpu)?.list(state.surfaces(), Some(state.velocity()), 8)?;
    let drop_params = DisturbParams {
        cells,
        pitch: state.pitch(),
        stride: 1,
        cell_m: 0.25,
        limit_m: 10.0,
        has_velocity: 1,
    };
    let drop =
        Disturbance { at_m: glam::vec2(15.0, 10.0), radius_m: 1.5, volume_m3: 0.3, ..Default::default() };
    let (drop, _) = drops.staging(&[drop])?;
    let readback = Buffer::new(&gpu, "readback", state.height().bytes(), Residence::Readback)?;

    let info = vk::CommandBufferAllocateInfo::default().command_pool(engine.pool).command_buffer_count(1);
    let cmd = engine.device.allocate_command_buffers(&info)?[0];
    for frame in 0..120 {
        engine.frame(cmd, |cmd| {
            // The caller's commands come before and after; ENTRY and EXIT say what the barriers to them are.
            let mut rec = Recorder::new(&gpu, cmd);
            if frame == 0 {
                rec.fill(state.height(), 0);
                rec.fill(state.velocity(), 0);
                rec.barrier(Access::FillWrite, Waves::ENTRY);
            }
            if frame % 10 == 0 {
                rec.barrier(Disturb::EXIT, Access::CopyWrite);
                rec.copy(&drop, drops.list());
                rec.barrier(Access::CopyWrite, Disturb::ENTRY);
                drops.record(&mut rec, &state.surface(), &drop_params);
                rec.barrier(Disturb::EXIT, Waves::ENTRY);
            }
            // A start at rest is half a step from its first flow.
            let params = if frame == 0 { params.first_from_rest() } else { params };
            state.record(&mut rec, &params);
            rec.barrier(Waves::EXIT, Waves::ENTRY);
            // Here the caller would draw from `state.height()`.
        })?;
    }
    engine.frame(cmd, |cmd| {
        let mut rec = Recorder::new(&gpu, cmd);
        rec.barrier(Waves::EXIT, Access::CopyRead);
        rec.copy(state.height(), &readback);
        rec.barrier(Access::CopyWrite, Access::HostRead);
    })?;
    Ok(readback.read::<f32>().into_iter().fold(0.0, f32::max))
}
