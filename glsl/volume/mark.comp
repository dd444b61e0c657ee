#version 460
// First pass over triangles: each marks the cells that it overlaps, and the nearest to the centre of a cell stays.
// One invocation a small triangle; large ones are put on a list for `volume.mark_large`. CPU twin: volume::cpu::mark.
layout(local_size_x = 128) in;
#include "volume/triangle.glsl"
#include "volume/item.glsl"
layout(set = 0, binding = 2, std430) writeonly buffer Normals { vec4 normals[]; };  // of triangles; w: along it, from the least corner (cells)
#define MARK_KEYS 3
#include "volume/mark.glsl"
#define WORK 4
#define WORK_ACCESS
#include "volume/work.glsl"

shared uint group_larges, group_first, group_columns;

void main() {
    uint i = item(), t = p.first + i, rank = EMPTY;
    if (gl_LocalInvocationIndex == 0u) {
        group_larges = 0u;
        group_columns = 0u;
    }
    barrier();
    if (i < p.triangles) {
        uint found = load_triangle(t);
        normals[t] = found == SOUND ? vec4(tri_normal, dot(tri_normal, tri_a)) : vec4(0.0);
        if (found == NO_AREA) atomicAdd(no_area, 1u);
        if (found == NOT_FINITE) atomicAdd(not_finite, 1u);
        if (found == SOUND && box_cells() > LARGE_CELLS) {
            rank = atomicAdd(group_larges, 1u);
            atomicMax(group_columns, box_columns(across_axis()));
        } else if (found == SOUND) {
            ivec3 cell;
            for (cell.z = tri_low.z; cell.z <= tri_high.z; ++cell.z)
                for (cell.y = tri_low.y; cell.y <= tri_high.y; ++cell.y)
                    for (cell.x = tri_low.x; cell.x <= tri_high.x; ++cell.x) mark(t, cell);
        }
    }
    // One place on the list a workgroup, not one a triangle.
    barrier();
    if (gl_LocalInvocationIndex == 0u && group_larges > 0u) {
        group_first = atomicAdd(larges, group_larges);
        atomicMax(groups_x, min(group_first + group_larges, MOST_GROUPS));
        atomicMax(groups_y, clamp((group_columns + COLUMNS - 1u) / COLUMNS, 1u, p.rows));
    }
    barrier();
    if (rank != EMPTY) large[group_first + rank] = t;
}
