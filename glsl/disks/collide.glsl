// Pairs that agree collide where they met: rewound, an exact impulse of two elastic bodies, played again. One invocation
// writes both, and nobody else does. Then those that the two now overlap, and that overlapped nobody, are woken for the
// next round: only disks without a partner are looked at, and those nobody writes.
// CPU twin: disks::cpu::Disks::collide.
#include "disks/disks.glsl"
#include "disks/box.glsl"
layout(constant_id = 3) const bool REWINDS = true;
layout(constant_id = 4) const bool MEASURES = false;

layout(set = 0, binding = 0, std430) buffer Place { vec4 place_m[]; };
layout(set = 0, binding = 1, std430) buffer Motion { Motion_t motion[]; };
layout(set = 0, binding = 2, std430) readonly buffer Start { uint start[]; };
layout(set = 0, binding = 3, std430) readonly buffer Partner { uint partner[]; };
layout(set = 0, binding = 4, std430) buffer Wake { uint wake[]; };
layout(set = 0, binding = 5, std430) writeonly buffer Hit { uint hit[]; };
layout(set = 0, binding = 6, std430) buffer Impulse { vec2 impulse[]; };

#include "disks/contact.glsl"

vec4 around;

void meet(uint k) {
    if (partner[k] != NONE) return;
    vec4 other = place_m[k];
    vecd d = way(at_of(around), at_of(other));
    float reach = radius_of(around) + radius_of(other);
    if (dot(d, d) < reach * reach) atomicOr(wake[k], 1u);
}

#include "disks/neighbours.glsl"

void main() {
    uint i = item();
    if (i >= p.disks) return;
    uint k = partner[i];
    if (k >= AWAKE || i >= k || partner[k] != i) return;
    vec4 mine = place_m[i], its = place_m[k];
    Motion_t moves = motion[i], other_moves = motion[k];
    uint id = id_of(mine, moves), other_id = id_of(its, other_moves);
    float radius = radius_of(mine), other_radius = radius_of(its), reach = radius + other_radius;
    float mass = mass_of(radius), other_mass = mass_of(other_radius);
    vecd velocity = velocity_of(moves), other_velocity = velocity_of(other_moves), u = other_velocity - velocity;
    Contact met = contact_of(way(at_of(mine), at_of(its)), u, reach, id, other_id, REWINDS);
    float given = impulse_of(mass, other_mass, met.normal, u);
    vecd kick = met.normal * (-given / mass), other_kick = met.normal * (given / other_mass);

    mine = place_of(at_of(mine) + kick * met.ago_s, radius, id);
    its = place_of(at_of(its) + other_kick * met.ago_s, other_radius, other_id);
    place_m[i] = mine;
    place_m[k] = its;
    motion[i] = motion_of(velocity + kick, id);
    motion[k] = motion_of(other_velocity + other_kick, other_id);
    hit[id] = p.step;
    hit[other_id] = p.step;
    if (MEASURES) impulse[id].x += given * reach;

    around = mine;
    visit(i, mine);
    around = its;
    visit(k, its);
}
