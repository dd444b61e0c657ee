// Particles that black holes attract and swallow: the law of Newton, a = -mu d / |d|^3 for each hole, and a horizon where
// a particle ends. The integrator is a specialization constant; what is not chosen is not compiled.
// A particle is swallowed when its path crosses a horizon, not when a step happens to end inside: in closed form for
// KEPLER, else along two chords of each substep. CPU twin: particles::cpu_black_hole.
#include "common/random.glsl"
#include "particles/particle.glsl"
#include "particles/kepler.glsl"

layout(constant_id = LAW_CONSTANT) const uint integrator = 2u;
layout(constant_id = LAW_CONSTANT + 1) const uint substeps = 1u;  // of a step; of LOGH: steps a radian of an orbit
layout(constant_id = LAW_CONSTANT + 2) const uint holes = 1u;     // in the list
layout(constant_id = LAW_CONSTANT + 3) const bool is_moving = false;  // the holes move

const uint EULER = 0u;        // kick, drift: the book's. First order, for its velocity is of half a step before
const uint HALF_KICK = 1u;    // the same after half a kick at birth: leapfrog between the steps
const uint LEAPFROG = 2u;     // drift, kick, drift: second order, 1 force a substep
const uint FOREST_RUTH = 3u;  // fourth order, 3 forces (Forest and Ruth, Physica D 43, 1990)
const uint RK4 = 4u;          // fourth order, 4 forces, not symplectic
const uint LOGH = 5u;         // leapfrog in its own time: on the right orbit whatever the step (Mikkola and Tanikawa, 1999)
const uint KEPLER = 6u;       // closed form: one hole, at rest or in even motion

// Mirrors `particles::Hole`. Its centre at time t is at + velocity t + swing_u cos(phase) + swing_w sin(phase).
struct Hole {
    vec3 at_m;           // at tick 0 (m)
    float mu_m3ps2;      // G m (m^3/s^2)
    vec3 velocity_mps;   // (m/s)
    float horizon_m;     // (m)
    vec3 swing_u_m;      // of a circular or elliptic motion (m)
    uint turn_per_tick;  // 2^-32 turns: wraps without loss
    vec3 swing_w_m;      // (m)
    uint phase;          // at tick 0 (2^-32 turns)
};

layout(set = 0, binding = LAW_BINDING, std430) readonly buffer Law { Hole law[]; };

// Through variables: what is computed from specialization constants alone, some tools cannot read.
bool uses(uint which) {
    uint chosen = integrator;
    return chosen == which;
}

bool moves() {
    bool it = is_moving;
    return it;
}

// Tick at the end of the step: every pass that calls a law defines it. Times within the step are from there, so below 0.
uint law_tick();

// Time into the step at which the particle was swallowed (s), once `advance` has said false.
float swallowed_s = 0.0;
// A force was asked for so far inside a horizon that the particle cannot be on any path that misses it.
bool is_deep = false;

vec3 centre_of(uint hole, uint tick, float t_s) {
    if (!moves()) return law[hole].at_m;
    precise float time = float(tick) * (1.0 / 65536.0) + t_s;
    uint phase = law[hole].phase + tick * law[hole].turn_per_tick;
    precise float turns = float(phase >> 8u) * (1.0 / 16777216.0) + t_s * (float(law[hole].turn_per_tick) * (1.0 / 65536.0));
    precise float part = turns - floor(turns);
    vec2 way = cos_sin_of_turn(part);
    precise vec3 centre = law[hole].at_m + time * law[hole].velocity_mps + way.x * law[hole].swing_u_m + way.y * law[hole].swing_w_m;
    return centre;
}

#ifndef MORE_FORCE
#define MORE_FORCE(at_m, velocity_mps) vec3(0.0)
#endif

