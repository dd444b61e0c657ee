#version 460
// `volume.mark` of the triangles on the list, a few workgroups each. CPU twin: volume::cpu::mark.
layout(local_size_x = 128) in;
#include "volume/triangle.glsl"
#define MARK_KEYS 2
#include "volume/mark.glsl"
#define WORK 3
#define WORK_ACCESS readonly
#include "volume/work.glsl"
#define VISIT mark
#include "volume/columns.glsl"

void main() {
    for (uint i = gl_WorkGroupID.x; i < larges; i += gl_NumWorkGroups.x) {
        uint t = large[i];
        load_triangle(t);
        visit_columns(t);
    }
}
