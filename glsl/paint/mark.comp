#version 460
#extension GL_GOOGLE_include_directive : require

// First of three: a mark for each impact that paints. Those that cannot are counted.
#include "paint/splat.glsl"

layout(set = 0, binding = 3, std430) buffer Marks { uint marks[]; };
layout(set = 0, binding = 4, std430) buffer WorkToDo { Work work; };

void main() {
    uint i = impact_index();
    if (i >= impact_count.count || impacts[i].mesh >= p.meshes) return;  // water and terrain take no paint
    uint key = key_of(i);
    if (key == NO_KEY) {
        atomicAdd(work.lost, 1u);
        return;
    }
    uint bit = 1u << (key & 31u);
    if ((atomicOr(marks[key >> 5u], bit) & bit) != 0u) atomicAdd(work.twice, 1u);
}
