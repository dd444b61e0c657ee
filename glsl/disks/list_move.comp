#version 460
#extension GL_GOOGLE_include_directive : require
#include "disks/list.glsl"
#include "disks/walls.glsl"

// A step forward, then into the list of the bin. CPU twin: disks::cpu::Disks::travel.

layout(set = 0, binding = 0, std430) buffer Disks { ListDisk disks[]; };
layout(set = 0, binding = 1, std430) buffer Head { uint head[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Next { uint next[]; };

void main() {
    uint i = item();
    if (i >= p.disks) return;
    ListDisk me = disks[i];
    vec2 velocity = me.new_velocity_mps, pull = p.gravity_mps2.xy * p.dt_s;
    vec2 at = me.new_at_m + (velocity + 0.5 * pull) * p.dt_s;
    velocity += pull;
    for (int axis = 0; axis < 2; ++axis) {
        between_walls(at[axis], velocity[axis], me.radius_m, p.size_m[axis] - me.radius_m, p.gravity_mps2[axis]);
    }
    disks[i].at_m = at;
    disks[i].velocity_mps = velocity;
    disks[i].temperature = me.temperature * exp(-2.0 * p.dt_s);
    uint c = cell_index(cell_of(at));
    next[i] = atomicExchange(head[c], i);
}
