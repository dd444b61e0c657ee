#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/disturb.glsl"

// Prepares disturbances, one workgroup each: refuses what is not finite or absurd, and finds the scale that makes the
// volume exact, to rounding, on the columns that the disc really covers (walls and shores cut discs). Counts what became
// of them. One that is tied to the one before it has a disc that holds that one's, and is refused with it.
// CPU twin: water::cpu_disturb::weigh.

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer Height { float height_m[]; };
layout(set = 0, binding = 1, std430) buffer Disturbances { uint count; uint reserved[3]; Disturbance items[]; };
layout(set = 0, binding = 2, std430) buffer Counters { uint applied; uint rejected; uint missed; };

layout(push_constant, std430) uniform Push { DisturbParams p; };

shared vec2 sums[64];  // of the disturbance, and of the one that it is tied to
shared vec2 peaks[64];

// isinf and isnan may be optimised away; bits may not.
bool is_finite(float x) { return (floatBitsToUint(x) & 0x7f800000u) != 0x7f800000u; }

bool is_sane(Disturbance d) {
    bool finite = is_finite(d.at_m.x) && is_finite(d.at_m.y) && is_finite(d.radius_m) && is_finite(d.volume_m3) &&
                  is_finite(d.push_m3ps);
    return finite && d.radius_m > 0.0 && (p.has_velocity == 1u || d.push_m3ps == 0.0);
}

// What the column gets that gets most.
float most_of(Disturbance d, float scale, float peak) {
    precise float most = max(abs(d.volume_m3), abs(d.push_m3ps)) * scale * peak;
    return most;
}

void main() {
    uint item = gl_WorkGroupID.x, lane = gl_LocalInvocationID.x;
    if (item >= min(count, uint(items.length()))) return;
    Disturbance d = items[item];
    Disturbance lead = d;
    if (d.tied == 1u && item > 0u) lead = items[item - 1u];
    bool sane = is_sane(d) && is_sane(lead);

    // Each lane sums its columns, then lane 0 the lanes: always in the same order.
    ivec2 lo = ivec2(0), hi = ivec2(0);
    if (sane) footprint(d, p, lo, hi);
    uvec2 size = uvec2(max(hi - lo, ivec2(0)));
    precise vec2 sum = vec2(0.0);
    vec2 peak = vec2(0.0);
    for (uint i = lane; i < size.x * size.y; i += 64u) {
        ivec2 c = lo + ivec2(i % size.x, i / size.x);
        if (height_m[(uint(c.y) * p.pitch + uint(c.x)) * p.stride] == LAND_M) continue;
        vec2 weight = vec2(weight_of(c, d, p), weight_of(c, lead, p));
        sum += weight;
        peak = max(peak, weight);
    }
    sums[lane] = sum;
    peaks[lane] = peak;
    barrier();
    if (lane != 0u) return;
    precise vec2 total = vec2(0.0);
    for (uint i = 0u; i < 64u; ++i) {
        total += sums[i];
        peak = max(peak, peaks[i]);
    }

    precise float scale = total.x > 0.0 ? 1.0 / (p.cell_m * p.cell_m * total.x) : 0.0;
    precise float lead_scale = total.y > 0.0 ? 1.0 / (p.cell_m * p.cell_m * total.y) : 0.0;
    bool absurd = most_of(d, scale, peak.x) > p.limit_m || most_of(lead, lead_scale, peak.y) > p.limit_m;
    items[item].scale = sane && !absurd ? scale : 0.0;
    if (!sane || absurd) atomicAdd(rejected, 1u);
    else if (scale == 0.0) atomicAdd(missed, 1u);
    else atomicAdd(applied, 1u);
}
