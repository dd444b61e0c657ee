#version 460
#extension GL_GOOGLE_include_directive : require
#include "ballistic/stored.glsl"

// What was appended becomes the arguments of the next frame's dispatch and of the draw; what found no room is counted and
// forgotten, and the other list is empty again.
layout(local_size_x = 1) in;
layout(push_constant) uniform Push { uint capacity; uint group; uint row; uint vertices; } p;
layout(set = 0, binding = 0, std430) buffer Counts { Counter counter; };
layout(set = 0, binding = 1, std430) buffer CountsBefore { Counter counter_before; };

void main() {
    uint appended = counter.count, count = min(appended, p.capacity);
    uint groups = (count + p.group - 1u) / p.group;
    uint rows = (groups + p.row - 1u) / p.row;
    uint dropped = counter_before.dropped + (appended - count);
    counter = Counter(count, dropped, min(groups, p.row), rows, 1u, p.vertices * count, 1u, 0u, 0u);
    counter_before.count = 0u;
}
