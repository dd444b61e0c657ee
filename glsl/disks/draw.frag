#version 460
#extension GL_GOOGLE_include_directive : require
#include "disks/draw.glsl"

// As the tutorial shades them: brightest in the middle, and fading at the edge.

layout(location = 0) in vec2 corner;
layout(location = 1) in float temperature;
layout(location = 0) out vec4 color;

void main() {
    float far = length(corner);
    if (far > 1.0) discard;
    float light = sqrt(1.0 - far), alpha = sqrt(light);
    color = vec4(1.6 * color_of(temperature) * light * alpha, alpha);
}
