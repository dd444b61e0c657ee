// Heights of a surface of water for drawing. `SurfaceParams` mirrors `water::draw::SurfaceParams`.
#include "water/land.glsl"

struct SurfaceParams {
    uvec2 cells;     // columns along x and z
    uint pitch;      // columns from one row to the next
    uint stride;     // floats from one column to the next
    vec2 size_m;     // extent, round the origin
    float level_m;   // height of the surface at rest
    float ripple;    // slope of the fine ripples that the grid is too coarse for
    float foam_m;    // depth below which there is foam (m)
    uint reserved;
};

layout(set = 0, binding = 3, std430) readonly buffer Height { float height_m[]; };

layout(push_constant, std430) uniform Push { SurfaceParams p; };

// Integer index: a float loses columns beyond 2^24 of them.
float surface_sample(ivec2 c) {
    c = clamp(c, ivec2(0), ivec2(p.cells) - 1);
    return height_m[(uint(c.y) * p.pitch + uint(c.x)) * p.stride];
}

// Land is drawn as water at rest: the ground hides it, and the shore has no gap.
float or_rest(float h) { return h == LAND_M ? 0.0 : h; }

float or_own(float h, float own) { return h == LAND_M ? own : h; }

vec2 column_centre_m(uvec2 c) { return ((vec2(c) + 0.5) / vec2(p.cells) - 0.5) * p.size_m; }
