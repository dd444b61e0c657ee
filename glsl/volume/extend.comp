#version 460
// Third pass over triangles, when the planes of every cell are known: where in it they stand for the triangle. One invocation
// a small triangle. CPU twin: volume::cpu::Voxels::extents.
layout(local_size_x = 128) in;
#include "volume/triangle.glsl"
#include "volume/item.glsl"
#include "volume/extend.glsl"
const uint LARGE_CELLS = 32u;  // as in volume/work.glsl

void main() {
    uint i = item(), t = p.first + i;
    if (i >= p.triangles || load_triangle(t) != SOUND || box_cells() > LARGE_CELLS) return;
    ivec3 cell;
    for (cell.z = tri_low.z; cell.z <= tri_high.z; ++cell.z)
        for (cell.y = tri_low.y; cell.y <= tri_high.y; ++cell.y)
            for (cell.x = tri_low.x; cell.x <= tri_high.x; ++cell.x) extend(t, cell);
}
