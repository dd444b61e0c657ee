// What closed-form effects share: their numbers, the serial numbers of their particles, and chance. Nothing is stored:
// particle i of an emitter is born at i / rate, all that is random about it is a hash of (seed, emitter, i), and where it
// is follows from its age. `Effect` mirrors ballistic::Params; CPU twin: ballistic::cpu.
//
// An effect is one file, included after this one, that defines
//     Birth birth(Who who, vec3 emitter_m)   what it starts with, from where the emitter was then
//     Look look(Who who, inout Flight f)     its size and colour at its age; what sways is moved here
// The same file is thrown by impacts where KINDLED_BINDING is defined (kindled.glsl): `emitter_m` is then where the impact
// was, and `struck` and `away` say the rest of it.
#include "common/random.glsl"

struct Effect {
    vec4 acceleration;      // xyz (m/s2); w: linear drag (1/s)
    vec4 emitter_m;         // xyz: where it is now, without its circling (m); w: radius of the circle that it runs (m)
    vec4 emitter_mps;       // xyz: velocity (m/s); w: where on the circle it is now (turns, 0 to 1)
    float turns_per_s;      // of the emitter
    float lives_per_s;      // 1 / life
    float interval_s;       // between births: ten bits, and the rest
    float interval_low_s;
    float since_s;          // from the newest birth to now, with what rounding took from it
    float since_low_s;
    uint seed;
    uint stream;            // which emitter, below 65536
    uint newest;            // serial number of the newest birth, low and high word
    uint newest_high;
    uint births;            // alive
    uint burst;             // particles in each
    vec2 ground_size_m;     // extent of the heightmap along x and z, round the origin
    uvec2 ground_cells;     // its samples
    float water_m;          // level of standing water
    float exposure_s;       // a streak is as long as its particle flies in this time
    float size;             // the user's: factor of all sizes
    uint capacity;          // particles that there is room for
};

#ifdef EFFECT_BINDING
layout(set = 0, binding = EFFECT_BINDING, std430) readonly buffer Effects { Effect effect; };
#else
layout(push_constant) uniform Push { Effect effect; };
#endif

// Serial number of a birth, and which particle of the burst.
struct Who { uint low; uint high; uint member; };

struct Birth {
    vec3 at_m;
    vec3 velocity_mps;
    float delay_s;          // from birth to the begin of its path: it is not seen before
};

struct Flight {
    vec3 at_m;
    vec3 velocity_mps;
    float age_s;            // since its path began
    float share;            // of its life that has passed, 0 to 1
    float down_s;           // since it met the ground, where it stays; below 0 before, and where there is none
};

struct Look {
    vec2 half_m;            // half width, half height; of a streak x alone
    float turn;             // turns
    vec4 color;             // linear, premultiplied by its alpha; alpha 0 only adds light
    bool is_streak;
};

// The impact that threw a particle. One that no impact threw is told of rest on level ground.
struct Struck {
    vec3 at_m;
    vec3 normal;            // of the surface, unit, towards what hit it
    vec3 velocity_mps;      // of what hit it, before, seen from the surface
    float impulse_mps;      // change of its velocity along the normal: impulse a mass
};

#ifdef KINDLED_BINDING
Struck struck;
#else
const Struck struck = Struck(vec3(0.0), vec3(0.0, 1.0, 0.0), vec3(0.0), 0.0);
#endif

// `v` with its y along the normal of what was hit (Duff and others, "Building an Orthonormal Basis, Revisited", JCGT 6(1),
// 2017). On level ground it is `v`.
vec3 away(vec3 v) {
#ifdef KINDLED_BINDING
    vec3 n = struck.normal;
    float side = n.y < 0.0 ? -1.0 : 1.0;
    precise float a = -1.0 / (side + n.y), b = n.x * n.z * a;
    precise vec3 right = vec3(1.0 + side * (n.x * n.x * a), -side * n.x, side * b);
    precise vec3 ahead = vec3(b, -n.z, side + n.z * n.z * a);
    precise vec3 turned = (v.x * right + v.y * n) + v.z * ahead;
    return turned;
#else
    return v;
#endif
}

// Four numbers, 0 to 1, without 1; others for each purpose, below 256.
vec4 chance(Who who, uint purpose) {
    return random_units(random_bits(effect.seed, effect.stream | who.high << 16u, who.low, purpose | who.member << 8u));
}
// What the whole burst has in common.
vec4 chance_of_burst(Who who, uint purpose) { return chance(Who(who.low, who.high, 0u), purpose | 128u); }
