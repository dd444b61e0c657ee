// A workgroup has a tile: all its invocations look for drops near the box of the tile, 2048 at a time, and note them as bits;
// then each texel takes those drops, in order. Bits keep the order: no list is sorted, and the bits of the result are those
// of `paint.brute`. A `busy` bit a word says where there is anything at all.
layout(local_size_x_id = 2) in;  // at least 64
#include "paint/gather.glsl"

const uint CHUNK = 2048u;

shared uint near[64];
shared uint busy[2];

bool is_near(uint i, Box box, uint tile) {
    Drop drop = drops[i];
    if (kind == IMPACTS) {
        if (drop.source >> 16u != box.mesh) return false;
        float reach_sq_m2 = coats[drop.source & 0xffffu].reach_sq_m2;
        return distance_sq(drop.at_m, box) < reach_sq_m2 || homes[i] / TILE_TEXELS == tile;
    }
    return distance_sq(drop.at_m, box) < p.reach_sq_m2;
}

// Sets the bits of the drops from `base` on, of `count`, that are near.
void find(uint base, uint count, Box box, uint tile);

void gather(uint tile) {
    Box box = tiles[tile];
    if (box.covered == 0u) return;  // the whole workgroup
    uint lane = gl_LocalInvocationIndex, texel = TILE_TEXELS * tile + lane;
    bool is_texel = lane < TILE_TEXELS && positions[texel].triangle != 0u;
    vec3 at_m = is_texel ? positions[texel].at_m : vec3(0.0);
    vec4 value = is_texel ? load(texel) : vec4(0.0);
    bool is_painted = false;
    uint count = taking_part();
    for (uint base = 0u; base < count; base += CHUNK) {
        if (lane < 64u) near[lane] = 0u;
        if (lane < 2u) busy[lane] = 0u;
        barrier();
        find(base, count, box, tile);
        barrier();
        for (uint half_chunk = 0u; half_chunk < 2u; ++half_chunk) {
            uint left = is_texel ? busy[half_chunk] : 0u;
            while (left != 0u) {
                uint word = 32u * half_chunk + findLSB(left);
                left &= left - 1u;
                uint bits = near[word];
                while (bits != 0u) {
                    uint k = base + 32u * word + findLSB(bits);
                    bits &= bits - 1u;
                    take(p.first + p.stride * k, texel, at_m, box.mesh, value, is_painted);
                }
            }
        }
        barrier();  // the bits may be cleared
    }
    if (is_painted) store(texel, value);
}
