#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/grid.glsl"
#include "water/surface.glsl"
#include "water/depth_surface.glsl"

// The surface of water over ground: as surface.vert, but hidden where it is dry, with the speed of the flow.

layout(set = 0, binding = 4, std430) readonly buffer Flow { float flow_at[]; };  // of four columns: east, then south faces

layout(location = 0) out vec3 at_m;
layout(location = 1) out vec3 slope;  // d height / dx, d height / dz, and the sum of the second derivatives (1/m)
layout(location = 2) out vec3 flow;   // speed along x and z (m/s), and share of white water

float face(ivec2 c, uint side) {
    if (any(lessThan(c, ivec2(0)))) return 0.0;
    uint i = uint(c.y) * p.pitch + uint(c.x);
    return flow_at[(i / 4u) * 8u + 4u * side + i % 4u];
}

float or_mine(Column other, float mine) { return other.is_wet ? other.surface : mine; }

void main() {
    ivec2 c = ivec2(grid_vertex(p.cells));
    Column here = column_at(c);
    float h = drawn_height(c, here);
    const ivec2 X = ivec2(1, 0), Z = ivec2(0, 1);
    float west = or_mine(column_at(c - X), h), east = or_mine(column_at(c + X), h);
    float north = or_mine(column_at(c - Z), h), south = or_mine(column_at(c + Z), h);
    vec2 cell_m = p.size_m / vec2(p.cells);
    float bend = (west + east - 2.0 * h) / (cell_m.x * cell_m.x) + (north + south - 2.0 * h) / (cell_m.y * cell_m.y);
    slope = here.is_wet ? vec3((east - west) / (2.0 * cell_m.x), (south - north) / (2.0 * cell_m.y), bend) : vec3(0.0);

    vec4 sides = vec4(face(c - X, 0u), face(c, 0u), face(c - Z, 1u), face(c, 1u));
    sides *= p.speeds > 0.0 ? p.speeds : 1.0 / max(here.depth, 0.02);
    vec2 speed_mps = 0.5 * (sides.xz + sides.yw);
    float rising_mps = here.depth * ((sides.x - sides.y) / cell_m.x + (sides.z - sides.w) / cell_m.y);
    flow = here.is_wet ? vec3(speed_mps, white_share(speed_mps, rising_mps, here.depth)) : vec3(0.0);

    vec2 xz = column_centre_m(uvec2(c));
    at_m = vec3(xz.x, p.level_m + h, xz.y);
    gl_Position = view.clip_from_world * vec4(at_m, 1.0);
}
