// Moves each disk to its cell. Ranks by atomics come in any order, so those of one cell, about one, are put in the order
// that they had: the same on every run. CPU twin: disks::cpu::Disks::sort.
#include "disks/disks.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Slot { uint slot[]; };
layout(set = 0, binding = 1, std430) readonly buffer Start { uint start[]; };
layout(set = 0, binding = 2, std430) readonly buffer NewPlace { vec4 new_place_m[]; };
layout(set = 0, binding = 3, std430) readonly buffer NewMotion { Motion_t new_motion[]; };
layout(set = 0, binding = 4, std430) writeonly buffer Place { vec4 place_m[]; };
layout(set = 0, binding = 5, std430) writeonly buffer Motion { Motion_t motion[]; };

void main() {
    uint s = item();
    if (s >= p.disks) return;
    uint i = s < p.large ? s : slot[s - p.large];
    vec4 place = new_place_m[i];
    uint to = s;
    if (s >= p.large) {
        uint cell = cell_index(cell_of(at_of(place)));
        uint first = start[cell], last = start[cell + 1u];
        to = p.large + first;
        for (uint k = first; k < last; ++k) to += slot[k] < i ? 1u : 0u;
    }
    place_m[to] = place;
    motion[to] = new_motion[i];
}
