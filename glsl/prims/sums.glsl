// Scan, second of three: one workgroup turns the sums of tiles into the sums of all tiles before each; the last word is
// the sum of all. CPU twin: prims::cpu::exclusive_scan.
layout(local_size_x = 256) in;
#include "prims/params.glsl"
#include "prims/group.glsl"

layout(set = 0, binding = 0, std430) buffer Sums { uint sums[]; };

void main() {
    uint carried = 0u;
    for (uint base = 0u; base < p.tiles; base += TILE) {
        uint own[ITEMS], sum = 0u;
        for (uint k = 0u; k < ITEMS; ++k) {
            uint i = base + gl_LocalInvocationIndex * ITEMS + k;
            own[k] = i < p.tiles ? sums[i] : 0u;
            sum += own[k];
        }
        uint total;
        uint before = carried + group_exclusive(sum, total);
        for (uint k = 0u; k < ITEMS; ++k) {
            uint i = base + gl_LocalInvocationIndex * ITEMS + k;
            if (i < p.tiles) sums[i] = before;
            before += own[k];
        }
        carried += total;
    }
    if (gl_LocalInvocationIndex == 0u) sums[p.tiles] = carried;
}
