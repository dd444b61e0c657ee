// Scan, last of three: each tile once more, from the sum of those before it. Elements are read and written in whole lines,
// and turned in shared memory so that an invocation adds up sixteen neighbours. CPU twin: prims::cpu::exclusive_scan.
layout(local_size_x = 256) in;
#include "prims/params.glsl"
#include "prims/group.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Values { uint values[]; };
layout(set = 0, binding = 1, std430) readonly buffer Sums { uint sums[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Scanned { uint scanned[]; };

shared uint turned[TILE + TILE / ITEMS];  // rows of an invocation, each one word further: no two in one bank

uint place(uint i) { return i + i / ITEMS; }

void main() {
    uint tile = tile_index(), lane = gl_LocalInvocationIndex;
    if (tile >= p.tiles) return;  // the whole workgroup
    for (uint k = 0u; k < ITEMS; ++k) {
        uint at = k * GROUP + lane, i = tile * TILE + at;
        turned[place(at)] = i < p.count ? values[i] : 0u;
    }
    barrier();
    uint own[ITEMS], sum = 0u;
    for (uint k = 0u; k < ITEMS; ++k) {
        own[k] = turned[place(lane * ITEMS + k)];
        sum += own[k];
    }
    uint total;
    uint before = sums[tile] + group_exclusive(sum, total);
    for (uint k = 0u; k < ITEMS; ++k) {
        turned[place(lane * ITEMS + k)] = before;
        before += own[k];
    }
    barrier();
    for (uint k = 0u; k < ITEMS; ++k) {
        uint at = k * GROUP + lane, i = tile * TILE + at;
        if (i < p.count) scanned[i] = turned[place(at)];
    }
}
