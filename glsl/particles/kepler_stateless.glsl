// Particles about one hole without a memory of them: a fountain throws them at a constant rate, each in a direction that
// is a hash of its number, and where number n is now follows from its birth in closed form. Nothing is stepped or stored.
// Whoever draws asks `thrown_at(n, now, particle)`. CPU twin: particles::kepler_stateless.
#include "common/random.glsl"
#include "particles/particle.glsl"
#include "particles/kepler.glsl"

// Mirrors `particles::kepler_stateless::Fountain`.
struct Fountain {
    vec3 at_m;             // of the fountain (m)
    float speed_mps;       // at birth
    vec3 hole_m;           // (m)
    float mu_m3ps2;        // of the hole (m^3/s^2)
    float horizon_m;       // of the hole (m)
    uint seed;
    uint stream;
    uint life_ticks;
    uint period_ticks;     // from one birth to the next: ticks
    uint period_part;      // and 2^-32 ticks
    uint first_tick;       // birth of number 0
    uint unused;
};

// The low 32 bits of how many 2^-32 turns an orbit of `per_tick` turns a tick makes in `ticks`: exact but for the rounding
// of `per_tick` itself, however many turns they are.
uint turns_of(float per_tick, uint ticks) {
    precise float scaled = per_tick * 4294967296.0;
    precise float whole = floor(scaled);
    precise float part = (scaled - whole) * 4294967296.0;
    uint high, low;
    umulExtended(uint(part), ticks, high, low);
    return uint(whole) * ticks + high;
}

// Moves `at` and `velocity`, as seen from the hole, by `age` ticks; false: it was swallowed before.
bool fall(float mu, float horizon, uint age, inout vec3 at, inout vec3 velocity) {
    precise float root = sqrt(mu);
    precise vec3 w = velocity / root;
    Flight flight = flight_of(at, w);
    precise float q = float(age) * (1.0 / 65536.0) * root;
    float crossing = crossing_of(flight, cross2(at, w), horizon);
    if (crossing >= 0.0 && crossing <= q) return false;
    if (flight.alpha > 0.0) {
        float period = period_of(flight);
        if (q > 0.5 * period) {
            precise float per_tick = root / (period * 65536.0);
            precise float rest = float(int(turns_of(per_tick, age))) * (1.0 / 4294967296.0) * period;
            q = rest;
        }
    }
    vec3 to_at, to_w;
    fly(flight, q, at, w, to_at, to_w);
    precise vec3 new_at = at + to_at;
    precise vec3 new_velocity = velocity + root * to_w;
    at = new_at;
    velocity = new_velocity;
    return true;
}

// Particle number n at tick `now`; false: not born yet, too old, or swallowed.
bool thrown_at(Fountain f, uint n, uint now, out Particle it) {
    uint high, low;
    umulExtended(n, f.period_part, high, low);
    uint born = f.first_tick + n * f.period_ticks + high;
    uint age = now - born;
    vec4 units = random_units(random_bits(f.seed, f.stream, n, 0u));
    vec3 way = direction_of(units.xy);
    precise vec3 velocity = f.speed_mps * way;
    precise vec3 at = f.at_m - f.hole_m;
    bool is_there = age < f.life_ticks && fall(f.mu_m3ps2, f.horizon_m, age, at, velocity);
    precise vec3 place = at + f.hole_m;
    it = Particle(place, velocity, born);
    return is_there;
}
