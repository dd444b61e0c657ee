// Impacts lie as atomics left them; here each finds its place by its key, which is its own among all that a step may have:
// a mark a key, sums over the marks, and the place is how many marks come before. Nothing is compared, and two runs have the
// same drops in the same order. CPU twin: paint::cpu::in_order.
#define IMPACTS_BINDING 0
#define IMPACT_COUNT_BINDING 1
#include "impact/impact.glsl"
#include "paint/drops.glsl"

layout(local_size_x = 64) in;

// Mirrors `paint::SplatParams`.
struct SplatParams {
    uint coats;
    uint meshes;
    uint unused0;
    uint unused1;
};

layout(set = 0, binding = 2, std430) readonly buffer Coats { Coat coats[]; };

layout(push_constant, std430) uniform Push { SplatParams p; };

const uint NO_KEY = 0xffffffffu;

// Of an impact on a mesh; NO_KEY if its source has no coat, or its order is beyond what the source said.
uint key_of(uint i) {
    uint source = impacts[i].source, order = impacts[i].order;
    if (source >= p.coats || order >= coats[source].orders) return NO_KEY;
    return coats[source].first_order + order;
}

// Which impact an invocation has.
uint impact_index() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * IMPACT_GROUP + gl_LocalInvocationIndex;
}