// Pull of all holes `t_s` after `tick` (m/s^2); `potential`: sum of mu / r. A user's law may add to
// it: #define MORE_FORCE(at_m, velocity_mps) before the include.
vec3 accelerate(vec3 at, vec3 velocity, uint tick, float t_s, out float potential) {
    precise vec3 sum = MORE_FORCE(at, velocity);
    precise float depth = 0.0;
    for (uint i = 0u; i < holes; ++i) {
        precise vec3 d = at - centre_of(i, tick, t_s);
        float least = max(0.25 * law[i].horizon_m * law[i].horizon_m, 1e-12);
        precise float r2 = dot3(d, d);
        if (!(r2 > least)) {
            is_deep = true;
            r2 = least;
        }
        precise float well = law[i].mu_m3ps2 / sqrt(r2);
        precise float pull = well / r2;
        sum = sum - pull * d;
        depth = depth + well;
    }
    potential = depth;
    return sum;
}

vec3 accelerate(vec3 at, vec3 velocity, uint tick, float t_s) {
    float unused;
    return accelerate(at, velocity, tick, t_s, unused);
}

// The part of the way from p to q, as seen from a hole, at which it first comes within the horizon; 2 if nowhere.
float entry_of(vec3 p, vec3 q, float horizon_m) {
    precise vec3 d = q - p;
    precise float c = dot3(p, p) - horizon_m * horizon_m;
    if (c <= 0.0) return 0.0;
    float b = dot3(p, d), a = dot3(d, d);
    precise float inside = b * b - a * c;
    if (b >= 0.0 || inside < 0.0) return 2.0;
    precise float part = c / (sqrt(inside) - b);
    return part <= 1.0 ? part : 2.0;
}

// Along the path from (at0, v0) to (at1, v1), h seconds long: when it first enters a horizon, as t_s (s), or 1 if
// it does not. Two chords that
// meet at the middle of the cubic through both ends, four times as close to the path as one.
float entry_s(vec3 at0, vec3 v0, vec3 at1, vec3 v1, uint tick, float t_s, float h) {
    precise vec3 middle = 0.5 * (at0 + at1) + (0.125 * h) * (v0 - v1);
    float first = 2.0;
    for (uint i = 0u; i < holes; ++i) {
        precise vec3 p = at0 - centre_of(i, tick, t_s);
        precise vec3 m = middle - centre_of(i, tick, t_s + 0.5 * h);
        precise vec3 q = at1 - centre_of(i, tick, t_s + h);
        precise float early = 0.5 * entry_of(p, m, law[i].horizon_m);
        if (early > 0.5) {
            early = 0.5 + 0.5 * entry_of(m, q, law[i].horizon_m);
            if (early > 1.0) early = 2.0;
        }
        first = min(first, early);
    }
    if (first > 1.0) return is_deep ? t_s : 1.0;
    precise float when = t_s + first * h;
    return when;
}

void drift_kick_drift(inout vec3 at, inout vec3 v, uint tick, float t_s, float h) {
    precise vec3 mid = at + (0.5 * h) * v;
    precise vec3 v1 = v + h * accelerate(mid, v, tick, t_s + 0.5 * h);
    precise vec3 at1 = mid + (0.5 * h) * v1;
    at = at1;
    v = v1;
}

void runge_kutta(inout vec3 at, inout vec3 v, uint tick, float t_s, float h) {
    vec3 a1 = accelerate(at, v, tick, t_s);
    precise vec3 at2 = at + (0.5 * h) * v;
    precise vec3 v2 = v + (0.5 * h) * a1;
    vec3 a2 = accelerate(at2, v2, tick, t_s + 0.5 * h);
    precise vec3 at3 = at + (0.5 * h) * v2;
    precise vec3 v3 = v + (0.5 * h) * a2;
    vec3 a3 = accelerate(at3, v3, tick, t_s + 0.5 * h);
    precise vec3 at4 = at + h * v3;
    precise vec3 v4 = v + h * a3;
    vec3 a4 = accelerate(at4, v4, tick, t_s + h);
    precise float sixth = h * (1.0 / 6.0);
    precise vec3 at1 = at + sixth * ((v + v4) + 2.0 * (v2 + v3));
    precise vec3 v1 = v + sixth * ((a1 + a4) + 2.0 * (a2 + a3));
    at = at1;
    v = v1;
}

