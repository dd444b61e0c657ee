// A grid of cells to look at: `VoxelParams` mirrors `draw::voxels::VoxelParams`.
#define CELLS_OCCUPIED 1
#define CELLS_PLANES 2
#include "cells/cells.glsl"

struct VoxelParams {
    Grid grid;
    uint slot;  // of the two planes of a cell
};

layout(push_constant, std430) uniform Push { VoxelParams p; };

layout(location = 0) out vec3 at_m;
layout(location = 1) flat out vec3 facing;     // which way the face looks
layout(location = 2) flat out vec3 color_of;   // of the plane that the cell holds
layout(location = 3) flat out vec4 cell_m;     // centre; half of a side

// An instance a cell: whether it is occupied, where it is, and its plane.
bool voxel(out Plane plane) {
    uint i = uint(gl_InstanceIndex);
    at_m = facing = color_of = vec3(0.0);
    cell_m = vec4(0.0);
    gl_Position = vec4(0.0, 0.0, 2.0, 1.0);  // beyond the near plane: nothing is there
    if (!is_occupied(i)) return false;
    plane = plane_of(i, p.slot);
    uint layer = p.grid.cells_x * p.grid.cells_y;
    ivec3 cell = ivec3(i % p.grid.cells_x, i % layer / p.grid.cells_x, i / layer);
    cell_m = vec4(cell_centre_m(p.grid, cell), 0.5 * p.grid.cell_m);
    color_of = 0.5 + 0.5 * plane.normal;
    return p.slot == 0u || plane.triangle != 0u;
}
