#version 460
#extension GL_GOOGLE_include_directive : require
#include "disks/scan.glsl"

// Scan, first half: how many disks are in each block of cells. CPU twin: disks::cpu::Disks::sort.

layout(set = 0, binding = 0, std430) readonly buffer Count { uvec4 count[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Sums { uint sums[]; };

shared uint part[ROW];

void main() {
    uint t = gl_LocalInvocationID.x, block = gl_WorkGroupID.x;
    uvec4 sum = uvec4(0u);
    for (uint row = 0u; row < 4u; ++row) sum += count[(block * 4u + row) * ROW + t];
    part[t] = sum.x + sum.y + sum.z + sum.w;
    for (uint half_way = ROW / 2u; half_way > 0u; half_way /= 2u) {
        barrier();
        if (t < half_way) part[t] += part[t + half_way];
    }
    if (t == 0u) sums[block] = part[0];
}
