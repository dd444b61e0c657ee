#version 460
#extension GL_GOOGLE_include_directive : require

// The gather with its drops culled by block first: a tile looks at those that `paint.sift` found near its block. Dispatched
// over the tiles of blocks that anything is near. CPU twin: paint::cpu::gather.
#include "paint/tiles.glsl"

layout(set = 0, binding = 7, std430) readonly buffer Masks { uint masks[]; };
layout(set = 0, binding = 8, std430) readonly buffer Touched { uint touched[]; };

void find(uint base, uint count, Box box, uint tile) {
    uint words = min(64u, (count - base + 31u) >> 5u);
    uint first = tile / BLOCK_TILES * p.words + (base >> 5u);
    for (uint word = gl_LocalInvocationIndex; word < words; word += gl_WorkGroupSize.x) {
        uint bits = masks[first + word], kept = 0u;
        while (bits != 0u) {
            uint bit = findLSB(bits);
            bits &= bits - 1u;
            uint k = base + 32u * word + bit;
            if (is_near(p.first + p.stride * k, box, tile)) kept |= 1u << bit;
        }
        if (kept != 0u) {
            near[word] = kept;
            atomicOr(busy[word >> 5u], 1u << (word & 31u));
        }
    }
}

void main() { gather(BLOCK_TILES * touched[gl_WorkGroupID.y] + gl_WorkGroupID.x); }
