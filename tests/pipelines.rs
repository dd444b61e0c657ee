// SPDX-License-Identifier: MIT OR Apache-2.0
//! `whitecap devices --pipelines`: every shader of the crate is in some pipeline, and what is said of it is true.
#![cfg(feature = "tools")]
#![allow(missing_docs)]

use serde_json::Value;
use std::{collections::BTreeSet, process::Command};
use whitecap::shaders;

fn pipelines(filter: &[&str]) -> Value {
    let output = Command::new(env!("CARGO_BIN_EXE_whitecap"))
        .args(["devices", "--pipelines", "--json"])
        .args(filter)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn every_shader_is_in_a_pipeline() {
    let all = pipelines(&[]);
    let of = |it: &Value| {
        let shaders = it["shaders"].as_array().unwrap().iter();
        shaders.map(|name| name.as_str().unwrap().to_string()).collect::<Vec<_>>()
    };
    let list = all["pipelines"].as_array().unwrap();
    let built: BTreeSet<String> = list.iter().flat_map(of).collect();
    let devices = Command::new(env!("CARGO_BIN_EXE_whitecap")).args(["devices", "--json"]).output().unwrap();
    let devices: Value = serde_json::from_slice(&devices.stdout).unwrap();
    let optional = &devices[0]["optional"];
    let has = |what: &str| optional[what] == true;
    let mut missing = Vec::new();
    for (name, _) in shaders::ALL {
        // What a device lacks is not built on it.
        let is_there = match *name {
            name if name.ends_with(".geom") || name.ends_with("point.vert") => has("geometryShader"),
            name if name.ends_with("_subgroup.comp") => has("subgroup arithmetic"),
            name if name.contains("_packed.") => has("atomics of 64 bits"),
            name if name.contains("_stream.") || name.contains(".stream.") => has("transform feedback"),
            _ => true,
        };
        if is_there && !built.contains(*name) {
            missing.push(*name);
        }
    }
    assert!(missing.is_empty(), "in no pipeline, to be added to study/pipelines.rs: {missing:?}");
    // A kernel has a workgroup, and what is drawn has none.
    for it in list {
        let is_kernel = of(it).first().is_some_and(|name| name.ends_with(".comp"));
        assert!(!is_kernel || it["workgroup"].is_array(), "{it}");
        assert!(!is_kernel || it["declared_shared_bytes"].is_u64(), "{it}");
    }
    let says_executables = has("pipeline executable properties");
    for it in list.iter().flat_map(|it| it["executables"].as_array().unwrap()) {
        assert_eq!(it["statistics"].is_object(), says_executables, "{it}");
    }
    let absent = all["absent"].to_string();
    assert_eq!(absent.contains("VK_KHR_pipeline_executable_properties"), !says_executables, "{absent}");
}

#[test]
fn shared_memory_is_what_the_shader_declares() {
    // One run for all three names: each builds every pipeline there is.
    let named = ["water.book", "water.fused", "gpu.copy"];
    let found = pipelines(&named);
    let list = found["pipelines"].as_array().unwrap();
    let is_named = |it: &Value| named.iter().any(|name| it["name"].as_str().unwrap().contains(name));
    assert!(list.iter().all(is_named), "{found}");
    let of = |name: &str| list.iter().filter(|it| it["name"] == name).collect::<Vec<_>>();
    // The book's tile: 18 x 18 columns of a height and four flows of 4 bytes.
    assert_eq!(of("water.book")[0]["declared_shared_bytes"], 18 * 18 * 20, "{found}");
    // Two floats a column of a tile and buffer: its constants are the workgroup, lanes, rows, steps and buffers.
    for it in of("water.fused") {
        assert!(it["declared_shared_bytes"].as_u64().unwrap() > 0, "{it}");
    }
    assert_eq!(of("gpu.copy")[0]["declared_shared_bytes"], 0);
}

#[test]
fn a_filter_that_names_nothing_is_an_error() {
    let run = |args: &[&str]| Command::new(env!("CARGO_BIN_EXE_whitecap")).args(args).output().unwrap();
    assert_eq!(run(&["devices", "--pipelines", "no.such"]).status.code(), Some(2));
    assert_eq!(run(&["devices", "water"]).status.code(), Some(2), "a filter without --pipelines");
}

/// Mesa compiles for AMD without any hardware, and says what became of it.
#[test]
fn what_a_driver_says_is_read() {
    let folders = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d"];
    let files = folders.iter().flat_map(|folder| std::fs::read_dir(folder).into_iter().flatten().flatten());
    let is_radv = |path: &std::path::PathBuf| path.to_string_lossy().contains("radeon_icd");
    let Some(driver) = files.map(|it| it.path()).find(is_radv) else {
        println!("SKIP: Mesa's driver for AMD is not installed");
        return;
    };
    let output = Command::new(env!("CARGO_BIN_EXE_whitecap"))
        .args(["devices", "--pipelines", "--json", "--device", "0", "water"])
        .envs([("VK_DRIVER_FILES", &driver), ("VK_ICD_FILENAMES", &driver)])
        .env("RADV_FORCE_FAMILY", "navi21")
        .output()
        .unwrap();
    let Ok(all) = serde_json::from_slice::<Value>(&output.stdout) else {
        println!("SKIP: no device without hardware: {}", String::from_utf8_lossy(&output.stderr));
        return;
    };
    assert!(all["device"].as_str().unwrap().starts_with("Null hardware"), "{}", all["device"]);
    let list = all["pipelines"].as_array().unwrap();
    assert!(list.len() > 20, "{} pipelines", list.len());
    for it in list {
        let executables = it["executables"].as_array().unwrap();
        assert_eq!(executables.len(), 1, "{it}");
        let executable = &executables[0];
        assert!((1..=256).contains(&executable["registers"].as_u64().unwrap()), "{it}");
        assert!(executable["binary_bytes"].as_u64().unwrap() > 0, "{it}");
        assert_eq!(executable["subgroup"], 64, "{it}");
        assert!(executable["statistics"].as_object().unwrap().len() > 3, "{it}");
        // What the SPIR-V declares, rounded up to the grain of the hardware: half a kilobyte.
        let declared = it["declared_shared_bytes"].as_u64().unwrap();
        assert_eq!(executable["shared_bytes"], declared.next_multiple_of(512), "{it}");
        assert!(executable["occupancy"].is_null(), "it is not known here: {it}");
    }
}
