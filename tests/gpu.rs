// SPDX-License-Identifier: MIT OR Apache-2.0
//! The Vulkan core: structs that cross to the GPU are laid out as the SPIR-V declares, kernels that disagree with their
//! shaders are refused, devices are chosen by name, what is not done in time is waited for, and the embedding example runs as it is.
#![allow(missing_docs)]

mod common;

#[allow(dead_code)]
#[path = "../examples/embed.rs"]
mod embed;

#[path = "gpu/timeout.rs"]
mod timeout;

use std::mem::{offset_of, size_of};
use whitecap::{
    draw,
    gpu::{
        compiler, glsl,
        reflect::{reflect, Interface},
        Buffer, Error, Gpu, GpuOptions, Kernel, KernelInfo, Residence,
    },
    impact, shaders,
    water::{self, book},
};

fn interface(spv: &[u8]) -> Interface {
    reflect(spv, &[8, 8, 1, 0]).unwrap()
}

/// `assert_layout!(interface, "GlslName" == rust::Type { a, b, c })`, with every field.
macro_rules! assert_layout {
    ($interface:expr, $glsl:literal == $rust:ty { $($field:ident),* $(,)? }) => {{
        let (structs, name) = ($interface.structs, $glsl);
        let glsl = structs.get(name).unwrap_or_else(|| panic!("no struct `{name}`, only {:?}", structs.keys()));
        let fields: Vec<_> = glsl.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
        assert_eq!(fields, [$((stringify!($field), offset_of!($rust, $field))),*], "fields of `{name}`");
        assert_eq!(glsl.bytes, size_of::<$rust>(), "size of `{name}`");
    }};
}

#[test]
fn impact_structs() {
    for spv in [shaders::IMPACT_CLOSE_COMP, shaders::IMPACT_LOCATE_COMP] {
        assert_layout!(
            interface(spv),
            "ImpactCount"
                == impact::Count {
                    count,
                    capacity,
                    dropped_low,
                    dropped_high,
                    groups_x,
                    groups_y,
                    groups_z,
                    appended,
                    quad_vertices,
                    quad_instances,
                    quad_first_vertex,
                    quad_first_instance,
                    stored_low,
                    stored_high
                }
        );
    }
    let locate = interface(shaders::IMPACT_LOCATE_COMP);
    assert_layout!(
        locate,
        "Impact"
            == impact::Impact {
                at_m,
                order,
                normal,
                impulse_mps,
                velocity_mps,
                triangle,
                u,
                v,
                mesh,
                source
            }
    );
    assert_layout!(interface(shaders::IMPACT_LOCATE_COMP), "LocateParams" == impact::LocateParams { meshes });
}

#[test]
fn water_structs() {
    for spv in [
        shaders::WATER_BOOK_COMP,
        shaders::WATER_WAVES_COMP,
        shaders::WATER_FUSED_COMP,
        shaders::WATER_PIPES_COMP,
        shaders::WATER_PIPES_FUSED_COMP,
    ] {
        assert_layout!(
            interface(spv),
            "WaterParams" == water::Params { cells, pitch, dt_s, pull, keep, diagonal, folded }
        );
    }
    assert_layout!(interface(shaders::WATER_BOOK_COMP), "Column" == book::Column { height_m, flow_mps });
    for spv in [shaders::WATER_WEIGH_COMP, shaders::WATER_DISTURB_COMP] {
        assert_layout!(
            interface(spv),
            "DisturbParams" == water::DisturbParams { cells, pitch, stride, cell_m, limit_m, has_velocity }
        );
    }
    for spv in [shaders::WATER_WEIGH_COMP, shaders::WATER_DISTURB_COMP, shaders::WATER_SPLASH_COMP] {
        assert_layout!(
            interface(spv),
            "Disturbance"
                == water::Disturbance { at_m, radius_m, volume_m3, push_m3ps, scale, tied, reserved }
        );
    }
    assert_layout!(
        interface(shaders::WATER_SPLASH_COMP),
        "SplashParams"
            == water::SplashParams {
                cells,
                pitch,
                stride,
                corner_m,
                cell_m,
                radius_m,
                volume_m3,
                push_m2,
                items,
                reserved
            }
    );
    assert_layout!(
        interface(shaders::WATER_WEIGH_COMP),
        "Counters" == water::Counts { applied, rejected, missed }
    );
    assert_layout!(
        interface(shaders::WATER_FOURTH_COMP),
        "Push" == water::FourthParams { cells, pitch, dt_s, pull, keep, sharpen, reserved }
    );
    for spv in [shaders::WATER_DRAUGHT_COMP, shaders::WATER_BODY_COMP] {
        assert_layout!(
            interface(spv),
            "BodyParams" == water::BodyParams { cells, origin, size, pitch, stride, first, count, cell_m }
        );
        assert_layout!(
            interface(spv),
            "Body" == water::bodies::Pose { at_m, is_box, half_m, submerged_m3, axis, scale, displaced_m3 }
        );
    }
    for spv in [shaders::WATER_SURFACE_VERT, shaders::WATER_SURFACE_FRAG, shaders::WATER_WIRE_VERT] {
        assert_layout!(
            interface(spv),
            "SurfaceParams"
                == water::draw::SurfaceParams {
                    cells,
                    pitch,
                    stride,
                    size_m,
                    level_m,
                    ripple,
                    foam_m,
                    speeds,
                    white_mps
                }
        );
    }
}

