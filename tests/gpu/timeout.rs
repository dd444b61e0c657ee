// SPDX-License-Identifier: MIT OR Apache-2.0
//! A GPU that does not finish in time. What it is at is waited for before it is begun anew or freed: a device whose fences
//! never seem to be signalled says in which order that is done.

use ash::vk;
use std::{
    ffi::{c_void, CStr},
    sync::{Mutex, OnceLock},
};
use whitecap::gpu::{Clock, Error, External, Gpu, Submitter};

static CALLS: Mutex<Vec<&str>> = Mutex::new(Vec::new());
static REAL: OnceLock<(vk::PFN_vkBeginCommandBuffer, vk::PFN_vkQueueWaitIdle, vk::PFN_vkDestroyCommandPool)> =
    OnceLock::new();

fn note(call: &'static str) {
    CALLS.lock().unwrap().push(call);
}

unsafe extern "system" fn wait_for_fences(
    _: vk::Device,
    _: u32,
    _: *const vk::Fence,
    _: vk::Bool32,
    _: u64,
) -> vk::Result {
    note("gives up");
    vk::Result::TIMEOUT
}

unsafe extern "system" fn begin(
    cmd: vk::CommandBuffer,
    info: *const vk::CommandBufferBeginInfo<'_>,
) -> vk::Result {
    note("begins");
    unsafe { (REAL.get().unwrap().0)(cmd, info) }
}

unsafe extern "system" fn wait_idle(queue: vk::Queue) -> vk::Result {
    note("waits");
    unsafe { (REAL.get().unwrap().1)(queue) }
}

unsafe extern "system" fn destroy_pool(
    device: vk::Device,
    pool: vk::CommandPool,
    allocator: *const vk::AllocationCallbacks<'_>,
) {
    note("destroys");
    unsafe { (REAL.get().unwrap().2)(device, pool, allocator) }
}

/// The device with those four in place of its own.
unsafe fn slow(instance: &ash::Instance, device: &ash::Device) -> ash::Device {
    let real = device.fp_v1_0();
    REAL.set((real.begin_command_buffer, real.queue_wait_idle, real.destroy_command_pool)).ok();
    let find = |name: &CStr| -> *const c_void {
        match name.to_bytes() {
            b"vkWaitForFences" => wait_for_fences as *const c_void,
            b"vkBeginCommandBuffer" => begin as *const c_void,
            b"vkQueueWaitIdle" => wait_idle as *const c_void,
            b"vkDestroyCommandPool" => destroy_pool as *const c_void,
            _ => unsafe {
                let found = (instance.fp_v1_0().get_device_proc_addr)(device.handle(), name.as_ptr());
                found.map_or(std::ptr::null(), |it| it as *const c_void)
            },
        }
    };
    unsafe { ash::Device::load_with(find, device.handle()) }
}

#[test]
fn what_is_not_done_in_time_is_waited_for() {
    // SAFETY: all that is made from the device is dropped before it is destroyed.
    unsafe {
        let loader = ash::Entry::load().unwrap();
        let app = vk::ApplicationInfo::default().api_version(vk::API_VERSION_1_3);
        let instance =
            loader.create_instance(&vk::InstanceCreateInfo::default().application_info(&app), None).unwrap();
        let physical = instance.enumerate_physical_devices().unwrap()[0];
        let families = instance.get_physical_device_queue_family_properties(physical);
        let family = families.iter().position(|it| it.queue_flags.contains(vk::QueueFlags::COMPUTE)).unwrap();
        let family = family as u32;
        let queues =
            [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let mut features = vk::PhysicalDeviceVulkan13Features::default()
            .synchronization2(true)
            .dynamic_rendering(true)
            .maintenance4(true);
        let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues).push_next(&mut features);
        let device = instance.create_device(physical, &info, None).unwrap();
        let queue = device.get_device_queue(family, 0);
        let slow = slow(&instance, &device);
        let external =
            External { instance: &instance, physical, device: &slow, queue, family, has_debug_utils: false };
        let gpu = Gpu::from_external(&external).unwrap();
        gpu.believe(Clock::Fence).unwrap();
        let mut submitter = Submitter::new(&gpu, 4).unwrap();
        let run = |submitter: &mut Submitter| {
            let spans = |rec: &mut whitecap::gpu::Recorder<'_>| {
                rec.span(c"test.first", |_| {});
                rec.span(c"test.second", |_| {});
            };
            assert!(matches!(submitter.run(spans), Err(Error::Timeout { .. })));
        };
        run(&mut submitter);
        // Each span begins the commands anew: after the first that is not done in time, only when it is.
        assert_eq!(*CALLS.lock().unwrap(), ["begins", "gives up", "waits", "begins"]);
        run(&mut submitter); // refused at once
        assert_eq!(CALLS.lock().unwrap().len(), 4);
        drop(submitter);
        assert_eq!(CALLS.lock().unwrap()[4..], ["waits", "destroys"]);

        // Without a clock there is one submission, and it is still on its way when it is given up on.
        CALLS.lock().unwrap().clear();
        assert!(matches!(gpu.once(|_| {}), Err(Error::Timeout { .. })));
        assert_eq!(*CALLS.lock().unwrap(), ["begins", "gives up", "waits", "destroys"]);
        drop(gpu);
        device.destroy_device(None);
        instance.destroy_instance(None);
    }
}
