#version 460
// Plane and velocity of a texel, written together. The plane is relative to the middle of its cell.
#include "volume/params.glsl"
#include "volume/slices.glsl"

layout(location = 0) flat in vec3 from_normal;
layout(location = 1) flat in vec3 from_a_m;
layout(location = 2) in vec3 from_velocity_mps;
layout(location = 3) flat in uint from_triangle;
layout(location = 4) flat in int from_slice;

layout(location = 0) out vec4 plane;     // normal, distance of the centre (m)
layout(location = 1) out vec4 velocity;  // (m/s), triangle plus 1: below 2^24, so a float knows it

void main() {
    float height = slice_height(gl_FragCoord.xy, from_normal, from_a_m);
    if (int(floor(height)) != from_slice) discard;
    ivec3 cell = turned_back(ivec3(ivec2(gl_FragCoord.xy), from_slice));
    plane = vec4(from_normal, centre_distance_m(cell, from_normal, from_a_m));
    velocity = vec4(from_velocity_mps, float(from_triangle + 1u));
    gl_FragDepth = depth_of(height);
}