#[test]
fn views() {
    for spv in [shaders::DRAW_SKY_FRAG, shaders::DRAW_TERRAIN_VERT, shaders::DRAW_LIGHT_COMP] {
        assert_layout!(
            interface(spv),
            "View"
                == draw::View {
                    clip_from_world,
                    eye_m,
                    ray_right,
                    ray_up,
                    ray_forward,
                    to_sun,
                    terrain_size_m,
                    terrain_cells,
                    pixels,
                    daylight,
                    reserved,
                    lamp_m,
                    lamp
                }
        );
    }
}

#[test]
fn every_shader_can_be_reflected() {
    assert!(shaders::ALL.len() > 10);
    for (name, spv) in shaders::ALL {
        let interface = reflect(spv, &[8, 8, 1, 0]).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(interface.local_size.is_some(), name.ends_with(".comp"), "{name}");
    }
}

#[test]
fn the_workgroup_is_the_one_that_was_asked_for() {
    let size = |constants: &[u32]| reflect(shaders::WATER_WAVES_COMP, constants).unwrap().local_size;
    assert_eq!(size(&[16, 4, 1, 0]), Some([16, 4, 1]));
    assert_eq!(interface(shaders::WATER_BOOK_COMP).local_size, Some([16, 16, 1]));
    // A size that nobody sets must not become 1 by accident.
    assert_eq!(reflect(shaders::WATER_WAVES_COMP, &[16]).unwrap_err(), "constant_id 1 is not set");
}

#[test]
#[should_panic(expected = "fields of `WaterParams`")]
fn swapped_fields_are_caught() {
    assert_layout!(
        interface(shaders::WATER_BOOK_COMP),
        "WaterParams" == water::Params { pitch, cells, dt_s, pull, keep, diagonal, folded }
    );
}

#[test]
#[should_panic(expected = "size of `Counters`")]
fn a_field_too_many_is_caught() {
    #[repr(C)]
    #[allow(dead_code)]
    struct Longer {
        applied: u32,
        rejected: u32,
        missed: u32,
        added: u32,
    }
    assert_layout!(interface(shaders::WATER_WEIGH_COMP), "Counters" == Longer { applied, rejected, missed });
}

const WAVES: KernelInfo<'_> = KernelInfo {
    name: c"water.waves",
    spv: shaders::WATER_WAVES_COMP,
    blocks: &["Height", "Velocity", "NewHeight"],
    constants: &[8, 8, 1, 0],
};

#[test]
fn a_kernel_that_disagrees_with_its_shader_is_refused() {
    let gpu = common::gpu();
    let text = |e: Option<Error>| e.unwrap().to_string();
    assert_eq!(
        text(Kernel::new::<[u32; 2]>(&gpu, &WAVES).err()),
        "kernel `water.waves`: push constants: 32 bytes in GLSL, 8 in Rust"
    );
    let swapped = KernelInfo { blocks: &["Velocity", "Height", "NewHeight"], ..WAVES };
    assert_eq!(
        text(Kernel::new::<water::Params>(&gpu, &swapped).err()),
        r#"kernel `water.waves`: bindings are ["Height", "Velocity", "NewHeight"] in GLSL, ["Velocity", "Height", "NewHeight"] in Rust"#
    );
    assert_eq!(
        text(Kernel::new::<water::Params>(&gpu, &KernelInfo { constants: &[8, 8, 1, 0, 5], ..WAVES }).err()),
        "kernel `water.waves`: constant_ids [0, 1, 2, 3] in GLSL, 5 constants in Rust"
    );
    assert_eq!(
        text(Kernel::new::<water::Params>(&gpu, &KernelInfo { spv: b"GLSL", ..WAVES }).err()),
        "kernel `water.waves`: not SPIR-V"
    );
    let huge =
        text(Kernel::new::<water::Params>(&gpu, &KernelInfo { constants: &[64, 64, 1, 0], ..WAVES }).err());
    assert!(huge.starts_with("kernel `water.waves`: workgroup [64, 64, 1], and "), "{huge}");
}

#[test]
fn buffers_bound_under_the_wrong_name_are_refused() {
    let gpu = common::gpu();
    let kernel = Kernel::new::<water::Params>(&gpu, &WAVES).unwrap();
    let buffer = Buffer::new(&gpu, "test", 64, Residence::Device).unwrap();
    let error = kernel.bind(&[("Velocity", (&buffer).into()), ("Height", (&buffer).into())]).err().unwrap();
    assert_eq!(
        error.to_string(),
        r#"kernel `water.waves`: bindings are ["Height", "Velocity", "NewHeight"], bound are ["Velocity", "Height"]"#
    );
}

