#version 460
#extension GL_GOOGLE_include_directive : require

// Particles as drops, for those who paint without an impact stream: of a state in planes, x, y and z first, as pools keep
// them. How many there are is a word on the device; what is beyond is nobody's. CPU twin: paint::cpu::take.

layout(local_size_x = 256) in;

// Mirrors `paint::Drop`, 16 bytes.
struct Drop {
    vec3 at_m;
    uint source;
};

// Mirrors `paint::TakeParams`.
struct TakeParams {
    uint most;      // drops to write
    uint stride;    // words from one plane to the next
    uint count_at;  // word of `Counts`
    uint source;    // whose paint
    uint to;        // the first drop to write
};

layout(set = 0, binding = 0, std430) readonly buffer Planes { float planes[]; };
layout(set = 0, binding = 1, std430) readonly buffer Counts { uint counts[]; };
layout(set = 0, binding = 2, std430) writeonly buffer Drops { Drop drops[]; };

layout(push_constant, std430) uniform Push { TakeParams p; };

const uint NOBODY = 0xffffffffu;

void main() {
    uint i = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 256u + gl_LocalInvocationIndex;
    if (i >= p.most) return;
    bool is_there = i < counts[p.count_at];
    vec3 at_m = vec3(0.0);
    if (is_there) at_m = vec3(planes[i], planes[p.stride + i], planes[2u * p.stride + i]);
    drops[p.to + i].at_m = at_m;
    drops[p.to + i].source = is_there ? p.source : NOBODY;
}
