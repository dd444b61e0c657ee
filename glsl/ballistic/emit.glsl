// The newborn of a frame: the newest `births` of an effect, each as old as it is by now, so that no frame is seen in where
// they are. Needs the effect's file.
#include "ballistic/flight.glsl"
#include "ballistic/stored.glsl"

layout(local_size_x_id = 0) in;
layout(set = 0, binding = 0, std430) writeonly buffer After { Stored after[]; };
layout(set = 0, binding = 1, std430) buffer Counts { Counter counter; };
#include "ballistic/append.glsl"

void main() {
    uint i = gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x;
    bool is_there = i < effect.births * effect.burst;
    Stored stored = Stored(vec4(0.0), vec4(0.0));
    if (is_there) {
        Who who;
        Wide age = age_of_particle(i, who);
        Birth start = birth(who, emitter_at(age));
        stored = Stored(vec4(start.at_m, age.high), vec4(start.velocity_mps, 0.0));
    }
    append(is_there, stored, effect.capacity);
}
