#version 460
#extension GL_GOOGLE_include_directive : require

// Counting sort, first: how many have each key, and as which of them each was counted. A key beyond the last bin counts as
// the last. CPU twin: prims::cpu::sort_by_key.

layout(local_size_x = 256) in;
#include "prims/params.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Keys { uint keys[]; };
layout(set = 0, binding = 1, std430) buffer Counts { uint counts[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Ranks { uint ranks[]; };

void main() {
    uint i = tile_index() * GROUP + gl_LocalInvocationIndex;
    if (i < p.count) ranks[i] = atomicAdd(counts[min(keys[i], p.bins - 1u)], 1u);
}
