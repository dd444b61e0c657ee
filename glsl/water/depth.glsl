// Water of any depth over ground, dry where there is none: what `wet` and `shallow` share. All heights are relative to
// one level, that of the water at rest. A column stores `rise`, its water less that at rest:
//     still = max(-bed, 0)          depth at rest: zero where the ground is above the level
//     depth = still + rise          surface = max(bed, 0) + rise
// In deep water `rise` is the surface and holds a ripple of 1 mm over 1000 m to seven digits; on dry ground it is the
// depth, and holds a film on a mountain as well. A wall, and all beyond the grid, is land: rise LAND_M, bed WALL_M.
#include "water/land.glsl"

// Mirrors `water::DepthParams`.
struct DepthParams {
    uvec2 cells;        // size of the grid
    uint pitch;         // columns from one row to the next
    float reach;        // dt / dx (s/m)
    float pull;         // g dt / dx (1/s)
    float keep;         // exp(-gamma dt): share of the flow kept per step
    float rain_m;       // falls on every column in this step (m)
    float thin_m;       // no water crosses a face where it would be shallower (m)
    float fastest_mps;  // dx / dt: water crosses no more than a column in a step
};

const float WALL_M = 1.0e30;

float depth_of(float bed, float rise) {
    precise float depth = max(-bed, 0.0) + rise;
    return max(depth, 0.0);  // below zero it is a debt: see DepthState::columns
}

float surface_of(float bed, float rise) {
    precise float surface = max(bed, 0.0) + max(rise, -max(-bed, 0.0));
    return surface;
}

// What drives the water from column a to b. Where the ground is above the level at rest the surface is a rounded sum: a
// difference of one unit in its last place is none, or lakes up there would stir themselves.
float slope_of(float surface_a, float surface_b, float bed_a, float bed_b) {
    precise float slope = surface_a - surface_b;
    precise float rounding = (1.5 / 8388608.0) * max(surface_a, surface_b);
    return max(bed_a, bed_b) <= 0.0 || abs(slope) > rounding ? slope : 0.0;
}

// The same of four columns.
vec4 depth_of(vec4 bed, vec4 rise) {
    return vec4(depth_of(bed.x, rise.x), depth_of(bed.y, rise.y), depth_of(bed.z, rise.z), depth_of(bed.w, rise.w));
}
vec4 surface_of(vec4 bed, vec4 rise) {
    return vec4(surface_of(bed.x, rise.x), surface_of(bed.y, rise.y), surface_of(bed.z, rise.z), surface_of(bed.w, rise.w));
}
vec4 slope_of(vec4 surface_a, vec4 surface_b, vec4 bed_a, vec4 bed_b) {
    return vec4(slope_of(surface_a.x, surface_b.x, bed_a.x, bed_b.x), slope_of(surface_a.y, surface_b.y, bed_a.y, bed_b.y),
                slope_of(surface_a.z, surface_b.z, bed_a.z, bed_b.z), slope_of(surface_a.w, surface_b.w, bed_a.w, bed_b.w));
}
