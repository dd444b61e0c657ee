// Each disk offers itself to the disk that it met first; of several at once, to the one of the lowest id. Pairs that agree
// collide next, in disks/collide.glsl. From the second round on, only who overlapped or was woken looks again.
// CPU twin: disks::cpu::Disks::propose.
#include "disks/disks.glsl"
#include "disks/box.glsl"
layout(constant_id = 3) const bool REWINDS = true;

layout(set = 0, binding = 0, std430) readonly buffer Place { vec4 place_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Motion { Motion_t motion[]; };
layout(set = 0, binding = 2, std430) readonly buffer Start { uint start[]; };
layout(set = 0, binding = 3, std430) buffer Partner { uint partner[]; };
layout(set = 0, binding = 4, std430) buffer Wake { uint wake[]; };

#include "disks/contact.glsl"

vec4 place;
uint best = NONE, lowest = NONE, mine;
float earliest = -1.0;

void meet(uint k) {
    vec4 other = place_m[k];
    vecd d = way(at_of(place), at_of(other));
    float reach = radius_of(place) + radius_of(other);
    if (dot(d, d) >= reach * reach) return;
    Motion_t moves = motion[mine], its = motion[k];
    uint id = id_of(place, moves), other_id = id_of(other, its);
    Contact met = contact_of(d, velocity_of(its) - velocity_of(moves), reach, id, other_id, REWINDS);
    if (!met.collides) {
        if (best == NONE) best = AWAKE;  // to be parted
    } else if (met.ago_s > earliest || (met.ago_s == earliest && other_id < lowest)) {
        best = k;
        earliest = met.ago_s;
        lowest = other_id;
    }
}

#include "disks/neighbours.glsl"

void main() {
    uint i = item();
    if (i >= p.disks) return;
    if (p.is_first == 0u) {
        bool is_woken = wake[i] != 0u;
        if (is_woken) wake[i] = 0u;
        if (!is_woken && partner[i] == NONE) return;
    }
    mine = i;
    place = place_m[i];
    visit(i, place);
    partner[i] = best;
}
