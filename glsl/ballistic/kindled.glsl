// Particles that impacts threw: particle i, 0 the oldest that lives, from its place in the ring. In place of the emitter of
// flight.glsl, which includes this. Needs path.glsl. CPU twin: ballistic::cpu_kindled.
#include "ballistic/ring.glsl"

layout(set = 0, binding = KINDLED_BINDING, std430) readonly buffer Rings { Ring ring; };
layout(set = 0, binding = KINDLED_BINDING + 1, std430) readonly buffer Strikes { Strike strikes[]; };

uint particles_alive() { return ring.living * effect.burst; }

// Particles begin where the impact was.
vec3 emitter_at(Wide age) { return struck.at_m; }

// Time between ticks, exact up to 36 hours; below 0 of a birth that is still to come.
Wide age_of_ticks(uvec2 born, uvec2 now) {
    uint borrow, ticks = usubBorrow(now.x, born.x, borrow), whole_s = now.y - born.y - borrow;
    if (whole_s > 0x7fffffffu) return Wide(-1.0, 0.0);
    // Each of the three is exact, and of falling size.
    precise float whole = float(whole_s), upper = float(ticks >> 16u) * (1.0 / 65536.0), lower = float(ticks & 0xffffu) * (1.0 / 4294967296.0);
    precise float high = whole + upper, low = (upper - (high - whole)) + lower;
    precise float sum = high + low, left = low - (sum - high);
    return Wide(sum, left);
}

// Who particle i is, and its age; `struck` is its impact from here on.
Wide age_of_particle(uint i, out Who who) {
    uint birth_number = effect.burst == 1u ? i : i / effect.burst, back = ring.living - birth_number;
    uint borrow;
    who.low = usubBorrow(ring.next_low, back, borrow);
    who.high = ring.next_high - borrow;
    who.member = i - birth_number * effect.burst;
    Strike strike = strikes[slot_before(ring.slot, back, effect.capacity)];
    struck = Struck(strike.at_m, strike.normal, strike.velocity_mps, strike.impulse_mps);
    return age_of_ticks(uvec2(strike.born_low, strike.born_high), uvec2(ring.now_low, ring.now_high));
}
