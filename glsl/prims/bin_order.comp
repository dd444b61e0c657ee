#version 460
#extension GL_GOOGLE_include_directive : require

// Counting sort, last: the scheduler decided the order within a bin; here it becomes that of the indices, so that a sort is
// stable and the same in every run. An invocation a bin: insertion, which moves little where few are out of order, and a
// heap for bins of many. CPU twin: prims::cpu::sort_by_key.

layout(local_size_x = 256) in;
#include "prims/params.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Firsts { uint firsts[]; };
layout(set = 0, binding = 1, std430) buffer Order { uint order[]; };

const uint FEW = 32u;

void sink(uint first, uint at, uint size) {
    uint value = order[first + at];
    while (true) {
        uint child = 2u * at + 1u;
        if (child >= size) break;
        uint one = order[first + child];
        if (child + 1u < size) {
            uint other = order[first + child + 1u];
            if (other > one) {
                one = other;
                ++child;
            }
        }
        if (one <= value) break;
        order[first + at] = one;
        at = child;
    }
    order[first + at] = value;
}

void main() {
    uint bin = tile_index() * GROUP + gl_LocalInvocationIndex;
    if (bin >= p.bins) return;
    uint first = firsts[bin], end = bin + 1u < p.bins ? firsts[bin + 1u] : p.count;
    uint size = end - first;
    if (size <= FEW) {
        for (uint i = first + 1u; i < end; ++i) {
            uint value = order[i], j = i;
            for (; j > first; --j) {
                uint before = order[j - 1u];
                if (before <= value) break;
                order[j] = before;
            }
            order[j] = value;
        }
        return;
    }
    for (uint i = size / 2u; i > 0u; --i) sink(first, i - 1u, size);
    for (uint last = size - 1u; last > 0u; --last) {
        uint largest = order[first];
        order[first] = order[first + last];
        order[first + last] = largest;
        sink(first, 0u, last);
    }
}
