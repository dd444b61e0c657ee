#ifndef BALLISTIC_PATH
#define BALLISTIC_PATH
// Closed forms of flight under constant acceleration a and linear drag k, from age t:
//     p = p0 + v0 t f1(k t) + a t^2 f2(k t),   f1(x) = (1 - e^-x) / x,   f2(x) = (x - 1 + e^-x) / x^2
//     v = v0 e^-kt + a t f1(k t)
// f1 = 1, f2 = 1/2 without drag, and nothing cancels on the way there. Terms of p may cancel, so it is summed with what
// rounding takes from each step (Dekker, "A floating-point technique for extending the available precision", 1971;
// Knuth's two-sum): p is right to an ulp. `precise` throughout: the bits are those of the CPU twin, ballistic::cpu.

struct Wide { float high; float low; };

// The leading 12 bits: products of two such are exact.
float leading(float x) { return uintBitsToFloat(floatBitsToUint(x) & 0xfffff000u); }
vec3 leading(vec3 x) { return uintBitsToFloat(floatBitsToUint(x) & 0xfffff000u); }

// Age of the birth `back` before the newest: since + back interval.
Wide age_of(uint back) {
    // Two exact products of twelve bits each and what is left; the parts are of falling size, so three steps sum two.
    float i1 = uintBitsToFloat(floatBitsToUint(effect.interval_s) & 0xffffc000u);  // ten bits: `back` has 14 above 12
    precise float i2 = effect.interval_s - i1 + effect.interval_low_s;
    // Conversions, without the unit for them, which is slow: whole numbers in the last bits of 2^35 and of 2^23.
    precise float k1 = uintBitsToFloat(0x51000000u | (back >> 12u)) - 34359738368.0;
    precise float k2 = uintBitsToFloat(0x4b000000u | (back & 0xfffu)) - 8388608.0;
    precise float a1 = k1 * i1, a2 = k2 * i1, rest = (k1 + k2) * i2 + effect.since_low_s;
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

// p0 + r.v v0 + r.a a
vec3 position(vec3 p0_m, vec3 v0_mps, vec3 a_mps2, Reach r) {
    float m1 = leading(r.v.high), m2 = leading(r.a.high);
    precise float r1 = r.v.high - m1 + r.v.low, r2 = r.a.high - m2 + r.a.low;
    vec3 v1 = leading(v0_mps), a1 = leading(a_mps2);
    precise vec3 v2 = v0_mps - v1, a2 = a_mps2 - a1;
    precise vec3 one = m1 * v1, other = m2 * a1;  // exact
    precise vec3 rest = m1 * v2 + r1 * v0_mps + (m2 * a2 + r2 * a_mps2);
    precise vec3 s = one + other, back = s - one, s_low = (one - (s - back)) + (other - back);
    precise vec3 q = p0_m + s, forth = q - p0_m, q_low = (p0_m - (q - forth)) + (s - forth);
    precise vec3 p = q + (q_low + (s_low + rest));
    return p;
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
