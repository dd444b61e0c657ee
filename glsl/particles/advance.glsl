// The pass that calls a law, included after it. In place: every slot is read, moved and written back.
#define POOL_ACCESS
#define NEW_PARTICLES_BINDING 2
#define CAPACITY p.capacity
layout(local_size_x_id = 0) in;

// Mirrors `particles::Step`.
struct StepParams {
    uint now;         // tick at the end of the step
    uint dt_ticks;    // length of the step
    float dt_s;       // the same (s), as the law has it
    uint life_ticks;  // of every particle
    uint seed;        // of the births
    uint capacity;    // slots of the pool
};

layout(push_constant, std430) uniform Push { StepParams p; };
#include "particles/pool.glsl"

uint law_tick() { return p.now; }

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= pool.slots) return;
    Particle it = load_particle(i);
    if (is_alive(it.born, p.now - p.dt_ticks, p.life_ticks) && !advance(it, p.dt_s)) it.born = p.now - p.life_ticks;
    store_particle(i, it);
}
