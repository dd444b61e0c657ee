#version 460
#extension GL_GOOGLE_include_directive : require

// The position map: where each texel of a paint map is, now that the mesh is posed, and the box round each tile.
//     at = A + b (B - A) + c (C - A)
// The seed draws the mesh with its texture coordinates for places, every frame; but which triangle a texel lies in, and
// where in it, never changes: that was found at load (paint::Atlas), and what is left is this sum. CPU twin:
// paint::cpu::place. A workgroup a tile.

layout(local_size_x = 64) in;
#include "paint/map.glsl"
#include "paint/boxes.glsl"

// Mirrors `paint::PlaceParams`.
struct PlaceParams {
    uint first;  // tile, or block
    uint count;  // of them
    uint mesh;
};

layout(set = 0, binding = 0, std430) readonly buffer Texels { uint texels[]; };        // triangle as in Position, b, c
layout(set = 0, binding = 1, std430) readonly buffer Triangles { uint triangles[]; };  // three vertices each
layout(set = 0, binding = 2, std430) readonly buffer Places { float places[]; };       // at (m), velocity (m/s)
layout(set = 0, binding = 3, std430) writeonly buffer Positions { Position positions[]; };
layout(set = 0, binding = 4, std430) writeonly buffer Tiles { Box tiles[]; };

layout(push_constant, std430) uniform Push { PlaceParams p; };

bool is_finite(vec3 v) { return all(notEqual(floatBitsToUint(v) & 0x7f800000u, uvec3(0x7f800000u))); }

vec3 vertex(uint i) { return vec3(places[6u * i], places[6u * i + 1u], places[6u * i + 2u]); }

void main() {
    uint tile = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    if (tile >= p.count) return;  // the whole workgroup
    tile += p.first;
    uint i = TILE_TEXELS * tile + gl_LocalInvocationIndex;
    uint triangle = texels[3u * i];
    bool is_covered = triangle != 0u;
    vec3 at = vec3(0.0);
    if (is_covered) {
        uint corner = 3u * ((triangle & ~GUTTER) - 1u);
        vec3 a = vertex(triangles[corner]), b = vertex(triangles[corner + 1u]), c = vertex(triangles[corner + 2u]);
        vec2 share = uintBitsToFloat(uvec2(texels[3u * i + 1u], texels[3u * i + 2u]));
        precise vec3 sum = a + (b - a) * share.x + (c - a) * share.y;
        // What is no place is in no box: the least of it and a number would be either.
        is_covered = is_finite(sum);
        at = is_covered ? sum : vec3(0.0);
    }
    positions[i].at_m = at;
    positions[i].triangle = is_covered ? triangle : 0u;
    vec3 low = is_covered ? at : vec3(FARTHEST), high = is_covered ? at : vec3(-FARTHEST);
    uint covered = uint(is_covered);
    if (join_all(low, high, covered)) {
        tiles[tile].low_m = low;
        tiles[tile].mesh = p.mesh;
        tiles[tile].high_m = high;
        tiles[tile].covered = covered;
    }
}
