// Triangles as `mesh.pose` left them, pulled by their number: three vertices a triangle, no vertex buffers.
#ifndef MESH_BINDING
#define MESH_BINDING 3
#endif

#include "draw/mesh_params.glsl"

layout(set = 0, binding = MESH_BINDING, std430) readonly buffer Triangles { uint triangle[]; };
layout(set = 0, binding = MESH_BINDING + 1, std430) readonly buffer Places { float places[]; };

uint mesh_vertex() { return triangle[3u * p.first_triangle + uint(gl_VertexIndex)]; }

vec3 vertex_place(uint v) { return vec3(places[6u * v], places[6u * v + 1u], places[6u * v + 2u]); }
