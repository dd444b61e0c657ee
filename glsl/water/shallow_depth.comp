#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/depth.glsl"
#include "water/shallow.glsl"

// Shallow water, second half of a step: the velocities of water.shallow_speed carry the water, upstream depth by
// velocity, limited and moved by water/donor.glsl. Velocities stay as they are: a limited flow means that little water
// was there, not that it was slow. 20 bytes a column and step. CPU twin: water::cpu_wet::Depths.

layout(push_constant, std430) uniform Push { DepthParams p; };

float flow_through(float velocity, float surface_a, float surface_b, float bed_a, float bed_b) {
    return carried(velocity, surface_a, surface_b, bed_a, bed_b);
}

#include "water/donor.glsl"
