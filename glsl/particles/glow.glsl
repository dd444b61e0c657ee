// How a pool is drawn: a glow whose colour goes with the distance to the nearest centre, say a black hole, or with age where
// there is none; a streak as long as the particle flies in `exposure_s`, or a disc. Needs draw/view.glsl and
// draw/sprite.glsl.
#define POOL_BINDING 8
#define PARTICLES_BINDING 9
#include "particles/pool.glsl"

// Mirrors `run::swarm::Glow`.
struct Glow {
    vec4 near;         // linear, premultiplied; alpha 0 only adds light
    vec4 far;
    float half_m;      // half width
    float exposure_s;  // 0: discs
    float far_m;       // where it is as `far` as it gets
    uint centres;
    vec4 centre_m[16]; // xyz
};

layout(set = 0, binding = 10, std430) readonly buffer Glows { Glow glow; };

bool sprite_of(uint i, out Sprite sprite) {
    Particle particle;
    if (i >= pool.slots || !particle_at(i, particle)) return false;
    float share = float(pool.now - particle.born) / float(pool.life_ticks);
    float far = share;
    if (glow.centres > 0u) {
        float least = 1e30;
        for (uint c = 0u; c < glow.centres; ++c) least = min(least, distance(particle.at_m, glow.centre_m[c].xyz));
        far = clamp(least / glow.far_m, 0.0, 1.0);
    }
    sprite.along_m = 0.5 * glow.exposure_s * particle.velocity_mps;
    sprite.at_m = particle.at_m - sprite.along_m;
    sprite.half_m = vec2(glow.half_m);
    sprite.turn = 0.0;
    sprite.color = mix(glow.near, glow.far, far) * min(10.0 * (1.0 - share), 1.0);  // the last tenth of a life fades
    return true;
}
