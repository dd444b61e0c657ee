#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/land.glsl"

// Waves on water of even depth, fourth order in space and time, one step.
//     g = h - sharpen L h,  v' = keep (v + pull L g),  h' = h + dt v'
//     L h = sum over the 4 sides of (h_other - h)  +  1/4 sum over the 4 corners of (h_other - h)
// L alone is too slow for short waves, the same in all directions, and a step of finite length is too fast: sharpen =
// (1 - courant^2) / 18 takes both errors out. At walls the surface goes on as its mirror image, and so does g.
// Each invocation walks down `rows` rows of 4 columns, with one more column of g and two more of h on either side; the
// rows of h and g that the stencils reach stay in registers. 16 bytes a column and step, as water.waves. CPU twin:
// water::cpu_fourth::Fourth.

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint rows = 8u;
layout(constant_id = 3) const bool has_land = false;

layout(set = 0, binding = 0, std430) readonly buffer Height { vec4 height_m[]; };
layout(set = 0, binding = 1, std430) buffer Velocity { vec4 velocity_mps[]; };
layout(set = 0, binding = 2, std430) writeonly buffer NewHeight { vec4 new_height_m[]; };

// Mirrors `water::FourthParams`.
layout(push_constant, std430) uniform Push {
    uvec2 cells;    // size of the grid
    uint pitch;     // columns from one row to the next
    float dt_s;     // step (s)
    float pull;     // what a unit of the stencil's sum adds to the velocity (1/s)
    float keep;     // share of the velocity kept per step, 1 = lossless
    float sharpen;  // weight of the second stencil
    uint reserved;
} p;

const float DIAGONAL = 0.25;

// Columns 4q - 2 .. 4q + 5 of h, or 4q - 1 .. 4q + 4 of g (then `west.x` and `east.y` are not used).
struct Row {
    vec2 west;
    vec4 mid;
    vec2 east;
};

// Row y of h. Beyond the grid: the mirror image, or land if walls are land. Only the two columns beyond the last one are
// right: no stencil reaches further. No branches: software drivers run both sides of each.
Row load_row(int y, uint q) {
    int last = int(p.cells.y) - 1;
    bool is_off = y < 0 || y > last;
    y = clamp(y < 0 ? -1 - y : y > last ? 2 * last + 1 - y : y, 0, last);
    uint i = uint(y) * (p.pitch >> 2u) + q;
    uint ahead = p.cells.x - 4u * q;  // columns from here to the wall
    Row r;
    r.mid = height_m[i];
    vec2 before = height_m[q > 0u ? i - 1u : i].zw;
    r.east = height_m[ahead > 4u ? i + 1u : i].xy;
    bool is_west = q == 0u;
    r.west.y = is_west ? r.mid.x : before.y;
    if (has_land) {
        r.mid = mix(r.mid, vec4(LAND_M), greaterThanEqual(uvec4(0u, 1u, 2u, 3u), uvec4(ahead)));
        r.east = mix(r.east, vec2(LAND_M), greaterThanEqual(uvec2(4u, 5u), uvec2(ahead)));
        r.west = is_west ? vec2(LAND_M) : before;
        if (is_off) r = Row(vec2(LAND_M), vec4(LAND_M), vec2(LAND_M));
        return r;
    }
    // Column `ahead` is the image of the one before it, and the next of the one before that.
    if (ahead == 1u) r.mid.yzw = vec3(r.mid.x, r.west.y, r.mid.x);
    if (ahead == 2u) r.mid.zw = r.mid.yx;
    if (ahead == 3u) r.mid.w = r.mid.z;
    if (ahead == 3u) r.east.x = r.mid.y;
    if (ahead == 4u) r.east = r.mid.wz;
    if (ahead == 5u) r.east.y = r.east.x;
    r.west.x = is_west ? r.mid.y : before.x;
    return r;
}

float side_pull(float side, float centre) {
    precise float pull = has_land && side == LAND_M ? 0.0 : side - centre;
    return pull;
}

