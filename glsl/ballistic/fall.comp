#version 460
#extension GL_GOOGLE_include_directive : require
#include "ballistic/effect.glsl"
#include "ballistic/path.glsl"

// fall_time of many falls at once: for tests, and for whoever wants the times alone. CPU twin: ballistic::cpu::fall_time.
layout(local_size_x_id = 0) in;
layout(set = 0, binding = 0, std430) readonly buffer Falls { vec4 falls[]; };  // above (m), rise (m/s), pull (m/s2)
layout(set = 0, binding = 1, std430) writeonly buffer Times { float time_s[]; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < effect.capacity) time_s[i] = fall_time(falls[i].x, falls[i].y, falls[i].z);
}
