#version 460
// Third pass over triangles, when the planes of every cell are known: where in it they stand for the triangle. One invocation
// a small triangle asks which cells it is in; what must be done in them takes long, and is dealt out evenly, since of some triangles it
// is one cell and of others ten. CPU twin: volume::cpu::Voxels::extents.
layout(local_size_x = 128) in;
#include "volume/triangle.glsl"
#include "volume/item.glsl"
#include "volume/extend.glsl"
const uint LARGE_CELLS = 32u;  // as in volume/work.glsl; no more than a word has bits
const uint MOST_PAIRS = 1024u;

shared uint pairs[MOST_PAIRS];  // triangle of the workgroup, and which cell of its box: five bits
shared uint pair_count;

ivec3 cell_of_box(uint k) {
    uvec3 n = uvec3(tri_high - tri_low + 1);
    return tri_low + ivec3(k % n.x, k / n.x % n.y, k / n.x / n.y);
}

void main() {
    uint lane = gl_LocalInvocationIndex, i = item(), t = p.first + i, cells = 0u;
    if (i < p.triangles && load_triangle(t) == SOUND && box_cells() <= LARGE_CELLS)
        for (uint k = box_cells(); k-- > 0u;) cells |= uint(is_asked(t, cell_of_box(k))) << k;
    bool is_over = false;
    while (!is_over) {
        barrier();
        if (lane == 0u) pair_count = 0u;
        barrier();
        for (; cells != 0u; cells &= cells - 1u) {
            uint at = atomicAdd(pair_count, 1u);
            if (at >= MOST_PAIRS) break;
            pairs[at] = lane << 5u | uint(findLSB(cells));
        }
        barrier();
        is_over = pair_count <= MOST_PAIRS;
        for (uint q = lane; q < min(pair_count, MOST_PAIRS); q += gl_WorkGroupSize.x) {
            load_triangle(t - lane + (pairs[q] >> 5u));
            extend(cell_of_box(pairs[q] & 31u));
        }
    }
}
