#version 460
#extension GL_GOOGLE_include_directive : require

// Last of three: each impact that throws something goes to the slot of its rank. Of more than the ring holds the newest stay.
#define IMPACTS_BINDING 0
#define IMPACT_COUNT_BINDING 1
#define SOURCES_BINDING 2
#define MESHES_BINDING 3
#include "ballistic/kindling.glsl"

layout(local_size_x = 64) in;
layout(set = 0, binding = 4, std430) readonly buffer Marks { uint marks[]; };
layout(set = 0, binding = 5, std430) readonly buffer Before { uint before[]; };
layout(set = 0, binding = 6, std430) readonly buffer Rings { Ring ring; };
layout(set = 0, binding = 7, std430) writeonly buffer Strikes { Strike strikes[]; };

void main() {
    uint i = impact_index();
    if (i >= impact_count.count || !kindles(i)) return;
    uint key = key_of(i);
    if (key == NO_KEY) return;
    uint rank = before[key >> 5u] + bitCount(marks[key >> 5u] & ((1u << (key & 31u)) - 1u)), back = ring.step_births - rank;
    if (back > p.capacity) return;
    strikes[slot_before(ring.slot, back, p.capacity)] = Strike(
        impacts[i].at_m, p.now_low, impacts[i].normal, p.now_high, impacts[i].velocity_mps, impacts[i].impulse_mps);
}
