#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "disks/draw.glsl"

// Disks seen from above: the box fills the picture, as far as its shape allows.

layout(set = 0, binding = 1, std430) readonly buffer Place { vec4 place_m[]; };
layout(set = 0, binding = 2, std430) readonly buffer Hit { uint hit[]; };

layout(location = 0) out vec2 corner;
layout(location = 1) out float temperature;

void main() {
    vec4 place = place_m[gl_InstanceIndex];
    corner = corner_of(gl_VertexIndex);
    temperature = temperature_of(hit[id_of_word(place.w)]);
    vec2 pixels = vec2(view.pixels), at = place.xy + corner * place.z - 0.5 * p.size_m.xy;
    float pixels_per_m = min(pixels.x / p.size_m.x, pixels.y / p.size_m.y);
    gl_Position = vec4(2.0 * pixels_per_m * at / pixels, 0.5, 1.0);
}
