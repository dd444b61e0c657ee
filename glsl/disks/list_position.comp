#version 460
#extension GL_GOOGLE_include_directive : require
#include "disks/list.glsl"

// The tutorial's first pass over contacts: out of every overlap by 0.51 of it, and how many there are.
// CPU twin: disks::cpu::Disks::contacts, answer.

layout(set = 0, binding = 0, std430) buffer Disks { ListDisk disks[]; };
layout(set = 0, binding = 1, std430) readonly buffer Head { uint head[]; };
layout(set = 0, binding = 2, std430) readonly buffer Next { uint next[]; };

ListDisk me;
vec2 push_m = vec2(0.0);
uint contacts = 0u;

void meet(uint k) {
    vec2 d = disks[k].at_m - me.at_m;
    float far = length(d), reach = me.radius_m + disks[k].radius_m;
    if (far < reach) {
        push_m -= d / far * (0.51 * (reach - far));
        ++contacts;
    }
}

#include "disks/list_walk.glsl"

void main() {
    uint i = item();
    if (i >= p.disks) return;
    me = disks[i];
    walk(i, me.at_m);
    disks[i].new_at_m = me.at_m + push_m;
    disks[i].contacts = contacts;
    if (contacts > 0u) disks[i].temperature = 1.0;
}
