// SPDX-License-Identifier: MIT OR Apache-2.0
//! Structs that cross to the host lie there as the shaders say.

use std::mem::{offset_of, size_of};
use whitecap::{
    gpu::reflect::{reflect, Struct},
    particles::{colliding::NearParams, Colliding, Drag, EmitterState, EmitterWords, PoolState, StepParams},
    shaders,
};

fn structs(spv: &[u8], name: &str) -> Struct {
    let all = reflect(spv, &[8; 8]).unwrap().structs;
    all.get(name).unwrap_or_else(|| panic!("no struct `{name}`, only {:?}", all.keys())).clone()
}

/// `assert_layout!(spv, "GlslName" == rust::Type { fields })`.
macro_rules! assert_layout {
    ($spv:expr, $glsl:literal == $rust:ident { $($field:ident),* $(,)? }) => {{
        let glsl = structs($spv, $glsl);
        let fields: Vec<_> = glsl.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
        assert_eq!(fields, [$((stringify!($field), offset_of!($rust, $field))),*], "fields of `{}`", $glsl);
        assert_eq!(glsl.bytes, size_of::<$rust>(), "size of `{}`", $glsl);
    }};
}

#[test]
fn structs_of_particles() {
    for spv in [shaders::PARTICLES_PREPARE_COMP, shaders::PARTICLES_DRAG_COMP] {
        // The push block holds one struct.
        assert_layout!(
            spv,
            "StepParams" == StepParams { now, dt_ticks, dt_s, life_ticks, seed, capacity, stride, emitters }
        );
        assert_layout!(
            spv,
            "PoolState"
                == PoolState {
                    groups_x,
                    groups_y,
                    groups_z,
                    slots,
                    quad_vertices,
                    quad_instances,
                    quad_first_vertex,
                    quad_first_instance,
                    point_vertices,
                    point_instances,
                    point_first_vertex,
                    point_first_instance,
                    reader_groups_x,
                    reader_groups_y,
                    reader_groups_z,
                    first,
                    capacity,
                    stride,
                    now,
                    life_ticks,
                    sources,
                    births,
                    appended,
                    free_first,
                    free_count,
                    taken,
                    turn,
                    finished,
                    born,
                    dropped,
                    aged,
                    ended,
                    spoiled,
                    born_high,
                    dropped_high,
                    aged_high,
                    ended_high,
                    spoiled_high,
                }
        );
        assert_layout!(
            spv,
            "EmitterState"
                == EmitterState {
                    next_low,
                    next_high,
                    serial,
                    first,
                    from_low,
                    from_high,
                    from_serial,
                    births
                }
        );
        let emitter = structs(spv, "Emitter");
        let offset = |name: &str| emitter.members.iter().find(|m| m.name == name).unwrap().offset;
        let vector = |at: usize| [at, at + 4, at + 8];
        assert_eq!(["at_x_m", "at_y_m", "at_z_m"].map(offset), vector(offset_of!(EmitterWords, at_m)));
        let velocity = ["velocity_x_mps", "velocity_y_mps", "velocity_z_mps"].map(offset);
        assert_eq!(velocity, vector(offset_of!(EmitterWords, velocity_mps)));
        let rest = ["speed_mps", "period_low", "period_high", "batch", "corners", "stream"].map(offset);
        assert_eq!(
            rest,
            [
                offset_of!(EmitterWords, speed_mps),
                offset_of!(EmitterWords, period_low),
                offset_of!(EmitterWords, period_high),
                offset_of!(EmitterWords, batch),
                offset_of!(EmitterWords, corners),
                offset_of!(EmitterWords, stream),
            ]
        );
        assert_eq!(emitter.bytes, size_of::<EmitterWords>());
    }
    let law = structs(shaders::PARTICLES_DRAG_COMP, "DragLaw");
    let offsets: Vec<_> = law.members.iter().map(|m| (m.name.as_str(), m.offset)).collect();
    assert_eq!(offsets, [("pull_x", 0), ("pull_y", 4), ("pull_z", 8), ("drag_per_s", 12)]);
    assert_eq!((offset_of!(Drag, drag_per_s), size_of::<Drag>()), (12, law.bytes));
}

#[test]
fn structs_of_the_colliding_law() {
    let law = structs(shaders::PARTICLES_COLLIDING_COMP, "CollidingLaw");
    let offset = |name: &str| law.members.iter().find(|m| m.name == name).unwrap().offset;
    let want = [
        ("grid", offset_of!(Colliding, grid)),
        ("gravity_x_mps2", offset_of!(Colliding, gravity_mps2)),
        ("gravity_y_mps2", offset_of!(Colliding, gravity_mps2) + 4),
        ("gravity_z_mps2", offset_of!(Colliding, gravity_mps2) + 8),
        ("radius_m", offset_of!(Colliding, radius_m)),
        ("restitution", offset_of!(Colliding, restitution)),
        ("friction", offset_of!(Colliding, friction)),
        ("slack_m", offset_of!(Colliding, slack_m)),
        ("surface_mps", offset_of!(Colliding, surface_mps)),
        ("lead_s", offset_of!(Colliding, lead_s)),
        ("source", offset_of!(Colliding, source)),
        ("sources", offset_of!(Colliding, sources)),
        ("respawns", offset_of!(Colliding, respawns)),
        ("floor_m", offset_of!(Colliding, floor_m)),
        ("emitter_x_m", offset_of!(Colliding, emitter_m)),
        ("emitter_y_m", offset_of!(Colliding, emitter_m) + 4),
        ("emitter_z_m", offset_of!(Colliding, emitter_m) + 8),
        ("emitter_radius_m", offset_of!(Colliding, emitter_radius_m)),
        ("seed", offset_of!(Colliding, seed)),
    ];
    assert_eq!(law.members.len(), want.len());
    for (name, at) in want {
        assert_eq!(offset(name), at, "{name}");
    }
    assert_eq!(law.bytes, size_of::<Colliding>());
    assert_layout!(
        shaders::PARTICLES_NEAR_COMP,
        "NearParams" == NearWords { cells_x, cells_y, cells_z, reach, cell_m }
    );
    assert_eq!(size_of::<NearParams>(), size_of::<NearWords>());
    assert_eq!(offset_of!(NearParams, reach), offset_of!(NearWords, reach));
}

/// [`NearParams`] with the names of the shader.
#[allow(dead_code)]
#[repr(C)]
struct NearWords {
    cells_x: u32,
    cells_y: u32,
    cells_z: u32,
    reach: u32,
    cell_m: f32,
}
