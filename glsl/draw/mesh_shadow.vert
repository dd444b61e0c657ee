#version 460
#extension GL_GOOGLE_include_directive : require
#define SHADOW_BINDING 0
#define SHADOW_CASTER
#define MESH_BINDING 1
#include "draw/shadow.glsl"
#include "draw/mesh.glsl"

// A vertex as the sun sees it.

void main() { gl_Position = vec4(shadow_place(vertex_place(mesh_vertex())), 1.0); }
