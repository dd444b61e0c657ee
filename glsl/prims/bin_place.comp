#version 460
#extension GL_GOOGLE_include_directive : require

// Counting sort, third, after the scan of the counts: indices of elements, bin by bin. CPU twin: prims::cpu::sort_by_key.

layout(local_size_x = 256) in;
#include "prims/params.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 1, std430) readonly buffer Firsts { uint firsts[]; };
layout(set = 0, binding = 2, std430) readonly buffer Ranks { uint ranks[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Order { uint order[]; };

void main() {
    uint i = tile_index() * GROUP + gl_LocalInvocationIndex;
    if (i < p.count) order[firsts[min(keys[i], p.bins - 1u)] + ranks[i]] = i;
}
