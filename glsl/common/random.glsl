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

// Cosine and sine of a part of a turn, 0 to 1, to 1.1e-7: folded into an eighth of a turn, which is exact, and there
// polynomials of the least largest error (1.2e-9 and 3.2e-8).
vec2 cos_sin_of_turn(float turns) {
    precise float half_turn = turns - 0.5, quarter = 0.25 - abs(half_turn);  // below 0: left of the axis
    precise float x = min(abs(quarter), 0.25 - abs(quarter)), xx = x * x;
    precise float s = x * (6.283185 + xx * (-41.34163 + xx * (81.58813 - xx * 75.24007)));
    precise float c = 1.0 + xx * (-19.739168 + xx * (64.923225 - xx * 83.66592));
    bool is_steep = abs(quarter) > 0.125;
    uvec2 way = floatBitsToUint(is_steep ? vec2(c, s) : vec2(s, c));
    return uintBitsToFloat(way | (~floatBitsToUint(vec2(quarter, half_turn)) & 0x80000000u));
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
