#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/map_view.glsl"

// The paint of a mesh on a checkered ground.

layout(set = 0, binding = 1, std430) readonly buffer Paint { uvec2 paint[]; };
#define FORMAT_CONSTANT 0
#include "paint/lookup.glsl"

layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;

void main() {
    vec4 coat = paint_at(p.map, uv);
    ivec2 square = ivec2(gl_FragCoord.xy) / 8;
    float ground = ((square.x + square.y) & 1) == 0 ? 0.30 : 0.36;
    color = vec4(coat.rgb + (1.0 - coat.a) * ground, 1.0);
}
