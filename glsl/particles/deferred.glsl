// Those whom a law puts off (LAW_DEFERS), for `advance_deferred` to move: the particle as it was read, and where the advance
// leaves room for it. It is the first of the law's own blocks.
#ifndef DEFERRED_GLSL
#define DEFERRED_GLSL
#extension GL_EXT_control_flow_attributes : require
#include "particles/particle.glsl"
#include "particles/step.glsl"

#ifndef DEFERRED_BINDING
#define DEFERRED_BINDING LAW_BLOCKS
#endif

layout(set = 0, binding = DEFERRED_BINDING, std430) buffer Deferred {
    uint groups_x;  // indirect dispatch of workgroups of DEFERRED_GROUP, which take turns
    uint groups_y;
    uint groups_z;
    uint count;
    // Planes of `p.stride` words: where it goes, what slot it was in this step (`law_slot`), its step or what is left of that
    // at its birth (s), place, velocity, birth.
    uint words[];
} deferred;

const uint DEFERRED_GROUP = 64u;
const uint MOST_DEFERRED_GROUPS = 4096u;  // three times what an H200 runs at once

void defer(uint q, uint place, uint slot, float dt_s, Particle it) {
    uint w[10] = uint[](place, slot, floatBitsToUint(dt_s), floatBitsToUint(it.at_m.x), floatBitsToUint(it.at_m.y),
                        floatBitsToUint(it.at_m.z), floatBitsToUint(it.velocity_mps.x), floatBitsToUint(it.velocity_mps.y),
                        floatBitsToUint(it.velocity_mps.z), it.born);
    [[unroll]] for (uint k = 0u; k < 10u; ++k) deferred.words[k * p.stride + q] = w[k];
}

Particle deferred_at(uint q, out uint place, out uint slot, out float dt_s) {
    uint w[10];
    [[unroll]] for (uint k = 0u; k < 10u; ++k) w[k] = deferred.words[k * p.stride + q];
    place = w[0];
    slot = w[1];
    dt_s = uintBitsToFloat(w[2]);
    return Particle(uintBitsToFloat(uvec3(w[3], w[4], w[5])), uintBitsToFloat(uvec3(w[6], w[7], w[8])), w[9]);
}

#endif
