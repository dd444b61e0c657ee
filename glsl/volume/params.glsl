// What every pass of `volume` is told, and the keys that triangles compete for a cell with.
#include "cells/cells.glsl"

// Mirrors `volume::VolumeParams`.
struct VolumeParams {
    Grid grid;
    uint first;         // of the triangles at hand
    uint triangles;     // at hand
    uint bits;          // of a key that say which triangle
    uint only_changed;  // `second`: cells whose first plane is not the still meshes'; `extend`: whose first or second is not
    uint rows;          // most workgroups a large triangle
    uint way;           // that most particles go, for what is drawn: an axis, plus 3 if down it
};

layout(push_constant, std430) uniform Push { VolumeParams p; };

const uint EMPTY = 0xffffffffu;  // a key of no triangle

// Spelt out, so that every stage rounds alike.
float precise_dot(vec3 a, vec3 b) {
    precise float sum = a.x * b.x + a.y * b.y + a.z * b.z;
    return sum;
}

// Of a cell's centre from the plane of a triangle (m).
float centre_distance_m(ivec3 cell, vec3 normal, vec3 a_m) {
    return precise_dot(normal, cell_centre_m(p.grid, cell) - a_m);
}

// Keys order triangles in a cell, and the lower wins: what is compared, in as many steps as there are bits to spare, and
// the triangle, so that no two are equal and the order of threads decides nothing.
uint key_of(float share, uint t) {
    uint most = (1u << (32u - p.bits)) - 1u;
    return min(uint(clamp(share, 0.0, 1.0) * float(most)), most) << p.bits | t;
}
// The second plane of a cell: where the first is still the still meshes' own, what they offered counts as well.
uint second_with(uint first, uint second, uvec2 still) { return first == still.x ? min(second, still.y) : second; }

uint key_triangle(uint key) { return key & ((1u << p.bits) - 1u); }
