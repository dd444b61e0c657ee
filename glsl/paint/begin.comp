#version 460
#extension GL_GOOGLE_include_directive : require

// How many drops take part, and the arguments of the dispatches that need to know. One invocation.

layout(local_size_x = 1) in;
#include "paint/drops.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Sums { uint sums[]; };  // of impacts: the last is how many there are
layout(set = 0, binding = 1, std430) buffer WorkToDo { Work work; };

layout(push_constant, std430) uniform Push { GatherParams p; };

void main() {
    uint count = p.first < p.total ? (p.total - p.first - 1u) / p.stride + 1u : 0u;
    if (kind == IMPACTS) count = min(sums[p.total_at], p.total);
    work.drops = count;
    work.sift_x = (count + 255u) / 256u;
    work.sift_y = (p.blocks + 31u) / 32u;
    work.sift_z = 1u;
    work.tiles_x = BLOCK_TILES;
    work.touched = 0u;
    work.tiles_z = 1u;
}
