#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/disturb.glsl"

// Adds the disturbances that water.weigh has prepared. A workgroup owns a tile of columns: it marks which disturbances
// reach the tile, 32 in a word, and then every column adds those in the order of the list. No atomics on heights, so
// the result is the same on every run. CPU twin: water::cpu_disturb::disturb.

const uint TILE = 16u;
layout(local_size_x = TILE, local_size_y = TILE) in;

layout(set = 0, binding = 0, std430) readonly buffer Disturbances { uint count; uint reserved[3]; Disturbance items[]; };
layout(set = 0, binding = 1, std430) buffer Height { float height_m[]; };
layout(set = 0, binding = 2, std430) buffer Velocity { float velocity_mps[]; };

layout(push_constant, std430) uniform Push { DisturbParams p; };

const uint BATCH = TILE * TILE;
shared uint reaches[BATCH / 32u];

void main() {
    ivec2 tile_lo = ivec2(gl_WorkGroupID.xy * TILE), c = ivec2(gl_GlobalInvocationID.xy);
    uint lane = gl_LocalInvocationIndex, listed = min(count, uint(items.length()));
    if (listed == 0u) return;
    bool is_mine = all(lessThan(c, ivec2(p.cells)));
    uint i = (uint(c.y) * p.pitch + uint(c.x)) * p.stride;
    is_mine = is_mine && height_m[i] != LAND_M;

    precise float rise = 0.0, speed = 0.0;
    for (uint batch = 0u; batch < listed; batch += BATCH) {
        if (lane < BATCH / 32u) reaches[lane] = 0u;
        barrier();
        if (batch + lane < listed) {
            Disturbance d = items[batch + lane];
            if (d.scale > 0.0) {
                ivec2 lo, hi;
                footprint(d, p, lo, hi);
                bool hit = all(lessThan(lo, tile_lo + int(TILE))) && all(greaterThan(hi, tile_lo));
                if (hit) atomicOr(reaches[lane >> 5u], 1u << (lane & 31u));
            }
        }
        barrier();
        for (uint word = 0u; word < BATCH / 32u; ++word) {
            for (uint bits = is_mine ? reaches[word] : 0u; bits != 0u; bits &= bits - 1u) {
                Disturbance d = items[batch + 32u * word + uint(findLSB(bits))];
                precise float share = weight_of(c, d, p) * d.scale;
                rise += share * d.volume_m3;
                speed += share * d.push_m3ps;
            }
        }
        barrier();
    }
    if (!is_mine) return;
    if (rise != 0.0) height_m[i] += rise;
    if (speed != 0.0) velocity_mps[(uint(c.y) * p.pitch + uint(c.x))] += speed;
}
