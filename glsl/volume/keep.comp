#version 460
// Keeps what the still meshes left in every cell, once.
layout(local_size_x = 256) in;
#include "volume/params.glsl"
#include "volume/item.glsl"
layout(set = 0, binding = 0, std430) readonly buffer FirstKeys { uint first_keys[]; };
layout(set = 0, binding = 1, std430) readonly buffer SecondKeys { uint second_keys[]; };
layout(set = 0, binding = 2, std430) writeonly buffer StillKeys { uvec2 still_keys[]; };
layout(set = 0, binding = 3, std430) readonly buffer Extents { uint extents[]; };
layout(set = 0, binding = 4, std430) writeonly buffer StillExtents { uint still_extents[]; };

void main() {
    uint i = item();
    if (i >= p.grid.cells_x * p.grid.cells_y * p.grid.cells_z) return;
    still_keys[i] = uvec2(first_keys[i], second_keys[i]);
    for (uint k = 0u; k < 3u; ++k) still_extents[3u * i + k] = extents[3u * i + k];
}
