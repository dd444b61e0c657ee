#version 460
#extension GL_GOOGLE_include_directive : require
#define IMPACTS_BINDING 0
#define IMPACT_COUNT_BINDING 1
#include "impact/impact.glsl"
#include "water/disturb.glsl"

// Impacts as disturbances: those over a column of water, into the list that water.weigh and water.disturb take, in the order
// of `Impact::order`. Impacts lie in no order, and the sum of a column goes by the list, so each counts those that come
// before it: n^2 comparisons of words in shared memory, no sort, no second pass. What lies on land or outside is counted.
//
// An impact brings its volume, and the momentum of its fall: pressure p on shallow water of depth H makes
// h_tt = c^2 laplace(h) + (H / rho) laplace(p), so a drop of volume V that is stopped from v sets
// h_t = H V v laplace(b), b a bell of volume 1. No water comes or goes by it: what sinks under the drop rises round it.
// Two bells stand for the laplacian, one of the radius and one of twice it: per m^3/s that they move outwards, their
// difference has the second moment 3/4 radius^2, and the laplacian 4. So they move 16/3 H V v / radius^2. They are tied:
// where one is refused as absurd, so is the other, or water would come from nowhere.
// CPU twin: water::cpu_splash::splash.

layout(local_size_x = 64) in;

// Mirrors `water::SplashParams`, 48 bytes.
struct SplashParams {
    uvec2 cells;       // size of the grid
    uint pitch;        // columns from one row to the next
    uint stride;       // floats from one column to the next
    vec2 corner_m;     // of the grid, x and z in the world
    float cell_m;      // edge of a column
    float radius_m;    // of the disc that an impact acts on
    float volume_m3;   // that it brings
    float push_m2;     // 16/3 H V / radius^2: times the speed that it loses, the water that it moves outwards
    uint items;        // disturbances an impact: 2 with momentum, else 1
    uint reserved;
};

layout(set = 0, binding = 2, std430) readonly buffer Height { float height_m[]; };
// The header is also the indirect dispatch of water.weigh: a workgroup a disturbance.
layout(set = 0, binding = 3, std430) writeonly buffer Disturbances { uint count; uint rows; uint layers; uint unused; Disturbance items[]; };
// Since the start, low and high words.
layout(set = 0, binding = 4, std430) buffer Counters { uint taken; uint taken_high; uint missed; uint missed_high; };

layout(push_constant, std430) uniform Push { SplashParams p; };

const uint TILE = 256u;
const uint ELSEWHERE = 0xffffffffu;  // after every order
shared uint orders[TILE];

bool is_over_water(vec3 at_m) {
    vec2 c = floor((at_m.xz - p.corner_m) / p.cell_m);
    if (!(all(greaterThanEqual(c, vec2(0.0))) && all(lessThan(c, vec2(p.cells))))) return false;
    return height_m[(uint(c.y) * p.pitch + uint(c.x)) * p.stride] != LAND_M;
}

// Whether land lies within the square of the outer bell. Bells know nothing of what is between their columns, and would move
// water through a wall: a drop so near it brings its volume alone.
bool is_by_land(vec2 from_corner_m) {
    float reach_m = 2.0 * p.radius_m;
    ivec2 lo = ivec2(clamp(floor((from_corner_m - reach_m) / p.cell_m), vec2(0.0), vec2(p.cells)));
    ivec2 hi = ivec2(clamp(floor((from_corner_m + reach_m) / p.cell_m) + 1.0, vec2(0.0), vec2(p.cells)));
    for (int y = lo.y; y < hi.y; ++y) {
        for (int x = lo.x; x < hi.x; ++x) {
            if (height_m[(uint(y) * p.pitch + uint(x)) * p.stride] == LAND_M) return true;
        }
    }
    return false;
}

uint order_of(uint i) { return i < impact_count.count && is_over_water(impacts[i].at_m) ? impacts[i].order : ELSEWHERE; }

void main() {
    uint lane = gl_LocalInvocationIndex, group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint i = group * IMPACT_GROUP + lane, listed = impact_count.count, mine = order_of(i);

    uint rank = 0u, all_taken = 0u;
    for (uint first = 0u; first < listed; first += TILE) {
        barrier();
        for (uint k = lane; k < TILE; k += IMPACT_GROUP) orders[k] = order_of(first + k);
        barrier();
        for (uint k = 0u; k < TILE; ++k) {
            bool is_before = orders[k] < mine || (orders[k] == mine && first + k < i);  // if two are alike, none is lost
            rank += uint(is_before);
            all_taken += uint(orders[k] != ELSEWHERE);
        }
    }
    if (i == 0u) {
        count = all_taken * p.items;
        rows = 1u;
        layers = 1u;
        uint gone = listed - all_taken;
        if (taken > 0xffffffffu - all_taken) ++taken_high;
        taken += all_taken;
        if (missed > 0xffffffffu - gone) ++missed_high;
        missed += gone;
    }
    if (mine == ELSEWHERE) return;
    vec2 at_m = impacts[i].at_m.xz - p.corner_m;
    float pushed_m3ps = p.items == 2u && !is_by_land(at_m) ? p.push_m2 * impacts[i].impulse_mps : 0.0;
    items[rank * p.items] = Disturbance(at_m, p.radius_m, p.volume_m3, -pushed_m3ps, 0.0, 0u, 0u);
    if (p.items == 2u) items[rank * 2u + 1u] = Disturbance(at_m, 2.0 * p.radius_m, 0.0, pushed_m3ps, 0.0, 1u, 0u);
}
