// `waves`, several steps a dispatch: the pass of water.fused, to the bit what as many dispatches of water.waves do, and of
// water.fused_f16, which stores halves.
// A workgroup loads a tile, steps it in registers and writes the columns that nothing beyond the tile could reach: a
// halo of as many rows and columns as there are steps is computed twice, and memory is touched once. Each invocation
// owns `ROWS` rows of 4 columns. A row is bent once for three uses, as in water.waves; what its neighbours need goes
// through shared memory: of each row the first and the last height, and the top and the bottom row whole. That is 4 bytes
// a column and step written and read, half of what a tile of heights would be, and few enough registers that a tile of
// 128 x 64 keeps its halo small.
// A column costs 10 1/4 flops a step (2 1/4 bend, 1 rise, 1 bend across, 3 sum, 2 + 1 advance), 1 access of shared
// memory, and the bends of the rows above and below once more for `ROWS` rows.
// Beyond the grid, a tile holds mirror images of the water, which move as the water does, so walls cost nothing. Where there
// may be land, there is land beyond the grid; only tiles that have some in reach look for shores.
#extension GL_EXT_control_flow_attributes : require
#include "water/storage.glsl"
#include "water/water.glsl"
#include "water/waves.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint LANES = 256u;   // product of the two
layout(constant_id = 3) const uint ROWS = 8u;      // of an invocation, at most 31
layout(constant_id = 4) const uint STEPS = 6u;     // most steps a dispatch: rows of the halo
layout(constant_id = 5) const uint BUFFERS = 1u;   // 2: one barrier a step and twice the shared memory
layout(constant_id = 6) const bool has_land = false;
layout(constant_id = 7) const bool drops = false;  // walls drop diagonal pipes; with land they are shores instead
layout(constant_id = 8) const bool has_shores = false;  // the tiles of this dispatch have land in reach

