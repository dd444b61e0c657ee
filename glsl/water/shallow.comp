#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/depth.glsl"
#include "water/donor.glsl"

// Shallow water, one step. First new velocities u of the east and v of the south faces, by Stelling and Duinmeijer, "A
// staggered conservative scheme for every Froude number in rapidly varied shallow water flows", Int. J. Numer. Meth. Fluids
// 43 (2003) 1329, first order. Advection conserves momentum, so bores run at the right speed:
//     u u_x + v u_y = ((q u)_x - u q_x + (r u)_y - u r_y) / depth,  q = flow to the east, r = flow to the south
// with u from upstream in (q u)_x this is, for the flows q_w, q_e, r_n, r_s through the sides of the box round a face,
//     A = max(q_w, 0) (u - u_w) + max(-q_e, 0) (u - u_e) + max(r_n, 0) (u - u_n) + max(-r_s, 0) (u - u_s)
//     u' = keep (u - dt / dx A / max(depth, dt / dx (max(q_w, 0) + max(-q_e, 0) + ..)) + g dt / dx (surface_a - surface_b))
// where depth is the mean of the two columns now, and the flows are those that made it so: of the surface a step before.
// With the flows of now, momentum would be lost in bores, and they would be late on the finest grid too. The maximum
// keeps what is carried between the velocities round about even where water is thin. A face under less than `thin` of
// water is shut. Then the velocities carry the water, upstream depth by velocity, limited and moved as
// water/donor.glsl says. Velocities stay as they are: a limited flow means that little water was there, not that it
// was slow.
//
// New velocities reach one column and flows two, K another: three in all. A workgroup is a row of lanes of four columns, of
// which the first and the last are not its own, and walks down `rows` rows. A row is loaded once, and what is computed of a
// column is computed once: lanes on the left and right see it in shared memory, the rows above and below in registers.
// 36 bytes a column and step. CPU twin: water::cpu_wet::Depths.

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint LANES = 32u;  // the same number
layout(constant_id = 2) const uint rows = 61u;   // best of the form 4 k + 1: rows are taken by fours, with 7 more
layout(constant_id = 3) const bool has_advection = true;  // else A is nothing: no bores, but the model of wet in velocities

