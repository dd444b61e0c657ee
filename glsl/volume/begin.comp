#version 460
// Before anything is marked: every cell has what the still meshes left there, and the list is empty.
layout(local_size_x = 256) in;
#include "volume/params.glsl"
#include "volume/item.glsl"
layout(set = 0, binding = 0, std430) readonly buffer StillKeys { uvec2 still_keys[]; };  // first and second of still meshes
layout(set = 0, binding = 1, std430) writeonly buffer FirstKeys { uint first_keys[]; };
layout(set = 0, binding = 2, std430) writeonly buffer SecondKeys { uint second_keys[]; };
#define WORK 3
#define WORK_ACCESS writeonly
#include "volume/work.glsl"

void main() {
    uint i = item();
    if (i == 0u) {
        groups_x = 0u;
        groups_y = p.rows;
        groups_z = 1u;
        larges = 0u;
        no_area = 0u;
        not_finite = 0u;
    }
    if (i >= p.grid.cells_x * p.grid.cells_y * p.grid.cells_z) return;
    first_keys[i] = still_keys[i].x;
    second_keys[i] = EMPTY;
}
