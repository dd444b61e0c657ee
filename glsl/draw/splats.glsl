// What small sprites add to a pixel, in fixed point: sums of integers are the same in every order. Four words a pixel: red,
// green, blue, and how deep the light's way is through what covers (0: nothing does). With SPLATS_PACKED defined, for
// devices with atomics of 64 bits: three times 21 bits in the first two words, so that light takes one atomic, not three.

#ifdef SPLATS_PACKED
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require

layout(set = 0, binding = 5, std430) buffer Splats { uint64_t splats[]; };

// A pixel holds 2^11 times the light of a white wall.
const float SPLAT_ONE = 1024.0;

void splat_add(uint pixel, uvec4 sums) {
    uint64_t light = uint64_t(sums.r) | uint64_t(sums.g) << 21 | uint64_t(sums.b) << 42;
    if (light != 0ul) atomicAdd(splats[2u * pixel], light);
    if (sums.a > 0u) atomicAdd(splats[2u * pixel + 1u], uint64_t(sums.a));
}

uvec4 splat_take(uint pixel) {
    uint64_t light = splats[2u * pixel], way = splats[2u * pixel + 1u];
    if ((light | way) == 0ul) return uvec4(0u);
    splats[2u * pixel] = 0ul;
    splats[2u * pixel + 1u] = 0ul;
    return uvec4(uint(light & 0x1ffffful), uint(light >> 21 & 0x1ffffful), uint(light >> 42), uint(way));
}
#else
layout(set = 0, binding = 5, std430) buffer Splats { uint splats[]; };

// A pixel holds 2^18 times the light of a white wall.
const float SPLAT_ONE = 16384.0;

void splat_add(uint pixel, uvec4 sums) {
    if (sums.r > 0u) atomicAdd(splats[4u * pixel], sums.r);
    if (sums.g > 0u) atomicAdd(splats[4u * pixel + 1u], sums.g);
    if (sums.b > 0u) atomicAdd(splats[4u * pixel + 2u], sums.b);
    if (sums.a > 0u) atomicAdd(splats[4u * pixel + 3u], sums.a);
}

uvec4 splat_take(uint pixel) {
    uint word = 4u * pixel;
    uvec4 sums = uvec4(splats[word], splats[word + 1u], splats[word + 2u], splats[word + 3u]);
    if (sums != uvec4(0u)) {
        for (uint k = 0u; k < 4u; ++k) splats[word + k] = 0u;
    }
    return sums;
}
#endif
