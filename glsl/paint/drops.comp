#version 460
#extension GL_GOOGLE_include_directive : require

// Last of three: impacts as drops, in their order, and the texel that each hit.
#include "paint/splat.glsl"

layout(set = 0, binding = 3, std430) readonly buffer Marks { uint marks[]; };
layout(set = 0, binding = 4, std430) readonly buffer Before { uint before[]; };
layout(set = 0, binding = 5, std430) readonly buffer Maps { Map maps[]; };
layout(set = 0, binding = 6, std430) writeonly buffer Drops { Drop drops[]; };
layout(set = 0, binding = 7, std430) writeonly buffer Homes { uint homes[]; };

void main() {
    uint i = impact_index();
    if (i >= impact_count.count || impacts[i].mesh >= p.meshes) return;
    uint key = key_of(i);
    if (key == NO_KEY) return;
    uint place = before[key >> 5u] + bitCount(marks[key >> 5u] & (1u << (key & 31u)) - 1u);
    uint mesh = impacts[i].mesh;
    drops[place].at_m = impacts[i].at_m;
    drops[place].source = impacts[i].source | mesh << 16u;
    homes[place] = texel_at(maps[mesh], vec2(impacts[i].u, impacts[i].v));
}
