#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/depth.glsl"
#include "water/shallow.glsl"

// Shallow water, first half of a step: new velocities u of the east and v of the south faces, by Stelling and Duinmeijer,
// "A staggered conservative scheme for every Froude number in rapidly varied shallow water flows", Int. J. Numer. Meth.
// Fluids 43 (2003) 1329, first order. Advection conserves momentum, so bores run at the right speed:
//     u u_x + v u_y = ((q u)_x - u q_x + (r u)_y - u r_y) / depth,  q = flow to the east, r = flow to the south
// with u from upstream in (q u)_x this is, for the flows q_w, q_e, r_n, r_s through the sides of the box round a face,
//     A = max(q_w, 0) (u - u_w) + max(-q_e, 0) (u - u_e) + max(r_n, 0) (u - u_n) + max(-r_s, 0) (u - u_s)
//     u' = keep (u - dt / dx A / max(depth, dt / dx (max(q_w, 0) + max(-q_e, 0) + ..)) + g dt / dx (surface_a - surface_b))
// where depth is the mean of the two columns now, and the flows are those that made it so: of the surface a step before.
// With the flows of now, momentum would be lost in bores, and they would be late on the finest grid too. The maximum
// keeps what is carried between the velocities round about even where water is thin. A face under less than `thin` of
// water is shut. Each invocation walks down `rows` rows of four columns, as in water/donor.glsl. 28 bytes a column and
// step. CPU twin: water::cpu_wet::Depths.

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint rows = 8u;
layout(constant_id = 3) const bool has_advection = true;  // else A is nothing: no bores, but the model of wet in velocities

