#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/map_view.glsl"

layout(location = 0) out vec2 uv;

void main() {
    uint corner = uint[6](0u, 1u, 2u, 2u, 1u, 3u)[uint(gl_VertexIndex)];
    uv = vec2(corner & 1u, corner >> 1u);
    vec2 at = (p.corner.xy + uv * p.corner.zw) / vec2(view.pixels) * 2.0 - 1.0;
    gl_Position = vec4(at.x, -at.y, 1.0, 1.0);  // nearer than all else
}
