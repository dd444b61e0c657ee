// Particle i of an effect, from nothing but i: 0 is the oldest that lives. Needs the effect's file. CPU twin:
// ballistic::cpu::flight.
#include "ballistic/path.glsl"
#ifdef GROUND_BINDING
#include "ballistic/ground.glsl"
#endif

#ifdef KINDLED_BINDING
#include "ballistic/kindled.glsl"
#else

// Where an emitter that is at `at_m` and, on its circle, at `turn` was `age` ago. w: radius of the circle.
vec3 emitter_before(vec4 at_m, float turn, Wide age) {
    vec3 at = at_m.xyz;
    if (effect.emitter_mps.xyz != vec3(0.0)) {
        precise vec3 moved = at - age.high * effect.emitter_mps.xyz;
        at = moved;
    }
    if (at_m.w == 0.0) return at;
    precise float turns = turn - age.high * effect.turns_per_s;
    vec2 way = cos_sin_of_turn(turns - floor(turns));
    precise vec3 circled = at + at_m.w * vec3(way.x, 0.0, way.y);
    return circled;
}

// Where the emitter was when something was born that is `age` old now.
vec3 emitter_at(Wide age) { return emitter_before(effect.emitter_m, effect.emitter_mps.w, age); }

// Who particle i is, and its age.
Wide age_of_particle(uint i, out Who who) {
    uint birth_number = effect.burst == 1u ? i : i / effect.burst;
    uint back = effect.births - 1u - birth_number;
    uint borrow;
    who.low = usubBorrow(effect.newest, back, borrow);
    who.high = effect.newest_high - borrow;
    who.member = i - birth_number * effect.burst;
    return age_of(back);
}

// Particles that live and have room.
uint particles_alive() { return min(effect.births * effect.burst, effect.capacity); }
#endif

// False: it is not to be seen, its path has not begun.
bool flight_of(uint i, out Who who, out Flight f) {
    Wide age = age_of_particle(i, who);
    Birth start = birth(who, emitter_at(age));
#ifdef KINDLED_BINDING
    if (age.high < 0.0) return false;
#endif
    f.share = age.high * effect.lives_per_s;
    f.down_s = -1.0;
    if (start.delay_s > 0.0) {
        age = less(age, start.delay_s);
        if (age.high < 0.0) return false;
    }
#ifdef GROUND_BINDING
    float end = ground_hit(start);
    if (age.high >= end) {
        f.down_s = age.high - end;
        age = Wide(end, 0.0);
    }
#endif
    Reach r = reach_of(age, effect.acceleration.w);
    f.age_s = age.high;
    f.at_m = position(start.at_m, start.velocity_mps, effect.acceleration.xyz, r);
    f.velocity_mps = velocity(start.velocity_mps, effect.acceleration.xyz, r);
    return true;
}
