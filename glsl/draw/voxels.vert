#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/voxels.glsl"

// A box for each cell that something is in: 36 vertices an instance.

void main() {
    Plane plane;
    if (!voxel(plane)) return;
    uint face = uint(gl_VertexIndex) / 6u, corner = uint[6](0u, 1u, 2u, 2u, 1u, 3u)[uint(gl_VertexIndex) % 6u];
    uint axis = face >> 1u;
    vec3 out_of = vec3(0.0), right = vec3(0.0), up = vec3(0.0);
    out_of[axis] = (face & 1u) == 0u ? 1.0 : -1.0;
    right[(axis + 1u) % 3u] = 1.0;
    up[(axis + 2u) % 3u] = 1.0;
    vec2 place = vec2(corner & 1u, corner >> 1u) * 2.0 - 1.0;
    facing = out_of;
    at_m = cell_m.xyz + cell_m.w * (out_of + right * place.x + up * place.y);
    gl_Position = view.clip_from_world * vec4(at_m, 1.0);
}
