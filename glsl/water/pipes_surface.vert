#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/grid.glsl"
#include "water/surface.glsl"

// The surface of water.pipes: as surface.vert, and what the pipes on its sides carry as a speed.

layout(set = 0, binding = 4, std430) readonly buffer Flow { float flow_mps[]; };  // planes: from the right, from below

layout(location = 0) out vec3 at_m;
layout(location = 1) out vec3 slope;  // d height / dx, d height / dz, and the sum of the second derivatives (1/m)
layout(location = 2) out vec3 flow;   // speed along x and z (m/s), and share of white water

float pipe(ivec2 c, uint plane) {
    if (any(lessThan(c, ivec2(0)))) return 0.0;
    return flow_mps[(plane * p.cells.y + uint(c.y)) * p.pitch + uint(c.x)];
}

void main() {
    ivec2 c = ivec2(grid_vertex(p.cells));
    float h = or_rest(surface_sample(c));
    float west = or_own(surface_sample(c - ivec2(1, 0)), h), east = or_own(surface_sample(c + ivec2(1, 0)), h);
    float north = or_own(surface_sample(c - ivec2(0, 1)), h), south = or_own(surface_sample(c + ivec2(0, 1)), h);
    vec2 cell_m = p.size_m / vec2(p.cells);
    float bend = (west + east - 2.0 * h) / (cell_m.x * cell_m.x) + (north + south - 2.0 * h) / (cell_m.y * cell_m.y);
    slope = vec3((east - west) / (2.0 * cell_m.x), (south - north) / (2.0 * cell_m.y), bend);

    float right = pipe(c, 0u), left = pipe(c - ivec2(1, 0), 0u), below = pipe(c, 1u), above = pipe(c - ivec2(0, 1), 1u);
    vec2 speed_mps = -0.5 * p.speeds * vec2(left + right, above + below);  // flow is stored as it comes in
    float depth_m = cell_m.x / p.speeds;
    flow = vec3(speed_mps, white_share(speed_mps, right - left + below - above, depth_m));
    vec2 xz = column_centre_m(uvec2(c));
    at_m = vec3(xz.x, p.level_m + h, xz.y);
    gl_Position = view.clip_from_world * vec4(at_m, 1.0);
}
