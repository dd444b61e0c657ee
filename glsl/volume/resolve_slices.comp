#version 460
// From the images that `volume.slices` drew to the cells that others read: one plane each.
layout(local_size_x = 256) in;
#include "volume/params.glsl"
#include "volume/item.glsl"
#include "volume/slices.glsl"
layout(set = 0, binding = 0, rgba32f) readonly uniform image3D PlaneImage;
layout(set = 0, binding = 1, rgba32f) readonly uniform image3D VelocityImage;
#define OCCUPIED 2
#define PLANES 3
#define EXTENTS 4
#define EXTENTS_ACCESS writeonly
#include "volume/planes.glsl"

void main() {
    uint i = item();
    bool is_cell = i < p.grid.cells_x * p.grid.cells_y * p.grid.cells_z;
    ivec3 cell = ivec3(i % p.grid.cells_x, i / p.grid.cells_x % p.grid.cells_y, i / p.grid.cells_x / p.grid.cells_y);
    ivec3 texel = ivec3(turned(vec3(cell)));
    vec4 velocity = is_cell ? imageLoad(VelocityImage, texel) : vec4(0.0);
    uint triangle = uint(velocity.w);
    write_occupied(i & ~255u, triangle != 0u);
    if (triangle == 0u) return;
    vec4 plane = imageLoad(PlaneImage, texel);
    write_plane(2u * i, plane.xyz, plane.w, velocity.xyz, triangle);
    planes[2u * i + 1u].triangle = 0u;
    write_all_extent(i);
}
