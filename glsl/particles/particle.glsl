// What a particle is, for laws, passes and whoever draws. Mirrors `particles::Particle`.
#ifndef PARTICLE_GLSL
#define PARTICLE_GLSL

struct Particle {
    vec3 at_m;          // (m)
    vec3 velocity_mps;  // (m/s)
    uint born;          // tick of birth: 2^-16 s, on a clock that wraps; its age is `now - born`
};

// A law is a file that defines
//     bool advance(inout Particle particle, float dt_s)
// which moves a particle by `dt_s`; false: it ends now. Particles are moved in the step of their birth too, by what is left
// of it. Numbers of the law come from
//     layout(set = 0, binding = LAW_BINDING, std140) uniform Law { ... };
// or, if they are an array, from a `readonly buffer`; its specialization constants begin at `constant_id` LAW_CONSTANT, and
// further blocks at binding LAW_BLOCKS. A law that must know the time or the place declares
//     uint law_tick();  // at the end of the step
//     float law_step_s();  // length of the step: what is born in it has less left
//     uint law_slot();  // of the particle in this step, births after the others: no two share one
// which the advance defines (other passes that call a law: the tick). A law that takes long for a few is two shaders: one
// that defines LAW_DEFERS and
//     bool advance_at_once(inout Particle particle, float dt_s)
// which moves the others, and says of those few, whom it leaves as they are, that they must wait (it is called before the first
// barrier of the advance, and may hold none); and one of `advance` with `particles/advance_deferred.glsl`, which moves those
// and binds less (`colliding.comp`, `colliding_deferred.comp`).
#ifndef LAW_BINDING
#define LAW_BINDING 5
#endif
#ifndef LAW_BLOCKS
#define LAW_BLOCKS 7
#endif
#ifndef LAW_CONSTANT
#define LAW_CONSTANT 6
#endif

// Where nobody is: of a slot that is free. Laws keep particles within half of it.
const float NOWHERE_M = 3.0e38;

#endif
