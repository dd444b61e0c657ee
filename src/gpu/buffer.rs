// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{
    device::Gpu,
    error::{Error, OrCall, Result},
};
use ash::vk;
use gpu_allocator::{vulkan as ga, MemoryLocation};
use std::sync::{Arc, Mutex, MutexGuard};

/// Where a buffer lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Residence {
    /// Device-local, not mapped.
    Device,
    /// Mapped, for the host to write.
    Upload,
    /// Mapped and cached, for the host to read.
    Readback,
}

/// A named buffer and its memory. Cheap to clone; a [`Bound`](super::Bound) kernel keeps the buffers that it uses alive.
/// Freed with the last clone: the caller makes sure that the GPU is done with it by then.
#[derive(Clone)]
pub struct Buffer(Arc<Inner>);

struct Inner {
    raw: vk::Buffer,
    memory: Mutex<ga::Allocation>, // null until placed
    name: String,
    bytes: u64,
    residence: Residence,
    gpu: Gpu,
}

impl Buffer {
    /// # Errors
    /// [`Error::Limit`] if a shader could not see all of it; [`Error::Memory`] or [`Error::Vulkan`] if the device has
    /// no room. Each names the buffer.
    ///
    /// # Panics
    /// If `bytes` is 0.
    pub fn new(gpu: &Gpu, name: &str, bytes: u64, residence: Residence) -> Result<Self> {
        Self::with_usage(gpu, name, bytes, residence, vk::BufferUsageFlags::empty())
    }

    /// Where [`Stream`](super::Stream) captures vertices, or counts them.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    ///
    /// # Panics
    /// If `bytes` is 0, or the device has no transform feedback.
    pub fn for_stream(gpu: &Gpu, name: &str, bytes: u64) -> Result<Self> {
        assert!(gpu.has_transform_feedback(), "`{name}`: {} has no transform feedback", gpu.name());
        let usage = vk::BufferUsageFlags::TRANSFORM_FEEDBACK_BUFFER_EXT
            | vk::BufferUsageFlags::TRANSFORM_FEEDBACK_COUNTER_BUFFER_EXT;
        Self::with_usage(gpu, name, bytes, Residence::Device, usage)
    }

    fn with_usage(
        gpu: &Gpu,
        name: &str,
        bytes: u64,
        residence: Residence,
        more: vk::BufferUsageFlags,
    ) -> Result<Self> {
        assert!(bytes > 0, "`{name}`: empty buffer");
        let allowed = u64::from(gpu.limits().max_storage_buffer_range);
        if bytes > allowed && residence == Residence::Device {
            return Err(Error::Limit {
                name: name.into(),
                needed: bytes,
                device: gpu.name().into(),
                allowed,
                limit: "maxStorageBufferRange, bytes",
            });
        }
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST
            | vk::BufferUsageFlags::INDEX_BUFFER
            | vk::BufferUsageFlags::INDIRECT_BUFFER
            | more;
        let info = vk::BufferCreateInfo::default().size(bytes).usage(usage);

        // Built in place: whatever fails below, `Drop` frees what exists by then.
        let mut buffer = Inner {
            raw: vk::Buffer::null(),
            memory: Mutex::default(),
            name: name.into(),
            bytes,
            residence,
            gpu: gpu.clone(),
        };
        buffer.raw =
            unsafe { gpu.device().create_buffer(&info, None) }.or_call_for("vkCreateBuffer", name)?;
        let memory = gpu
            .allocator()
            .allocate(&ga::AllocationCreateDesc {
                name,
                requirements: unsafe { gpu.device().get_buffer_memory_requirements(buffer.raw) },
                location: match residence {
                    Residence::Device => MemoryLocation::GpuOnly,
                    Residence::Upload => MemoryLocation::CpuToGpu,
                    Residence::Readback => MemoryLocation::GpuToCpu,
                },
                linear: true,
                allocation_scheme: ga::AllocationScheme::GpuAllocatorManaged,
            })
            .map_err(|source| Error::Memory { name: name.into(), bytes, source })?;
        let (raw, offset) = unsafe { (memory.memory(), memory.offset()) };
        buffer.memory = Mutex::new(memory);
        unsafe { gpu.device().bind_buffer_memory(buffer.raw, raw, offset) }
            .or_call_for("vkBindBufferMemory", name)?;
        gpu.set_name(buffer.raw, name);
        Ok(Self(Arc::new(buffer)))
    }

    /// A mapped buffer that holds `data`, to be copied from.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn staging<T: bytemuck::Pod>(gpu: &Gpu, name: &str, data: &[T]) -> Result<Self> {
        let buffer = Self::new(gpu, name, size_of_val(data) as u64, Residence::Upload)?;
        buffer.write(0, data);
        Ok(buffer)
    }

    /// Writes `data` at byte `offset` of mapped memory.
    ///
    /// # Panics
    /// If it does not fit, or the buffer is [`Residence::Device`].
    pub fn write<T: bytemuck::Pod>(&self, offset: usize, data: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let mut memory = self.memory();
        let mapped = memory.mapped_slice_mut().unwrap_or_else(|| panic!("`{}` is not mapped", self.name()));
        mapped[..self.0.bytes as usize][offset..offset + bytes.len()].copy_from_slice(bytes);
    }

    /// What mapped memory holds.
    ///
    /// # Panics
    /// If the buffer is [`Residence::Device`].
    pub fn read<T: bytemuck::Pod>(&self) -> Vec<T> {
        let memory = self.memory();
        let mapped = memory.mapped_slice().unwrap_or_else(|| panic!("`{}` is not mapped", self.name()));
        bytemuck::allocation::pod_collect_to_vec(&mapped[..self.0.bytes as usize])
    }

    fn memory(&self) -> MutexGuard<'_, ga::Allocation> {
        self.0.memory.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
    }

    /// Whether two are one buffer.
    pub fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// For whoever records beside this crate.
    pub fn raw(&self) -> vk::Buffer {
        self.0.raw
    }

    /// As captures and validation show it.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Size (bytes).
    pub fn bytes(&self) -> u64 {
        self.0.bytes
    }

    /// Where it lives.
    pub fn residence(&self) -> Residence {
        self.0.residence
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        unsafe { self.gpu.device().destroy_buffer(self.raw, None) };
        let memory = self.memory.get_mut().unwrap_or_else(|poisoned| poisoned.into_inner());
        let _ = self.gpu.allocator().free(std::mem::take(memory));
    }
}
