// Heights of a surface of water for drawing. `SurfaceParams` mirrors `water::draw::SurfaceParams`.
#include "water/land.glsl"

struct SurfaceParams {
    uvec2 cells;     // columns along x and z
    uint pitch;      // columns from one row to the next
    uint stride;     // floats from one column to the next
    vec2 size_m;     // extent, round the origin
    float level_m;   // height of the surface at rest
    float ripple;    // slope of the fine ripples that the grid is too coarse for
    float foam_m;    // depth below which there is foam along shores (m), 0 for none
    float speeds;    // a stored flow times this is a speed (m/s); 0: it is to be divided by the depth
    float white_mps; // speed above which water is white where it outruns its waves (m/s)
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

// Share of white water. It breaks where it outruns its own waves, and where it rises so fast that a bore comes in.
float white_share(vec2 speed_mps, float rising_mps, float depth_m) {
    float waves_mps = sqrt(9.81 * max(depth_m, 0.01)), fast = length(speed_mps);
    float torrent = smoothstep(1.0, 2.4, fast / waves_mps) * smoothstep(p.white_mps, 3.0 * p.white_mps, fast);
    float bore = smoothstep(0.08, 0.4, rising_mps / waves_mps) * smoothstep(0.2 * p.white_mps, 0.8 * p.white_mps, rising_mps);
    return max(torrent, bore) * smoothstep(0.005, 0.05, depth_m);
}
