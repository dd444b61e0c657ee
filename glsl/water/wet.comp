#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/depth.glsl"
#include "water/donor.glsl"

// Pipes over ground that may be dry, one step: the surface drives, and a pipe is as deep as the water above the higher
// of its two grounds.
//     D = max(surface_a, surface_b) - max(bed_a, bed_b)
//     flow' = keep (flow + g dt / dx D (surface_a - surface_b)) where D > thin, else 0
// then the flows are limited, stored limited, and move the water, as water/donor.glsl says. Flows (m^2/s) are of a unit of width,
// positive to the east and south. No advection: a dam break comes out slow (see shallow). 28 bytes a column and step:
// ground read, rise and two flows read and written. CPU twin: water::cpu_wet::Depths.
//
// A flow depends on the two columns that it joins, K on four flows, and the new depth on five K: a radius of two columns.
// Each invocation walks down `rows` rows of four columns with two more on either side, loads each row once, and keeps
// what the next rows need in registers: no shared memory, no barrier, 6 K and 13 flows for 4 columns instead of 4 and 8.

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint rows = 8u;

layout(set = 0, binding = 0, std430) readonly buffer Bed { vec4 bed_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Rise { vec4 rise_m[]; };
layout(set = 0, binding = 2, std430) readonly buffer Flow { vec4 stored_flow[]; };  // east, south of four columns
layout(set = 0, binding = 3, std430) writeonly buffer NewRise { vec4 new_rise_m[]; };
layout(set = 0, binding = 4, std430) writeonly buffer NewFlow { vec4 new_flow[]; };

layout(push_constant, std430) uniform Push { DepthParams p; };

float flow_through(float stored, float surface_a, float surface_b, float bed_a, float bed_b) {
    precise float head = max(surface_a, surface_b) - max(bed_a, bed_b);
    precise float slope = slope_of(surface_a, surface_b, bed_a, bed_b);
    precise float flow = p.keep * (stored + (p.pull * head) * slope);
    return head > p.thin_m ? flow : 0.0;
}

// A row at the columns 4q - 2 .. 4q + 5, and its flows.
struct Row {
    float bed[8];
    float surface[8];
    float depth[8];
    float rise[8];
    float flow[4];   // through the face on the east of each of the four columns (m^2/s)
    float east[7];   // what it moves, of each column (m)
    float south[8];  // stored in the face on the south: [1] to [6]
};

float[8] eight(vec2 west, vec4 mid, vec2 east) {
    return float[8](west.x, west.y, mid.x, mid.y, mid.z, mid.w, east.x, east.y);
}

Row load_row(int y, uint q) {
    uint fours = p.pitch >> 2u;
    bool is_in = y >= 0 && y < int(p.cells.y), has_west = is_in && q > 0u, has_east = is_in && q + 1u < fours;
    uint i = uint(y) * fours + q;
    Row row;
    row.bed = eight(has_west ? bed_m[i - 1u].zw : vec2(WALL_M), is_in ? bed_m[i] : vec4(WALL_M),
                    has_east ? bed_m[i + 1u].xy : vec2(WALL_M));
    row.rise = eight(has_west ? rise_m[i - 1u].zw : vec2(LAND_M), is_in ? rise_m[i] : vec4(LAND_M),
                     has_east ? rise_m[i + 1u].xy : vec2(LAND_M));
    float east[8] = eight(has_west ? stored_flow[2u * i - 2u].zw : vec2(0.0), is_in ? stored_flow[2u * i] : vec4(0.0),
                          vec2(has_east ? stored_flow[2u * i + 2u].x : 0.0, 0.0));
    row.south = eight(vec2(0.0, has_west ? stored_flow[2u * i - 1u].w : 0.0),
                      is_in ? stored_flow[2u * i + 1u] : vec4(0.0),
                      vec2(has_east ? stored_flow[2u * i + 3u].x : 0.0, 0.0));
    for (int k = 0; k < 8; ++k) {
        row.depth[k] = depth_of(row.bed[k], row.rise[k]);
        row.surface[k] = surface_of(row.bed[k], row.rise[k]);
    }
    for (int k = 0; k < 7; ++k) {
        precise float flow = flow_through(east[k], row.surface[k], row.surface[k + 1], row.bed[k], row.bed[k + 1]);
        precise float moved = p.reach * flow;
        row.east[k] = in_whole_units(moved, row.rise[k], row.rise[k + 1]);
        if (k >= 2 && k < 6) row.flow[k - 2] = flow;
    }
    return row;
}

void main() {
    uint q = gl_GlobalInvocationID.x, fours = p.pitch >> 2u;
    int y0 = int(gl_GlobalInvocationID.y * rows), y1 = min(y0 + int(rows), int(p.cells.y));
    if (q >= fours || y0 >= y1) return;

    // Row y comes in, K of row y - 1 becomes known, row y - 2 goes out.
    Row above = load_row(y0 - 2, q);   // y - 1
    Row leaving = above;               // y - 2
    float leaving_share[8], north[8];  // its K, and what moves between rows y - 2 and y - 1
    float flow[4], north_flow[4];      // through the south faces of rows y - 1 and y - 2
    vec4 from_north = vec4(0.0);       // what moves into row y - 2, limited
    for (int k = 0; k < 8; ++k) leaving_share[k] = north[k] = 0.0;
    for (int k = 0; k < 4; ++k) north_flow[k] = 0.0;
    for (int y = y0 - 1; y < y1 + 2; ++y) {
        Row row = load_row(y, q);
        float south[8], above_share[8];
        for (int k = 1; k < 7; ++k) {
            precise float through =
                flow_through(above.south[k], above.surface[k], row.surface[k], above.bed[k], row.bed[k]);
            precise float moved = p.reach * through;
            south[k] = in_whole_units(moved, above.rise[k], row.rise[k]);
            above_share[k] = share(above.depth[k], above.east[k - 1], above.east[k], north[k], south[k]);
            if (k >= 2 && k < 6) flow[k - 2] = through;
        }
        vec4 to_south, from_west, to_east, rise, east_flow, south_flow;
        for (int k = 0; k < 4; ++k) {
            to_south[k] = limited(north[k + 2], leaving_share[k + 2], above_share[k + 2]);
            from_west[k] = limited(leaving.east[k + 1], leaving_share[k + 1], leaving_share[k + 2]);
            to_east[k] = limited(leaving.east[k + 2], leaving_share[k + 2], leaving_share[k + 3]);
            east_flow[k] = limited(leaving.flow[k], leaving_share[k + 2], leaving_share[k + 3]);
            south_flow[k] = limited(north_flow[k], leaving_share[k + 2], above_share[k + 2]);
            rise[k] = leaving.rise[k + 2];
        }
        if (y >= y0 + 2) {
            uint i = uint(y - 2) * fours + q;
            precise vec4 gain = (from_west - to_east) + (from_north - to_south);
            precise vec4 new_rise = (rise + gain) + p.rain_m;
            new_rise_m[i] = new_rise;
            new_flow[2u * i] = east_flow;
            new_flow[2u * i + 1u] = south_flow;
        }
        from_north = to_south;
        north = south;
        north_flow = flow;
        leaving_share = above_share;
        leaving = above;
        above = row;
    }
}
