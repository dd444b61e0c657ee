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
// New velocities reach one column and flows two, K another: three in all. A workgroup is a row of columns, of which all
// but HALO at either end are its own, and walks down `rows` rows. A row is loaded once, and what is computed of a column is
// computed once: the columns on the left and right see it in shared memory, the rows above and below in registers.
// 36 bytes a column and step. CPU twin: water::cpu_wet::Depths.

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint LANES = 128u;  // the same number: columns of a workgroup
layout(constant_id = 2) const uint rows = 64u;
layout(constant_id = 3) const bool has_advection = true;  // else A is nothing: no bores, but the model of wet in velocities

layout(set = 0, binding = 0, std430) readonly buffer Bed { float bed_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Rise { float rise_m[]; };
layout(set = 0, binding = 2, std430) readonly buffer Before { float before_m[]; };  // rise a step before
layout(set = 0, binding = 3, std430) readonly buffer Speed { float speed_mps[]; };  // east, south of four columns
layout(set = 0, binding = 4, std430) writeonly buffer NewRise { float new_rise_m[]; };
layout(set = 0, binding = 5, std430) writeonly buffer NewBefore { float new_before_m[]; };
layout(set = 0, binding = 6, std430) writeonly buffer NewSpeed { float new_speed_mps[]; };

layout(push_constant, std430) uniform Push { DepthParams p; };

const int HALO = 4;  // one more than is reached, so that groups begin where memory does

// What neighbours in the row see, of the last 4 rows, or 2: row y is at y & 3, or y & 1.
shared vec4 columns[4u * LANES];  // bed, surface, surface a step before, rise
shared vec2 speeds[4u * LANES];   // through the east and the south face
shared vec2 flows[4u * LANES];    // the same, a step before
shared float moves[2u * LANES];   // what moves through the east face now
shared float shares[2u * LANES];  // K

// As memory has it.
struct Loaded {
    float bed;
    float rise;
    float before;
    float u;
    float v;
};

struct Column {
    float bed;
    float surface;
    float depth;
    float before;  // surface a step before
    float rise;
    float u;       // through the east face
    float v;       // through the south face
    float flow_u;  // the same flows a step before
    float flow_v;
};

uint speed_at(int x, int y) { return 2u * (uint(y) * p.pitch + uint(x & ~3)) + uint(x & 3); }

Loaded load(int x, int y) {
    bool is_in = x >= 0 && x < int(p.pitch) && y >= 0 && y < int(p.cells.y);
    uint i = uint(y) * p.pitch + uint(x), k = speed_at(x, y);
    if (!is_in) return Loaded(WALL_M, LAND_M, LAND_M, 0.0, 0.0);
    return Loaded(bed_m[i], rise_m[i], before_m[i], speed_mps[k], speed_mps[k + 4u]);
}

// Water that a face velocity carries (m^2/s): it is as deep as upstream, above the higher ground.
float carried(float velocity, float surface_a, float surface_b, float bed_a, float bed_b) {
    precise float depth = (velocity > 0.0 ? surface_a : surface_b) - max(bed_a, bed_b);
    precise float flow = velocity * max(depth, 0.0);
    return flow;
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
    const uint lane = gl_LocalInvocationID.x;
    const uint west = max(lane, 1u) - 1u, east = min(lane + 1u, LANES - 1u);  // of the outermost: of no use, and not used
    const int x = int(gl_WorkGroupID.x) * (int(LANES) - 2 * HALO) + int(lane) - HALO;
    const int y0 = int(gl_WorkGroupID.y * rows), y1 = min(y0 + int(rows), int(p.cells.y));
    const bool is_mine = int(lane) >= HALO && int(lane) < int(LANES) - HALO && x < int(p.pitch);

    // Row y comes in; velocities of row y - 2 become known, and K of row y - 3; row y - 4 goes out.
    const Column none = Column(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    Column n = none, c = none, s = none;                // rows y - 3, y - 2, y - 1
    float leaving_rise = 0.0, leaving_share = 0.0;      // of row y - 4
    vec2 leaving_moves = vec2(0.0), moved = vec2(0.0);  // through the east and south faces of rows y - 4 and y - 3
    float from_north = 0.0;                             // what moves into row y - 4, limited
    Loaded next = load(x, y0 - 3);
    for (int y = y0 - 3; y < y1 + 4; ++y) {
        const uint at = uint(y & 3) * LANES, at_s = uint((y - 1) & 3) * LANES, at_c = uint((y - 2) & 3) * LANES,
                   at_n = uint((y - 3) & 3) * LANES;
        const uint even = uint(y & 1) * LANES, odd = LANES - even;  // of rows y - 2 and y - 4, of row y - 3
        Column row;
        row.bed = next.bed;
        row.surface = surface_of(next.bed, next.rise);
        row.depth = depth_of(next.bed, next.rise);
        row.before = surface_of(next.bed, next.before);
        row.rise = next.rise;
        row.u = next.u;
        row.v = next.v;
        columns[at + lane] = vec4(row.bed, row.surface, row.before, row.rise);
        speeds[at + lane] = vec2(row.u, row.v);
        next = load(x, y + 1);  // arrives while this row is worked at
        barrier();

        vec4 beside = columns[at + east];
        row.flow_u = carried(row.u, row.before, beside.z, row.bed, beside.x);
        s.flow_v = carried(s.v, s.before, row.before, s.bed, row.bed);
        flows[at + lane].x = row.flow_u;
        flows[at_s + lane].y = s.flow_v;
        float share_n = share(n.depth, moves[odd + west], moved.x, leaving_moves.y, moved.y);
        float to_south = limited(leaving_moves.y, leaving_share, share_n);
        float from_west = limited(moves[even + west], shares[even + west], leaving_share);
        float to_east = limited(leaving_moves.x, leaving_share, shares[even + east]);
        shares[odd + lane] = share_n;
        if (is_mine && y >= y0 + 4) {
            uint i = uint(y - 4) * p.pitch + uint(x);
            precise float gain = (from_west - to_east) + (from_north - to_south);
            precise float new_rise = (leaving_rise + gain) + p.rain_m;
            new_rise_m[i] = new_rise;
            new_before_m[i] = leaving_rise;
        }
        from_north = to_south;
        leaving_rise = n.rise;
        leaving_share = share_n;
        leaving_moves = moved;
        barrier();

        beside = columns[at_c + east];
        vec2 speed_w = speeds[at_c + west], speed_e = speeds[at_c + east];
        float flow_n = n.flow_v, flow_n_e = flows[at_n + east].y, flow_c_e = flows[at_c + east].y;
        float flow_w = flows[at_c + west].x, flow_e = flows[at_c + east].x, flow_s_w = flows[at_s + west].x;
        precise vec4 round_east =
            0.5 * vec4(flow_w + c.flow_u, c.flow_u + flow_e, flow_n + flow_n_e, c.flow_v + flow_c_e);
        precise vec4 round_south =
            0.5 * vec4(flow_n + c.flow_v, c.flow_v + s.flow_v, flow_w + flow_s_w, c.flow_u + s.flow_u);
        float depth_e = depth_of(beside.x, beside.w);
        float u = advance(c.u, speed_w.x, speed_e.x, n.u, s.u, round_east, vec2(c.surface, beside.y),
                          vec2(c.bed, beside.x), vec2(c.depth, depth_e));
        float v = advance(c.v, n.v, s.v, speed_w.y, speed_e.y, round_south, vec2(c.surface, s.surface),
                          vec2(c.bed, s.bed), vec2(c.depth, s.depth));
        if (is_mine && y >= y0 + 2 && y < y1 + 2) {
            uint k = speed_at(x, y - 2);
            new_speed_mps[k] = u;
            new_speed_mps[k + 4u] = v;
        }
        precise float to_e = p.reach * carried(u, c.surface, beside.y, c.bed, beside.x);
        precise float to_s = p.reach * carried(v, c.surface, s.surface, c.bed, s.bed);
        moved = vec2(in_whole_units(to_e, c.rise, beside.w), in_whole_units(to_s, c.rise, s.rise));
        moves[even + lane] = moved.x;
        n = c;
        c = s;
        s = row;
    }
}
