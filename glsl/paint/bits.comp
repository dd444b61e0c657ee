#version 460
#extension GL_GOOGLE_include_directive : require

// Second of three: marks of each word. A scan makes of them how many come before each.

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) readonly buffer Marks { uint marks[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Before { uint before[]; };

layout(push_constant, std430) uniform Push { uint words; } p;

void main() {
    uint i = gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x;
    if (i < p.words) before[i] = bitCount(marks[i]);
}
