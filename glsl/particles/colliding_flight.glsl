// The flight of a particle that has something in the way: to the next impact, and off again, until the step is over. Included
// after the law (`colliding.glsl`), by `colliding_deferred.comp`.
// CPU twin: particles::cpu_colliding.
#extension GL_EXT_control_flow_attributes : require
#include "particles/collide_sweep.glsl"

const uint MOST_IMPACTS = 8u;
const uint MOST_LEGS = 16u;
const float SAME = 0.9999;          // cosine of 0.8 degrees
const float SAME_SQ_M2PS2 = 1.0e-8;  // 0.1 mm/s apart

// Planes that a particle rests or slides on in this step, as `Hit` has them. Not an array: those that are indexed by a
// variable lie in memory.
struct Held {
    uint count;
    uvec3 planes;
};

uint held_at(Held held, uint i) { return i == 0u ? held.planes.x : i == 1u ? held.planes.y : held.planes.z; }

// One and the same plane, of two cells, is held once.
void hold(inout Held held, uint plane) {
    if (held.count == 3u) return;
    vec3 n = normal_of(plane), u = velocity_of(plane);
    for (uint i = 0u; i < held.count; ++i) {
        uint other = held_at(held, i);
        precise vec3 apart = velocity_of(other) - u;
        if (dotted(normal_of(other), n) > SAME && dotted(apart, apart) <= SAME_SQ_M2PS2) return;
    }
    if (held.count == 0u) held.planes.x = plane;
    else if (held.count == 1u) held.planes.y = plane;
    else held.planes.z = plane;
    ++held.count;
}

// Part of the velocity along the surface that friction leaves, where `press` is the change of velocity into it.
float kept_of(float slide, float press) {
    precise float most = law.friction * press;
    if (!(slide > most)) return 0.0;
    precise float kept = (slide - most) / slide;
    return kept;
}

// Gravity as those on the held planes feel it: with it, the velocity after `left_s` is what is left of gravity's once the
// planes have taken what goes into them, and friction what it can of the rest.
vec3 held_pull(Held held, vec3 velocity_mps, vec3 gravity_mps2, float left_s) {
    precise vec3 end = velocity_mps + gravity_mps2 * left_s;
    uint rounds = held.count > 1u ? 4u : 1u;
    for (uint round = 0u; round < rounds; ++round) {
        for (uint i = 0u; i < held.count; ++i) {
            vec3 n = normal_of(held_at(held, i)), u = velocity_of(held_at(held, i));
            precise float leaving = dotted(velocity_mps - u, n);
            precise float pressing = dotted(end - u, n);
            precise float little = 0.01 * abs(dotted(gravity_mps2, n)) * left_s;
            if (pressing >= 0.0 || leaving > little) continue;
            precise vec3 slide = end - u - n * pressing;
            float kept = kept_of(sqrt(dotted(slide, slide)), -pressing);
            end = u + slide * kept;
        }
    }
    precise vec3 pull = (end - velocity_mps) / left_s;
    return pull;
}

// The place of an impact is rounded, always to the same side for the same plane: without more, each bounce would win or lose
// a little. What the speed into the plane lacks, so that it is that of a fall by what the particle has really come down.
float rounding(float w, float a, float after_s, float rise_m) {
    precise float square = w * w + 2.0 * a * rise_m;
    precise float speed = w + a * after_s;
    if (!(speed < 0.0) || !(square > 0.0)) return 0.0;
    precise float lacks = -sqrt(square) - speed;
    return lacks;
}

// A particle in flight.
struct Flight {
    vec3 at_m;
    vec3 velocity_mps;
    vec3 pull_mps2;
    vec3 push_mps;  // moves it out of what it lay in, and is no velocity
    float left_s;
    uint legs;
    uint impacts;
    bool stops;  // where it is
    Held held;
};

Flight takes_off(Particle it, float dt_s) {
    return Flight(it.at_m, it.velocity_mps, gravity_mps2(), vec3(0.0), dt_s, 0u, 0u, false, Held(0u, uvec3(NO_PLANE)));
}

Leg next_leg(Flight it) {
    precise vec3 moving = it.velocity_mps + it.push_mps;
    return Leg(it.at_m, moving, it.pull_mps2, elapsed_at(it.left_s), it.left_s);
}

