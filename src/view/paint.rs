// SPDX-License-Identifier: MIT OR Apache-2.0
//! The panel on the GPU: egui's triangles over the picture. The only file here that names Vulkan.

use super::ViewError;
use crate::gpu::{
    window::{Frames, FRAMES},
    Gpu,
};
use ash::vk;
use egui::{ClippedPrimitive, TextureId, TexturesDelta};
use egui_ash_renderer::{
    allocator::DefaultAllocator, DynamicRendering, Options, RenderMode, Renderer, RendererError,
};
use winit::{event::WindowEvent, window::Window};

/// egui, from events to triangles.
pub struct Painter {
    renderer: Renderer<DefaultAllocator>,
    state: egui_winit::State,
    format: vk::Format,
    /// What earlier frames may still sample, by the number of the last.
    retired: Vec<(u64, TextureId)>,
    pending: TexturesDelta,
    gpu: Gpu, // last: the renderer uses its device
}

/// One frame's triangles.
pub struct Triangles {
    list: Vec<ClippedPrimitive>,
    pixels_per_point: f32,
}

fn failed(error: RendererError) -> ViewError {
    match error {
        RendererError::Vulkan(code) => {
            crate::gpu::Error::Vulkan { call: "the panel's renderer", object: String::new(), code }.into()
        }
        other => ViewError::Panel(other.to_string()),
    }
}

fn mode(format: vk::Format) -> RenderMode {
    RenderMode::DynamicRendering(DynamicRendering {
        color_attachment_format: format,
        depth_attachment_format: None,
        stencil_attachment_format: None,
    })
}

impl Painter {
    /// # Errors
    /// The device's.
    pub fn new(gpu: &Gpu, frames: &Frames, window: &Window) -> Result<Self, ViewError> {
        let context = egui::Context::default();
        context.set_visuals(egui::Visuals::dark());
        let side = gpu.limits().max_image_dimension2_d as usize;
        let id = egui::ViewportId::ROOT;
        let scale = window.scale_factor() as f32;
        let state = egui_winit::State::new(context, id, window, Some(scale), None, Some(side));
        let (instance, physical) = frames.vulkan();
        let options = Options { in_flight_frames: FRAMES, ..Options::default() };
        let format = frames.format();
        let device = gpu.device().clone();
        let renderer = Renderer::with_default_allocator(instance, physical, device, mode(format), options)
            .map_err(failed)?;
        let (retired, pending) = (Vec::new(), TexturesDelta::default());
        Ok(Self { renderer, state, format, retired, pending, gpu: gpu.clone() })
    }

    /// Something has happened to the window. `true` if the panel takes it for itself.
    pub fn on_event(&mut self, window: &Window, event: &WindowEvent) -> bool {
        self.state.on_window_event(window, event).consumed
    }

    /// Whether the pointer is the panel's.
    pub fn wants_pointer(&self) -> bool {
        self.state.egui_ctx().egui_wants_pointer_input() || self.state.egui_ctx().is_pointer_over_egui()
    }

    /// Whether what is typed is the panel's.
    pub fn wants_keys(&self) -> bool {
        self.state.egui_ctx().egui_wants_keyboard_input()
    }

    /// Lays out one frame.
    pub fn run(&mut self, window: &Window, ui: impl FnMut(&mut egui::Ui)) -> Triangles {
        let input = self.state.take_egui_input(window);
        let context = self.state.egui_ctx().clone();
        let output = context.run_ui(input, ui);
        self.state.handle_platform_output(window, output.platform_output);
        self.pending.append(output.textures_delta);
        let pixels_per_point = output.pixels_per_point;
        Triangles { list: context.tessellate(output.shapes, pixels_per_point), pixels_per_point }
    }

    /// Brings textures to the GPU, before the frame is recorded that samples them.
    ///
    /// # Errors
    /// The device's.
    pub fn upload(&mut self, frames: &mut Frames) -> Result<(), ViewError> {
        if frames.format() != self.format {
            frames.wait()?;
            self.format = frames.format();
            self.renderer.set_render_mode(mode(self.format)).map_err(failed)?;
        }
        let (set, free) = (std::mem::take(&mut self.pending.set), std::mem::take(&mut self.pending.free));
        if !set.is_empty() {
            frames.wait()?; // one that is replaced may be in use
            let queue = self.gpu.queue();
            for (id, deltas) in &set {
                for delta in deltas {
                    self.renderer.set_texture(*queue, frames.pool(), *id, delta).map_err(failed)?;
                }
            }
        }
        self.retired.extend(free.into_iter().map(|id| (frames.number(), id)));
        let done = frames.done();
        for (_, id) in self.retired.extract_if(.., |(last_use, _)| *last_use <= done) {
            self.renderer.free_texture(id).map_err(failed)?;
        }
        Ok(())
    }

    /// Draws over a picture.
    ///
    /// # Errors
    /// The device's.
    pub fn draw(
        &mut self,
        cmd: vk::CommandBuffer,
        size: [u32; 2],
        triangles: &Triangles,
    ) -> Result<(), ViewError> {
        let extent = vk::Extent2D { width: size[0], height: size[1] };
        self.renderer.cmd_draw(cmd, extent, triangles.pixels_per_point, &triangles.list).map_err(failed)
    }
}

impl Drop for Painter {
    fn drop(&mut self) {
        self.pending.clear(); // egui takes what is left for a mistake
    }
}
