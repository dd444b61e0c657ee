#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/voxels.glsl"

// What a cell knows of the surface in it: a square on its plane, as large as to reach its corners; what is outside the cell
// is left out when it is drawn. Six vertices an instance.

void main() {
    Plane plane;
    if (!voxel(plane)) return;
    uint corner = uint[6](0u, 1u, 2u, 2u, 1u, 3u)[uint(gl_VertexIndex)];
    vec2 place = (vec2(corner & 1u, corner >> 1u) * 2.0 - 1.0) * 1.7321 * cell_m.w;
    vec3 n = plane.normal, side = normalize(abs(n.y) < 0.9 ? vec3(n.z, 0.0, -n.x) : vec3(0.0, -n.z, n.y));
    facing = n;
    at_m = cell_m.xyz - plane.distance_m * n + side * place.x + cross(n, side) * place.y;
    gl_Position = view.clip_from_world * vec4(at_m, 1.0);
}
