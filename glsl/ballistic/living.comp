#version 460
#extension GL_GOOGLE_include_directive : require

// Before a picture: how many births live at its moment, and the arguments of those who draw or write their particles.
#define STRIKES_BINDING 0
#define RING_BINDING 1
#include "ballistic/kindling.glsl"

layout(local_size_x = 1) in;

// Workgroups in rows, as short as every device allows.
uvec2 rows_of(uint groups) { return uvec2(min(groups, 32768u), (groups + 32767u) / 32768u); }

void main() {
    ring.living = living_now();
    ring.now_low = p.now_low;
    ring.now_high = p.now_high;
    uint particles = ring.living * p.burst;
    ring.quad_vertices = 6u * particles;
    ring.points = particles;
    ring.quad_instances = ring.point_instances = 1u;
    ring.quad_first_vertex = ring.quad_first_instance = ring.point_first_vertex = ring.point_first_instance = 0u;
    uvec2 groups = rows_of((particles + 511u) / 512u), splat = rows_of((particles + 127u) / 128u);
    ring.groups_x = groups.x;
    ring.groups_y = groups.y;
    ring.splat_x = splat.x;
    ring.splat_y = splat.y;
    ring.groups_z = ring.splat_z = 1u;
}
