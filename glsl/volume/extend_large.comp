#version 460
// `volume.extend` of the triangles on the list, a few workgroups each. CPU twin: volume::cpu::Voxels::extents.
layout(local_size_x = 128) in;
#include "volume/triangle.glsl"
#include "volume/extend.glsl"
#define WORK 7
#define WORK_ACCESS readonly
#include "volume/work.glsl"
// Where many large triangles lie on each other, nearly all find the cell full.
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
