// Scan, first of three: the sum of each tile, read in whole lines. With FLAGS, how many are not 0.
// CPU twin: prims::cpu::exclusive_scan.
layout(local_size_x = 256) in;
#include "prims/params.glsl"
#include "prims/group.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Values { uint values[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Sums { uint sums[]; };

void main() {
    uint tile = tile_index();
    if (tile >= p.tiles) return;  // the whole workgroup
    uint sum = 0u;
    for (uint k = 0u; k < ITEMS; ++k) {
        uint i = tile * TILE + k * GROUP + gl_LocalInvocationIndex;
        if (i < p.count) {
#ifdef FLAGS
            sum += uint(values[i] != 0u);
#else
            sum += values[i];
#endif
        }
    }
    uint total;
    group_exclusive(sum, total);
    if (gl_LocalInvocationIndex == 0u) sums[tile] = total;
}
