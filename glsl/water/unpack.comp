#version 460
#extension GL_GOOGLE_include_directive : require
#define HALVES
#include "water/storage.glsl"

// The halves of waves_f16.comp and fused_f16.comp to floats, for whoever draws or disturbs them.

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer Halves { uvec2 halves[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Floats { vec4 floats[]; };

layout(push_constant, std430) uniform Push { uvec2 size; };  // of a plane: fours of columns, rows

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(at, size))) return;
    uint i = at.y * size.x + at.x;
    floats[i] = floats_of(halves[i]);
}
