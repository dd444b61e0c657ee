#version 460
#extension GL_GOOGLE_include_directive : require
// The end of a step: how many impacts there are, how many found no room, and the arguments of those who read them. The
// count of the next step begins at 0. CPU twin: impact::cpu::close.
#define IMPACT_COUNT_BINDING 0
#define IMPACT_COUNT_ACCESS
#include "impact/impact.glsl"

layout(local_size_x = 1) in;

// Adds to a number of 64 bits; true: the low word has gone round.
bool carries(uint before, uint more) { return before > 0xffffffffu - more; }

void main() {
    uint appended = impact_count.appended, stored = min(appended, impact_count.capacity), lost = appended - stored;
    if (carries(impact_count.dropped_low, lost)) ++impact_count.dropped_high;
    impact_count.dropped_low += lost;
    if (carries(impact_count.stored_low, stored)) ++impact_count.stored_high;
    impact_count.stored_low += stored;
    impact_count.count = stored;
    impact_count.appended = 0u;
    // Rows as short as every device allows: 65535 workgroups.
    uint groups = (stored + IMPACT_GROUP - 1u) / IMPACT_GROUP, rows = max((groups + 65534u) / 65535u, 1u);
    impact_count.groups_x = (groups + rows - 1u) / rows;
    impact_count.groups_y = rows;
    impact_count.groups_z = 1u;
    impact_count.quad_vertices = 6u * stored;
    impact_count.quad_instances = 1u;
    impact_count.quad_first_vertex = 0u;
    impact_count.quad_first_instance = 0u;
}
