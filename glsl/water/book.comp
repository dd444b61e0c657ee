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

shared float height_m[PADDED * PADDED];
shared vec4 flow_mps[PADDED * PADDED];

bool is_in_grid(ivec2 c) { return all(greaterThanEqual(c, ivec2(0))) && all(lessThan(c, ivec2(p.cells))); }

void main() {
    const ivec2 corner = ivec2(gl_WorkGroupID.xy) * TILE - 1;  // of the padded tile
    const int first = int(gl_LocalInvocationIndex);

    // 1. The tile and its ring. Columns outside the grid stay zero: no pipe leads to them.
    for (int i = first; i < PADDED * PADDED; i += TILE * TILE) {
        ivec2 c = corner + ivec2(i % PADDED, i / PADDED);
        Column column = Column(0.0, float[4](0.0, 0.0, 0.0, 0.0));
        if (is_in_grid(c)) column = columns[uint(c.y) * p.pitch + uint(c.x)];
        height_m[i] = column.height_m;
        flow_mps[i] = vec4(column.flow_mps[0], column.flow_mps[1], column.flow_mps[2], column.flow_mps[3]);
    }
    barrier();

    // 2. New flow in every pipe that starts here and ends inside the padded tile, for the ring too: its flows are
    //    needed below, and thrown away after that.
    const precise vec4 pull = p.pull * vec4(1.0, p.diagonal, 1.0, p.diagonal);
    for (int i = first; i < PADDED * PADDED; i += TILE * TILE) {
        ivec2 at = ivec2(i % PADDED, i / PADDED), c = corner + at;
        bool right = at.x < PADDED - 1 && c.x + 1 < int(p.cells.x);
        bool below = at.y < PADDED - 1 && c.y + 1 < int(p.cells.y);
        bool left = at.x > 0 && c.x > 0;
        bvec4 exists = bvec4(right, right && below, below, below && left);
        if (!is_in_grid(c)) exists = bvec4(false);
        float h = height_m[i];
        precise vec4 slope = vec4(0.0);
        if (exists.x) slope.x = height_m[i + 1] - h;
        if (exists.y) slope.y = height_m[i + PADDED + 1] - h;
        if (exists.z) slope.z = height_m[i + PADDED] - h;
        if (exists.w) slope.w = height_m[i + PADDED - 1] - h;
        precise vec4 flow = p.keep * (flow_mps[i] + pull * slope);
        flow_mps[i] = mix(vec4(0.0), flow, exists);
    }
    barrier();

    // 3. New height: what the own four pipes bring, less what the other four take away to their owners.
    ivec2 c = ivec2(gl_GlobalInvocationID.xy);
    if (!is_in_grid(c)) return;
    int i = (int(gl_LocalInvocationID.y) + 1) * PADDED + int(gl_LocalInvocationID.x) + 1;
    vec4 own = flow_mps[i];
    precise float gain = (own.x + own.y) + (own.z + own.w);
    precise float loss = (flow_mps[i - 1].x + flow_mps[i - PADDED - 1].y) +
                         (flow_mps[i - PADDED].z + flow_mps[i - PADDED + 1].w);
    precise float height = height_m[i] + p.dt_s * (gain - loss);
    new_columns[uint(c.y) * p.pitch + uint(c.x)] = Column(height, float[4](own.x, own.y, own.z, own.w));
}
