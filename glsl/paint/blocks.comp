#version 460
#extension GL_GOOGLE_include_directive : require

// The box round each block of 64 tiles, a workgroup each. CPU twin: paint::cpu::boxes.

layout(local_size_x = 64) in;
#include "paint/map.glsl"
#include "paint/boxes.glsl"

// Mirrors `paint::PlaceParams`.
struct PlaceParams {
    uint first;  // tile, or block
    uint count;  // of them
    uint mesh;
};

layout(set = 0, binding = 0, std430) readonly buffer Tiles { Box tiles[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Blocks { Box blocks[]; };

layout(push_constant, std430) uniform Push { PlaceParams p; };

void main() {
    uint block = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (block >= p.count) return;  // the whole workgroup
    block += p.first;
    Box tile = tiles[BLOCK_TILES * block + gl_LocalInvocationIndex];
    vec3 low = tile.low_m, high = tile.high_m;
    uint covered = tile.covered;
    if (join_all(low, high, covered)) {
        blocks[block].low_m = low;
        blocks[block].mesh = p.mesh;
        blocks[block].high_m = high;
        blocks[block].covered = covered;
    }
}
