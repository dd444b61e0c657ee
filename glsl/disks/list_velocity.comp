#version 460
#extension GL_GOOGLE_include_directive : require
#include "disks/list.glsl"

// The tutorial's second pass over contacts: one that is the only one of both is elastic, several reverse the velocity,
// which loses momentum. CPU twin: disks::cpu::Disks::answer.

layout(set = 0, binding = 0, std430) buffer Disks { ListDisk disks[]; };
layout(set = 0, binding = 1, std430) readonly buffer Head { uint head[]; };
layout(set = 0, binding = 2, std430) readonly buffer Next { uint next[]; };

ListDisk me;
vec2 velocity_mps;

void meet(uint k) {
    vec2 d = disks[k].at_m - me.at_m;
    float far = length(d), reach = me.radius_m + disks[k].radius_m;
    if (far >= reach) return;
    if (me.contacts > 1u) {
        velocity_mps = -me.velocity_mps;
    } else if (disks[k].contacts == 1u) {
        vec2 n = d / far;
        float mass = mass_of(me.radius_m), other_mass = mass_of(disks[k].radius_m);
        velocity_mps += n * (2.0 * other_mass / (mass + other_mass) * dot(n, disks[k].velocity_mps - me.velocity_mps));
    }
}

#include "disks/list_walk.glsl"

void main() {
    uint i = item();
    if (i >= p.disks) return;
    me = disks[i];
    velocity_mps = me.velocity_mps;
    walk(i, me.at_m);
    disks[i].new_velocity_mps = velocity_mps;
}
