// Random numbers without a state: a hash of (seed, stream, serial, purpose), the same on every device and in every order.
// Bits: pcg4d (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020). CPU twin: crate::random.
// No sin() or cos() of the driver's: those differ between devices, sums and products marked `precise` do not.
#ifndef RANDOM_GLSL
#define RANDOM_GLSL

uvec4 random_bits(uint seed, uint stream, uint serial, uint purpose) {
    uvec4 v = uvec4(seed, stream, serial, purpose) * 1664525u + 1013904223u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    v ^= v >> 16u;
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// 0 to 1, without 1: 24 bits, exact.
vec4 random_units(uvec4 bits) { return vec4(bits >> 8u) * (1.0 / 16777216.0); }

// Cosine and sine of a part of a turn, 0 to 1: quarter turns exactly, and the Taylor series of what is left (8e-8).
vec2 cos_sin_of_turn(float turns) {
    precise float quarters = floor(4.0 * turns + 0.5);
    precise float x = (4.0 * turns - quarters) * 1.57079632679;
    precise float xx = x * x;
    precise float s = x * (1.0 + xx * (-1.6666667e-1 + xx * (8.3333333e-3 + xx * (-1.9841270e-4 + xx * 2.7557319e-6))));
    precise float c = 1.0 + xx * (-0.5 + xx * (4.1666667e-2 + xx * (-1.3888889e-3 + xx * 2.4801587e-5)));
    uint quarter = uint(quarters) & 3u;
    vec2 way = (quarter & 1u) == 0u ? vec2(c, s) : vec2(-s, c);
    return quarter >= 2u ? -way : way;
}

// A unit vector, all directions alike (Archimedes: the height on a sphere is uniform), of two units.
vec3 direction_of(vec2 units) {
    precise float y = 2.0 * units.x - 1.0;
    precise float radius = sqrt(max(1.0 - y * y, 0.0));
    vec2 way = cos_sin_of_turn(units.y);
    precise vec3 direction = vec3(radius * way.x, y, radius * way.y);
    return direction;
}

#endif
