#version 460
#extension GL_GOOGLE_include_directive : require
#include "ballistic/effect.glsl"

// Those that live go to the list of the next frame: the book's stream-out geometry shader.
layout(points) in;
layout(points, max_vertices = 1) out;
layout(location = 0) in vec4 at_age[];
layout(location = 1) in vec4 flown[];
layout(location = 0, xfb_buffer = 0, xfb_stride = 32, xfb_offset = 0) out vec4 kept_at_age;
layout(location = 1, xfb_buffer = 0, xfb_stride = 32, xfb_offset = 16) out vec4 kept_flown;

void main() {
    if (at_age[0].w * effect.lives_per_s >= 1.0) return;
    kept_at_age = at_age[0];
    kept_flown = flown[0];
    EmitVertex();
    EndPrimitive();
}
