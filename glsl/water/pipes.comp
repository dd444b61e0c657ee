#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/water.glsl"
#include "water/pipes.glsl"

// Columns of water joined by pipes that keep their flow, one step, without shared memory: the scheme of book.comp with
// walls that may fold diagonal pipes, land, and flows as planes of their own: right, below, lower right, lower left; the
// last two only if there are diagonals. Each invocation walks down `rows` rows of 4 columns, so heights and the flows
// between rows are used twice. 40 bytes a column and step, 24 without diagonals. CPU twin: water::cpu_pipes::Pipes.

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint rows = 8u;
layout(constant_id = 3) const bool has_land = false;
layout(constant_id = 4) const bool has_diagonals = true;

layout(set = 0, binding = 0, std430) readonly buffer Height { vec4 height_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Flow { vec4 flow_mps[]; };
layout(set = 0, binding = 2, std430) writeonly buffer NewHeight { vec4 new_height_m[]; };
layout(set = 0, binding = 3, std430) writeonly buffer NewFlow { vec4 new_flow_mps[]; };

layout(push_constant, std430) uniform Push { WaterParams p; };

// Beyond the grid there is land, or water to which no pipe leads.
Row load_row(int y, uint q) {
    float beyond = 0.0;
    if (has_land) beyond = LAND_M;
    if (y < 0 || y >= int(p.cells.y)) return Row(beyond, vec4(beyond), beyond);
    uint i = uint(y) * (p.pitch >> 2u) + q;
    Row r = Row(beyond, height_m[i], beyond);
    if (q > 0u) r.west = height_m[i - 1u].w;
    if (4u * q + 4u < p.cells.x) r.east = height_m[i + 1u].x;
    if (has_land) {
        for (uint k = 1u; k < 4u; ++k) {
            if (4u * q + k >= p.cells.x) r.mid[k] = LAND_M;
        }
    }
    return r;
}

Along load_along(uint y, uint q) {
    uint i = y * (p.pitch >> 2u) + q;
    return Along(q > 0u ? flow_mps[i - 1u].w : 0.0, flow_mps[i]);
}

Down load_down(int y, uint q) {
    Down d = NO_FLOW;
    if (y < 0) return d;
    uint plane = p.cells.y * (p.pitch >> 2u), i = plane + uint(y) * (p.pitch >> 2u) + q;
    d.below = flow_mps[i];
    if (has_diagonals) {
        d.right = flow_mps[i + plane];
        d.left = flow_mps[i + 2u * plane];
        if (q > 0u) d.right_w = flow_mps[i + plane - 1u].w;
        if (4u * q + 4u < p.cells.x) d.left_e = flow_mps[i + 2u * plane + 1u].x;
    }
    return d;
}

// The pipes between row y and the next.
Down stepped(int y, uint q, Row c, Row s, Down pull) {
    Down d = load_down(y, q);
    if (y < 0 || y + 1 >= int(p.cells.y)) return NO_FLOW;
    if (has_land) pull = down_beside_land(c, s, p);
    step_down(d, c, s, pull, p.keep, has_diagonals);
    return d;
}

void main() {
    uint q = gl_GlobalInvocationID.x;
    uint y0 = gl_GlobalInvocationID.y * rows;
    if (4u * q >= p.cells.x || y0 >= p.cells.y) return;
    uint fours = p.pitch >> 2u, plane = p.cells.y * fours, y1 = min(y0 + rows, p.cells.y);
    Pulls pulls = pulls_of(int(4u * q), p);

    Row n = load_row(int(y0) - 1, q), c = load_row(int(y0), q);
    Down above = stepped(int(y0) - 1, q, n, c, pulls.down);
    for (uint y = y0; y < y1; ++y) {
        Row s = load_row(int(y) + 1, q);
        Along along = load_along(y, q), pull = along_wall(pulls.along, int(y), p);
        if (has_land) pull = along_beside_land(n, c, s, p);
        step_along(along, c, pull, p.keep);
        Down below = stepped(int(y), q, c, s, pulls.down);
        uint i = y * fours + q;
        new_height_m[i] = height_after(c.mid, along, above, below, p.dt_s);
        new_flow_mps[i] = along.mid;
        new_flow_mps[i + plane] = below.below;
        if (has_diagonals) {
            new_flow_mps[i + 2u * plane] = below.right;
            new_flow_mps[i + 3u * plane] = below.left;
        }
        n = c;
        c = s;
        above = below;
    }
}
