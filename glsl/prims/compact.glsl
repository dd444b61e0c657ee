// Compaction, last of three: values whose flag is not 0, in their order, behind those of the tiles before.
// CPU twin: prims::cpu::compact.
layout(local_size_x = 256) in;
#include "prims/params.glsl"
#include "prims/group.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Flags { uint flags[]; };
layout(set = 0, binding = 1, std430) readonly buffer Values { uint values[]; };
layout(set = 0, binding = 2, std430) readonly buffer Sums { uint sums[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Kept { uint kept[]; };

shared uint marks[TILE / 32u];
shared uint gathered[TILE];

void main() {
    uint tile = tile_index(), lane = gl_LocalInvocationIndex;
    if (tile >= p.tiles) return;  // the whole workgroup
    if (lane < TILE / 32u) marks[lane] = 0u;
    barrier();
    for (uint k = 0u; k < ITEMS; ++k) {
        uint at = k * GROUP + lane, i = tile * TILE + at;
        if (i < p.count && flags[i] != 0u) atomicOr(marks[at / 32u], 1u << (at & 31u));
    }
    barrier();
    // Half a word of marks an invocation.
    uint word = marks[lane / 2u] >> (16u * (lane & 1u)) & 0xffffu;
    uint total;
    uint before = group_exclusive(bitCount(word), total);
    while (word != 0u) {
        uint bit = findLSB(word);
        word &= word - 1u;
        gathered[before++] = values[tile * TILE + 16u * lane + bit];
    }
    barrier();
    for (uint j = lane; j < total; j += GROUP) kept[sums[tile] + j] = gathered[j];
}
