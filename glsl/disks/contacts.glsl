// The tutorial's first pass: whom each disk touches. Its second pass needs no search then: see disks/travel.glsl.
// CPU twin: disks::cpu::Disks::contacts.
#include "disks/disks.glsl"
#include "disks/box.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Place { vec4 place_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Start { uint start[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Partner { uint partner[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Hit { uint hit[]; };  // by id: step of the last hit
#if DIMENSIONS == 3
layout(set = 0, binding = 4, std430) readonly buffer Motion { Motion_t motion[]; };
#endif

vec4 place;
uint found = NONE;

void meet(uint k) {
    vec4 other = place_m[k];
    vecd d = way(at_of(place), at_of(other));
    float reach = radius_of(place) + radius_of(other);
    if (dot(d, d) < reach * reach) found = found == NONE ? k : MANY;
}

#include "disks/neighbours.glsl"

void main() {
    uint i = item();
    if (i >= p.disks) return;
    place = place_m[i];
    visit(i, place);
    partner[i] = found;
#if DIMENSIONS == 2
    if (found != NONE) hit[id_of(place, vec2(0.0))] = p.step;
#else
    if (found != NONE) hit[id_of(place, motion[i])] = p.step;
#endif
}
