// Impulses one after the other, in colours of cells. No times of impact: who overlaps and comes nearer collides where it
// is, and is parted. CPU twin: disks::cpu::Disks::settle.
#include "disks/disks.glsl"
#include "disks/box.glsl"
layout(constant_id = 3) const bool MEASURES = false;

layout(set = 0, binding = 0, std430) buffer Place { vec4 place_m[]; };
layout(set = 0, binding = 1, std430) buffer Motion { Motion_t motion[]; };
layout(set = 0, binding = 2, std430) readonly buffer Start { uint start[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Hit { uint hit[]; };
layout(set = 0, binding = 4, std430) buffer Impulse { vec2 impulse[]; };

#include "disks/contact.glsl"

uint mine;

vec4 where(uint i) { return place_m[i]; }

void meet(uint k) {
    uint i = mine;
    vec4 place = place_m[i], other = place_m[k];
    vecd d = way(at_of(place), at_of(other));
    float far = length(d), radius = radius_of(place), other_radius = radius_of(other), reach = radius + other_radius;
    if (far >= reach) return;
    Motion_t moves = motion[i], its = motion[k];
    uint id = id_of(place, moves), other_id = id_of(other, its);
    float mass = mass_of(radius), other_mass = mass_of(other_radius);
    vecd n = axis_of(d, reach, id, other_id), u = velocity_of(its) - velocity_of(moves);
    if (dot(n, u) < 0.0) {
        float given = impulse_of(mass, other_mass, n, u);
        motion[i] = motion_of(velocity_of(moves) - n * (given / mass), id);
        motion[k] = motion_of(velocity_of(its) + n * (given / other_mass), other_id);
        hit[id] = p.step;
        hit[other_id] = p.step;
        if (MEASURES) impulse[id].x += given * reach;
    }
    vecd apart = n * ((reach - far) / (mass + other_mass));
    place_m[i] = place_of(at_of(place) - apart * other_mass, radius, id);
    place_m[k] = place_of(at_of(other) + apart * mass, other_radius, other_id);
}

#include "disks/neighbours.glsl"

#include "disks/colors.glsl"
