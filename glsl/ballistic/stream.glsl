// Particles that are stored, by way of the graphics pipeline: the vertex shader of the book's stream-out. A draw of what the
// last frame captured has no births: each is older by since_s. The other draw has the newborn. Needs the effect's file.
#include "ballistic/flight.glsl"
#include "ballistic/stored.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Before { Stored before[]; };
layout(location = 0) out vec4 at_age;
layout(location = 1) out vec4 flown;

void main() {
    uint i = uint(gl_VertexIndex);
    gl_Position = vec4(0.0);
    if (effect.births == 0u) {
        at_age = before[i].at_age;
        at_age.w += effect.since_s;
        flown = before[i].velocity;
        return;
    }
    Who who;
    Wide age = age_of_particle(i, who);
    Birth start = birth(who, emitter_at(age));
    at_age = vec4(start.at_m, age.high);
    flown = vec4(start.velocity_mps, 0.0);
}
