#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"

// How much of the sun and of the sky each sample of the terrain sees, once for a scene: a ray towards the sun, and the
// horizon in twelve directions.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, std430) readonly buffer Terrain { float terrain_m[]; };
layout(set = 0, binding = 2, std430) buffer Light { uint light[]; };  // sun, sky, what it is built of

float height(vec2 at) {
    at = clamp(at, vec2(0.0), vec2(view.terrain_cells) - 1.001);
    ivec2 c = ivec2(at);
    vec2 f = at - vec2(c);
    uint i = uint(c.y) * view.terrain_cells.x + uint(c.x);
    uint below = i + view.terrain_cells.x;
    return mix(mix(terrain_m[i], terrain_m[i + 1u], f.x), mix(terrain_m[below], terrain_m[below + 1u], f.x), f.y);
}

void main() {
    uvec2 c = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(c, view.terrain_cells))) return;
    vec2 per_m = vec2(view.terrain_cells) / view.terrain_size_m;
    float cell_m = 1.0 / max(per_m.x, per_m.y);
    vec2 here = vec2(c);
    float base = height(here) + 0.05 * cell_m;

    // Penumbra: the nearest miss, as an angle.
    vec3 to_sun = view.to_sun.xyz;
    float along = length(to_sun.xz), sun = 1.0;
    if (along > 1e-4) {
        vec2 step_cells = to_sun.xz / along * per_m;
        float climb = to_sun.y / along, far = 1.5 * cell_m;
        for (int i = 0; i < 72; ++i) {
            float clear = base + far * climb - height(here + far * step_cells);
            sun = min(sun, 0.5 + 14.0 * clear / far);
            far *= 1.065;
            far += 0.35 * cell_m;
        }
    }

    // Sky: share of the hemisphere above the horizon, by solid angle and cosine.
    float sky = 0.0;
    for (int d = 0; d < 12; ++d) {
        float angle = (float(d) + 0.5) * 6.2831853 / 12.0;
        vec2 step_cells = vec2(cos(angle), sin(angle)) * per_m;
        float horizon = 0.0, far = cell_m;
        for (int i = 0; i < 12; ++i) {
            horizon = max(horizon, (height(here + far * step_cells) - base) / far);
            far *= 1.6;
        }
        sky += 1.0 / (1.0 + horizon * horizon);
    }
    uint i = c.y * view.terrain_cells.x + c.x;
    light[i] = packUnorm4x8(vec4(clamp(sun, 0.0, 1.0), sky / 12.0, unpackUnorm4x8(light[i]).zw));
}
