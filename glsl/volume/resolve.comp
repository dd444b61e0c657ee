#version 460
// From the triangles that won to what is collided with: planes about the centres of their cells, and how they move there.
// Where both are the still meshes' own, so is what they stand for. CPU twin: volume::cpu::Voxels::plane.
layout(local_size_x = 256) in;
#include "volume/triangle.glsl"
#include "volume/item.glsl"
layout(set = 0, binding = 2, std430) readonly buffer FirstKeys { uint first_keys[]; };
layout(set = 0, binding = 3, std430) readonly buffer StillKeys { uvec2 still_keys[]; };
layout(set = 0, binding = 4, std430) readonly buffer SecondKeys { uint second_keys[]; };
#define OCCUPIED 5
#define PLANES 6
#define EXTENTS 7
#define EXTENTS_ACCESS
#include "volume/planes.glsl"
layout(set = 0, binding = 8, std430) readonly buffer StillExtents { uint still_extents[]; };

void write(uint slot, ivec3 cell, uint t) {
    load_triangle(t);
    vec2 shares = nearest_shares(vec3(cell) + 0.5 - tri_a);
    vec3 a = corner_mps(tri_corners.x), b = corner_mps(tri_corners.y), c = corner_mps(tri_corners.z);
    write_plane(slot, tri_normal, centre_distance_m(cell, tri_normal, tri_a_m), a + shares.x * (b - a) + shares.y * (c - a), t + 1u);
}

void main() {
    uint i = item();
    bool is_cell = i < p.grid.cells_x * p.grid.cells_y * p.grid.cells_z;
    uint first = is_cell ? first_keys[i] : EMPTY;
    write_occupied(i & ~255u, first != EMPTY);
    if (first == EMPTY) return;
    uvec2 still = still_keys[i];
    uint second = second_with(first, second_keys[i], still);
    if (uvec2(first, second) == still)
        for (uint k = 0u; k < 3u; ++k) extents[3u * i + k] |= still_extents[3u * i + k];
    ivec3 cell = ivec3(i % p.grid.cells_x, i / p.grid.cells_x % p.grid.cells_y, i / p.grid.cells_x / p.grid.cells_y);
    write(2u * i, cell, key_triangle(first));
    if (second == EMPTY) {
        planes[2u * i + 1u].triangle = 0u;
    } else {
        write(2u * i + 1u, cell, key_triangle(second));
    }
}
