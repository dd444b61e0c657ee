#version 460

// Keeps the GPU busy for a time that the host can choose: the probe of the clock (src/gpu/timing.rs).

layout(local_size_x = 64) in;

layout(set = 0, binding = 0, std430) writeonly buffer Sink { uint sink[]; };

layout(push_constant, std430) uniform Push { uint rounds; };

void main() {
    uint x = gl_GlobalInvocationID.x + 1u;
    for (uint i = 0u; i < rounds; ++i) x = x * 747796405u + (x >> 9u);  // each round waits for the last
    sink[gl_GlobalInvocationID.x] = x;
}
