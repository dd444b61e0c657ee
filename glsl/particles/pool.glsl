// The pool of particles as it lies in memory. A reader (say, a vertex shader) defines POOL_BINDING and PARTICLES_BINDING
// if they are not 0 and 1, includes this, and asks `particle_at(i, particle)` for every i below `pool.slots`.
#ifndef POOL_GLSL
#define POOL_GLSL
#include "particles/particle.glsl"

#ifndef POOL_BINDING
#define POOL_BINDING 0
#endif
#ifndef PARTICLES_BINDING
#define PARTICLES_BINDING 1
#endif
#ifndef POOL_ACCESS
#define POOL_ACCESS readonly
#endif
#ifndef CAPACITY
#define CAPACITY pool.capacity
#endif

// Counts and arguments, written on the GPU and read there. Mirrors `particles::PoolState`.
struct PoolState {
    uint groups_x;  // indirect dispatch of the advance
    uint groups_y;
    uint groups_z;
    uint slots;           // in use, from `first` on; in some a particle has ended
    uint quad_vertices;   // indirect draw of six vertices a slot: `gl_VertexIndex / 6` is the slot
    uint quad_instances;
    uint quad_first_vertex;
    uint quad_first_instance;
    uint point_vertices;  // indirect draw of one vertex a slot
    uint point_instances;
    uint point_first_vertex;
    uint point_first_instance;
    uint reader_groups_x;  // indirect dispatch of 256 invocations a workgroup, one a slot
    uint reader_groups_y;
    uint reader_groups_z;
    uint first;       // slot of the first: not 0 in a ring
    uint capacity;    // slots there are
    uint now;         // tick that the particles are at
    uint life_ticks;  // of every particle: who is as old has ended
    uint births;      // of this step
    uint appended;    // slots written in this step, by those who count them as they go
    uint free_first;  // free list of slots: a queue
    uint free_count;
    uint taken;       // of the free list by the births of this step
    uint born;        // since the start: low words, then high words
    uint dropped;     // births for which there was no room
    uint aged;        // ends by age
    uint ended;       // ends by the law
    uint spoiled;     // ends because a number was none
    uint born_high;
    uint dropped_high;
    uint aged_high;
    uint ended_high;
    uint spoiled_high;
};

layout(set = 0, binding = POOL_BINDING, std430) POOL_ACCESS buffer Pool { PoolState pool; };
layout(set = 0, binding = PARTICLES_BINDING, std430) readonly buffer Particles { uint particles[]; };

// Seven planes of words: word k of the particle in slot i is at `k * capacity + i`.
Particle load_particle(uint i) {
    uint w[7];
    for (uint k = 0u; k < 7u; ++k) w[k] = particles[k * CAPACITY + i];
    return Particle(uintBitsToFloat(uvec3(w[0], w[1], w[2])), uintBitsToFloat(uvec3(w[3], w[4], w[5])), w[6]);
}

// Who is as old as a life has ended, by age or because it was made so old.
bool is_alive(uint born, uint now, uint life_ticks) { return now - born < life_ticks; }

// The particle at i, 0 to `pool.slots`; false if none lives there.
bool particle_at(uint i, out Particle particle) {
    uint slot = pool.first + i;
    if (slot >= pool.capacity) slot -= pool.capacity;
    particle = load_particle(slot);
    return is_alive(particle.born, pool.now, pool.life_ticks);
}

#ifdef NEW_PARTICLES_BINDING
layout(set = 0, binding = NEW_PARTICLES_BINDING, std430) writeonly buffer NewParticles { uint new_particles[]; };

void store_particle(uint i, Particle it) {
    uvec3 at = floatBitsToUint(it.at_m), velocity = floatBitsToUint(it.velocity_mps);
    uint w[7] = uint[](at.x, at.y, at.z, velocity.x, velocity.y, velocity.z, it.born);
    for (uint k = 0u; k < 7u; ++k) new_particles[k * CAPACITY + i] = w[k];
}
#endif

#endif
