#version 460
#extension GL_GOOGLE_include_directive : require
#include "ballistic/stored.glsl"

// A frame passes: every particle is older by dt, and those that live go on to the other list. What ages must be in
// the end: ballistic::cpu::age_of.
layout(local_size_x_id = 0) in;
layout(push_constant) uniform Push { float dt_s; float life_s; uint capacity; uint group; } p;
layout(set = 0, binding = 0, std430) readonly buffer Before { Stored before[]; };
layout(set = 0, binding = 1, std430) readonly buffer CountsBefore { Counter counter_before; };
layout(set = 0, binding = 2, std430) writeonly buffer After { Stored after[]; };
layout(set = 0, binding = 3, std430) buffer Counts { Counter counter; };
#include "ballistic/append.glsl"

void main() {
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * p.group + gl_LocalInvocationIndex;
    bool is_there = i < counter_before.count;
    Stored stored = Stored(vec4(0.0), vec4(0.0));
    if (is_there) {
        stored = before[i];
        precise float age_s = stored.at_age.w + p.dt_s;
        stored.at_age.w = age_s;
        is_there = age_s < p.life_s;
    }
    append(is_there, stored, p.capacity);
}
