#version 460
#extension GL_GOOGLE_include_directive : require
#include "disks/list.glsl"

// Empties the lists. CPU twin: disks::cpu::Disks::sort.

layout(set = 0, binding = 0, std430) writeonly buffer Head { uint head[]; };

void main() {
    uint c = item();
    if (c < p.cells.x * p.cells.y) head[c] = NONE;
}
