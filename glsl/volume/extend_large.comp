#version 460
// `volume.extend` of the triangles on the list, a few workgroups each. CPU twin: volume::cpu::Voxels::extents.
layout(local_size_x = 128) in;
#include "volume/triangle.glsl"
#include "volume/extend.glsl"
#define WORK 7
#define WORK_ACCESS readonly
#include "volume/work.glsl"

// Whether no triangle can add to the extents of a cell: so nearly all find it where many large ones lie on each other. Bits that come
// meanwhile and are not seen cost work, no more.
bool is_full(uint i) {
    return (extents[3u * i] & extents[3u * i + 1u] & extents[3u * i + 2u]) == EXTENT_ALL;
}

void extend_if_asked(uint t, ivec3 cell) {
    if (!is_full(cell_index(p.grid, cell)) && is_asked(t, cell)) extend(cell);
}

#define VISIT extend_if_asked
#include "volume/columns.glsl"

void main() {
    for (uint i = gl_WorkGroupID.x; i < larges; i += gl_NumWorkGroups.x) {
        uint t = large[i];
        load_triangle(t);
        visit_columns(t);
    }
}
