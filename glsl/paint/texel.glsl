// What a texel holds: paint, premultiplied by its opacity. Four halves (8 bytes) or four floats (16 bytes).
//     a coat of colour c and opacity a:  paint' = (1 - a) paint + a (c, 1)
// so n coats cover 1 - (1 - a)^n, and white on white is white to the bit: colour and opacity are the same numbers. Halves are
// made here and not by packHalf2x16, whose rounding Vulkan leaves open: to the nearest, ties to even. CPU twin: paint::cpu.
#ifndef PAINT_TEXEL_GLSL
#define PAINT_TEXEL_GLSL

const uint HALVES = 0u;
const uint FLOATS = 1u;

#ifndef FORMAT_CONSTANT
#define FORMAT_CONSTANT 1
#endif
layout(constant_id = FORMAT_CONSTANT) const uint format = HALVES;

// Of numbers from 0 to 65504.
uint half_of(float x) {
    if (x < 6.103515625e-5) return uint(roundEven(x * 16777216.0));  // below 2^-14 steps are of 2^-24
    uint bits = floatBitsToUint(min(x, 65504.0));
    return (bits + 0xfffu + (bits >> 13u & 1u) >> 13u) - (112u << 10u);
}

float float_of(uint bits) {
    bits &= 0xffffu;
    return bits < 0x400u ? float(bits) * 5.9604644775390625e-8 : uintBitsToFloat(bits + (112u << 10u) << 13u);
}

uvec2 halves_of(vec4 x) {
    return uvec2(half_of(x.x) | half_of(x.y) << 16u, half_of(x.z) | half_of(x.w) << 16u);
}

vec4 floats_of(uvec2 h) {
    return vec4(float_of(h.x), float_of(h.x >> 16u), float_of(h.y), float_of(h.y >> 16u));
}

// `coat` is (a c, a).
vec4 over(vec4 paint, vec4 coat) {
    precise float keep = 1.0 - coat.w;
    precise vec4 sum = paint * keep + coat;
    return sum;
}

#endif
