// SPDX-License-Identifier: MIT OR Apache-2.0
//! GLSL to SPIR-V through shaderc. build.rs compiles the crate's own shaders with this file, and the crate compiles
//! those that users write, at run time: one set of options for both.

use std::fmt;

/// Stage of a shader.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// `.comp`
    Compute,
    /// `.vert`
    Vertex,
    /// `.geom`
    Geometry,
    /// `.frag`
    Fragment,
}

impl Stage {
    /// The stage that a file extension stands for.
    pub fn of_extension(extension: &str) -> Option<Self> {
        match extension {
            "comp" => Some(Self::Compute),
            "vert" => Some(Self::Vertex),
            "geom" => Some(Self::Geometry),
            "frag" => Some(Self::Fragment),
            _ => None,
        }
    }
}

/// Tells one text from another (FNV-1a): whether a file is still what the binary was made from.
pub fn hash(text: &str) -> u64 {
    text.bytes()
        .fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

/// GLSL that does not compile: the compiler's own lines, each with file and line, and an excerpt of the first.
#[derive(Debug)]
pub struct CompileError {
    /// What shaderc printed.
    pub log: String,
    /// `   12 | the line` of the first error, empty if it lies in an include or is not known.
    pub excerpt: String,
}

impl fmt::Display for CompileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.log.trim_end())?;
        if !self.excerpt.is_empty() {
            write!(f, "\n{}", self.excerpt)?;
        }
        Ok(())
    }
}

impl std::error::Error for CompileError {}

/// A compiler with its include files.
pub struct Compiler {
    compiler: shaderc::Compiler,
    options: shaderc::CompileOptions<'static>,
}

impl Compiler {
    /// `include` gives the text of `#include "module/file.glsl"`.
    ///
    /// # Errors
    /// If shaderc cannot start.
    pub fn new(include: impl Fn(&str) -> Option<String> + 'static) -> Result<Self, CompileError> {
        let failed = |e: shaderc::Error| CompileError { log: e.to_string(), excerpt: String::new() };
        let mut options = shaderc::CompileOptions::new().map_err(failed)?;
        options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
        options.set_optimization_level(shaderc::OptimizationLevel::Performance);
        // The optimizer strips OpName and OpMemberName unless debug information is asked for, and with them go the
        // layout checks and the source view of GPU profilers.
        options.set_generate_debug_info();
        options.set_warnings_as_errors();
        options.set_include_callback(move |name, _, from, _| match include(name) {
            Some(content) => Ok(shaderc::ResolvedInclude { resolved_name: name.into(), content }),
            None => Err(format!("no include `{name}`, asked for by {from}")),
        });
        Ok(Self { compiler: shaderc::Compiler::new().map_err(failed)?, options })
    }

    /// Compiles the text `source` of `file`.
    ///
    /// # Errors
    /// [`CompileError`], warnings included.
    pub fn compile(&self, source: &str, file: &str, stage: Stage) -> Result<Vec<u32>, CompileError> {
        let kind = match stage {
            Stage::Compute => shaderc::ShaderKind::Compute,
            Stage::Vertex => shaderc::ShaderKind::Vertex,
            Stage::Geometry => shaderc::ShaderKind::Geometry,
            Stage::Fragment => shaderc::ShaderKind::Fragment,
        };
        match self.compiler.compile_into_spirv(source, kind, file, "main", Some(&self.options)) {
            Ok(artifact) => Ok(artifact.as_binary().to_vec()),
            Err(error) => {
                let log = error.to_string();
                Err(CompileError { excerpt: excerpt(&log, source, file), log })
            }
        }
    }
}

/// The line of `source` that the first `file:LINE:` of `log` names.
fn excerpt(log: &str, source: &str, file: &str) -> String {
    let line = log.split(&format!("{file}:")).nth(1).and_then(|rest| rest.split(':').next());
    let line = line.and_then(|number| number.trim().parse::<usize>().ok());
    let text = line.and_then(|number| Some((number, source.lines().nth(number.checked_sub(1)?)?)));
    text.map_or(String::new(), |(number, text)| format!("{number:5} | {text}"))
}
