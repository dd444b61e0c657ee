// What the passes share that make births of impacts. Impacts lie as atomics left them: each has a key of its own among all that
// a step may have, sets the mark of its key, and its rank is how many marks come before it. So serial numbers, and with them
// all that is random, do not depend on who came first, and two runs have the same ring to the bit.
#include "ballistic/ring.glsl"

// Mirrors `ballistic::KindleParams`.
struct KindleParams {
    uint capacity;      // slots of the ring
    uint burst;         // particles of each birth
    uint sources;
    uint meshes;        // 0: on whatever it was
    float least_impulse_mps;  // a lesser one throws nothing
    uint total_at;      // the word of `Sums` with the births of the step
    uint now_low;       // end of the step, or the moment of the picture: ticks of 2^-32 s
    uint now_high;
    uint life_low;      // ticks
    uint life_high;
};

layout(push_constant, std430) uniform Push { KindleParams p; };

#ifdef IMPACTS_BINDING
#include "impact/impact.glsl"

// The keys of a source: `x` + order, for orders below `y`; none throws nothing.
layout(set = 0, binding = SOURCES_BINDING, std430) readonly buffer Sources { uvec2 sources[]; };
// By mesh: 0 throws nothing.
layout(set = 0, binding = MESHES_BINDING, std430) readonly buffer Meshes { uint meshes[]; };

uint impact_index() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * IMPACT_GROUP + gl_LocalInvocationIndex;
}

// Whether it throws something. An impulse that is no number does not.
bool kindles(uint i) {
    uint source = impacts[i].source, mesh = impacts[i].mesh;
    if (!(impacts[i].impulse_mps >= p.least_impulse_mps) || source >= p.sources || sources[source].y == 0u) return false;
    return p.meshes == 0u || mesh < p.meshes && meshes[mesh] != 0u;
}

const uint NO_KEY = 0xffffffffu;

uint key_of(uint i) {
    uvec2 keys = sources[impacts[i].source];
    return impacts[i].order < keys.y ? keys.x + impacts[i].order : NO_KEY;
}
#else
layout(set = 0, binding = STRIKES_BINDING, std430) readonly buffer Strikes { Strike strikes[]; };
layout(set = 0, binding = RING_BINDING, std430) buffer Rings { Ring ring; };

bool is_over(uint slot) {
    uint borrow, low = usubBorrow(p.now_low, strikes[slot].born_low, borrow), high = p.now_high - strikes[slot].born_high - borrow;
    if (high > 0x7fffffffu) return false;  // it is still to come
    return high > p.life_high || high == p.life_high && low >= p.life_low;
}

// Births that live: as times rise round the ring, the newest from some birth on, which bisection finds.
uint living_now() {
    uint kept = ring.next_high > 0u ? p.capacity : min(ring.next_low, p.capacity);
    uint over = 0u, alive = kept;  // of the kept, those before `over` are over, those from `alive` on are not
    while (over < alive) {
        uint middle = (over + alive) / 2u;
        if (is_over(slot_before(ring.slot, kept - middle, p.capacity))) {
            over = middle + 1u;
        } else {
            alive = middle;
        }
    }
    return kept - over;
}
#endif
