// SPDX-License-Identifier: MIT OR Apache-2.0
//! Laws: functions in GLSL that move a particle.

use std::ffi::CStr;

/// How particles move: the advance with a law in it.
#[derive(Clone, Copy, Debug)]
pub struct Law<'a> {
    /// `particles.LAW`: debug label and row of the bench.
    pub name: &'static CStr,
    /// The law, then `particles/advance.glsl`, compiled.
    pub spv: &'a [u8],
    /// The same with SUBGROUPS defined, for [`Compaction::Subgroup`](super::Compaction::Subgroup).
    pub subgroups: Option<&'a [u8]>,
    /// Name and code of the pass for those whom `spv` puts off (LAW_DEFERS): `advance` of the law with
    /// `particles/advance_deferred.glsl`. Such a law names `Deferred` first among its blocks.
    pub deferred: Option<(&'static CStr, &'a [u8])>,
    /// Specialization constants of the law, from `constant_id` 6 on.
    pub constants: &'a [u32],
    /// Blocks of the law beside its numbers, from binding 7 on: [`Particles::pool_with`](super::Particles::pool_with) binds
    /// them.
    pub blocks: &'a [&'a str],
}

/// SPIR-V of a law that a user wrote, the text of `file`: `glsl/particles/particle.glsl` says what is in one. It may include
/// what the crate's own shaders do.
///
/// # Errors
/// Of the compiler, with the lines of `file`.
#[cfg(feature = "tools")]
pub fn compile_law(source: &str, file: &str) -> Result<Vec<u8>, crate::gpu::glsl::CompileError> {
    use crate::gpu::glsl::Stage;
    let before = "#version 460\n#extension GL_GOOGLE_include_directive : require\n#include \"particles/particle.glsl\"\n";
    let text = format!("{before}#line 1\n{source}\n#include \"particles/advance.glsl\"\n");
    let compiled = crate::gpu::compiler()?.compile(&text, file, Stage::Compute);
    let words = compiled.map_err(|mut error| {
        // The line that the compiler names is one of `source`, not of the text around it.
        let line = error
            .log
            .split(&format!("{file}:"))
            .nth(1)
            .and_then(|rest| rest.split(':').next()?.parse::<usize>().ok());
        let found = line.and_then(|line| Some((line, source.lines().nth(line.checked_sub(1)?)?)));
        error.excerpt = found.map_or(String::new(), |(line, text)| format!("{line:5} | {text}"));
        error
    })?;
    Ok(words.into_iter().flat_map(u32::to_le_bytes).collect())
}