layout(set = 0, binding = 0, std430) readonly buffer Bed { vec4 bed_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Rise { vec4 rise_m[]; };
layout(set = 0, binding = 2, std430) readonly buffer Before { vec4 before_m[]; };  // rise a step before
layout(set = 0, binding = 3, std430) readonly buffer Speed { vec4 speed_mps[]; };  // east, south of four columns
layout(set = 0, binding = 4, std430) writeonly buffer NewSpeed { vec4 new_speed_mps[]; };

layout(push_constant, std430) uniform Push { DepthParams p; };

// A row at the columns 4q - 1 .. 4q + 6: velocities and flows through the east and south faces.
struct Row {
    float bed[8];
    float surface[8];
    float depth[8];
    float u[8];       // of the east faces
    float v[8];       // of the south faces
    float before[8];  // surface a step before
    float flow_u[7];  // through the east faces, a step before
};

float[8] eight(float west, vec4 mid, vec3 east) {
    return float[8](west, mid.x, mid.y, mid.z, mid.w, east.x, east.y, east.z);
}

Row load_row(int y, uint q) {
    uint fours = p.pitch >> 2u;
    bool is_in = y >= 0 && y < int(p.cells.y), has_west = is_in && q > 0u, has_east = is_in && q + 1u < fours;
    uint i = uint(y) * fours + q;
    Row row;
    row.bed = eight(has_west ? bed_m[i - 1u].w : WALL_M, is_in ? bed_m[i] : vec4(WALL_M),
                    has_east ? bed_m[i + 1u].xyz : vec3(WALL_M));
    float rise[8] = eight(has_west ? rise_m[i - 1u].w : LAND_M, is_in ? rise_m[i] : vec4(LAND_M),
                          has_east ? rise_m[i + 1u].xyz : vec3(LAND_M));
    float before[8] = eight(has_west ? before_m[i - 1u].w : LAND_M, is_in ? before_m[i] : vec4(LAND_M),
                            has_east ? before_m[i + 1u].xyz : vec3(LAND_M));
    row.u = eight(has_west ? speed_mps[2u * i - 2u].w : 0.0, is_in ? speed_mps[2u * i] : vec4(0.0),
                  has_east ? speed_mps[2u * i + 2u].xyz : vec3(0.0));
    row.v = eight(has_west ? speed_mps[2u * i - 1u].w : 0.0, is_in ? speed_mps[2u * i + 1u] : vec4(0.0),
                  has_east ? speed_mps[2u * i + 3u].xyz : vec3(0.0));
    for (int k = 0; k < 7; ++k) {
        row.depth[k] = depth_of(row.bed[k], rise[k]);
        row.surface[k] = surface_of(row.bed[k], rise[k]);
        row.before[k] = surface_of(row.bed[k], before[k]);
    }
    for (int k = 0; k < 6; ++k) {
        row.flow_u[k] = carried(row.u[k], row.before[k], row.before[k + 1], row.bed[k], row.bed[k + 1]);
    }
    return row;
}

// New velocity of one face between columns a and b: the velocity `here` and those round about, and the flows through
// the four sides of its box.
float advance(float here, float back, float ahead, float left, float right, vec4 flows, vec2 surface, vec2 bed,
              vec2 depth) {
    precise float head = max(surface.x, surface.y) - max(bed.x, bed.y);
    float a = max(flows.x, 0.0), b = max(-flows.y, 0.0), c = max(flows.z, 0.0), d = max(-flows.w, 0.0);
    precise float brought = (a * (here - back) + b * (here - ahead)) + (c * (here - left) + d * (here - right));
    brought = has_advection ? brought : 0.0;
    precise float mean = 0.5 * (depth.x + depth.y);
    precise float over = max(mean, p.reach * ((a + b) + (c + d)));
    precise float slope = slope_of(surface.x, surface.y, bed.x, bed.y);
    precise float velocity = p.keep * ((here - p.reach * brought / over) + p.pull * slope);
    velocity = clamp(velocity, -p.fastest_mps, p.fastest_mps);
    return head > p.thin_m ? velocity : 0.0;
}

void main() {
    uint q = gl_GlobalInvocationID.x, fours = p.pitch >> 2u;
    int y0 = int(gl_GlobalInvocationID.y * rows), y1 = min(y0 + int(rows), int(p.cells.y));
    if (q >= fours || y0 >= y1) return;

    // Row y + 2 comes in; row y goes out.
    Row n = load_row(y0 - 1, q), c = load_row(y0, q), s = load_row(y0 + 1, q);
    float flow_n[7], flow_c[7], flow_s[7];  // through the south faces of the three rows
    for (int k = 1; k < 6; ++k) {
        flow_n[k] = carried(n.v[k], n.before[k], c.before[k], n.bed[k], c.bed[k]);
        flow_c[k] = carried(c.v[k], c.before[k], s.before[k], c.bed[k], s.bed[k]);
    }
    for (int y = y0; y < y1; ++y) {
        Row next = load_row(y + 2, q);
        for (int k = 1; k < 6; ++k) {
            flow_s[k] = carried(s.v[k], s.before[k], next.before[k], s.bed[k], next.bed[k]);
        }
        vec4 east, south;
        for (int j = 0; j < 4; ++j) {
            int k = j + 1;
            precise vec4 round_east = 0.5 * vec4(c.flow_u[k - 1] + c.flow_u[k], c.flow_u[k] + c.flow_u[k + 1],
                                                 flow_n[k] + flow_n[k + 1], flow_c[k] + flow_c[k + 1]);
            east[j] = advance(c.u[k], c.u[k - 1], c.u[k + 1], n.u[k], s.u[k], round_east,
                              vec2(c.surface[k], c.surface[k + 1]), vec2(c.bed[k], c.bed[k + 1]),
                              vec2(c.depth[k], c.depth[k + 1]));
            precise vec4 round_south = 0.5 * vec4(flow_n[k] + flow_c[k], flow_c[k] + flow_s[k],
                                                  c.flow_u[k - 1] + s.flow_u[k - 1], c.flow_u[k] + s.flow_u[k]);
            south[j] = advance(c.v[k], n.v[k], s.v[k], c.v[k - 1], c.v[k + 1], round_south,
                               vec2(c.surface[k], s.surface[k]), vec2(c.bed[k], s.bed[k]),
                               vec2(c.depth[k], s.depth[k]));
        }
        uint i = uint(y) * fours + q;
        new_speed_mps[2u * i] = east;
        new_speed_mps[2u * i + 1u] = south;
        n = c;
        c = s;
        s = next;
        flow_n = flow_c;
        flow_c = flow_s;
    }
}
