#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/terrain.glsl"
#include "water/surface.glsl"

// Clear water: what it mirrors (sky, and the shore by a walk over the heightmap), and what is seen through it (the lit
// ground, tinted by the way that the light goes through water), mixed by Schlick's form of Fresnel's equations.

layout(location = 0) in vec3 at_m;
layout(location = 1) in vec3 slope;
layout(location = 2) in vec3 flow;  // speed along x and z (m/s), and share of white water
layout(location = 0) out vec4 color;

const vec3 ABSORPTION = vec3(0.62, 0.16, 0.13);  // (1/m)
const float THIN_M = 0.015;  // a film below this depth mirrors less, and ends without an edge (m)
const vec3 SCATTERED = vec3(0.006, 0.036, 0.042);

// Slopes of wind ripples that run both ways across each other, fading where a pixel covers many.
vec2 ripples(vec2 xz, float far) {
    float t = view.eye_m.w;
    vec2 slopes = noise_and_slope(xz * 1.3 + vec2(0.5, 0.3) * t).yz * 0.8 + noise_and_slope(xz * 2.9 - vec2(0.6, 0.9) * t).yz * 0.6;
    slopes += noise_and_slope(xz * 6.7 + vec2(-1.1, 0.7) * t).yz * 0.4;
    return p.ripple * slopes * exp(-far / 60.0);
}

vec3 mirrored(vec3 from_m, vec3 dir) {
    float cell_m = min(p.size_m.x / float(p.cells.x), 0.25), far = 2.4 * cell_m, before = 0.0;
    for (int i = 0; i < 26; ++i) {
        vec3 at = from_m + far * dir;
        if (any(greaterThan(abs(at.xz), 0.5 * view.terrain_size_m))) break;
        float ground = terrain_height(at.xz);
        if (ground > at.y) {
            for (int k = 0; k < 4; ++k) {  // where between the last two steps
                float mid = 0.5 * (before + far);
                bool is_under = terrain_height(from_m.xz + mid * dir.xz) > from_m.y + mid * dir.y;
                if (is_under) far = mid;
                else before = mid;
            }
            at = from_m + far * dir;
            vec3 n = terrain_normal_at(at.xz);
            return with_haze(terrain_lit(at, n, terrain_light(at.xz), 0.0), at - from_m);
        }
        before = far;
        far += max(0.55 * (at.y - ground), 0.06 * far + 0.8 * cell_m);
    }
    return clouded_sky(dir);
}

// Ground below the surface, in the light that reaches it. Bent water gathers the sun to caustics: a lens of curvature
// `slope.z` focuses at a depth of 4 / slope.z for water's index.
vec3 through(vec3 dir, float depth_m) {
    float way = depth_m / max(-dir.y, 0.3);
    for (int i = 0; i < 2; ++i) {  // where the ground rises along the ray, it is met sooner
        float deep = max(at_m.y - terrain_height(at_m.xz + way * dir.xz), 0.0);
        way = min(way, 0.5 * (way + deep / max(-dir.y, 0.3)));
    }
    vec3 ground = at_m + way * dir;
    vec3 n = terrain_normal_at(ground.xz);
    float lens = clamp(1.0 / max(1.0 + 0.25 * depth_m * slope.z, 0.3), 0.4, 2.6);
    float sunlight = depth_m / max(view.to_sun.y, 0.3);
    float detail = exp(-length(ground - view.eye_m.xyz) / 120.0);
    vec3 lit = terrain_lit(ground, n, terrain_light(ground.xz), detail) * lens;
    lit *= 1.0 - 0.5 * smoothstep(0.0005, 0.01, depth_m) * smoothstep(0.0, 0.3, ground.y);  // soaked; shores are so already
    vec3 clear = exp(-ABSORPTION * (way + sunlight));
    return lit * clear + SCATTERED * SUN_LIGHT * (1.0 - exp(-ABSORPTION.g * 2.0 * way));
}

// Noise that goes with the flow for a second at a time; a second one fades in as it is stretched too far.
float drifting(vec2 xz, float scale) {
    float t = view.eye_m.w, sum = 0.0;
    for (int k = 0; k < 2; ++k) {
        float phase = fract(t + 0.5 * float(k)), turn = floor(t + 0.5 * float(k));
        float weight = 1.0 - abs(2.0 * phase - 1.0);
        sum += weight * fbm(scale * (xz - phase * flow.xy) + 17.3 * turn + 5.1 * float(k), 4);
    }
    return sum;
}

void main() {
    vec3 from_eye = at_m - view.eye_m.xyz;
    float far = length(from_eye);
    vec3 dir = from_eye / far;
    vec2 fine = ripples(at_m.xz, far);
    vec3 n = normalize(vec3(-slope.x - fine.x, 1.0, -slope.y - fine.y));
    n = normalize(n + dir * max(0.02 - dot(n, -dir), 0.0) * 1.5);  // no wave faces away from the eye

    float facing = max(dot(n, -dir), 0.0);
    vec3 up = reflect(dir, n);
    up.y = abs(up.y);
    vec3 reflected = mirrored(at_m, up);
    float depth_m = max(at_m.y - terrain_height(at_m.xz), 0.0);
    float film = smoothstep(0.0, THIN_M, depth_m);
    float mirror = film * (0.02 + 0.98 * pow(1.0 - facing, 5.0));
    vec3 seen = through(refract(dir, n, 1.0 / 1.33), depth_m);

    vec3 arrives = terrain_light(at_m.xz);
    vec3 half_way = normalize(view.to_sun.xyz - dir);
    float glint = pow(max(dot(n, half_way), 0.0), 700.0) * 5.0 + pow(max(dot(n, half_way), 0.0), 90.0) * 0.025;
    vec3 water = mix(seen, reflected, mirror) + SUN_LIGHT * film * glint * arrives.x * (0.3 + 0.7 * mirror);

    vec3 foam = vec3(0.75) * (SUN_LIGHT * arrives.x * max(view.to_sun.y, 0.0) + SKY_LIGHT * arrives.y);
    if (p.foam_m > 0.0) {  // a thin wash where the water runs out
        float edge = smoothstep(p.foam_m, p.foam_m / 11.0, depth_m + p.foam_m * 4.0 / 11.0 * fbm(at_m.xz * 3.0, 3));
        float bubbles = smoothstep(-0.1, 0.45, fbm(at_m.xz * 7.0 + 0.2 * view.eye_m.w, 3) + 0.35 * edge);
        water = mix(water, foam, 0.55 * edge * bubbles);
    }
    if (flow.z > 0.0) {  // air in the water makes it milky; bubbles come up in patches
        vec3 milky = vec3(0.2, 0.27, 0.26) * (SUN_LIGHT * arrives.x * max(view.to_sun.y, 0.0) + SKY_LIGHT * arrives.y);
        water = mix(water, milky, 0.55 * flow.z * smoothstep(0.0, 0.25, depth_m));
        float patches = drifting(at_m.xz, 1.1) + 0.6 * drifting(at_m.xz, 4.3);
        water = mix(water, foam, 0.85 * smoothstep(0.05, 0.75, patches + 1.1 * flow.z - 0.45));
    }
    color = vec4(with_haze(water, from_eye) * view.daylight, 1.0);
}