// In a plane from the start: out of it within this step, but not by more than half a radius.
void rises(inout Flight it, vec3 deep_m) {
    float most = 0.5 * law.radius_m, deepest = sqrt(dotted(deep_m, deep_m));
    precise vec3 out_of = deep_m * (min(most / deepest, 1.0) / it.left_s);
    it.push_mps = out_of;
    ++it.legs;
}

// Goes to where the leg ends, at a plane, and off again. False: that was the last.
bool bounces(inout Flight it, Leg leg, Hit hit, float dt_s) {
    vec3 gravity = gravity_mps2(), n = normal_of(hit.plane), u = velocity_of(hit.plane), from = it.at_m;
    it.at_m = moved(from, leg.velocity_mps, leg.pull_mps2, hit.after_s);
    precise vec3 then = it.velocity_mps + leg.pull_mps2 * hit.after_s;
    precise vec3 sinking = leg.velocity_mps - u;
    precise vec3 moves = it.at_m - from;
    precise float rise = dotted(moves, n) - dotted(u, n) * hit.after_s;
    precise vec3 made_good = then + n * rounding(dotted(sinking, n), dotted(leg.pull_mps2, n), hit.after_s, rise);
    it.velocity_mps = made_good;
    precise float after = it.left_s - hit.after_s;
    it.left_s = max(after, 0.0);
    precise float pushing = dotted(it.push_mps, n);
    if (pushing < 0.0) {
        precise vec3 kept = it.push_mps - n * pushing;
        it.push_mps = kept;
    }
    precise vec3 seen = it.velocity_mps - u;
    precise float approach = dotted(seen, n);
    bool is_slow = true;
    it.stops = ++it.legs == MOST_LEGS;
    if (approach < 0.0) {
        // Who would be back within two steps stays; what gravity gives in half a step is no impact.
        precise float step = abs(dotted(gravity, n)) * dt_s;
        precise float rebound = -approach * law.restitution;
        is_slow = rebound <= step * (law.restitution < 1.0 ? 1.0 : 1.0e-3);
        bool rests = is_slow && -approach <= 0.5 * step;
        if (!rests && it.impacts == MOST_IMPACTS) {
            it.stops = true;
            return false;
        }
        precise float press = -approach * (is_slow ? 1.0 : 1.0 + law.restitution);
        precise vec3 slide = seen - n * approach;
        float kept = kept_of(sqrt(dotted(slide, slide)), press);
        precise vec3 after_it = u + slide * kept + n * (approach + press);
        it.velocity_mps = after_it;
        if (!rests) {
            precise vec3 touch = it.at_m - n * hit.distance_m;
            append_impact(touch, n, seen, press, planes[hit.plane & ~IS_BACK].triangle, law_slot() * 8u + it.impacts, source_now());
            ++it.impacts;
        }
    }
    if (is_slow) hold(it.held, hit.plane);
    it.stops = it.stops || it.left_s == 0.0;
    if (it.stops) return false;
    it.pull_mps2 = it.held.count > 0u ? held_pull(it.held, it.velocity_mps, gravity, it.left_s) : gravity;
    return true;
}

void lands(Flight flight, inout Particle it) {
    if (flight.stops) {
        it.at_m = flight.at_m;
        it.velocity_mps = flight.velocity_mps;
    } else {
        precise vec3 moving = flight.velocity_mps + flight.push_mps;
        precise vec3 end = flight.velocity_mps + flight.pull_mps2 * flight.left_s;
        it.at_m = moved(flight.at_m, moving, flight.pull_mps2, flight.left_s);
        it.velocity_mps = end;
    }
    if (law.respawns != 0u && !(it.at_m.y >= law.floor_m)) respawn(it);
}

bool advance(inout Particle it, float dt_s) {
    Flight flight = takes_off(it, dt_s);
    for (bool is_flying = true; is_flying;) {
        Leg leg = next_leg(flight);
        vec3 deep_m;
        Hit hit = first_hit(leg, flight.legs == 0u, deep_m);
        if (deep_m != vec3(0.0)) rises(flight, deep_m);
        else is_flying = hit.plane != NO_PLANE && bounces(flight, leg, hit, dt_s);
    }
    lands(flight, it);
    return true;
}