layout(set = 0, binding = 0, std430) readonly buffer Bed { vec4 bed_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Rise { vec4 rise_m[]; };
layout(set = 0, binding = 2, std430) readonly buffer Before { vec4 before_m[]; };  // rise a step before
layout(set = 0, binding = 3, std430) readonly buffer Speed { vec4 speed_mps[]; };  // east, south of four columns
layout(set = 0, binding = 4, std430) writeonly buffer NewRise { vec4 new_rise_m[]; };
layout(set = 0, binding = 5, std430) writeonly buffer NewBefore { vec4 new_before_m[]; };
layout(set = 0, binding = 6, std430) writeonly buffer NewSpeed { vec4 new_speed_mps[]; };

layout(push_constant, std430) uniform Push { DepthParams p; };

// What other lanes see of the first and the last of four columns, in row y at y & 3, or y & 1.
shared vec4 first_column[4u * LANES];  // bed, surface, surface a step before, rise
shared vec2 first_speed[4u * LANES];   // through the east and the south face
shared vec2 last_speed[4u * LANES];
shared vec2 first_flow[4u * LANES];    // the same, a step before
shared float last_flow_u[4u * LANES];
shared float last_moved[2u * LANES];   // through the east face now
shared float first_share[2u * LANES];  // K
shared float last_share[2u * LANES];

// As memory has it.
struct Loaded {
    vec4 bed;
    vec4 rise;
    vec4 before;
    vec4 u;
    vec4 v;
};

// Four columns of a row, and their east (u) and south (v) faces.
struct Four {
    vec4 bed;
    vec4 surface;
    vec4 depth;
    vec4 before;   // surface a step before
    vec4 rise;
    vec4 u;
    vec4 v;
    vec4 flow_u;   // a step before
    vec4 flow_v;
    vec4 mean_v;   // of flow_v and that on the east
    vec4 along_v;  // of flow_v and that on the south
    vec4 moved_u;  // now (m)
    vec4 moved_v;
    vec4 share;
};

// What a walk carries from row to row beside the last four.
struct Walk {
    Loaded next;
    vec4 from_north;  // what moves into the row that goes out next, limited
};

vec4 eastward(vec4 a, float next) { return vec4(a.yzw, next); }
vec4 westward(vec4 a, float last) { return vec4(last, a.xyz); }

Loaded load(int y, int q) {
    int fours = int(p.pitch >> 2u), i = y * fours + q;
    bool is_in = q >= 0 && q < fours && y >= 0 && y < int(p.cells.y);
    if (!is_in) return Loaded(vec4(WALL_M), vec4(LAND_M), vec4(LAND_M), vec4(0.0), vec4(0.0));
    return Loaded(bed_m[i], rise_m[i], before_m[i], speed_mps[2 * i], speed_mps[2 * i + 1]);
}

// Water that a face velocity carries (m^2/s): it is as deep as upstream, above the higher ground.
vec4 carried(vec4 velocity, vec4 surface_a, vec4 surface_b, vec4 bed_a, vec4 bed_b) {
    precise vec4 depth = mix(surface_b, surface_a, greaterThan(velocity, vec4(0.0))) - max(bed_a, bed_b);
    precise vec4 flow = velocity * max(depth, 0.0);
    return flow;
}

// New velocities of faces between columns a and b: the velocity `here` and those round about, and the flows through the
// four sides of the box.
vec4 advance(vec4 here, vec4 back, vec4 ahead, vec4 left, vec4 right, vec4 flow_back, vec4 flow_ahead, vec4 flow_left,
             vec4 flow_right, vec4 surface_a, vec4 surface_b, vec4 bed_a, vec4 bed_b, vec4 depth_a, vec4 depth_b) {
    precise vec4 head = max(surface_a, surface_b) - max(bed_a, bed_b);
    vec4 a = max(flow_back, 0.0), b = max(-flow_ahead, 0.0), c = max(flow_left, 0.0), d = max(-flow_right, 0.0);
    precise vec4 brought = (a * (here - back) + b * (here - ahead)) + (c * (here - left) + d * (here - right));
    brought = has_advection ? brought : vec4(0.0);
    precise vec4 mean = 0.5 * (depth_a + depth_b);
    precise vec4 over = max(mean, p.reach * ((a + b) + (c + d)));
    precise vec4 slope = slope_of(surface_a, surface_b, bed_a, bed_b);
    precise vec4 velocity = p.keep * ((here - p.reach * brought / over) + p.pull * slope);
    velocity = clamp(velocity, -p.fastest_mps, p.fastest_mps);
    return mix(vec4(0.0), velocity, greaterThan(head, vec4(p.thin_m)));
}

// Row y comes in, over row y - 4, which goes out; s, c and n are rows y - 1, y - 2 and y - 3. Velocities of row y - 2 become
// known, and K of row y - 3. Rows y0 to y1 are the walk's own.
void walk(int y, int y0, int y1, inout Walk w, inout Four row, inout Four s, inout Four c, inout Four n) {
    const uint lane = gl_LocalInvocationID.x, west = max(lane, 1u) - 1u, east = min(lane + 1u, LANES - 1u);
    const int fours = int(p.pitch >> 2u), q = int(gl_WorkGroupID.x) * (int(LANES) - 2) + int(lane) - 1;
    const bool is_mine = lane > 0u && lane + 1u < LANES && q < fours;
    const uint at = uint(y & 3) * LANES, at_s = uint((y - 1) & 3) * LANES, at_c = uint((y - 2) & 3) * LANES;
    const uint even = uint(y & 1) * LANES, odd = LANES - even;  // of rows y - 2 and y - 4, of row y - 3

    Four leaving = row;
    row.bed = w.next.bed;
    row.rise = w.next.rise;
    row.u = w.next.u;
    row.v = w.next.v;
    row.surface = surface_of(row.bed, row.rise);
    row.depth = depth_of(row.bed, row.rise);
    row.before = surface_of(row.bed, w.next.before);
    first_column[at + lane] = vec4(row.bed.x, row.surface.x, row.before.x, row.rise.x);
    first_speed[at + lane] = vec2(row.u.x, row.v.x);
    last_speed[at + lane] = vec2(row.u.w, row.v.w);
    w.next = load(y + 1, q);  // arrives while this row is worked at
    barrier();

    vec4 beside = first_column[at + east];
    row.flow_u = carried(row.u, row.before, eastward(row.before, beside.z), row.bed, eastward(row.bed, beside.x));
    s.flow_v = carried(s.v, s.before, row.before, s.bed, row.bed);
    first_flow[at + lane].x = row.flow_u.x;
    first_flow[at_s + lane].y = s.flow_v.x;
    last_flow_u[at + lane] = row.flow_u.w;
    n.share = share(n.depth, westward(n.moved_u, last_moved[odd + west]), n.moved_u, leaving.moved_v, n.moved_v);
    first_share[odd + lane] = n.share.x;
    last_share[odd + lane] = n.share.w;
    vec4 to_south = limited(leaving.moved_v, leaving.share, n.share);
    vec4 to_east = limited(leaving.moved_u, leaving.share, eastward(leaving.share, first_share[even + east]));
    float first_from_west = limited(last_moved[even + west], last_share[even + west], leaving.share.x);
    if (is_mine && y >= y0 + 4 && y < y1 + 4) {
        int i = (y - 4) * fours + q;
        precise vec4 gain = (westward(to_east, first_from_west) - to_east) + (w.from_north - to_south);
        precise vec4 new_rise = (leaving.rise + gain) + p.rain_m;
        new_rise_m[i] = new_rise;
        new_before_m[i] = leaving.rise;
    }
    w.from_north = to_south;
    barrier();

    beside = first_column[at_c + east];
    vec4 bed_e = eastward(c.bed, beside.x), surface_e = eastward(c.surface, beside.y);
    vec4 rise_e = eastward(c.rise, beside.w), depth_e = eastward(c.depth, depth_of(beside.x, beside.w));
    vec2 speed_w = last_speed[at_c + west], speed_e = first_speed[at_c + east], flow_e = first_flow[at_c + east];
    // Flows through the sides of boxes are means of two, and each is a side of two boxes.
    precise vec4 across_u = 0.5 * (c.flow_u + eastward(c.flow_u, flow_e.x)), along_u = 0.5 * (c.flow_u + s.flow_u);
    precise float across_w = 0.5 * (last_flow_u[at_c + west] + c.flow_u.x);
    precise float along_w = 0.5 * (last_flow_u[at_c + west] + last_flow_u[at_s + west]);
    precise vec4 mean_v = 0.5 * (c.flow_v + eastward(c.flow_v, flow_e.y)), along_v = 0.5 * (c.flow_v + s.flow_v);
    c.mean_v = mean_v;
    c.along_v = along_v;
    vec4 u = advance(c.u, westward(c.u, speed_w.x), eastward(c.u, speed_e.x), n.u, s.u, westward(across_u, across_w),
                     across_u, n.mean_v, mean_v, c.surface, surface_e, c.bed, bed_e, c.depth, depth_e);
    vec4 v = advance(c.v, n.v, s.v, westward(c.v, speed_w.y), eastward(c.v, speed_e.y), n.along_v, along_v,
                     westward(along_u, along_w), along_u, c.surface, s.surface, c.bed, s.bed, c.depth, s.depth);
    if (is_mine && y >= y0 + 2 && y < y1 + 2) {
        int i = (y - 2) * fours + q;
        new_speed_mps[2 * i] = u;
        new_speed_mps[2 * i + 1] = v;
    }
    precise vec4 to_e = p.reach * carried(u, c.surface, surface_e, c.bed, bed_e);
    precise vec4 to_s = p.reach * carried(v, c.surface, s.surface, c.bed, s.bed);
    c.moved_u = in_whole_units(to_e, c.rise, rise_e);
    c.moved_v = in_whole_units(to_s, c.rise, s.rise);
    last_moved[even + lane] = c.moved_u.w;
}

void main() {
    const int y0 = int(gl_WorkGroupID.y * rows), y1 = min(y0 + int(rows), int(p.cells.y));
    const int q = int(gl_WorkGroupID.x) * (int(LANES) - 2) + int(gl_LocalInvocationID.x) - 1;
    const vec4 zero = vec4(0.0);
    Four a = Four(zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero, zero);
    Four b = a, c = a, d = a;
    Walk w = Walk(load(y0 - 3, q), zero);
    for (int y = y0 - 3; y < y1 + 4; y += 4) {  // the last few may be one too many: they write nothing
        walk(y, y0, y1, w, a, d, c, b);
        walk(y + 1, y0, y1, w, b, a, d, c);
        walk(y + 2, y0, y1, w, c, b, a, d);
        walk(y + 3, y0, y1, w, d, c, b, a);
    }
}
