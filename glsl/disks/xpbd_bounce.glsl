// Extended position based dynamics, the velocity pass (Mueller et al. 2020, equation 34, restitution 1): each contact gets
// back the speed with which it was met, and none if it was not. Without it what was pushed apart is inelastic. Contacts are
// those before the pushes. CPU twin: disks::cpu::Disks::xpbd_bounce.
#include "disks/disks.glsl"
#include "disks/box.glsl"
layout(constant_id = 3) const bool MEASURES = false;

layout(set = 0, binding = 0, std430) readonly buffer NewPlace { vec4 new_place_m[]; };      // before the pushes
layout(set = 0, binding = 1, std430) readonly buffer NewMotion { Motion_t new_motion[]; };
layout(set = 0, binding = 2, std430) readonly buffer Start { uint start[]; };
layout(set = 0, binding = 3, std430) buffer Motion { Motion_t motion[]; };
layout(set = 0, binding = 4, std430) buffer Impulse { vec2 impulse[]; };

#include "disks/contact.glsl"

uint mine;

vec4 where(uint i) { return new_place_m[i]; }

void meet(uint k) {
    uint i = mine;
    vec4 place = new_place_m[i], other = new_place_m[k];
    vecd d = way(at_of(place), at_of(other));
    float radius = radius_of(place), other_radius = radius_of(other), reach = radius + other_radius;
    if (dot(d, d) >= reach * reach) return;
    Motion_t moves = motion[i], its = motion[k];
    uint id = id_of(place, moves), other_id = id_of(other, its);
    float mass = mass_of(radius), other_mass = mass_of(other_radius);
    vecd n = axis_of(d, reach, id, other_id);
    float before = dot(n, velocity_of(new_motion[k]) - velocity_of(new_motion[i]));
    float now = dot(n, velocity_of(its) - velocity_of(moves));
    float given = (max(-before, 0.0) - now) * (mass * other_mass / (mass + other_mass));
    motion[i] = motion_of(velocity_of(moves) - n * (given / mass), id);
    motion[k] = motion_of(velocity_of(its) + n * (given / other_mass), other_id);
    if (MEASURES) impulse[id].x += given * reach;
}

#include "disks/neighbours.glsl"
#include "disks/colors.glsl"
