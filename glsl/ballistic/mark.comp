#version 460
#extension GL_GOOGLE_include_directive : require

// First of three: a mark for each impact that throws something, and how many marks each word has. A scan makes of these how
// many come before each word.
#define IMPACTS_BINDING 0
#define IMPACT_COUNT_BINDING 1
#define SOURCES_BINDING 2
#define MESHES_BINDING 3
#include "ballistic/kindling.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 4, std430) buffer Marks { uint marks[]; };
layout(set = 0, binding = 5, std430) buffer Marked { uint marked[]; };
layout(set = 0, binding = 6, std430) buffer Rings { Ring ring; };

const uint ENOUGH = 0x80000000u;  // counts of what ought not to be stop there

void main() {
    uint i = impact_index();
    if (i >= impact_count.count || !kindles(i)) return;
    uint key = key_of(i);
    if (key == NO_KEY) {
        if (ring.lost < ENOUGH) atomicAdd(ring.lost, 1u);
        return;
    }
    uint bit = 1u << (key & 31u);
    if ((atomicOr(marks[key >> 5u], bit) & bit) == 0u) {
        atomicAdd(marked[key >> 5u], 1u);
    } else {
        if (ring.twice < ENOUGH) atomicAdd(ring.twice, 1u);
    }
}
