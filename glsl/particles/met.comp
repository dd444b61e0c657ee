#version 460
#extension GL_GOOGLE_include_directive : require
// Which planes are met in each cell, its own and those that it lacks and a cell beside it has: half a word a cell, behind the
// bits that `particles.near` writes. An invocation looks at two cells. CPU twin: particles::cpu_near::near.
#define CELLS_OCCUPIED 0
#define CELLS_PLANES 1
#include "cells/cells.glsl"
#include "particles/cell_bits.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 2, std430) writeonly buffer Near { uint near[]; };

#include "particles/near_params.glsl"

bool in_box(ivec3 cell) {
    return all(greaterThanEqual(cell, ivec3(0))) && all(lessThan(cell, ivec3(p.cells_x, p.cells_y, p.cells_z)));
}

uint index_of(ivec3 cell) { return uint(cell.x) + p.cells_x * (uint(cell.y) + p.cells_y * uint(cell.z)); }

// Bit k: plane k of `cell_of_met` is met in this cell. A cell that is full borrows what is like none that it has.
uint met_in(uint i) {
    ivec3 cell = ivec3(i % p.cells_x, i / p.cells_x % p.cells_y, i / p.cells_x / p.cells_y);
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
    uint pair = near_item(), count = p.cells_x * p.cells_y * p.cells_z;
    if (2u * pair >= count) return;
    uint met = 0u;
    for (uint k = 0u; k < 2u; ++k) {
        uint i = 2u * pair + k;
        if (i < count && is_occupied(i)) met |= met_in(i) << (16u * k);
    }
    near[(count + 31u) / 32u + pair] = met;
}
