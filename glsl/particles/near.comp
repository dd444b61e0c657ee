#version 460
#extension GL_GOOGLE_include_directive : require
// Which cells have an occupied one within `reach` cells along every axis: one bit a cell, as `Occupied` has them. A particle
// that cannot leave that reach in a step, and whose own bit is clear, needs no other look. A cube is a row of rows of rows:
// bits are spread along x, of that along y, and of that along z. An invocation has 32 cells.
// CPU twin: particles::cpu_near::near.
#include "cells/cells.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint axis = 0u;

layout(set = 0, binding = 0, std430) readonly buffer From { uint occupied[]; };
layout(set = 0, binding = 1, std430) writeonly buffer To { uint spread[]; };

#include "particles/cell_bits.glsl"
#include "particles/near_params.glsl"

void main() {
    uint word = near_item();
    uint count = p.cells_x * p.cells_y * p.cells_z;
    if (word >= (count + 31u) / 32u) return;
    // A step along the axis, and how many there are.
    uint stride = axis == 0u ? 1u : axis == 1u ? p.cells_x : p.cells_x * p.cells_y;
    uint most = (axis == 0u ? p.cells_x : axis == 1u ? p.cells_y : p.cells_z) - 1u;
    uint bits = 0u;
    for (uint b = 0u; b < 32u && 32u * word + b < count;) {
        uint i = 32u * word + b, along = i / stride % (most + 1u);
        uint from = along - min(along, p.reach), to = min(along + p.reach, most);
        uint first = i - (along - from) * stride;
        if (axis == 0u) {
            bits |= uint(occupied_bits(first, to - from + 1u) != 0u) << b;
            ++b;
            continue;
        }
        // Cells as far along are looked at together.
        uint together = min(min(stride - i % stride, 32u - b), count - i);
        uint found = 0u;
        for (uint k = from; k <= to; ++k) found |= occupied_bits(first + (k - from) * stride, together);
        bits |= found << b;
        b += together;
    }
    spread[word] = bits;
}
