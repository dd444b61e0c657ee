#version 460
#extension GL_GOOGLE_include_directive : require
// Which cells have an occupied one within `reach` cells along every axis: one bit a cell, as `Occupied` has them. A particle
// that cannot leave that reach in a step, and whose own bit is clear, needs no other look. Behind them half a word a cell:
// which planes are met in it, its own and those it lacks and a cell beside it has. An invocation looks at 32 cells.
// CPU twin: particles::cpu_near::near.
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

uint index_of(ivec3 cell) { return uint(cell.x) + p.cells_x * (uint(cell.y) + p.cells_y * uint(cell.z)); }

// Bit k: plane k of `cell_of_met` is met in this cell. A cell that is full borrows what is like none that it has.
uint met_in(ivec3 cell) {
    uint i = index_of(cell);
    Plane one = plane_of(i, 0u), two = plane_of(i, 1u);
    if (two.triangle == 0u) return 1u;
    uint met = 3u;
    for (uint k = 2u; k < 14u; ++k) {
        ivec3 beside = cell_of_met(cell, k);
        if (!in_box(beside) || !is_occupied(index_of(beside))) continue;
        Plane lent = plane_of(index_of(beside), k & 1u);
        if (lent.triangle == 0u || !is_missing(lent, one, two, (k >> 1u) - 1u, p.cell_m)) continue;
        bool is_new = true;
        for (uint bits = met & ~3u; bits != 0u && is_new; bits &= bits - 1u) {
            uint other = uint(findLSB(bits));
            is_new = !is_alike(lent, plane_of(index_of(cell_of_met(cell, other)), other & 1u));
        }
        if (is_new) met |= 1u << k;
    }
    return met;
}

void main() {
    uint word = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    uint count = p.cells_x * p.cells_y * p.cells_z;
    uint words = (count + 31u) / 32u;
    if (word >= words) return;
    uint bits = 0u, pair = 0u;
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
        if (is_near && is_occupied(i)) pair |= met_in(ivec3(x, y, z)) << (16u * (b & 1u));
        if ((b & 1u) == 1u || i + 1u == count) {
            near[words + i / 2u] = pair;
            pair = 0u;
        }
    }
    near[word] = bits;
}
