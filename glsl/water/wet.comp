#version 460
#extension GL_GOOGLE_include_directive : require
#include "water/depth.glsl"

// Pipes over ground that may be dry, one step: the surface drives, and a pipe is as deep as the water above the higher
// of its two grounds.
//     D = max(surface_a, surface_b) - max(bed_a, bed_b)
//     flow' = keep (flow + g dt / dx D (surface_a - surface_b)) where D > thin, else 0
// then water/donor.glsl limits the flows, stores them limited, and moves the water. Flows (m^2/s) are of a unit of width,
// positive to the east and south. No advection: a dam break comes out slow (see shallow). 28 bytes a column and step:
// ground read, rise and two flows read and written. CPU twin: water::cpu_wet::Depths.

layout(push_constant, std430) uniform Push { DepthParams p; };

float flow_through(float stored, float surface_a, float surface_b, float bed_a, float bed_b) {
    precise float head = max(surface_a, surface_b) - max(bed_a, bed_b);
    precise float slope = slope_of(surface_a, surface_b, bed_a, bed_b);
    precise float flow = p.keep * (stored + (p.pull * head) * slope);
    return head > p.thin_m ? flow : 0.0;
}

#define KEEPS_FLOWS
#include "water/donor.glsl"
