#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"

layout(location = 0) in vec2 at;
layout(location = 0) out vec4 color;

// One star in a cell of directions at the most, dim ones more often.
vec3 stars(vec3 dir) {
    vec3 a = abs(dir);
    vec3 face = a.x > max(a.y, a.z) ? dir.xyz : a.y > a.z ? dir.yzx : dir.zxy;
    vec2 at = 90.0 * face.yz / abs(face.x) + (face.x > 0.0 ? 400.0 : 1000.0) * (1.0 + float(a.y > max(a.x, a.z)));
    ivec2 c = ivec2(floor(at));
    vec2 place = vec2(hash2(c), hash2(c + ivec2(511, 67))) * 0.8 + 0.1;
    float size = hash2(c + ivec2(91, 1023));
    float bright = 0.5 * pow(size, 24.0) * smoothstep(-0.02, 0.25, dir.y);
    vec2 off = at - vec2(c) - place;
    return vec3(0.9, 0.95, 1.0) * bright * exp(-dot(off, off) * 180.0);
}

void main() {
    vec3 dir = normalize(view.ray_forward.xyz + at.x * view.ray_right.xyz + at.y * view.ray_up.xyz);
    vec3 sky = clouded_sky(dir);
    sky += SUN_LIGHT * 12.0 * smoothstep(0.99992, 0.99998, dot(dir, view.to_sun.xyz));
    color = vec4(sky * view.daylight + (1.0 - view.daylight) * stars(dir), 1.0);
}
