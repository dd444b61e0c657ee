#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/body.glsl"
#include "water/land.glsl"

// Prepares the poses of bodies, one workgroup each: the scale that makes the sum of a body's draughts its volume below
// the level, whichever way the columns cut it, and how much of that volume is on water. CPU twin:
// water::cpu_bodies::draught.

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer Height { float height_m[]; };
layout(set = 0, binding = 1, std430) buffer Bodies { Body bodies[]; };

layout(push_constant, std430) uniform Push { BodyParams p; };

shared vec2 sums[64];

void main() {
    uint which = p.first + gl_WorkGroupID.x, lane = gl_LocalInvocationID.x;
    Body b = bodies[which];
    ivec2 lo, hi;
    reach_of(b, p.cell_m, lo, hi);
    uvec2 size = uvec2(max(hi - lo, ivec2(0)));
    precise vec2 sum = vec2(0.0);  // all, and on water
    for (uint i = lane; i < size.x * size.y; i += 64u) {
        ivec2 c = lo + ivec2(i % size.x, i / size.x);
        float draught = draught_of(c, b, p.cell_m);
        bool is_water = all(greaterThanEqual(c, ivec2(0))) && all(lessThan(c, ivec2(p.cells)));
        if (is_water) is_water = height_m[(uint(c.y) * p.pitch + uint(c.x)) * p.stride] != LAND_M;
        sum += vec2(draught, is_water ? draught : 0.0);
    }
    sums[lane] = sum;
    barrier();
    if (lane != 0u) return;
    precise vec2 total = vec2(0.0);
    for (uint i = 0u; i < 64u; ++i) total += sums[i];
    precise float scale = total.x > 0.0 ? b.submerged_m3 / (p.cell_m * p.cell_m * total.x) : 0.0;
    precise float displaced = scale * (p.cell_m * p.cell_m) * total.y;
    bodies[which].scale = scale;
    bodies[which].displaced_m3 = displaced;
}
