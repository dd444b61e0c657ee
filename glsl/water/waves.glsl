// The stencil of `waves`, for the kernel that takes one step and for the one that takes several: both must round alike.
//     L h = sum over the 4 sides of (h_other - h)  +  w sum over the 4 corners of (h_other - h)
// Rows are bent along x once each, b = (h_west - h) + (h_east - h), and used by the three rows that they touch:
//     L h = b + w (b_above + b_below) + (1 + 2 w) (h_above - 2 h + h_below)
// All are differences of neighbours: even water stays even to the bit, and what is rounded is as small as the waves.
// `fma` is named where it is meant, and `precise` forbids any other, so that every kernel rounds in the same places.
// CPU twin: water::cpu::Waves.

#include "water/row.glsl"

vec4 bend_of(Row r) {
    precise vec4 rise = vec4(r.mid.yzw, r.east) - r.mid;  // eastward; each is used by two columns
    precise vec4 bend = rise - vec4(r.mid.x - r.west, rise.xyz);
    return bend;
}

// `up` and `down` are the rises from the row above and to the row below; `upright` is 1 + 2 w, less w for each wall
// beside a column that drops its diagonal pipes.
vec4 pull_of(vec4 bend_n, vec4 bend, vec4 bend_s, vec4 up, vec4 down, float diagonal, vec4 upright) {
    precise vec4 along = fma(vec4(diagonal), bend_n + bend_s, bend);
    precise vec4 pull = fma(upright, down - up, along);
    return pull;
}

// Weight of the pipes up and down in four columns, the first of which is `x`.
vec4 upright_of(int x, int width, float diagonal, bool folded) {
    ivec4 columns = x + ivec4(0, 1, 2, 3);
    vec4 walls = vec4(0.0);
    // Walls recur in mirror images beyond the grid.
    if (!folded) walls = vec4(equal(abs(columns) % width, ivec4(0))) + vec4(equal(abs(columns + 1) % width, ivec4(0)));
    precise vec4 weight = vec4(1.0) + (2.0 - walls) * diagonal;  // the product is exact
    return weight;
}

void advance(inout vec4 h, inout vec4 v, vec4 pull, WaterParams p) {
    precise vec4 new_v = p.keep * fma(vec4(p.pull), pull, v);
    precise vec4 new_h = fma(vec4(p.dt_s), new_v, h);
    v = new_v;
    h = new_h;
}

// Beside land or on it the pull above is absurd, as land lies so deep: that is how the shore is found, without looking.
const float SHORE = 1.0e9;

// What one corner adds beside land: its pipe if it has water on one of its flanks, and where the corner is land, the
// image of the flank that is water (the wall lies along the other). The shore is a mirror as the border is.
float corner_pull(float corner, float flank, float other_flank, float centre, bool folded) {
    bool wet = corner != LAND_M, a = flank != LAND_M, b = other_flank != LAND_M;
    precise float pull = 0.0;
    if (wet) {
        if (a || b) pull = corner - centre;
    } else if (folded && a != b) {
        pull = (a ? flank : other_flank) - centre;
    }
    return pull;
}

float side_pull(float side, float centre) {
    precise float pull = side == LAND_M ? 0.0 : side - centre;
    return pull;
}

// The same sum beside land, pipe by pipe.
float pull_beside_land(vec3 n, vec3 c, vec3 s, float diagonal, bool folded) {
    precise float sides =
        (side_pull(c.x, c.y) + side_pull(c.z, c.y)) + (side_pull(n.y, c.y) + side_pull(s.y, c.y));
    precise float corners =
        (corner_pull(n.x, n.y, c.x, c.y, folded) + corner_pull(n.z, n.y, c.z, c.y, folded)) +
        (corner_pull(s.x, s.y, c.x, c.y, folded) + corner_pull(s.z, s.y, c.z, c.y, folded));
    precise float pull = sides + diagonal * corners;
    return pull;
}

vec3 around(Row r, int k) {
    return vec3(k == 0 ? r.west : r.mid[max(k - 1, 0)], r.mid[k], k == 3 ? r.east : r.mid[min(k + 1, 3)]);
}

bool is_at_shore(vec4 pull) {
    vec4 size = abs(pull);
    return max(max(size.x, size.y), max(size.z, size.w)) > SHORE;
}

// Corrects the columns of `pull` that are beside land or land.
vec4 at_shores(vec4 pull, Row n, Row c, Row s, float diagonal, bool folded) {
    for (int k = 0; k < 4; ++k) {
        if (pull[k] > SHORE) pull[k] = 0.0;
        if (pull[k] < -SHORE) pull[k] = pull_beside_land(around(n, k), around(c, k), around(s, k), diagonal, folded);
    }
    return pull;
}

// Land without velocity and pull stays where it is, to the bit.
vec4 still_on_land(vec4 h, vec4 v) { return mix(v, vec4(0.0), equal(h, vec4(LAND_M))); }
