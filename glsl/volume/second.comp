#version 460
// Second pass over triangles: each offers itself as the second plane of the cells that it overlaps. One
// invocation a small triangle. CPU twin: volume::cpu::Voxels::second.
layout(local_size_x = 128) in;
#include "volume/triangle.glsl"
#include "volume/item.glsl"
#include "volume/second.glsl"
const uint LARGE_CELLS = 32u;  // as in volume/work.glsl

void main() {
    uint i = item(), t = p.first + i;
    if (i >= p.triangles || load_triangle(t) != SOUND || box_cells() > LARGE_CELLS) return;
    ivec3 cell;
    for (cell.z = tri_low.z; cell.z <= tri_high.z; ++cell.z)
        for (cell.y = tri_low.y; cell.y <= tri_high.y; ++cell.y)
            for (cell.x = tri_low.x; cell.x <= tri_high.x; ++cell.x) offer(t, cell);
}
