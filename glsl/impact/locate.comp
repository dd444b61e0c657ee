#version 460
#extension GL_GOOGLE_include_directive : require
// On which mesh an impact is, and where on its texture: the texture coordinates of the corners, weighed as the point of the
// triangle nearest to the impact is made of them (Ericson, "Real-Time Collision Detection", 2005, section 5.1.5).
// CPU twin: impact::cpu::locate.
#define IMPACTS_BINDING 0
#define IMPACTS_ACCESS
#define IMPACT_COUNT_BINDING 1
#include "impact/impact.glsl"
#include "impact/nearest.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 2, std430) readonly buffer Places { float places[]; };      // six words a vertex: at (m), velocity (m/s)
layout(set = 0, binding = 3, std430) readonly buffer Triangles { uint corners[]; };   // three vertices a triangle
layout(set = 0, binding = 4, std430) readonly buffer Uvs { float uvs[]; };            // two words a vertex
layout(set = 0, binding = 5, std430) readonly buffer Firsts { uint first_triangle[]; };  // of each mesh, then of all

// Mirrors `impact::LocateParams`.
struct LocateParams { uint meshes; };
layout(push_constant, std430) uniform Push { LocateParams p; };

vec3 place_of(uint vertex) { return vec3(places[6u * vertex], places[6u * vertex + 1u], places[6u * vertex + 2u]); }
vec2 uv_of(uint vertex) { return vec2(uvs[2u * vertex], uvs[2u * vertex + 1u]); }

void main() {
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * IMPACT_GROUP + gl_LocalInvocationIndex;
    if (i >= impact_count.count) return;
    uint triangle = impacts[i].triangle;
    if (triangle == 0u || triangle > first_triangle[p.meshes]) return;  // of no mesh: stays NO_MESH
    --triangle;
    uint mesh = 0u;  // the last that does not begin after it
    for (uint after = p.meshes; after - mesh > 1u;) {
        uint middle = (mesh + after) / 2u;
        if (first_triangle[middle] <= triangle) mesh = middle;
        else after = middle;
    }
    uint a = corners[3u * triangle], b = corners[3u * triangle + 1u], c = corners[3u * triangle + 2u];
    vec3 weights = nearest_weights(impacts[i].at_m, place_of(a), place_of(b), place_of(c));
    vec2 one = uv_of(a), two = uv_of(b), three = uv_of(c);
    precise vec2 uv = (one * weights.x + two * weights.y) + three * weights.z;
    impacts[i].u = uv.x;
    impacts[i].v = uv.y;
    impacts[i].mesh = mesh;
}
