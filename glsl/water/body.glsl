// Bodies that push water aside. `Body` mirrors `water::bodies::Pose`.

struct Body {
    vec3 at_m;           // centre: x and z from the corner of the grid, y above the level of rest (m)
    uint is_box;         // 0: a sphere
    vec3 half_m;         // half its extent along its own axes; a sphere's radius, three times (m)
    float submerged_m3;  // volume below the level of rest (m^3)
    vec2 axis;           // its own x axis, in x and z
    float scale;         // of its draught, written by water.draught, so that its volume is right
    float displaced_m3;  // volume on water, neither on land nor outside the grid, written by water.draught (m^3)
};

// Mirrors `water::bodies::BodyParams`.
struct BodyParams {
    uvec2 cells;   // size of the grid
    uvec2 origin;  // of the rectangle that the bodies reach
    uvec2 size;    // of the rectangle
    uint pitch;    // columns from one row to the next
    uint stride;   // floats from one column to the next
    uint first;    // pose of the first body before the step; those after it follow
    uint count;    // bodies
    float cell_m;  // edge of a column (m)
};

// Columns that the body can reach, on a grid without end: [lo, hi).
void reach_of(Body b, float cell_m, out ivec2 lo, out ivec2 hi) {
    vec2 along = abs(b.axis);
    vec2 reach = b.is_box == 1u ? vec2(along.x * b.half_m.x + along.y * b.half_m.z, along.y * b.half_m.x + along.x * b.half_m.z)
                                : b.half_m.xz;
    // Half a column more for the soft edge; clamped as floats, for a float out of range has no defined integer.
    lo = ivec2(clamp(floor((b.at_m.xz - reach) / cell_m - 0.5), vec2(-65536.0), vec2(65536.0)));
    hi = ivec2(clamp(floor((b.at_m.xz + reach) / cell_m + 0.5) + 1.0, vec2(-65536.0), vec2(65536.0)));
}

// How far the body reaches below the level of rest, averaged over the column c (m).
float draught_of(ivec2 c, Body b, float cell_m) {
    vec2 from = (vec2(c) + 0.5) * cell_m - b.at_m.xz;
    if (b.is_box == 1u) {
        precise vec2 own = abs(vec2(from.x * b.axis.x + from.y * b.axis.y, from.y * b.axis.x - from.x * b.axis.y));
        // The share of the column that the box covers: exact where it lies along the grid.
        precise vec2 cover = clamp((b.half_m.xz - own) / cell_m + 0.5, 0.0, 1.0);
        precise float deep = max(b.half_m.y - b.at_m.y, 0.0) - max(-b.half_m.y - b.at_m.y, 0.0);
        return cover.x * cover.y * deep;
    }
    precise float sum = 0.0;
    for (int i = 0; i < 16; ++i) {
        precise vec2 at = from + (vec2(i & 3, i >> 2) - 1.5) * (0.25 * cell_m);
        precise float inside = b.half_m.x * b.half_m.x - (at.x * at.x + at.y * at.y);
        precise float root = sqrt(max(inside, 0.0));
        sum += max(root - b.at_m.y, 0.0) - max(-root - b.at_m.y, 0.0);
    }
    return 0.0625 * sum;
}
