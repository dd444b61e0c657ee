#version 460
// From the triangles that won in `volume.once` to the cells that others read: the planes and velocities that `volume.slices`
// would have written.
layout(local_size_x = 256) in;
#include "volume/triangle.glsl"
#include "volume/item.glsl"
#include "volume/slices.glsl"
layout(set = 0, binding = 2, std430) readonly buffer OnceKeys { uint once_keys[]; };
#define OCCUPIED 3
#define PLANES 4
#define EXTENTS 5
#define EXTENTS_ACCESS writeonly
#include "volume/planes.glsl"

float across(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }

void main() {
    uint i = item();
    bool is_cell = i < p.grid.cells_x * p.grid.cells_y * p.grid.cells_z;
    uint key = is_cell ? once_keys[i] : EMPTY;
    write_occupied(i & ~255u, key != EMPTY);
    if (key == EMPTY) return;
    ivec3 cell = ivec3(i % p.grid.cells_x, i / p.grid.cells_x % p.grid.cells_y, i / p.grid.cells_x / p.grid.cells_y);
    uint t = key_triangle(key);
    load_triangle(t);
    float distance_m = centre_distance_m(cell, tri_normal, tri_a_m);
    vec2 from_a = turned(vec3(cell) + 0.5 - tri_a).xy, ab = turned(tri_ab).xy, ac = turned(tri_ac).xy;
    vec2 shares = vec2(across(from_a, ac), across(ab, from_a)) / across(ab, ac);
    vec3 a = corner_mps(tri_corners.x), b = corner_mps(tri_corners.y), c = corner_mps(tri_corners.z);
    write_plane(2u * i, tri_normal, distance_m, a + shares.x * (b - a) + shares.y * (c - a), t + 1u);
    planes[2u * i + 1u].triangle = 0u;
    write_all_extent(i);
}