#[test]
fn no_room_names_the_buffer_and_the_limit() {
    let gpu = common::gpu();
    let over = u64::from(gpu.limits().max_storage_buffer_range) + 4;
    let error = Buffer::new(&gpu, "water.height_m", over, Residence::Device).err().unwrap();
    assert!(error.to_string().starts_with(&format!("`water.height_m` needs {over}, and ")), "{error}");
    let error = Buffer::new(&gpu, "water.height_m", 1 << 41, Residence::Readback).err().unwrap();
    assert!(error.to_string().contains("`water.height_m`"), "{error}");
}

/// What `spirv-val` says of every shader; it comes with the packages that `./dev` installs.
#[test]
fn every_shader_is_valid_spirv() {
    let dir = tempfile::tempdir().unwrap();
    for (name, spv) in shaders::ALL {
        let path = dir.path().join(name);
        std::fs::write(&path, spv).unwrap();
        let said =
            std::process::Command::new("spirv-val").args(["--target-env", "vulkan1.3"]).arg(&path).output();
        match said {
            Ok(said) => assert!(said.status.success(), "{name}: {}", String::from_utf8_lossy(&said.stderr)),
            Err(_) => return println!("SKIP: no spirv-val on this machine"),
        }
    }
}

const DOUBLED: &str = r#"#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/land.glsl"
layout(local_size_x = 64) in;
layout(set = 0, binding = 0, std430) buffer Numbers { float numbers[]; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(numbers.length()) && numbers[i] != LAND_M) numbers[i] *= 2.0;
}
"#;

#[test]
fn a_users_kernel_is_compiled_and_run_at_run_time() {
    let gpu = common::gpu();
    let words = compiler().unwrap().compile(DOUBLED, "mine.comp", glsl::Stage::Compute).unwrap();
    let spv: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let info = KernelInfo { name: c"user.doubled", spv: &spv, blocks: &["Numbers"], constants: &[] };
    let numbers = gpu.upload("test.numbers", &[1.0f32, water::LAND_M, -3.5]).unwrap();
    let bound = Kernel::new::<()>(&gpu, &info).unwrap().bind(&[("Numbers", (&numbers).into())]).unwrap();
    gpu.once(|rec| rec.dispatch(&bound, [3, 1, 1], &())).unwrap();
    assert_eq!(gpu.download::<f32>(&numbers).unwrap(), [2.0, water::LAND_M, -7.0]);
}

#[test]
fn a_shader_that_does_not_compile_is_shown_with_file_line_and_excerpt() {
    let compile =
        |source: &str| compiler().unwrap().compile(source, "mine.comp", glsl::Stage::Compute).unwrap_err();
    let error = compile(&DOUBLED.replace("*= 2.0", "*= two")).to_string();
    assert!(error.contains("mine.comp:8: error: 'two' : undeclared identifier"), "{error}");
    assert!(
        error.ends_with(
            "    8 |     if (i < uint(numbers.length()) && numbers[i] != LAND_M) numbers[i] *= two;"
        ),
        "{error}"
    );
    let error = compile(&DOUBLED.replace("water/land.glsl", "water/lava.glsl")).to_string();
    assert!(error.contains("no include `water/lava.glsl`"), "{error}");
}

#[test]
fn the_embedding_example_makes_waves_on_a_device_of_its_own() {
    let _alone = common::gpu();
    let highest = embed::run().unwrap();
    assert!((0.02..2.0).contains(&highest), "{highest} m");
}

#[test]
fn a_device_is_chosen_by_index_uuid_or_part_of_its_name() {
    let _alone = common::gpu();
    let all = Gpu::adapters().unwrap();
    let first = &all[0];
    let open =
        |device: &str| Gpu::headless(&GpuOptions { device: Some(device.into()), ..Default::default() });
    let part = first.name[1..4].to_uppercase();
    for device in ["0", &first.uuid, &part, &first.name] {
        assert_eq!(open(device).unwrap().name(), first.name, "{device}");
    }
    let error = open("no such device").err().unwrap();
    assert!(matches!(error, Error::NoSuchDevice { .. }));
    assert!(error.to_string().contains(&first.uuid), "{error}");
}

#[test]
fn the_pipeline_cache_is_kept_in_a_file_and_a_damaged_one_does_no_harm() {
    let _alone = common::gpu();
    let dir = tempfile::tempdir().unwrap();
    let options = GpuOptions { cache: Some(dir.path().join("cache")), ..Default::default() };
    let build = || {
        let gpu = Gpu::headless(&options).unwrap();
        Kernel::new::<water::Params>(&gpu, &WAVES).unwrap();
    };
    build();
    let files: Vec<_> = std::fs::read_dir(dir.path().join("cache")).unwrap().flatten().collect();
    assert_eq!(files.len(), 1, "{files:?}");
    let path = files[0].path();
    assert!(std::fs::metadata(&path).unwrap().len() > 16);
    std::fs::write(&path, b"not a pipeline cache").unwrap();
    build();
    assert!(std::fs::read(&path).unwrap() != b"not a pipeline cache");
}
