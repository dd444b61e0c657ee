// The flight of a particle that has something in the way: to the next impact, and off again, until the step is over. Included
// after the law (`colliding.glsl`), by `colliding_deferred.comp`.
// CPU twin: particles::cpu_colliding.
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

void collide(inout Particle it, float dt_s) {
    vec3 gravity = gravity_mps2();
    vec3 at = it.at_m, velocity = it.velocity_mps, pull = gravity, push = vec3(0.0);
    float left_s = dt_s;
    uint impacts = 0u;
    Held held = Held(0u, uvec3(NO_PLANE));
    bool stops = false;
    for (uint leg = 0u; leg < MOST_LEGS; ++leg) {
        vec3 deep = vec3(0.0);
        precise vec3 moving = velocity + push;
        Hit hit = first_hit(Leg(at, moving, pull, elapsed_at(left_s), left_s), leg == 0u, deep);
        if (leg == 0u && deep != vec3(0.0)) {
            // In a plane from the start: out of it within this step, but not by more than half a radius.
            float most = 0.5 * law.radius_m, deepest = sqrt(dotted(deep, deep));
            precise vec3 out_of = deep * (min(most / deepest, 1.0) / left_s);
            push = out_of;
            continue;
        }
        if (hit.plane == NO_PLANE) break;
        stops = leg == MOST_LEGS - 1u;
        vec3 n = normal_of(hit.plane), u = velocity_of(hit.plane);
        vec3 from = at;
        at = moved(at, moving, pull, hit.after_s);
        precise vec3 then = velocity + pull * hit.after_s;
        precise vec3 sinking = moving - u;
        precise vec3 moves = at - from;
        precise float rise = dotted(moves, n) - dotted(u, n) * hit.after_s;
        precise vec3 made_good = then + n * rounding(dotted(sinking, n), dotted(pull, n), hit.after_s, rise);
        velocity = made_good;
        precise float after = left_s - hit.after_s;
        left_s = max(after, 0.0);
        precise float pushing = dotted(push, n);
        if (pushing < 0.0) {
            precise vec3 kept = push - n * pushing;
            push = kept;
        }
        precise vec3 seen = velocity - u;
        precise float approach = dotted(seen, n);
        bool is_slow = true;
        if (approach < 0.0) {
            // Who would be back within two steps stays; what gravity gives in half a step is no impact.
            precise float step = abs(dotted(gravity, n)) * dt_s;
            precise float rebound = -approach * law.restitution;
            is_slow = rebound <= step * (law.restitution < 1.0 ? 1.0 : 1.0e-3);
            bool rests = is_slow && -approach <= 0.5 * step;
            if (!rests && impacts == MOST_IMPACTS) { stops = true; break; }
            precise float press = -approach * (is_slow ? 1.0 : 1.0 + law.restitution);
            precise vec3 slide = seen - n * approach;
            float kept = kept_of(sqrt(dotted(slide, slide)), press);
            precise vec3 after_it = u + slide * kept + n * (approach + press);
            velocity = after_it;
            if (!rests) {
                precise vec3 touch = at - n * hit.distance_m;
                append_impact(touch, n, seen, press, planes[hit.plane & ~IS_BACK].triangle, law_slot() * 8u + impacts, source_now());
                ++impacts;
            }
        }
        if (is_slow) hold(held, hit.plane);
        if (left_s == 0.0) { stops = true; break; }
        pull = held.count > 0u ? held_pull(held, velocity, gravity, left_s) : gravity;
    }
    if (stops) {
        it.at_m = at;
        it.velocity_mps = velocity;
        return;
    }
    precise vec3 moving = velocity + push;
    precise vec3 end = velocity + pull * left_s;
    it.at_m = moved(at, moving, pull, left_s);
    it.velocity_mps = end;
}

bool advance(inout Particle it, float dt_s) {
    collide(it, dt_s);
    if (law.respawns != 0u && !(it.at_m.y >= law.floor_m)) respawn(it);
    return true;
}
