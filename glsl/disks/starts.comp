#version 460
#extension GL_GOOGLE_include_directive : require
#include "disks/scan.glsl"

// Scan, second half: how many disks are in the cells before each; counts become 0 for the next step. Every workgroup sums
// the blocks before its own again, which is cheaper than a dispatch between. CPU twin: disks::cpu::Disks::sort.

layout(set = 0, binding = 0, std430) readonly buffer Sums { uint sums[]; };
layout(set = 0, binding = 1, std430) buffer Count { uvec4 count[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Start { uvec4 start[]; };

shared uvec4 part[ROW];

void main() {
    uint t = gl_LocalInvocationID.x, block = gl_WorkGroupID.x;
    uint before = 0u;
    for (uint b = t; b < block; b += ROW) before += sums[b];

    // The rows at once: one component each.
    uvec4 of[4];
    uvec4 mine;
    for (uint row = 0u; row < 4u; ++row) {
        uint i = (block * 4u + row) * ROW + t;
        of[row] = count[i];
        count[i] = uvec4(0u);
        mine[row] = of[row].x + of[row].y + of[row].z + of[row].w;
    }

    part[t] = uvec4(before, 0u, 0u, 0u);
    for (uint half_way = ROW / 2u; half_way > 0u; half_way /= 2u) {
        barrier();
        if (t < half_way) part[t].x += part[t + half_way].x;
    }
    barrier();
    uint base = part[0].x;
    barrier();

    part[t] = mine;
    for (uint stride = 1u; stride < ROW; stride *= 2u) {
        barrier();
        uvec4 lower = t >= stride ? part[t - stride] : uvec4(0u);
        barrier();
        part[t] += lower;
    }
    barrier();
    uvec4 total = part[ROW - 1u], first = part[t] - mine;
    first += uvec4(0u, total.x, total.x + total.y, total.x + total.y + total.z) + base;
    for (uint row = 0u; row < 4u; ++row) {
        uvec4 n = of[row];
        start[(block * 4u + row) * ROW + t] = first[row] + uvec4(0u, n.x, n.x + n.y, n.x + n.y + n.z);
    }
}
