// SPDX-License-Identifier: MIT OR Apache-2.0
//! From the pixels of a kernel to the image of a window, and on to the window system.

use super::{
    frames::{Finished, Frames},
    swapchain::{whole, Shown},
};
use crate::gpu::{Buffer, Gpu, Image, ImageUse, Result};
use ash::vk::{self, AccessFlags2 as A, PipelineStageFlags2 as S};
use std::slice;

impl Frames {
    /// A picture of four bytes a pixel on the device, between the pixels of a kernel and the image of a window.
    pub(super) fn canvas(&mut self, size: [u32; 2]) -> Result<Image> {
        match &self.canvas {
            Some(canvas) if canvas.size() == size => Ok(canvas.clone()),
            _ => {
                let canvas = Image::new(&self.gpu, "view.canvas", size, ImageUse::Canvas, 1)?;
                Ok(self.canvas.insert(canvas).clone())
            }
        }
    }

    /// Pixels to canvas to window: a blit, as the window may have another order of bytes and another size.
    pub(super) fn record_canvas(
        &self,
        cmd: vk::CommandBuffer,
        canvas: &Image,
        picture: &Finished,
        shown: &Shown,
    ) {
        let (gpu, chain) = (&self.gpu, self.chain.as_ref().expect("begun"));
        let layers =
            vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1);
        let [width, height] = picture.size;
        assert!(picture.pixels.bytes() == 4 * u64::from(width) * u64::from(height), "{width} x {height}");
        let region = vk::BufferImageCopy::default().image_subresource(layers).image_extent(vk::Extent3D {
            width,
            height,
            depth: 1,
        });
        let general = vk::ImageLayout::GENERAL;
        let pixels = picture.pixels.raw();
        unsafe { gpu.device().cmd_copy_buffer_to_image(cmd, pixels, canvas.raw(), general, &[region]) };
        barrier(gpu, cmd, (S::COPY, A::TRANSFER_WRITE), (S::BLIT, A::TRANSFER_READ));
        turn(gpu, cmd, shown, TAKEN, FILLED);
        let extent = chain.extent;
        let corner = |x: u32, y: u32| vk::Offset3D { x: x as i32, y: y as i32, z: 1 };
        let zero = vk::Offset3D::default();
        let region = vk::ImageBlit::default()
            .src_subresource(layers)
            .src_offsets([zero, corner(width, height)])
            .dst_subresource(layers)
            .dst_offsets([zero, corner(extent.width, extent.height)]);
        let is_same = [extent.width, extent.height] == picture.size;
        let filter = if is_same { vk::Filter::NEAREST } else { vk::Filter::LINEAR };
        let filled = vk::ImageLayout::TRANSFER_DST_OPTIMAL;
        unsafe {
            let device = gpu.device();
            device.cmd_blit_image(cmd, canvas.raw(), general, shown.image, filled, &[region], filter);
        }
        turn(gpu, cmd, shown, FILLED, DRAWN);
    }

    /// To what the window system takes, by way of `copy`.
    pub(super) fn record_end(&self, cmd: vk::CommandBuffer, shown: &Shown, copy: Option<&Buffer>) {
        let (gpu, chain) = (&self.gpu, self.chain.as_ref().expect("begun"));
        let Some(copy) = copy.filter(|_| chain.is_readable) else {
            return turn(gpu, cmd, shown, DRAWN, GIVEN);
        };
        turn(gpu, cmd, shown, DRAWN, COPIED);
        let vk::Extent2D { width, height } = chain.extent;
        assert!(copy.bytes() == 4 * u64::from(width) * u64::from(height), "`{}`", copy.name());
        let region = vk::BufferImageCopy::default()
            .image_subresource(
                vk::ImageSubresourceLayers::default().aspect_mask(vk::ImageAspectFlags::COLOR).layer_count(1),
            )
            .image_extent(vk::Extent3D { width, height, depth: 1 });
        let layout = vk::ImageLayout::TRANSFER_SRC_OPTIMAL;
        unsafe { gpu.device().cmd_copy_image_to_buffer(cmd, shown.image, layout, copy.raw(), &[region]) };
        barrier(gpu, cmd, (S::COPY, A::TRANSFER_WRITE), (S::HOST, A::HOST_READ));
        turn(gpu, cmd, shown, COPIED, GIVEN);
    }
}

/// Layout of a window's image, and who was or will be at it.
type Turn = (vk::ImageLayout, S, A);
/// Just taken: the stage is the one that the submission waits for it with.
const TAKEN: Turn = (vk::ImageLayout::UNDEFINED, S::BLIT, A::NONE);
const FILLED: Turn = (vk::ImageLayout::TRANSFER_DST_OPTIMAL, S::BLIT, A::TRANSFER_WRITE);
const DRAWN: Turn = (
    vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL,
    S::COLOR_ATTACHMENT_OUTPUT,
    A::from_raw(A::COLOR_ATTACHMENT_READ.as_raw() | A::COLOR_ATTACHMENT_WRITE.as_raw()),
);
const COPIED: Turn = (vk::ImageLayout::TRANSFER_SRC_OPTIMAL, S::COPY, A::TRANSFER_READ);
/// Given to the window system: the semaphore orders it.
const GIVEN: Turn = (vk::ImageLayout::PRESENT_SRC_KHR, S::NONE, A::NONE);

fn turn(gpu: &Gpu, cmd: vk::CommandBuffer, shown: &Shown, from: Turn, to: Turn) {
    let barrier = vk::ImageMemoryBarrier2::default()
        .old_layout(from.0)
        .src_stage_mask(from.1)
        .src_access_mask(from.2)
        .new_layout(to.0)
        .dst_stage_mask(to.1)
        .dst_access_mask(to.2)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(shown.image)
        .subresource_range(whole());
    let info = vk::DependencyInfo::default().image_memory_barriers(slice::from_ref(&barrier));
    unsafe { gpu.device().cmd_pipeline_barrier2(cmd, &info) };
}

fn barrier(gpu: &Gpu, cmd: vk::CommandBuffer, from: (S, A), to: (S, A)) {
    let barrier = vk::MemoryBarrier2::default()
        .src_stage_mask(from.0)
        .src_access_mask(from.1)
        .dst_stage_mask(to.0)
        .dst_access_mask(to.1);
    let info = vk::DependencyInfo::default().memory_barriers(slice::from_ref(&barrier));
    unsafe { gpu.device().cmd_pipeline_barrier2(cmd, &info) };
}
