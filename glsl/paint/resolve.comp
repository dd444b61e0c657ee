#version 460
#extension GL_GOOGLE_include_directive : require

// The paint map of one mesh row by row, as a texture wants it: premultiplied, four halves or floats a texel, v down. CPU twin:
// paint::cpu::rows.

layout(local_size_x = 8, local_size_y = 8) in;
#define FORMAT_CONSTANT 0
#include "paint/map.glsl"
#include "paint/texel.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Paint { uvec2 paint[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Rows { uvec2 rows[]; };

// Mirrors `paint::Map`.
layout(push_constant, std430) uniform Push { Map p; };

void main() {
    uvec2 at = gl_GlobalInvocationID.xy;
    if (at.x >= p.width || at.y >= p.height) return;
    uint to = p.width * at.y + at.x, from = texel_of(p, at);
    if (format == HALVES) {
        rows[to] = paint[from];
    } else {
        rows[2u * to] = paint[2u * from];
        rows[2u * to + 1u] = paint[2u * from + 1u];
    }
}
