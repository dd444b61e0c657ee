#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/water.glsl"

// Water columns joined by virtual pipes, as Zink, Pettineo and Hoxley, "Practical Rendering and Computation with
// Direct3D 11" (2011), section 12.1, has it: a tile of 16 x 16 columns with a ring of one more on each side in shared
// memory, four pipes a column, flows first, then heights.
//     Q' = keep (Q + dt k w (h_other - h)),  h' = h + dt (sum of what flows in),  k = c^2 / (dx^2 (1 + 2 w))
// Unlike the listings: a pipe exists only between two columns of the grid (theirs leak at the upper and left border and
// wrap at the others), dt is in both updates, the grid has any size, and 256 invocations load the 324 columns in a loop.
// Flow is positive into the column that stores it. CPU twin: water::cpu::Book.

const int TILE = 16;
const int PADDED = TILE + 2;

layout(local_size_x = TILE, local_size_y = TILE) in;

struct Column {
    float height_m;
    float flow_mps[4];  // to the right, lower right, below, lower left: as rise of the surface
};

layout(set = 0, binding = 0, std430) readonly buffer Columns { Column columns[]; };
layout(set = 0, binding = 1, std430) writeonly buffer NewColumns { Column new_columns[]; };

layout(push_constant, std430) uniform Push { WaterParams p; };

const ivec2 PIPES[4] = ivec2[4](ivec2(1, 0), ivec2(1, 1), ivec2(0, 1), ivec2(-1, 1));

shared Column tile[PADDED * PADDED];

bool is_in_grid(ivec2 c) { return all(greaterThanEqual(c, ivec2(0))) && all(lessThan(c, ivec2(p.cells))); }

void main() {
    const ivec2 corner = ivec2(gl_WorkGroupID.xy) * TILE - 1;  // of the padded tile
    const int first = int(gl_LocalInvocationIndex);

    // 1. The tile and its ring. Columns outside the grid stay zero: no pipe leads to them.
    for (int i = first; i < PADDED * PADDED; i += TILE * TILE) {
        ivec2 c = corner + ivec2(i % PADDED, i / PADDED);
        tile[i] = Column(0.0, float[4](0.0, 0.0, 0.0, 0.0));
        if (is_in_grid(c)) tile[i] = columns[uint(c.y) * p.pitch + uint(c.x)];
    }
    barrier();

    // 2. New flow in every pipe that starts here and ends inside the padded tile, for the ring too: its flows are
    //    needed below, and thrown away after that.
    for (int i = first; i < PADDED * PADDED; i += TILE * TILE) {
        ivec2 at = ivec2(i % PADDED, i / PADDED);
        for (int k = 0; k < 4; ++k) {
            ivec2 to = at + PIPES[k];
            bool is_in_tile = to.x >= 0 && to.x < PADDED && to.y < PADDED;
            precise float flow = 0.0;
            if (is_in_tile && is_in_grid(corner + at) && is_in_grid(corner + to)) {
                precise float pull = (k & 1) == 1 ? p.diagonal * p.pull : p.pull;
                flow = p.keep * (tile[i].flow_mps[k] + pull * (tile[to.y * PADDED + to.x].height_m - tile[i].height_m));
            }
            tile[i].flow_mps[k] = flow;
        }
    }
    barrier();

    // 3. New height: what the own four pipes bring, less what the other four take away to their owners.
    ivec2 c = ivec2(gl_GlobalInvocationID.xy);
    if (!is_in_grid(c)) return;
    int i = (int(gl_LocalInvocationID.y) + 1) * PADDED + int(gl_LocalInvocationID.x) + 1;
    Column column = tile[i];
    precise float gain = (column.flow_mps[0] + column.flow_mps[1]) + (column.flow_mps[2] + column.flow_mps[3]);
    precise float loss = (tile[i - 1].flow_mps[0] + tile[i - PADDED - 1].flow_mps[1]) +
                         (tile[i - PADDED].flow_mps[2] + tile[i - PADDED + 1].flow_mps[3]);
    precise float height = column.height_m + p.dt_s * (gain - loss);
    column.height_m = height;
    new_columns[uint(c.y) * p.pitch + uint(c.x)] = column;
}
