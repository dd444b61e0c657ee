// Writes the live particles of an effect as 16-byte vertices, oldest first: for whoever draws them by other means, and to
// see how fast they come. Reads nothing. CPU twin: ballistic::cpu::flight.
#extension GL_EXT_control_flow_attributes : require
#include "ballistic/flight.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint items = 2u;  // particles an invocation
layout(constant_id = 2) const uint group = 256u;  // invocations of a workgroup: constant 0 once more

// Position (m); from the low byte: red, green, blue (linear, premultiplied, up to 1), and age in 255ths of its life.
layout(set = 0, binding = 0, std430) writeonly buffer Vertices { vec4 vertex[]; };

// packUnorm4x8 without conversions, which a GPU has few units for: in the last bits of 2^23 stands the nearest whole number.
// What stands above them in y, z and w is shifted out.
uint packed_bytes(vec4 parts) {
    uvec4 b = floatBitsToUint(clamp(parts, 0.0, 1.0) * 255.0 + 8388608.0);
    return b.x - 0x4b000000u + (b.y << 8u) + (b.z << 16u) + (b.w << 24u);
}

void main() {
    uint first = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * (group * items) + gl_LocalInvocationIndex;
    uint count = particles_alive();
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        uint i = first + k * group;
        if (i >= count) return;
        Who who;
        Flight f;
        vec3 at_m = vec3(0.0);
        vec4 seen = vec4(0.0, 0.0, 0.0, 1.0);  // black: adds nothing
        if (flight_of(i, who, f)) {
            Look l = look(who, f);
            at_m = f.at_m;
            seen = vec4(l.color.rgb, f.share);
        }
        vertex[i] = vec4(at_m, uintBitsToFloat(packed_bytes(seen)));
    }
}
