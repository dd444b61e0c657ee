#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#include "water/water.glsl"
#include "water/pipes.glsl"

// Columns of water joined by pipes, several steps a dispatch: to the bit what as many dispatches of pipes.comp do.
// Tiles, halo and what is shared are those of fused_pass.glsl: heights, of each row the first and the last of four, and the
// top and bottom row of each invocation. Flows stay in registers: an invocation keeps those of its neighbours that end in
// its columns as well (3 a row and 14 above) and steps them itself, which costs less than sharing 4 flows a column.
// A column costs about 22 flops a step (19 pipes of 3 for 4 columns, 8 for the height), and 14 pipes more for `ROWS` rows.

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint LANES = 256u;  // product of the two
layout(constant_id = 3) const uint ROWS = 4u;     // of an invocation
layout(constant_id = 4) const uint STEPS = 4u;    // most steps a dispatch: rows of the halo
layout(constant_id = 5) const uint BUFFERS = 1u;  // 2: one barrier a step and twice the shared memory
layout(constant_id = 6) const bool has_land = false;
layout(constant_id = 7) const bool has_diagonals = true;
layout(constant_id = 8) const bool has_shores = false;  // the tiles of this dispatch have land in reach

layout(set = 0, binding = 0, std430) readonly buffer Height { vec4 height_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Flow { vec4 flow_mps[]; };
layout(set = 0, binding = 2, std430) writeonly buffer NewHeight { vec4 new_height_m[]; };
layout(set = 0, binding = 3, std430) writeonly buffer NewFlow { vec4 new_flow_mps[]; };

layout(push_constant, std430) uniform Push {
    WaterParams p;
    uint steps;  // 1 to STEPS
};

shared float first[BUFFERS * LANES * ROWS];  // height of the first of four columns, by row and lane
shared float last[BUFFERS * LANES * ROWS];
shared vec4 ends[BUFFERS * LANES * 2u];      // top and bottom row of each invocation

#include "water/tiles.glsl"

vec4 height_at(int q, int y) {
    vec4 h = vec4(0.0);
    if (has_land) h = vec4(LAND_M);
    if (q < 0 || 4 * q >= int(p.cells.x) || y < 0 || y >= int(p.cells.y)) return h;
    h = height_m[y * int(p.pitch >> 2u) + q];
    if (has_land) {
        for (int k = 1; k < 4; ++k) {
            if (4 * q + k >= int(p.cells.x)) h[k] = LAND_M;
        }
    }
    return h;
}

vec4 flow_at(uint plane, int q, int y) {
    if (q < 0 || 4 * q >= int(p.cells.x) || y < 0 || y >= int(p.cells.y)) return vec4(0.0);
    return flow_mps[(plane * p.cells.y + uint(y)) * (p.pitch >> 2u) + uint(q)];
}

Down down_at(int q, int y) {
    Down d = NO_FLOW;
    d.below = flow_at(1u, q, y);
    if (has_diagonals) {
        d.right_w = flow_at(2u, q - 1, y).w;
        d.right = flow_at(2u, q, y);
        d.left = flow_at(3u, q, y);
        d.left_e = flow_at(3u, q + 1, y).x;
    }
    return d;
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

    vec4 h[ROWS];
    Along along[ROWS];
    Down down[ROWS + 1u];  // [k] is between rows k - 1 and k
    [[unroll]] for (uint k = 0u; k < ROWS; ++k) {
        int y = y0 + int(k);
        h[k] = height_at(q, y);
        along[k] = Along(flow_at(0u, q - 1, y).w, flow_at(0u, q, y));
        down[k] = down_at(q, y - 1);
    }
    down[ROWS] = down_at(q, y0 + int(ROWS) - 1);
    Pulls pulls = pulls_of(4 * q, p);

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
        [[unroll]] for (uint k = 0u; k <= ROWS; ++k) {
            int y = y0 + int(k);  // c is row k, n the one before
            if (y != 0 && y != int(p.cells.y)) {  // no pipe leads through a wall
                Down pull = pulls.down;
                if (has_shores) pull = down_beside_land(n, c, p);
                step_down(down[k], n, c, pull, p.keep, has_diagonals);
            }
            if (k > 0u) h[k - 1u] = height_after(n.mid, along[k - 1u], down[k - 1u], down[k], p.dt_s);
            if (k < ROWS) {
                const uint next = k + 1u < ROWS ? row + (k + 1u) * wide : below;
                Row s = Row(last[next - to_west],
                            k + 1u < ROWS ? h[min(k + 1u, ROWS - 1u)] : ends[end + wide + to_south],
                            first[next + to_east]);
                Along pull = along_wall(pulls.along, y, p);
                if (has_shores) pull = along_beside_land(n, c, s, p);
                step_along(along[k], c, pull, p.keep);
                n = c;
                c = s;
            }
        }
        if (BUFFERS == 1u) barrier();
    }

    const int fours = int(p.pitch >> 2u), plane = int(p.cells.y) * fours;
    bool is_mine = lane.x >= halo && lane.x + halo < wide && q < fours;
    [[unroll]] for (uint k = 0u; k < ROWS; ++k) {
        uint row = lane.y * ROWS + k;
        int y = y0 + int(k), i = y * fours + q;
        if (is_mine && row >= STEPS && row + STEPS < high * ROWS && y < int(p.cells.y)) {
            new_height_m[i] = h[k];
            new_flow_mps[i] = along[k].mid;
            new_flow_mps[i + plane] = down[k + 1u].below;
            if (has_diagonals) {
                new_flow_mps[i + 2 * plane] = down[k + 1u].right;
                new_flow_mps[i + 3 * plane] = down[k + 1u].left;
            }
        }
    }
}
