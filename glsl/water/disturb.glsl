// Disturbances: drops, pushes and bodies that act on a disc of the surface. Mirrors `water::Disturbance`.
#include "water/land.glsl"

struct Disturbance {
    vec2 at_m;        // from the corner of the grid (m)
    float radius_m;   // (m)
    float volume_m3;  // added to the water (m^3)
    float push_m3ps;  // added to the rate at which the surface rises (m^3/s)
    float scale;      // 1 / (area of a column x sum of the weights), written by water.weigh: 0 = rejected (1/m^2)
    uint tied;        // 1: it is refused if the one before it in the list is
    uint reserved;
};

// Mirrors `water::DisturbParams`.
struct DisturbParams {
    uvec2 cells;        // size of the grid
    uint pitch;         // columns from one row to the next
    uint stride;        // floats from one column to the next
    float cell_m;       // edge of a column (m)
    float limit_m;      // no disturbance may lift the surface by more (m), nor speed it up by more (m/s)
    uint has_velocity;  // 0: the model has no velocity to push, and a push is rejected
};

// Bell of compact support: smooth at its edge, and no transcendental function.
float bell(vec2 from_centre_m, float radius_m) {
    vec2 r = from_centre_m / radius_m;
    precise float x = max(1.0 - dot(r, r), 0.0);
    return x * x;
}

// Columns whose centres the disc can cover, at least the one that holds its centre: [lo, hi).
void footprint(Disturbance d, DisturbParams p, out ivec2 lo, out ivec2 hi) {
    vec2 reach = vec2(d.radius_m);
    // Clamped as floats first: a float out of range has no defined integer.
    lo = ivec2(clamp(floor((d.at_m - reach) / p.cell_m), vec2(0.0), vec2(p.cells)));
    hi = ivec2(clamp(floor((d.at_m + reach) / p.cell_m) + 1.0, vec2(0.0), vec2(p.cells)));
}

// Weight of a column: the bell at its centre. A disc smaller than a column gives all to the column that it falls in.
float weight_of(ivec2 c, Disturbance d, DisturbParams p) {
    if (d.radius_m <= 0.71 * p.cell_m) return ivec2(floor(d.at_m / p.cell_m)) == c ? 1.0 : 0.0;
    return bell((vec2(c) + 0.5) * p.cell_m - d.at_m, d.radius_m);
}
