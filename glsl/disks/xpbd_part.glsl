// Extended position based dynamics, positions: out of every overlap, by mass, one contact after the other, in colours of
// cells (Mueller et al., "Detailed Rigid Body Simulation with Extended Position Based Dynamics", 2020, section 3.5, without
// compliance). CPU twin: disks::cpu::Disks::xpbd_part.
#include "disks/disks.glsl"
#include "disks/box.glsl"
layout(constant_id = 3) const bool MEASURES = false;

layout(set = 0, binding = 0, std430) buffer Place { vec4 place_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer Start { uint start[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Hit { uint hit[]; };
layout(set = 0, binding = 3, std430) buffer Impulse { vec2 impulse[]; };
#if DIMENSIONS == 3
layout(set = 0, binding = 4, std430) readonly buffer Motion { Motion_t motion[]; };
uint id_at(uint i, vec4 place) { return id_of(place, motion[i]); }
#else
uint id_at(uint i, vec4 place) { return id_of(place, vec2(0.0)); }
#endif

#include "disks/contact.glsl"

uint mine;

vec4 where(uint i) { return place_m[i]; }

void meet(uint k) {
    uint i = mine;
    vec4 place = place_m[i], other = place_m[k];
    vecd d = way(at_of(place), at_of(other));
    float far = length(d), radius = radius_of(place), other_radius = radius_of(other), reach = radius + other_radius;
    if (far >= reach) return;
    uint id = id_at(i, place), other_id = id_at(k, other);
    float mass = mass_of(radius), other_mass = mass_of(other_radius);
    vecd apart = axis_of(d, reach, id, other_id) * ((reach - far) / (mass + other_mass));
    place_m[i] = place_of(at_of(place) - apart * other_mass, radius, id);
    place_m[k] = place_of(at_of(other) + apart * mass, other_radius, other_id);
    hit[id] = p.step;
    hit[other_id] = p.step;
    // What disks/xpbd_derive.glsl makes of it.
    if (MEASURES) impulse[id].x += mass * other_mass / (mass + other_mass) * (reach - far) / p.dt_s * reach;
}

#include "disks/neighbours.glsl"
#include "disks/colors.glsl"