layout(set = 0, binding = 0, std430) readonly buffer Height { FOUR height_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Velocity { FOUR velocity_mps[]; };
layout(set = 0, binding = 2, std430) writeonly buffer NewHeight { FOUR new_height_m[]; };
layout(set = 0, binding = 3, std430) writeonly buffer NewVelocity { FOUR new_velocity_mps[]; };

layout(push_constant, std430) uniform Push {
    WaterParams p;
    uint steps;  // 1 to STEPS
};

shared float first[BUFFERS * LANES * ROWS];  // height of the first of four columns, by row and lane
shared float last[BUFFERS * LANES * ROWS];
shared vec4 ends[BUFFERS * LANES * 2u];      // top and bottom row of each invocation

#include "water/tiles.glsl"

// Column or row of which `i` is an image, when walls are mirrors: 0 1 2 | 2 1 0 | 0 1 2.
uint image_of(int i, uint n) {
    uint m = uint(i < 0 ? -1 - i : i) % (2u * n);
    return m < n ? m : 2u * n - 1u - m;
}

// Four columns at the border, or beyond it.
void load_beyond(int x, int y, out vec4 h, out vec4 v) {
    for (int k = 0; k < 4; ++k) {
        bool beyond = x + k < 0 || x + k >= int(p.cells.x) || y < 0 || y >= int(p.cells.y);
        uint i = image_of(y, p.cells.y) * p.pitch + image_of(x + k, p.cells.x);
        h[k] = floats_of(height_m[i >> 2u])[i & 3u];
        v[k] = floats_of(velocity_mps[i >> 2u])[i & 3u];
        if (has_land && beyond) h[k] = LAND_M;
    }
}

void main() {
    uvec3 group = gl_WorkGroupSize;
    uint wide = group.x, high = group.y;
    const uvec2 lane = gl_LocalInvocationID.xy;
    const uint halo = (STEPS + 3u) / 4u;  // in fours of columns
    const ivec2 inner = ivec2(wide - 2u * halo, high * ROWS - 2u * STEPS);
    const uvec2 tile = tile_of_group();
    if (tile.x == NONE) return;
    const ivec2 corner = ivec2(tile) * inner - ivec2(halo, STEPS);
    const int q = corner.x + int(lane.x), y0 = corner.y + int(lane.y * ROWS);
    const int fours = int(p.pitch >> 2u);

    vec4 h[ROWS], v[ROWS];
    bool is_within = corner.x >= 0 && 4 * (corner.x + int(wide)) <= int(p.cells.x) && corner.y >= 0 &&
                     corner.y + int(high * ROWS) <= int(p.cells.y);
    if (is_within) {
        [[unroll]] for (uint k = 0u; k < ROWS; ++k) {
            int i = (y0 + int(k)) * fours + q;
            h[k] = floats_of(height_m[i]);
            v[k] = floats_of(velocity_mps[i]);
        }
    } else {
        [[unroll]] for (uint k = 0u; k < ROWS; ++k) load_beyond(4 * q, y0 + int(k), h[k], v[k]);
    }

    if (has_shores) {
        [[unroll]] for (uint k = 0u; k < ROWS; ++k) v[k] = still_on_land(h[k], v[k]);
    }

    bool folded = p.folded == 1u;
    const vec4 upright = upright_of(4 * q, int(p.cells.x), p.diagonal, folded || has_land);
    uint walls = 0u;  // bit k: between rows k - 1 and k
    if (drops) {
        for (uint k = 0u; k <= ROWS; ++k) walls |= uint(abs(y0 + int(k)) % int(p.cells.y) == 0) << k;
    }

    // At the edges of the tile anything finite will do: a lane's own.
    const uint at = lane.y * ROWS * wide + lane.x, at_end = 2u * lane.y * wide + lane.x;
    const uint to_west = lane.x > 0u ? 1u : 0u, to_east = lane.x + 1u < wide ? 1u : 0u;
    const uint to_north = lane.y > 0u ? wide : 0u, to_south = lane.y + 1u < high ? wide : 0u;
    for (uint step = 0u; step < steps; ++step) {
        const uint copy = step & (BUFFERS - 1u);
        const uint row = copy * LANES * ROWS + at, end = copy * LANES * 2u + at_end;
        [[unroll]] for (uint k = 0u; k < ROWS; ++k) {
            first[row + k * wide] = h[k].x;
            last[row + k * wide] = h[k].w;
        }
        ends[end] = h[0];
        ends[end + wide] = h[ROWS - 1u];
        barrier();

        const uint above = row - to_north, below = row + (ROWS - 1u) * wide + to_south;
        Row n = Row(last[above - to_west], ends[end - to_north], first[above + to_east]);
        Row c = Row(last[row - to_west], h[0], first[row + to_east]);
        precise vec4 up = c.mid - n.mid;
        vec4 bend_n = bend_of(n), bend = bend_of(c);
        [[unroll]] for (uint k = 0u; k < ROWS; ++k) {
            const uint next = k + 1u < ROWS ? row + (k + 1u) * wide : below;
            Row s = Row(last[next - to_west], k + 1u < ROWS ? h[min(k + 1u, ROWS - 1u)] : ends[end + wide + to_south],
                        first[next + to_east]);
            precise vec4 down = s.mid - c.mid;
            vec4 bend_s = bend_of(s);
            vec4 over = bend_n, under = bend_s;
            if (drops) {
                if ((walls >> k & 1u) == 1u) over = vec4(0.0);
                if ((walls >> k & 2u) == 2u) under = vec4(0.0);
            }
            vec4 pull = pull_of(over, bend, under, up, down, p.diagonal, upright);
            if (has_shores) {
                if (is_at_shore(pull)) pull = at_shores(pull, n, c, s, p.diagonal, folded);
            }
            advance(h[k], v[k], pull, p);
            n = c;
            c = s;
            up = down;
            bend_n = bend;
            bend = bend_s;
        }
        if (BUFFERS == 1u) barrier();
    }

    bool is_mine = lane.x >= halo && lane.x + halo < wide && q < fours;
    [[unroll]] for (uint k = 0u; k < ROWS; ++k) {
        uint row = lane.y * ROWS + k;
        int y = y0 + int(k);
        if (is_mine && row >= STEPS && row + STEPS < high * ROWS && y < int(p.cells.y)) {
            new_height_m[y * fours + q] = stored(h[k]);
            new_velocity_mps[y * fours + q] = stored(v[k]);
        }
    }
}