// One step of Forest and Ruth's, or of leapfrog.
void symplectic(inout vec3 at, inout vec3 v, uint tick, float t_s, float h) {
    if (uses(FOREST_RUTH)) {
        const float LONG = 1.3512071919596578, BACK = -1.7024143839193155;  // 1 / (2 - 2^(1/3)), and what is left of 1
        precise float first = LONG * h;
        precise float second = BACK * h;
        precise float after = t_s + first;
        drift_kick_drift(at, v, tick, t_s, first);
        drift_kick_drift(at, v, tick, after, second);
        precise float last = after + second;
        drift_kick_drift(at, v, tick, last, first);
    } else {
        drift_kick_drift(at, v, tick, t_s, h);
    }
}

// Takes away what rounding has added to the energy: place and speed are scaled, along its gradient, so that little is asked
// of either. `way` is towards what attracts, a unit long where that is one hole, and total / well the distance of it.
void hold_orbit(inout vec3 at, inout vec3 v, uint tick, float energy, float total) {
    float well;
    vec3 pull = accelerate(at, v, tick, 0.0, well);
    if (well < abs(energy)) return;  // far out on a hyperbola
    precise vec3 way = (total / max(well * well, 1e-30)) * pull;
    float v2 = dot3(v, v), way2 = dot3(way, way);
    precise float excess = (0.5 * v2 - well) - energy;
    precise float part = excess / max(well * well * way2 + v2 * v2, 1e-30);
    precise vec3 held_at = at + (part * total) * way;
    precise vec3 held_v = v - (part * v2) * v;
    at = held_at;
    v = held_v;
}

// LOGH for holes at rest: leapfrog in a time s with dt = ds / (kinetic energy + binding energy) for drifts and
// ds / potential for kicks. Of one hole it follows the exact orbit; only when it is where is off, by s^2. The step is a
// part of a radian of the eccentric anomaly, sqrt(mu a), even all round an ellipse, so that errors of the time cancel. On
// hyperbolas it is not above sqrt(mu r): too long a step turns time back there. The last step of all is shortened until it ends with the frame.
bool advance_logh(inout vec3 at, inout vec3 v, uint tick, float dt_s) {
    float potential;
    accelerate(at, v, tick, -dt_s, potential);
    precise float energy = 0.5 * dot3(v, v) - potential;
    precise float total = 0.0;
    for (uint i = 0u; i < holes; ++i) total = total + law[i].mu_m3ps2;
    precise float a = total / max(2.0 * abs(energy), 1e-30);
    float reach = energy < 0.0 ? 100.0 : 1.0;
    precise float t = 0.0;
    for (uint i = 0u; i < 4096u; ++i) {
        precise float left = dt_s - t;
        if (left <= 2e-6 * dt_s) break;
        precise float kinetic = 0.5 * dot3(v, v) - energy;
        precise float r = reach * (total / max(kinetic, 1e-30));
        precise float s = sqrt(total * min(a, r)) / float(substeps);
        precise vec3 at1, v1;
        precise float took = 0.0;
        for (uint round = 0u; round < 6u; ++round) {
            precise float before = 0.5 * s / max(kinetic, 1e-30);
            precise vec3 mid = at + before * v;
            float well;
            vec3 force = accelerate(mid, v, tick, -dt_s, well);
            v1 = v + (s / well) * force;
            precise float after = 0.5 * s / max(0.5 * dot3(v1, v1) - energy, 1e-30);
            at1 = mid + after * v1;
            took = before + after;
            if (took <= 1.000001 * left && (round == 0u || took >= 0.999999 * left)) break;
            s = s * (left / took);
        }
        float entry = entry_s(at, v, at1, v1, tick, t - dt_s, took);
        if (entry < 0.5) {
            swallowed_s = dt_s + entry;
            return false;
        }
        at = at1;
        v = v1;
        t = t + took;
    }
    hold_orbit(at, v, tick, energy, total);  // the next frame knows the energy from place and speed alone
    return true;  // within a part in 10^6 of the frame: a drift over the rest would leave the orbit
}

