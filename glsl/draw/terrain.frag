#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/terrain.glsl"

layout(location = 0) in vec3 at_m;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 arrives;
layout(location = 0) out vec4 color;

void main() {
    vec3 from_eye = at_m - view.eye_m.xyz;
    float far = length(from_eye);
    float detail = exp(-far / 120.0);
    vec3 n = normalize(normal);
    if (detail > 0.02) {  // roughness that the heightmap is too coarse for
        vec2 bumps = noise_and_slope(at_m.xz * 1.9).yz * 0.12 + noise_and_slope(at_m.xz * 5.3).yz * 0.1;
        n = normalize(n + detail * vec3(-bumps.x, 0.0, -bumps.y));
    }
    vec3 lit = with_haze(terrain_lit(at_m, n, arrives, detail), from_eye) * view.daylight;
    color = vec4(lit + terrain_albedo(at_m, n.y, detail) * lamp_light(at_m, n), 1.0);
}
