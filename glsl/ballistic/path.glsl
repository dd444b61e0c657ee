#ifndef BALLISTIC_PATH
#define BALLISTIC_PATH
// Closed forms of flight under constant acceleration a and linear drag k, from age t:
//     p = p0 + v0 t f1(k t) + a t^2 f2(k t),   f1(x) = (1 - e^-x) / x,   f2(x) = (x - 1 + e^-x) / x^2
//     v = v0 e^-kt + a t f1(k t)
// f1 = 1, f2 = 1/2 without drag, and nothing cancels on the way there. Terms of p may cancel, so products are split into an
// exact one and a small rest (Dekker, "A floating-point technique for extending the available precision", 1971), and what
// rounding takes from the sum of the two ways is kept (Knuth's two-sum): p is right to an ulp. `precise` throughout: the bits are those of the CPU twin, ballistic::cpu.

struct Wide { float high; float low; };

// The leading 12 bits: products of two such are exact.
float leading(float x) { return uintBitsToFloat(floatBitsToUint(x) & 0xfffff000u); }

// Age of the birth `back` before the newest: since + back interval.
Wide age_of(uint back) {
    // Of `interval_s` the host gives ten bits, so that its products with twelve bits and with fourteen of `back` are exact;
    // the parts are of falling size, so three steps sum two.
    // Conversions, without the unit for them, which is slow: whole numbers in the last bits of 2^35 and of 2^23.
    precise float k1 = uintBitsToFloat(0x51000000u | (back >> 12u)) - 34359738368.0;
    precise float k2 = uintBitsToFloat(0x4b000000u | (back & 0xfffu)) - 8388608.0;
    precise float a1 = k1 * effect.interval_s, a2 = k2 * effect.interval_s;
    precise float rest = (k1 + k2) * effect.interval_low_s + effect.since_low_s;
    precise float s = a1 + a2, s_low = a2 - (s - a1);
    precise float high = s + effect.since_s, low = effect.since_s - (high - s) + (s_low + rest);
    precise float sum = high + low, left = low - (sum - high);
    return Wide(sum, left);
}

Wide less(Wide age, float s) {
    precise float high = age.high - s, low = (age.high - high) - s + age.low;
    return Wide(high, low);
}

// Factors of v0 and of a in p, and of v0 in v.
struct Reach { Wide v; Wide a; float keep; };

Reach reach_of(Wide age, float drag) {
    if (drag == 0.0) {
        precise float t1 = leading(age.high), t2 = age.high - t1 + age.low;
        precise float half_square = 0.5 * (t1 * t1), low = t2 * (t1 + 0.5 * t2);  // the first is exact
        return Reach(age, Wide(half_square, low), 1.0);
    }
    // f2 by its series up to 1, where 1 - f1 would cancel; from there on each doubling squares e^-x.
    precise float x = drag * age.high, y = x;
    uint doublings = 0u;
    while (y > 1.0 && doublings < 7u) {
        y *= 0.5;
        ++doublings;
    }
    precise float f2 = 0.5 - y * (1.6666667e-1 - y * (4.1666667e-2 - y * (8.3333333e-3 - y * (1.3888889e-3
        - y * (1.9841270e-4 - y * (2.4801587e-5 - y * (2.7557319e-6 - y * (2.7557319e-7 - y * (2.5052108e-8 - y * 2.0876757e-9)))))))));
    precise float f1 = 1.0 - y * f2, keep = 1.0 - y * f1;
    for (uint i = 0u; i < doublings; ++i) keep *= keep;
    if (x > 128.0) keep = 0.0;
    if (doublings > 0u) {
        f1 = (1.0 - keep) / x;
        f2 = (1.0 - f1) / x;
    }
    precise float v = age.high * f1, v_low = age.low * keep;  // d (t f1) / dt = e^-kt
    precise float a = age.high * age.high * f2, a_low = age.low * v;
    return Reach(Wide(v, v_low), Wide(a, a_low), keep);
}

// One coordinate of a flight without pull: p0 + (m + rest) v0. `way` is exact, and either cancels with p0, and then the
// difference is exact too, or is rounded but once.
float coasted(float p0, float v0, float m, float rest) {
    float v1 = leading(v0);
    precise float v2 = v0 - v1, way = m * v1, low = m * v2 + rest * v0;
    precise float p = (p0 + way) + low;
    return p;
}

// The same with a pull: p0 + (mv + rv) v0 + (ma + ra) a.
float pulled(float p0, float v0, float a, float mv, float rv, float ma, float ra) {
    float v1 = leading(v0), a1 = leading(a);
    precise float v2 = v0 - v1, a2 = a - a1, one = mv * v1, other = ma * a1;
    precise float low = mv * v2 + rv * v0 + (ma * a2 + ra * a);
    precise float way = one + other, back = way - one, way_low = (one - (way - back)) + (other - back);
    precise float p = (p0 + way) + (way_low + low);
    return p;
}

// p0 + r.v v0 + r.a a. Most pulls are down: what a coordinate has none of is not added, which changes no bit.
vec3 position(vec3 p0, vec3 v0, vec3 a, Reach r) {
    float mv = leading(r.v.high), ma = leading(r.a.high);
    precise float rv = r.v.high - mv + r.v.low, ra = r.a.high - ma + r.a.low;
    float y = pulled(p0.y, v0.y, a.y, mv, rv, ma, ra);
    if (a.x == 0.0 && a.z == 0.0) return vec3(coasted(p0.x, v0.x, mv, rv), y, coasted(p0.z, v0.z, mv, rv));
    return vec3(pulled(p0.x, v0.x, a.x, mv, rv, ma, ra), y, pulled(p0.z, v0.z, a.z, mv, rv, ma, ra));
}

vec3 velocity(vec3 v0_mps, vec3 a_mps2, Reach r) {
    precise vec3 v = r.keep * v0_mps + r.v.high * a_mps2;
    return v;
}

// When something `above` (m) a level, that moves at `rise` (m/s) and is pulled by `pull` (m/s2), first falls to it:
// above + rise t + pull t^2 / 2 = 0 (s); 0 below, 1e30 if never. The root is taken in the form that does not subtract: the
// other, (-rise - s) / pull, is off by some 100 % where it grazes.
float fall_time(float above, float rise, float pull) {
    precise float d = rise * rise - 2.0 * pull * above;
    if (above <= 0.0) return 0.0;
    if (d < 0.0) return 1e30;
    precise float s = sqrt(d), down = s - rise, up = -(s + rise);
    precise float t = rise <= 0.0 ? 2.0 * above / down : up / pull;
    return t > 0.0 && t < 1e30 ? t : 1e30;
}
#endif
