#version 460
// Vertices for `volume.slices.geom`: where they are and how they move.
#include "volume/triangle.glsl"

layout(location = 0) out vec3 to_at_m;
layout(location = 1) out vec3 to_velocity_mps;
layout(location = 2) flat out int to_slice;

void main() {
    uint corner = corners[gl_VertexIndex];
    to_at_m = corner_m(corner);
    to_velocity_mps = corner_mps(corner);
    to_slice = gl_InstanceIndex;
    gl_Position = vec4(0.0);  // the geometry shader says where
}
