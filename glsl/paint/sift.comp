#version 460
#extension GL_GOOGLE_include_directive : require

// Which drops are near which block of the map: a bit each, so that their order stays and no list can overflow. A workgroup
// has 256 drops, one an invocation, and 32 blocks; blocks with any bit are listed (in any order: they share no texel).
// CPU twin: paint::cpu::sift.

layout(local_size_x = 256) in;
#include "paint/drops.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Drops { Drop drops[]; };
layout(set = 0, binding = 1, std430) readonly buffer Homes { uint homes[]; };
layout(set = 0, binding = 2, std430) readonly buffer Coats { Coat coats[]; };
layout(set = 0, binding = 3, std430) readonly buffer Blocks { Box blocks[]; };
layout(set = 0, binding = 4, std430) buffer WorkToDo { Work work; };
layout(set = 0, binding = 5, std430) buffer Flags { uint flags[]; };  // of a block: 1 once it is listed
layout(set = 0, binding = 6, std430) writeonly buffer Masks { uint masks[]; };
layout(set = 0, binding = 7, std430) writeonly buffer Touched { uint touched[]; };

layout(push_constant, std430) uniform Push { GatherParams p; };

shared uint near[256];  // 32 blocks, 8 words each

void main() {
    uint lane = gl_LocalInvocationIndex, k = 256u * gl_WorkGroupID.x + lane, first = 32u * gl_WorkGroupID.y;
    near[lane] = 0u;
    barrier();
    if (k < work.drops) {
        uint i = p.first + p.stride * k, mesh = 0u, home = NO_HOME;
        Drop drop = drops[i];
        float reach_sq_m2 = p.reach_sq_m2;
        if (kind == IMPACTS) {
            mesh = drop.source >> 16u;
            reach_sq_m2 = coats[drop.source & 0xffffu].reach_sq_m2;
            home = homes[i] / (TILE_TEXELS * BLOCK_TILES);
        }
        uint count = min(32u, p.blocks - first);
        for (uint b = 0u; b < count; ++b) {
            Box box = blocks[first + b];
            if (box.covered == 0u || kind == IMPACTS && box.mesh != mesh) continue;
            if (distance_sq(drop.at_m, box) < reach_sq_m2 || home == first + b) {
                atomicOr(near[8u * b + (lane >> 5u)], 1u << (lane & 31u));
            }
        }
    }
    barrier();
    uint block = first + (lane >> 3u), bits = near[lane];
    if (block >= p.blocks) return;
    masks[p.words * block + 8u * gl_WorkGroupID.x + (lane & 7u)] = bits;
    if (bits != 0u && atomicExchange(flags[block], 1u) == 0u) touched[atomicAdd(work.touched, 1u)] = block;
}
