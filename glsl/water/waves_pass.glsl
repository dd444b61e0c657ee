// Waves on water of even depth, one step: the pass of water.waves, and of water.waves_f16, which stores halves. On a flat, wet bottom the pipes of the book can be summed before they are
// stored, exactly: a column then needs its height and the velocity of its surface, and nothing else.
//     v' = keep (v + pull L h),  h' = h + dt v'
// At a wall a missing neighbour is the mirror image of the column itself, and so adds nothing; with `folded` the corners
// beyond the wall are mirror images too, which keeps the scheme second order and its waves straight along walls.
// Each invocation walks down `rows` rows of 4 columns, so a row is loaded and bent once for three uses; h and v are read
// and written once a step. CPU twin: water::cpu::Waves.
#include "water/storage.glsl"
#include "water/water.glsl"
#include "water/waves.glsl"

layout(local_size_x_id = 0, local_size_y_id = 1) in;
layout(constant_id = 2) const uint rows = 8u;
layout(constant_id = 3) const bool has_land = false;

layout(set = 0, binding = 0, std430) readonly buffer Height { FOUR height_m[]; };
layout(set = 0, binding = 1, std430) buffer Velocity { FOUR velocity_mps[]; };
layout(set = 0, binding = 2, std430) writeonly buffer NewHeight { FOUR new_height_m[]; };

layout(push_constant, std430) uniform Push { WaterParams p; };

// Row y at the columns 4q .. 4q + 3. Beyond the grid: land if there may be any, else the mirror image at the wall.
Row load_row(int y, uint q) {
    uint fours = p.pitch >> 2u;
    uint ahead = p.cells.x - 4u * q;  // columns from here to the wall
    Row r;
    if (has_land && (y < 0 || y >= int(p.cells.y))) return Row(LAND_M, vec4(LAND_M), LAND_M);
    uint i = uint(clamp(y, 0, int(p.cells.y) - 1)) * fours + q;
    r.mid = floats_of(height_m[i]);
    // The last four of a row may reach beyond the wall: what lies there is the image of the last column.
    if (ahead < 4u) r.mid.w = has_land ? LAND_M : ahead == 3u ? r.mid.z : ahead == 2u ? r.mid.y : r.mid.x;
    if (ahead < 3u) r.mid.z = has_land ? LAND_M : ahead == 2u ? r.mid.y : r.mid.x;
    if (ahead < 2u) r.mid.y = has_land ? LAND_M : r.mid.x;
    r.west = q > 0u ? floats_of(height_m[i - 1u]).w : has_land ? LAND_M : r.mid.x;
    r.east = ahead > 4u ? floats_of(height_m[i + 1u]).x : has_land ? LAND_M : r.mid.w;
    return r;
}

void main() {
    uint q = gl_GlobalInvocationID.x;
    uint y0 = gl_GlobalInvocationID.y * rows;
    if (4u * q >= p.cells.x || y0 >= p.cells.y) return;
    uint fours = p.pitch >> 2u;
    uint y1 = min(y0 + rows, p.cells.y);
    bool folded = p.folded == 1u, drops = !folded;
    vec4 upright = upright_of(int(4u * q), int(p.cells.x), p.diagonal, folded || has_land);

    Row n = load_row(int(y0) - 1, q), c = load_row(int(y0), q);
    precise vec4 up = c.mid - n.mid;
    vec4 bend_n = bend_of(n), bend = bend_of(c);
    for (uint y = y0; y < y1; ++y) {
        Row s = load_row(int(y) + 1, q);
        precise vec4 down = s.mid - c.mid;
        vec4 bend_s = bend_of(s);
        vec4 above = bend_n, below = bend_s;
        if (has_land ? false : drops) {  // a corner beyond a wall is the column itself: its pipe is dropped
            if (y == 0u) above = vec4(0.0);
            if (y + 1u == p.cells.y) below = vec4(0.0);
        }
        vec4 pull = pull_of(above, bend, below, up, down, p.diagonal, upright);
        if (has_land) pull = at_shores(pull, n, c, s, p.diagonal, folded);
        uint i = y * fours + q;
        vec4 h = c.mid, v = floats_of(velocity_mps[i]);
        if (has_land) v = still_on_land(h, v);
        advance(h, v, pull, p);
        velocity_mps[i] = stored(v);
        new_height_m[i] = stored(h);
        n = c;
        c = s;
        up = down;
        bend_n = bend;
        bend = bend_s;
    }
}
