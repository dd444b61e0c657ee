#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/grid.glsl"
#include "water/surface.glsl"

// The surface as triangles between the centres of columns, heights pulled from the buffer that the simulation wrote.

layout(location = 0) out vec3 at_m;
layout(location = 1) out vec3 slope;  // d height / dx, d height / dz, and the sum of the second derivatives (1/m)
layout(location = 2) out vec3 flow;   // speed along x and z (m/s), and share of white water

void main() {
    ivec2 c = ivec2(grid_vertex(p.cells));
    float h = or_rest(surface_sample(c));
    float west = or_own(surface_sample(c - ivec2(1, 0)), h), east = or_own(surface_sample(c + ivec2(1, 0)), h);
    float north = or_own(surface_sample(c - ivec2(0, 1)), h), south = or_own(surface_sample(c + ivec2(0, 1)), h);
    vec2 cell_m = p.size_m / vec2(p.cells);
    float bend = (west + east - 2.0 * h) / (cell_m.x * cell_m.x) + (north + south - 2.0 * h) / (cell_m.y * cell_m.y);
    slope = vec3((east - west) / (2.0 * cell_m.x), (south - north) / (2.0 * cell_m.y), bend);
    flow = vec3(0.0);
    vec2 xz = column_centre_m(uvec2(c));
    at_m = vec3(xz.x, p.level_m + h, xz.y);
    gl_Position = view.clip_from_world * vec4(at_m, 1.0);
}
