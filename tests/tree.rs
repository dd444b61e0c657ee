// SPDX-License-Identifier: MIT OR Apache-2.0
//! The tree keeps what its documents promise: who may use whom, and the porting sheet of the README.
#![allow(missing_docs)]

use std::{fs, path::Path};
use whitecap::{gpu::reflect::reflect, shaders};

/// Modules from the bottom up; one uses those below it, and simulations do not use each other.
const LAYERS: &[&[&str]] = &[
    &["gpu", "clock", "check", "random"],
    &["prims", "mesh", "impact", "cells"],
    &["draw"],
    &["water", "particles", "ballistic", "disks", "paint", "volume"],
    &["scene"],
    &["run"],
    &["study", "view"],
    &["cli"],
];

fn layer(module: &str) -> usize {
    let found = LAYERS.iter().position(|layer| layer.contains(&module));
    found.unwrap_or_else(|| panic!("module `{module}` has no layer: add it to the list"))
}

fn rust_files(dir: &Path, found: &mut Vec<String>) {
    for path in fs::read_dir(dir).unwrap().flatten().map(|entry| entry.path()) {
        if path.is_dir() {
            rust_files(&path, found);
        } else if path.extension().is_some_and(|e| e == "rs") {
            found.push(path.to_string_lossy().into_owned());
        }
    }
}

/// Modules that a file names after `crate::` (or, in the tool, `whitecap::`).
fn used(text: &str) -> Vec<String> {
    let mut modules = Vec::new();
    for part in ["crate::", "whitecap::"].iter().flat_map(|prefix| text.split(*prefix).skip(1)) {
        let names: Vec<&str> = if let Some(list) = part.strip_prefix('{') {
            // A list such as `{gpu::{Buffer, Gpu}, scene::Scene}`: what stands at its own depth.
            let (mut depth, mut names, mut start) = (0, Vec::new(), 0);
            for (i, c) in list.char_indices() {
                match c {
                    '{' => depth += 1,
                    '}' if depth == 0 => {
                        names.push(&list[start..i]);
                        break;
                    }
                    '}' => depth -= 1,
                    ',' if depth == 0 => {
                        names.push(&list[start..i]);
                        start = i + 1;
                    }
                    _ => {}
                }
            }
            names
        } else {
            vec![part]
        };
        for name in names {
            let name = name.trim_start();
            let end = name.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(name.len());
            if !name[..end].is_empty() && name[..end].starts_with(|c: char| c.is_lowercase()) {
                modules.push(name[..end].to_string());
            }
        }
    }
    modules
}

#[test]
fn dependencies_point_down() {
    let mut files = Vec::new();
    rust_files(Path::new("src"), &mut files);
    assert!(files.len() > 40, "{} files", files.len());
    let mut arrows = 0;
    for file in files {
        let module = file.split(['/', '\\']).nth(1).unwrap().trim_end_matches(".rs").to_string();
        if module == "lib" || module == "main" {
            continue;
        }
        let text = fs::read_to_string(&file).unwrap();
        // The tool's own modules are `super` there, and shaders are data.
        for other in used(&text).into_iter().filter(|other| *other != "shaders" && *other != module) {
            assert!(layer(&other) < layer(&module), "{file} uses `{other}`, which is not below `{module}`");
            arrows += 1;
        }
    }
    assert!(arrows > 50, "{arrows} uses found: the reader is blind");
}

#[test]
fn twins_know_nothing_of_the_gpu() {
    for file in [
        "src/ballistic/cpu.rs",
        "src/ballistic/cpu_kindled.rs",
        "src/impact/cpu.rs",
        "src/paint/cpu.rs",
        "src/particles/cpu.rs",
        "src/prims/cpu.rs",
        "src/volume/cpu.rs",
        "src/water/cpu.rs",
        "src/water/oracle.rs",
        "src/water/starts.rs",
        "src/random.rs",
    ] {
        let text = fs::read_to_string(file).unwrap();
        assert!(!text.contains("crate::gpu") && !text.contains("ash::"), "{file}");
    }
}

/// Whether `word` stands in a text, and not as the end of another word, as `ash::` in `splash::`.
fn has_word(text: &str, word: &str) -> bool {
    let is_end = |at: usize| text[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
    text.match_indices(word).any(|(at, _)| !is_end(at))
}

#[test]
fn a_word_is_not_the_end_of_another() {
    assert!(has_word("use ash::vk;", "ash::") && has_word("(ash::vk, splash::x)", "ash::"));
    assert!(!has_word("splash::Hit", "ash::"));
}

#[test]
fn only_the_core_calls_vulkan() {
    let mut files = Vec::new();
    rust_files(Path::new("src"), &mut files);
    for file in files.into_iter().filter(|file| !file.starts_with("src/gpu/")) {
        if file == "src/view/paint.rs" {
            continue; // hands the panel's renderer its device and commands
        }
        let text = fs::read_to_string(&file).unwrap();
        for word in ["unsafe {", "gpu_allocator", "ash::"] {
            assert!(!has_word(&text, word), "{file}: {word}");
        }
    }
}

/// Every kernel has its row: of water in the README, of the others in a file of `docs`.
#[test]
fn the_porting_sheets_are_what_the_shaders_say() {
    let mut rows = 0;
    let readme = fs::read_to_string("README.md").unwrap();
    let docs: String = fs::read_dir("docs")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .map(|path| fs::read_to_string(path).unwrap())
        .collect();
    for (name, spv) in shaders::ALL.iter().filter(|(name, _)| name.ends_with(".comp")) {
        let kernel = name.trim_end_matches(".comp");
        let (module, pass) = kernel.split_once('.').unwrap();
        // The same pass with its sums in subgroups: one row for both.
        if matches!(module, "gpu" | "draw") || pass.ends_with("_subgroup") {
            continue;
        }
        let sheet = if module == "water" { &readme } else { &docs };
        let row = sheet.lines().find(|line| line.starts_with(&format!("| `{kernel}` |")));
        let row = row.unwrap_or_else(|| panic!("`{kernel}` has no row"));
        let cells: Vec<&str> = row.split('|').collect();
        let interface = reflect(spv, &[8; 8]).unwrap();
        let mut rest = cells[2];
        for block in interface.blocks.values() {
            let at = rest.find(&format!("`{}` ({}", block.name, block.access));
            let at = at.unwrap_or_else(|| {
                panic!("`{kernel}`: `{}` ({}) not in order in {}", block.name, block.access, cells[2])
            });
            rest = &rest[at + 1..];
        }
        let bytes = format!("{} bytes", interface.push_bytes);
        assert!(cells[3].contains(&bytes), "`{kernel}`: {bytes}, not {}", cells[3]);
        rows += 1;
    }
    assert!(rows > 20, "{rows} kernels found");
}
