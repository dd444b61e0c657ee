#version 460
// `volume.second` of the triangles on the list, a few workgroups each. CPU twin: volume::cpu::Voxels::second.
layout(local_size_x = 128) in;
#include "volume/triangle.glsl"
#include "volume/second.glsl"
#define WORK 6
#define WORK_ACCESS readonly
#include "volume/work.glsl"
#define VISIT offer
#include "volume/columns.glsl"

void main() {
    for (uint i = gl_WorkGroupID.x; i < larges; i += gl_NumWorkGroups.x) {
        uint t = large[i];
        load_triangle(t);
        visit_columns(t);
    }
}
