#version 460
#extension GL_GOOGLE_include_directive : require
// Which cells have an occupied one within `reach` cells along every axis: one bit a cell, as `Occupied` has them. A particle
// that cannot leave that reach in a step, and whose own bit is clear, needs no other look. Behind them one more bit a cell:
// whether it lacks a plane that a cell beside it has. An invocation makes a word of each.
// CPU twin: particles::cpu_colliding::near.
#define CELLS_OCCUPIED 0
#define CELLS_PLANES 1
#include "cells/cells.glsl"
#include "particles/cell_bits.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 2, std430) writeonly buffer Near { uint near[]; };

// Mirrors `particles::NearParams`.
struct NearParams {
    uint cells_x;
    uint cells_y;
    uint cells_z;
    uint reach;  // cells
    float cell_m;
};
layout(push_constant, std430) uniform Push { NearParams p; };

bool in_box(ivec3 cell) {
    return all(greaterThanEqual(cell, ivec3(0))) && all(lessThan(cell, ivec3(p.cells_x, p.cells_y, p.cells_z)));
}

bool is_crowded(uint i, ivec3 cell) {
    Plane one = plane_of(i, 0u), two = plane_of(i, 1u);
    if (two.triangle == 0u) return false;
    for (uint face = 0u; face < 6u; ++face) {
        ivec3 beside = cell_beside(cell, face);
        if (!in_box(beside)) continue;
        uint j = uint(beside.x) + p.cells_x * (uint(beside.y) + p.cells_y * uint(beside.z));
        if (!is_occupied(j)) continue;
        Plane first = plane_of(j, 0u), second = plane_of(j, 1u);
        if (is_missing(first, one, two, face, p.cell_m)) return true;
        if (second.triangle != 0u && is_missing(second, one, two, face, p.cell_m)) return true;
    }
    return false;
}

void main() {
    uint word = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    uint count = p.cells_x * p.cells_y * p.cells_z;
    if (word >= (count + 31u) / 32u) return;
    uint bits = 0u, crowded = 0u;
    for (uint b = 0u; b < 32u && 32u * word + b < count; ++b) {
        uint i = 32u * word + b, x = i % p.cells_x, y = i / p.cells_x % p.cells_y, z = i / p.cells_x / p.cells_y;
        uint from_x = x - min(x, p.reach), to_x = min(x + p.reach, p.cells_x - 1u);
        uint from_y = y - min(y, p.reach), to_y = min(y + p.reach, p.cells_y - 1u);
        uint from_z = z - min(z, p.reach), to_z = min(z + p.reach, p.cells_z - 1u);
        bool is_near = false;
        for (uint k = from_z; k <= to_z && !is_near; ++k) {
            for (uint j = from_y; j <= to_y && !is_near; ++j) {
                is_near = occupied_bits(from_x + p.cells_x * (j + p.cells_y * k), to_x - from_x + 1u) != 0u;
            }
        }
        if (is_near) bits |= 1u << b;
        if (is_near && is_occupied(i) && is_crowded(i, ivec3(x, y, z))) crowded |= 1u << b;
    }
    near[word] = bits;
    near[(count + 31u) / 32u + word] = crowded;
}
