#version 460
#extension GL_GOOGLE_include_directive : require

// Where the particles of a fountain are at tick `now`: writes positions if it is asked to, else it only computes them, as a
// vertex shader would.
#include "particles/kepler_stateless.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint writes = 1u;

layout(set = 0, binding = 0, std430) readonly buffer Law { Fountain fountain; };
layout(set = 0, binding = 1, std430) writeonly buffer Places { vec4 places[]; };  // place (m), 1 if it is there else 0

// Mirrors `particles::kepler_stateless::StatelessParams`.
struct StatelessParams {
    uint now;    // tick
    uint first;  // number of the first particle
    uint count;  // how many
};

layout(push_constant, std430) uniform Push { StatelessParams p; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= p.count) return;
    Particle it;
    bool is_there = thrown_at(fountain, p.first + i, p.now, it);
    // What is never true, and cannot be known to be: without it nothing would be computed.
    bool is_wanted = writes == 1u || it.at_m.x + it.velocity_mps.x == 1e30;
    if (is_wanted) places[i] = vec4(it.at_m, is_there ? 1.0 : 0.0);
}
