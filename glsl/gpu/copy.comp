#version 460

// Copies 16 bytes an invocation: the rate that memory-bound kernels are compared with (`whitecap bench`).

layout(local_size_x = 256) in;

layout(set = 0, binding = 0, std430) readonly buffer From { uvec4 from[]; };
layout(set = 0, binding = 1, std430) writeonly buffer To { uvec4 to[]; };

layout(push_constant, std430) uniform Push { uint count; };

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) to[i] = from[i];
}
