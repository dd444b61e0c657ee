// The pool of particles as it lies in memory. A reader (say, a vertex shader) defines POOL_BINDING and PARTICLES_BINDING
// if they are not 0 and 1, includes this, and asks `particle_at(i, particle)` for every i below `pool.slots`.
#ifndef POOL_GLSL
#define POOL_GLSL
#include "particles/particle.glsl"
#include "particles/state.glsl"

#ifndef PARTICLES_BINDING
#define PARTICLES_BINDING 1
#endif

layout(set = 0, binding = PARTICLES_BINDING, std430) readonly buffer Particles { uint particles[]; };

Particle particle_of(uint w[7]) {
    return Particle(uintBitsToFloat(uvec3(w[0], w[1], w[2])), uintBitsToFloat(uvec3(w[3], w[4], w[5])), w[6]);
}

// Seven planes of words: word k of the particle in slot i is at `k * stride + i`.
Particle load_particle(uint i) {
    uint w[7], stride = pool.stride;
    for (uint k = 0u; k < 7u; ++k) w[k] = particles[k * stride + i];
    return particle_of(w);
}

// Who is as old as a life has ended, by age or because it was made so old.
bool is_alive(uint born, uint now, uint life_ticks) { return now - born < life_ticks; }

// The particle at i, 0 to `pool.slots`; false if none lives there.
bool particle_at(uint i, out Particle particle) {
    uint slot = pool.first + i;
    if (slot >= pool.capacity) slot -= pool.capacity;
    particle = load_particle(slot);
    return is_alive(particle.born, pool.now, pool.life_ticks) && particle.at_m.x != NOWHERE_M;
}

#endif
