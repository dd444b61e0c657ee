#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/terrain.glsl"
#include "draw/grid.glsl"

layout(location = 0) out vec3 at_m;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec3 arrives;  // share of sun and of sky, and what is built

void main() {
    uvec2 c = grid_vertex(view.terrain_cells);
    vec2 xz = ((vec2(c) + 0.5) / vec2(view.terrain_cells) - 0.5) * view.terrain_size_m;
    at_m = vec3(xz.x, terrain_sample(ivec2(c)), xz.y);
    normal = terrain_normal(ivec2(c));
    arrives = light_sample(ivec2(c));
    gl_Position = view.clip_from_world * vec4(at_m, 1.0);
}