// KEPLER: in closed form, as seen from the hole.
bool advance_kepler(inout vec3 at, inout vec3 v, uint tick, float dt_s) {
    precise float root = sqrt(law[0].mu_m3ps2);
    precise vec3 d = at - centre_of(0u, tick, -dt_s);
    precise vec3 w = (moves() ? v - law[0].velocity_mps : v) / root;
    precise float q = dt_s * root;
    Flight flight = flight_of(d, w);
    float crossing = crossing_of(flight, cross2(d, w), law[0].horizon_m);
    if (crossing >= 0.0 && crossing <= q) {
        swallowed_s = crossing / root;
        return false;
    }
    vec3 to_at, to_w;
    fly(flight, within_period(flight, q), d, w, to_at, to_w);
    precise vec3 new_d = d + to_at;
    precise vec3 new_w = w + to_w;
    precise vec3 new_at = at + to_at;
    precise vec3 new_v = v + root * to_w;
    if (moves()) new_at = new_at + dt_s * law[0].velocity_mps;
    if (is_narrow(flight.alpha, new_d, to_at)) {
        hold_energy(flight.alpha, new_d, new_w);
        new_at = centre_of(0u, tick, 0.0) + new_d;
        new_v = root * new_w;
        if (moves()) new_v = new_v + law[0].velocity_mps;
    }
    at = new_at;
    v = new_v;
    return true;
}

bool advance(inout Particle it, float dt_s) {
    uint tick = law_tick();
    swallowed_s = 0.0;
    is_deep = false;
    vec3 at = it.at_m, v = it.velocity_mps;
    for (uint i = 0u; i < holes; ++i) {
        precise vec3 d = at - centre_of(i, tick, -dt_s);
        float least = max(law[i].horizon_m * law[i].horizon_m, 1e-12);
        if (!(dot3(d, d) > least)) return false;
    }
    if (uses(KEPLER)) {
        if (!advance_kepler(at, v, tick, dt_s)) return false;
    } else if (uses(LOGH)) {
        if (!advance_logh(at, v, tick, dt_s)) return false;
    } else {
        precise float h = dt_s / float(substeps);
        // Born when the step began, or within it: to the tick, for steps may be rounded to one.
        bool is_first = uses(HALF_KICK) && float(tick - it.born) < dt_s * 65536.0 + 0.75;
        for (uint i = 0u; i < substeps; ++i) {
            precise float t = float(i) * h - dt_s;
            vec3 at0 = at, v0 = v;
            if (uses(RK4)) {
                runge_kutta(at, v, tick, t, h);
            } else if (uses(EULER) || uses(HALF_KICK)) {
                precise float kick = is_first && i == 0u ? 0.5 * h : h;
                precise vec3 v1 = v + kick * accelerate(at, v, tick, t);
                precise vec3 at1 = at + h * v1;
                at = at1;
                v = v1;
            } else {
                symplectic(at, v, tick, t, h);
            }
            float entry = entry_s(at0, v0, at, v, tick, t, h);
            if (entry < 0.5) {
                swallowed_s = dt_s + entry;
                return false;
            }
        }
    }
    it.at_m = at;
    it.velocity_mps = v;
    // Who has no place or no speed any more, or is so far that squares overflow, ends: the pool counts and stores no such
    // number.
    return dot3(at, at) < 3e38 && dot3(v, v) < 3e38;
}
