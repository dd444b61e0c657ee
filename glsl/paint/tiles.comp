#version 460
#extension GL_GOOGLE_include_directive : require

// The gather with its drops culled by tile. Each tile looks at all drops: best for some thousands. CPU twin:
// paint::cpu::gather.
#include "paint/tiles.glsl"

void find(uint base, uint count, Box box, uint tile) {
    uint end = min(CHUNK, count - base);
    for (uint k = gl_LocalInvocationIndex; k < end; k += gl_WorkGroupSize.x) {
        if (is_near(p.first + p.stride * (base + k), box, tile)) {
            atomicOr(near[k >> 5u], 1u << (k & 31u));
            atomicOr(busy[k >> 10u], 1u << (k >> 5u & 31u));
        }
    }
}

void main() {
    uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (tile >= BLOCK_TILES * p.blocks) return;
    gather(tile);
}
