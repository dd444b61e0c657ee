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
shared uint before[GROUP];  // marks before each half word
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
    uint total;
    before[lane] = group_exclusive(bitCount(marks[lane / 2u] >> (16u * (lane & 1u)) & 0xffffu), total);
    barrier();
    for (uint k = 0u; k < ITEMS; ++k) {
        uint at = k * GROUP + lane, word = marks[at / 32u];
        if ((word >> (at & 31u) & 1u) == 0u) continue;
        uint half_word = word >> (at & 16u) & 0xffffu;
        gathered[before[at / 16u] + bitCount(half_word & ((1u << (at & 15u)) - 1u))] = values[tile * TILE + at];
    }
    barrier();
    for (uint j = lane; j < total; j += GROUP) kept[sums[tile] + j] = gathered[j];
}
