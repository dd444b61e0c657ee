// SPDX-License-Identifier: MIT OR Apache-2.0
//! Thin Vulkan core: device (its own or the caller's), memory, kernels, drawing, recording, time. Knows nothing about
//! simulations.
//!
//! Reading order: [`Access`] (all barriers there are), [`Recorder`] (what can be recorded), [`Kernel`] (how shader and
//! host meet), [`Submitter`] (how tools run it).

mod access;
mod adapter;
mod buffer;
mod cache;
mod calibrate;
mod device;
mod draws;
mod error;
mod executables;
#[cfg(feature = "tools")]
pub mod files;
#[cfg(feature = "tools")]
pub mod glsl;
mod image;
mod instance;
mod kernel;
mod layers;
mod program;
mod raster;
mod recorder;
pub mod reflect;
#[cfg(feature = "tools")]
pub mod reload;
mod renderdoc;
mod shared;
mod statistics;
mod stream;
mod submit;
mod timing;
#[cfg(feature = "viewer")]
pub mod window;
mod zone;

pub use access::Access;
pub use adapter::Adapter;
pub use buffer::{Buffer, Residence};
pub use calibrate::Placed;
pub use device::{External, Gpu, GpuOptions};
pub use draws::Target;
pub use error::{Error, Result};
pub use executables::{Executable, PipelineReport, Statistic};
pub use image::{Image, ImageUse};
pub use instance::Messages;
pub use kernel::{Kernel, KernelInfo};
pub use layers::LayersTarget;
pub use program::{Bound, Resource};
pub use raster::{Attachments, Blend, Depth, Raster, RasterInfo, Topology};
pub use recorder::Recorder;
pub use renderdoc::RenderDoc;
pub use statistics::Statistics;
pub use stream::{Stream, StreamDraw, StreamInfo};
pub use submit::{HostTime, SpanTime, Submitter, Times};
pub use timing::Clock;
pub use zone::Zone;

/// A compiler of GLSL at run time, which knows the files that this crate's own shaders include.
///
/// # Errors
/// If shaderc cannot start.
#[cfg(feature = "tools")]
pub fn compiler() -> std::result::Result<glsl::Compiler, glsl::CompileError> {
    glsl::Compiler::new(|wanted| {
        if let Some(text) = reload::included(wanted) {
            return Some(text);
        }
        let found = crate::shaders::INCLUDES.iter().find(|(name, _)| *name == wanted);
        found.map(|(_, text)| text.to_string())
    })
}

/// From now on [`compiler`] takes these files, by their paths below `glsl/`, for the binary's: laws and effects that are compiled
/// at run time then agree with the shaders of [`Gpu::replace_shaders`].
#[cfg(feature = "tools")]
pub fn include(files: std::collections::BTreeMap<String, String>) {
    reload::include(files);
}
