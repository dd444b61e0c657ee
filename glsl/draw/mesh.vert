#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/mesh.glsl"

// A vertex in the world. Its normal at rest is turned by the cofactors of the matrix that moves it: right for any scale.

layout(set = 0, binding = 5, std430) readonly buffer Rest { uint rest[]; };             // 13 words a vertex
layout(set = 0, binding = 6, std430) readonly buffer Matrices { vec4 matrix_rows[]; };  // a mesh has three poses, of which the first is now, of three rows a joint

layout(location = 0) out vec3 at_m;
layout(location = 1) out vec3 normal;
layout(location = 2) out vec2 uv;

void main() {
    uint v = mesh_vertex(), word = 13u * v;
    at_m = vertex_place(v);
    uvec4 joints = uvec4(rest[word + 8u], rest[word + 8u] >> 16u, rest[word + 9u], rest[word + 9u] >> 16u) & 0xffffu;
    vec3 three = uintBitsToFloat(uvec3(rest[word + 10u], rest[word + 11u], rest[word + 12u]));
    vec4 weights = vec4(three, max(1.0 - three.x - three.y - three.z, 0.0));
    mat3 rows = mat3(0.0);
    for (uint k = 0u; k < 4u; ++k) {
        if (weights[k] == 0.0) continue;
        for (uint r = 0u; r < 3u; ++r) rows[r] += weights[k] * matrix_rows[3u * (3u * p.first_joint + joints[k]) + r].xyz;
    }
    vec3 n = uintBitsToFloat(uvec3(rest[word + 3u], rest[word + 4u], rest[word + 5u]));
    normal = vec3(dot(cross(rows[1], rows[2]), n), dot(cross(rows[2], rows[0]), n), dot(cross(rows[0], rows[1]), n));
    uv = uintBitsToFloat(uvec2(rest[word + 6u], rest[word + 7u]));
    gl_Position = view.clip_from_world * vec4(at_m, 1.0);
}
