#version 460
// Finds the slice of a texel, and lets the triangle compete for it: the nearest to where particles come from stays, in
// whatever order fragments come. There is no depth test, as there is no image.
#include "volume/params.glsl"
#include "volume/slices.glsl"

layout(set = 0, binding = 2, std430) buffer OnceKeys { uint once_keys[]; };  // one a cell

layout(location = 0) flat in vec3 from_normal;
layout(location = 1) flat in vec3 from_a_m;
layout(location = 2) flat in uint from_triangle;

void main() {
    float height = slice_height(gl_FragCoord.xy, from_normal, from_a_m), slice = floor(height);
    if (!(slice >= 0.0 && slice < turned(vec3(grid_cells(p.grid))).z)) return;
    float share = goes_down() ? slice + 1.0 - height : height - slice;
    uint i = cell_index(p.grid, turned_back(ivec3(ivec2(gl_FragCoord.xy), int(slice))));
    atomicMin(once_keys[i], key_of(share, from_triangle));
}
