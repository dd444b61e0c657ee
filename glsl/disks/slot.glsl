// Where each disk goes: the numbers of those of a cell side by side, in any order. CPU twin: disks::cpu::Disks::sort.
#include "disks/disks.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Key { uvec2 key[]; };
layout(set = 0, binding = 1, std430) readonly buffer Start { uint start[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Slot { uint slot[]; };

void main() {
    uint i = item();
    if (i >= p.disks || i < p.large) return;
    uvec2 to = key[i];
    slot[start[to.x] + to.y] = i;
}
