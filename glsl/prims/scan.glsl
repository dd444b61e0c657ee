// Scan, last: each tile once more, from the sum of those before it, which `prims.sums` has worked out if there are many.
// Elements are read and written in whole lines, and turned in shared memory so that an invocation adds up sixteen
// neighbours. What was counted may be cleared on the way, for who counts again. CPU twin: prims::cpu::exclusive_scan.
layout(local_size_x = 256) in;
#include "prims/params.glsl"
#include "prims/group.glsl"

layout(constant_id = 0) const bool clears = false;

layout(set = 0, binding = 0, std430) buffer Values { uint values[]; };
layout(set = 0, binding = 1, std430) buffer Sums { uint sums[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Scanned { uint scanned[]; };

shared uint turned[TILE + TILE / ITEMS];  // rows of an invocation, each one word further: no two in one bank

uint place(uint i) { return i + i / ITEMS; }

void main() {
    uint tile = tile_index(), lane = gl_LocalInvocationIndex;
    if (tile >= p.tiles) return;  // the whole workgroup
    for (uint k = 0u; k < ITEMS; ++k) {
        uint at = k * GROUP + lane, i = tile * TILE + at;
        turned[place(at)] = i < p.count ? values[i] : 0u;
        if (clears && i < p.count) values[i] = 0u;
    }
    uint tiles_before = 0u;
    if (p.tiles > FEW_TILES) {
        tiles_before = sums[tile];
    } else {
        uint part = 0u;
        for (uint k = lane; k < tile; k += GROUP) part += sums[k];
        group_exclusive(part, tiles_before);
    }
    barrier();
    uint own[ITEMS], sum = 0u;
    for (uint k = 0u; k < ITEMS; ++k) {
        own[k] = turned[place(lane * ITEMS + k)];
        sum += own[k];
    }
    uint total;
    uint before = tiles_before + group_exclusive(sum, total);
    if (p.tiles <= FEW_TILES && tile + 1u == p.tiles && lane == 0u) sums[p.tiles] = before + total;  // nobody reads that word here
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
