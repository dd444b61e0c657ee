#version 460
#extension GL_GOOGLE_include_directive : require
#include "ballistic/stored.glsl"

// The same flight by steps, in place, as it would be without the formula (explicit Euler, position first): it is half a step
// of fall behind per step, 1/2 a t dt in the end. For the study of speed against error alone.
layout(local_size_x_id = 0) in;
layout(push_constant) uniform Push { vec4 acceleration; float dt_s; uint count; uint row; uint reserved; } p;
layout(set = 0, binding = 0, std430) buffer Flying { Stored flying[]; };

void main() {
    uint i = gl_GlobalInvocationID.y * p.row + gl_GlobalInvocationID.x;
    if (i >= p.count || gl_GlobalInvocationID.x >= p.row) return;
    Stored it = flying[i];
    precise vec3 at = it.at_age.xyz + p.dt_s * it.velocity.xyz;
    precise vec3 v = it.velocity.xyz + p.dt_s * p.acceleration.xyz;
    flying[i] = Stored(vec4(at, it.at_age.w + p.dt_s), vec4(v, 0.0));
}
