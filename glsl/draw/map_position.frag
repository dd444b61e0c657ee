#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/map_view.glsl"

// Where in the world each texel is: x, y and z as red, green and blue. Grey: no mesh. Darker: beside a chart.

layout(set = 0, binding = 1, std430) readonly buffer Positions { Position positions[]; };

layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;

void main() {
    Position position = positions[texel_at(p.map, uv)];
    vec3 place = (position.at_m - p.low_m.xyz) / max(p.high_m.xyz - p.low_m.xyz, vec3(1e-6));
    vec3 shown = position.triangle == 0u ? vec3(0.08) : clamp(place, 0.0, 1.0);
    if ((position.triangle & GUTTER) != 0u) shown *= 0.4;
    color = vec4(shown * shown, 1.0);
}
