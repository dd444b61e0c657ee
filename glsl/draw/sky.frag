#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"

layout(location = 0) in vec2 at;
layout(location = 0) out vec4 color;

void main() {
    vec3 dir = normalize(view.ray_forward.xyz + at.x * view.ray_right.xyz + at.y * view.ray_up.xyz);
    vec3 sky = clouded_sky(dir);
    sky += SUN_LIGHT * 12.0 * smoothstep(0.99992, 0.99998, dot(dir, view.to_sun.xyz));
    color = vec4(sky, 1.0);
}
