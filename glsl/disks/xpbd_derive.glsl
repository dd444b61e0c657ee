// Extended position based dynamics: the velocity is the way that was gone, pushes included. Keeps the one before, which the
// velocity pass asks for. CPU twin: disks::cpu::Disks::xpbd_derive.
#include "disks/disks.glsl"
#include "disks/box.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Place { vec4 place_m[]; };
layout(set = 0, binding = 1, std430) readonly buffer NewPlace { vec4 new_place_m[]; };  // before the pushes
layout(set = 0, binding = 2, std430) buffer Motion { Motion_t motion[]; };
layout(set = 0, binding = 3, std430) writeonly buffer NewMotion { Motion_t new_motion[]; };

void main() {
    uint i = item();
    if (i >= p.disks) return;
    vec4 place = place_m[i];
    Motion_t moves = motion[i];
    new_motion[i] = moves;
    vecd pushed = way(at_of(new_place_m[i]), at_of(place));
    motion[i] = motion_of(velocity_of(moves) + pushed / p.dt_s, id_of(place, moves));
}
