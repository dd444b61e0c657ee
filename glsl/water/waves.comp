#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/water.glsl"

// Waves on water of even depth, one step. On a flat, wet bottom the pipes of the book can be summed before they are
// stored, exactly: a column then needs its height and the velocity of its surface, and nothing else.
//     v' = keep (v + pull L h),  h' = h + dt v'
//     L h = sum over the 4 sides of (h_other - h)  +  w sum over the 4 corners of (h_other - h)
// At a wall a missing neighbour is the mirror image of the column itself, and so adds nothing; with `folded` the corners
// beyond the wall are mirror images too, which keeps the scheme second order and its waves straight along walls.
// Each invocation walks down `rows` rows of 4 columns, so a row is loaded once for three uses. 16 bytes a column and
// step: h and v are read and written once. CPU twin: water::cpu::Waves.

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint rows = 8u;
layout(constant_id = 3) const bool has_land = false;

layout(set = 0, binding = 0, std430) readonly buffer Height { vec4 height_m[]; };
layout(set = 0, binding = 1, std430) buffer Velocity { vec4 velocity_mps[]; };
layout(set = 0, binding = 2, std430) writeonly buffer NewHeight { vec4 new_height_m[]; };

layout(push_constant, std430) uniform Push { WaterParams p; };

// Four columns of a row and the one on either side.
struct Row {
    float west;
    vec4 mid;
    float east;
};

vec4 west_of(Row r) { return vec4(r.west, r.mid.xyz); }
vec4 east_of(Row r) { return vec4(r.mid.yzw, r.east); }

// Row y at the columns 4q .. 4q + 3. Beyond the grid: the mirror image at the wall, or land if walls are land.
Row load_row(int y, uint q) {
    uint fours = p.pitch >> 2u;
    uint i = uint(clamp(y, 0, int(p.cells.y) - 1)) * fours + q;
    Row r;
    r.mid = height_m[i];
    uint ahead = p.cells.x - 4u * q;  // columns from here to the wall
    // The last four of a row may reach beyond the wall: what lies there is the image of the last column.
    if (ahead < 4u) r.mid.w = ahead == 3u ? r.mid.z : ahead == 2u ? r.mid.y : r.mid.x;
    if (ahead < 3u) r.mid.z = ahead == 2u ? r.mid.y : r.mid.x;
    if (ahead < 2u) r.mid.y = r.mid.x;
    r.west = q > 0u ? height_m[i - 1u].w : r.mid.x;
    r.east = ahead > 4u ? height_m[i + 1u].x : r.mid.w;
    return r;
}

// The stencil where all is water.
vec4 laplacian(Row n, Row c, Row s, vec4 nw, vec4 ne, vec4 sw, vec4 se) {
    precise vec4 sides = ((west_of(c) - c.mid) + (east_of(c) - c.mid)) + ((n.mid - c.mid) + (s.mid - c.mid));
    precise vec4 corners = ((nw - c.mid) + (ne - c.mid)) + ((sw - c.mid) + (se - c.mid));
    precise vec4 sum = sides + p.diagonal * corners;
    return sum;
}

// What one corner adds beside land: its pipe if it has water on one of its flanks, and where the corner is land, the
// image of the flank that is water (the wall lies along the other). The shore is a mirror as the border is.
float corner_pull(float corner, float flank, float other_flank, float centre) {
    bool wet = corner != LAND_M, a = flank != LAND_M, b = other_flank != LAND_M;
    precise float pull = 0.0;
    if (wet) {
        if (a || b) pull = corner - centre;
    } else if (p.folded == 1u && a != b) {
        pull = (a ? flank : other_flank) - centre;
    }
    return pull;
}

float side_pull(float side, float centre) {
    precise float pull = side == LAND_M ? 0.0 : side - centre;
    return pull;
}

float laplacian_beside_land(mat3 h) {  // h[row][column]
    precise float sides = (side_pull(h[1][0], h[1][1]) + side_pull(h[1][2], h[1][1])) +
                          (side_pull(h[0][1], h[1][1]) + side_pull(h[2][1], h[1][1]));
    precise float corners =
        (corner_pull(h[0][0], h[0][1], h[1][0], h[1][1]) + corner_pull(h[0][2], h[0][1], h[1][2], h[1][1])) +
        (corner_pull(h[2][0], h[2][1], h[1][0], h[1][1]) + corner_pull(h[2][2], h[2][1], h[1][2], h[1][1]));
    precise float sum = sides + p.diagonal * corners;
    return sum;
}

void main() {
    uint q = gl_GlobalInvocationID.x;
    uint y0 = gl_GlobalInvocationID.y * rows;
    if (4u * q >= p.cells.x || y0 >= p.cells.y) return;
    uint fours = p.pitch >> 2u;
    uint y1 = min(y0 + rows, p.cells.y);
    bool is_west = q == 0u, folds = p.folded == 1u;
    uint last = p.cells.x - 1u - 4u * q;  // the column of these four at the east wall, if it is one of them

    Row n = load_row(int(y0) - 1, q), c = load_row(int(y0), q);
    for (uint y = y0; y < y1; ++y) {
        Row s = load_row(int(y) + 1, q);
        vec4 sum;
        if (has_land) {
            for (int k = 0; k < 4; ++k) {
                vec3 column[3];
                float wests[3] = float[3](n.west, c.west, s.west), easts[3] = float[3](n.east, c.east, s.east);
                vec4 mids[3] = vec4[3](n.mid, c.mid, s.mid);
                bool off_west = is_west && k == 0, off_east = uint(k) >= last;
                for (int j = 0; j < 3; ++j) {
                    float here = mids[j][k];
                    float west = k == 0 ? wests[j] : mids[j][max(k - 1, 0)];
                    float east = k == 3 ? easts[j] : mids[j][min(k + 1, 3)];
                    bool off_row = (j == 0 && y == 0u) || (j == 2 && y + 1u == p.cells.y);
                    column[j] = vec3(off_row || off_west ? LAND_M : west, off_row ? LAND_M : here,
                                     off_row || off_east ? LAND_M : east);
                }
                sum[k] = laplacian_beside_land(mat3(column[0], column[1], column[2]));
            }
        } else {
            vec4 nw = west_of(n), ne = east_of(n), sw = west_of(s), se = east_of(s);
            if (!folds) {  // a corner beyond a wall is the column itself: its pipe is dropped
                if (y == 0u) nw = ne = c.mid;
                if (y + 1u == p.cells.y) sw = se = c.mid;
                if (is_west) nw.x = sw.x = c.mid.x;
                bvec4 at_east = greaterThanEqual(uvec4(0u, 1u, 2u, 3u), uvec4(last));
                ne = mix(ne, c.mid, at_east);
                se = mix(se, c.mid, at_east);
            }
            sum = laplacian(n, c, s, nw, ne, sw, se);
        }
        uint i = y * fours + q;
        precise vec4 v = p.keep * (velocity_mps[i] + p.pull * sum);
        precise vec4 h = c.mid + p.dt_s * v;
        if (has_land) {
            bvec4 land = equal(c.mid, vec4(LAND_M));
            v = mix(v, vec4(0.0), land);
            h = mix(h, vec4(LAND_M), land);
        }
        velocity_mps[i] = v;
        new_height_m[i] = h;
        n = c;
        c = s;
    }
}
