// SPDX-License-Identifier: MIT OR Apache-2.0
//! Cells: the layout that shaders and host agree on, and which cell a place is in.
#![allow(missing_docs)]

mod common;

use common::gpu;
use glam::{ivec3, uvec3, vec3, IVec3, Vec3};
use std::mem::{offset_of, size_of};
use whitecap::{
    cells::{Cells, Grid, Plane},
    gpu::{compiler, glsl::Stage, reflect::reflect, Access, Kernel, KernelInfo},
};

/// Looks up as every user of cells does.
const LOOKUP: &str = "#version 460
layout(local_size_x = 64) in;
#define CELLS_OCCUPIED 1
#define CELLS_PLANES 2
#include \"cells/cells.glsl\"
struct LookupParams { Grid grid; uint count; };
layout(set = 0, binding = 0, std430) readonly buffer At { float at_m[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Found { ivec4 found[]; };
layout(push_constant, std430) uniform Push { LookupParams p; };
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= p.count) return;
    ivec3 cell = cell_of(p.grid, vec3(at_m[3u * i], at_m[3u * i + 1u], at_m[3u * i + 2u]));
    int flag = 0;
    if (in_grid(p.grid, cell)) {
        uint index = cell_index(p.grid, cell);
        flag = 1;
        if (is_occupied(index)) flag = 2 + int(plane_of(index, 1u).triangle);
    }
    found[i] = ivec4(cell, flag);
}";

fn lookup() -> Vec<u8> {
    let words = compiler().unwrap().compile(LOOKUP, "lookup.comp", Stage::Compute).unwrap();
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct LookupParams {
    grid: Grid,
    count: u32,
}

#[test]
fn grids_and_planes_are_laid_out_alike() {
    let interface = reflect(&lookup(), &[]).unwrap();
    let offsets = |name: &str| -> Vec<(String, usize)> {
        interface.structs[name].members.iter().map(|m| (m.name.clone(), m.offset)).collect()
    };
    let want = |list: &[(&str, usize)]| list.iter().map(|(n, o)| (n.to_string(), *o)).collect::<Vec<_>>();
    let (low, cells) = (offset_of!(Grid, low_m), offset_of!(Grid, cells));
    assert_eq!(
        offsets("Grid"),
        want(&[
            ("low_x_m", low),
            ("low_y_m", low + 4),
            ("low_z_m", low + 8),
            ("cell_m", offset_of!(Grid, cell_m)),
            ("cells_x", cells),
            ("cells_y", cells + 4),
            ("cells_z", cells + 8),
            ("mesh_triangles", offset_of!(Grid, mesh_triangles)),
        ])
    );
    assert_eq!(
        offsets("Plane"),
        want(&[
            ("normal", offset_of!(Plane, normal)),
            ("distance_m", offset_of!(Plane, distance_m)),
            ("velocity_mps", offset_of!(Plane, velocity_mps)),
            ("triangle", offset_of!(Plane, triangle)),
        ])
    );
    assert_eq!((interface.structs["Grid"].bytes, size_of::<Grid>()), (32, 32));
    assert_eq!((interface.blocks[&2].stride, size_of::<Plane>()), (32, 32));
    assert_eq!(interface.push_bytes, size_of::<LookupParams>());
}

#[test]
fn shaders_and_host_find_a_place_in_the_same_cell() {
    let gpu = gpu();
    let grid = Grid::new(vec3(-1.1, 0.3, -2.0), 0.13, uvec3(7, 5, 9));
    let cells = Cells::new(&gpu, grid).unwrap();
    let marked = ivec3(3, 2, 4);
    let index = grid.index(marked).unwrap();
    assert_eq!(grid.cell(index), marked);
    let mut bits = vec![0u32; grid.count().div_ceil(32)];
    bits[index / 32] |= 1 << (index % 32);
    gpu.upload_to(cells.occupied(), &bits).unwrap();
    let mut planes = vec![Plane::default(); 2 * grid.count()];
    planes[2 * index + 1].triangle = 40;
    gpu.upload_to(cells.planes(), &planes).unwrap();

    // Faces of cells, the first number below each, far away, and none.
    let mut at: Vec<Vec3> = Vec::new();
    for i in -2..12 {
        let face = Vec3::from(grid.low_m) + Vec3::splat(i as f32) * grid.cell_m;
        at.extend([face, face * (1.0 - f32::EPSILON), face + vec3(0.0, 0.05, 0.1)]);
    }
    at.extend([Vec3::splat(3e38), Vec3::splat(-3e38), Vec3::splat(f32::INFINITY), vec3(0.0, f32::NAN, 0.0)]);
    at.push(grid.centre_m(marked));

    let kernel = Kernel::new::<LookupParams>(
        &gpu,
        &KernelInfo {
            name: c"test.lookup",
            spv: &lookup(),
            blocks: &["At", "Occupied", "Planes", "Found"],
            constants: &[],
        },
    )
    .unwrap();
    let at_m = gpu.upload("test.at", &at.iter().flat_map(|v| v.to_array()).collect::<Vec<_>>()).unwrap();
    let found = gpu.upload("test.found", &vec![[0i32; 4]; at.len()]).unwrap();
    let bound = kernel
        .bind(&[
            ("At", (&at_m).into()),
            ("Occupied", cells.occupied().into()),
            ("Planes", cells.planes().into()),
            ("Found", (&found).into()),
        ])
        .unwrap();
    let params = LookupParams { grid, count: at.len() as u32 };
    gpu.once(|rec| {
        rec.dispatch(&bound, [at.len() as u32, 1, 1], &params);
        rec.barrier(Access::ComputeWrite, Access::ComputeReadWrite);
    })
    .unwrap();
    let found: Vec<[i32; 4]> = gpu.download(&found).unwrap();
    let (mut inside, mut outside) = (0, 0);
    for (at, &[x, y, z, flag]) in at.iter().zip(&found) {
        let cell = grid.cell_of(*at);
        let want = match grid.index(cell) {
            Some(i) if i == index => 42,
            Some(_) => 1,
            None => 0,
        };
        assert_eq!((ivec3(x, y, z), flag), (cell, want), "{at}");
        *(if want == 0 { &mut outside } else { &mut inside }) += 1;
    }
    assert!(inside > 10 && outside > 10, "{inside} inside, {outside} outside");
    assert_eq!(found.last().unwrap()[3], 42, "the occupied cell is seen");
    assert_eq!(grid.cell_of(Vec3::NAN), IVec3::NEG_ONE);
}

#[test]
fn grids_that_cannot_be_are_refused() {
    let good = Grid::new(Vec3::ZERO, 0.1, uvec3(4, 4, 4));
    assert_eq!(good.check(), Ok(()));
    for (bad, part) in [
        (Grid { cell_m: 0.0, ..good }, "more than 0"),
        (Grid { cell_m: f32::NAN, ..good }, "more than 0"),
        (Grid { cells: [4, 0, 4], ..good }, "1 to 1024"),
        (Grid { cells: [4, 4, 1025], ..good }, "1 to 1024"),
        (Grid { low_m: [0.0, f32::INFINITY, 0.0], ..good }, "finite"),
        (Grid { low_m: [9.0e4, 0.0, 0.0], cell_m: 0.01, ..good }, "a thousandth"),
    ] {
        let what = bad.check().unwrap_err();
        assert!(what.contains(part), "{what}");
    }
}