// What one corner adds; beside land as in water.waves: a corner that is land is the image of the flank that is water.
float corner_pull(float corner, float flank, float other_flank, float centre) {
    if (has_land) {
        bool wet = corner != LAND_M, flank_wet = flank != LAND_M, other_wet = other_flank != LAND_M;
        if (wet && !flank_wet && !other_wet) return 0.0;
        if (!wet) {
            if (flank_wet == other_wet) return 0.0;
            corner = flank_wet ? flank : other_flank;
        }
    }
    precise float pull = corner - centre;
    return pull;
}

float laplacian(vec3 n, vec3 c, vec3 s) {
    precise float sides =
        (side_pull(c.x, c.y) + side_pull(c.z, c.y)) + (side_pull(n.y, c.y) + side_pull(s.y, c.y));
    precise float corners = (corner_pull(n.x, n.y, c.x, c.y) + corner_pull(n.z, n.y, c.z, c.y)) +
                            (corner_pull(s.x, s.y, c.x, c.y) + corner_pull(s.z, s.y, c.z, c.y));
    precise float sum = sides + DIAGONAL * corners;
    return sum;
}

float sharpened(vec3 n, vec3 c, vec3 s) {
    precise float g = c.y - p.sharpen * laplacian(n, c, s);
    return has_land && c.y == LAND_M ? LAND_M : g;
}

// A row of g from three of h.
Row sharpen_row(Row n, Row c, Row s) {
    Row g;
    g.west = vec2(0.0, sharpened(vec3(n.west, n.mid.x), vec3(c.west, c.mid.x), vec3(s.west, s.mid.x)));
    g.mid.x = sharpened(vec3(n.west.y, n.mid.xy), vec3(c.west.y, c.mid.xy), vec3(s.west.y, s.mid.xy));
    g.mid.y = sharpened(n.mid.xyz, c.mid.xyz, s.mid.xyz);
    g.mid.z = sharpened(n.mid.yzw, c.mid.yzw, s.mid.yzw);
    g.mid.w = sharpened(vec3(n.mid.zw, n.east.x), vec3(c.mid.zw, c.east.x), vec3(s.mid.zw, s.east.x));
    g.east = vec2(sharpened(vec3(n.mid.w, n.east), vec3(c.mid.w, c.east), vec3(s.mid.w, s.east)), 0.0);
    return g;
}

void main() {
    uint q = gl_GlobalInvocationID.x;
    int y0 = int(gl_GlobalInvocationID.y * rows);
    if (4u * q >= p.cells.x || y0 >= int(p.cells.y)) return;
    int y1 = min(y0 + int(rows), int(p.cells.y));

    Row n = load_row(y0 - 1, q), c = load_row(y0, q), s = load_row(y0 + 1, q);  // of h
    Row gn = sharpen_row(load_row(y0 - 2, q), n, c), gc = sharpen_row(n, c, s);
    for (int y = y0; y < y1; ++y) {
        Row ss = load_row(y + 2, q);
        Row gs = sharpen_row(c, s, ss);
        vec4 sum;
        sum.x = laplacian(vec3(gn.west.y, gn.mid.xy), vec3(gc.west.y, gc.mid.xy), vec3(gs.west.y, gs.mid.xy));
        sum.y = laplacian(gn.mid.xyz, gc.mid.xyz, gs.mid.xyz);
        sum.z = laplacian(gn.mid.yzw, gc.mid.yzw, gs.mid.yzw);
        sum.w = laplacian(vec3(gn.mid.zw, gn.east.x), vec3(gc.mid.zw, gc.east.x), vec3(gs.mid.zw, gs.east.x));
        uint i = uint(y) * (p.pitch >> 2u) + q;
        precise vec4 v = p.keep * (velocity_mps[i] + p.pull * sum);
        precise vec4 h = c.mid + p.dt_s * v;
        if (has_land) {
            bvec4 land = equal(c.mid, vec4(LAND_M));
            v = mix(v, vec4(0.0), land);
            h = mix(h, vec4(LAND_M), land);
        }
        velocity_mps[i] = v;
        new_height_m[i] = h;
        c = s;
        s = ss;
        gn = gc;
        gc = gs;
    }
}
