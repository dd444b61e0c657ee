#version 460
#extension GL_GOOGLE_include_directive : require

// Second of three: the ring turns by the births of the step. Those that live and lose their slots are counted, births of the
// same step among them where it has more than the ring.
#define STRIKES_BINDING 0
#define RING_BINDING 1
#include "ballistic/kindling.glsl"

layout(local_size_x = 1) in;
layout(set = 0, binding = 2, std430) readonly buffer Sums { uint sums[]; };

void main() {
    uint births = sums[p.total_at], wanted = living_now() + births;
    uint carry;
    ring.overwritten_low = uaddCarry(ring.overwritten_low, max(wanted, p.capacity) - p.capacity, carry);
    ring.overwritten_high += carry;
    ring.next_low = uaddCarry(ring.next_low, births, carry);
    ring.next_high += carry;
    ring.slot = (ring.slot + births) % p.capacity;
    ring.step_births = births;
}
