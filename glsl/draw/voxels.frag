#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"

// Colour by normal, light by face, dark along the edges of the cell.

layout(location = 0) in vec3 at_m;
layout(location = 1) flat in vec3 facing;
layout(location = 2) flat in vec3 color_of;
layout(location = 3) flat in vec4 cell_m;
layout(location = 0) out vec4 color;

void main() {
    vec3 within = abs(at_m - cell_m.xyz) / cell_m.w;
    if (any(greaterThan(within, vec3(1.001)))) discard;
    vec3 n = dot(facing, at_m - view.eye_m.xyz) > 0.0 ? -facing : facing;
    float light = 0.55 + 0.25 * n.y + 0.35 * max(dot(n, view.to_sun.xyz), 0.0);
    float middle = within.x + within.y + within.z - max(within.x, max(within.y, within.z)) - min(within.x, min(within.y, within.z));
    float edge = 1.0 - 0.45 * smoothstep(0.88, 0.97, middle);
    color = vec4(color_of * color_of * (light * edge), 1.0);
}
