#version 460
#extension GL_GOOGLE_include_directive : require

// What becomes of particles: any number of steps in registers, and when a hole swallowed each. For tools, and for what has
// no use for the steps in between: 28 B read and 32 B written, however many there are.
#define LAW_BINDING 3
#define LAW_CONSTANT 1
#include "particles/black_hole.glsl"

layout(local_size_x_id = 0) in;

// Seven planes of words, as in the pool: word k of particle i at k * count + i.
layout(set = 0, binding = 0, std430) readonly buffer Particles { uint particles[]; };
layout(set = 0, binding = 1, std430) writeonly buffer NewParticles { uint new_particles[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Ends { float swallowed_after_s[]; };  // -1: it was not

// Mirrors `particles::black_hole::FateParams`.
struct FateParams {
    uint now;       // tick at the start
    uint dt_ticks;  // length of a step
    float dt_s;     // the same (s)
    uint steps;     // to take
    uint count;     // particles
};

layout(push_constant, std430) uniform Push { FateParams p; };

uint tick_now = 0u;
uint law_tick() { return tick_now; }

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= p.count) return;
    uint w[7];
    for (uint k = 0u; k < 7u; ++k) w[k] = particles[k * p.count + i];
    Particle it = Particle(uintBitsToFloat(uvec3(w[0], w[1], w[2])), uintBitsToFloat(uvec3(w[3], w[4], w[5])), w[6]);
    precise float end_s = -1.0;
    for (uint step = 0u; step < p.steps; ++step) {
        tick_now = p.now + (step + 1u) * p.dt_ticks;
        Particle before = it;
        if (!advance(it, p.dt_s)) {
            if (!(dot3(it.at_m, it.at_m) < 3e38 && dot3(it.velocity_mps, it.velocity_mps) < 3e38)) it = before;
            end_s = float(step) * p.dt_s + swallowed_s;
            break;
        }
    }
    uvec3 at = floatBitsToUint(it.at_m), velocity = floatBitsToUint(it.velocity_mps);
    w = uint[](at.x, at.y, at.z, velocity.x, velocity.y, velocity.z, it.born);
    for (uint k = 0u; k < 7u; ++k) new_particles[k * p.count + i] = w[k];
    swallowed_after_s[i] = end_s;
}
