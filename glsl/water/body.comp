#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/body.glsl"
#include "water/land.glsl"

// Bodies on their way from one pose to the next push the water aside that is under them, and leave a hollow behind: a
// column is raised by the change of their draught in it, so what they raise in a closed passage is nothing. On land
// nothing is raised. CPU twin: water::cpu_bodies::body.

layout(local_size_x = 16, local_size_y = 16) in;

layout(set = 0, binding = 0, std430) buffer Height { float height_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Bodies { Body bodies[]; };

layout(push_constant, std430) uniform Push { BodyParams p; };

float scaled_draught(ivec2 c, uint which) {
    Body b = bodies[which];
    ivec2 lo, hi;
    reach_of(b, p.cell_m, lo, hi);
    if (any(lessThan(c, lo)) || any(greaterThanEqual(c, hi))) return 0.0;
    precise float draught = b.scale * draught_of(c, b, p.cell_m);
    return draught;
}

void main() {
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, p.size))) return;
    ivec2 c = ivec2(p.origin + gl_GlobalInvocationID.xy);
    precise float rise = 0.0;
    for (uint i = p.first; i < p.first + p.count; ++i) {
        rise += scaled_draught(c, i + p.count) - scaled_draught(c, i);
    }
    uint i = (uint(c.y) * p.pitch + uint(c.x)) * p.stride;
    float h = height_m[i];
    if (rise == 0.0 || h == LAND_M) return;
    precise float raised = h + rise;
    height_m[i] = raised;
}
