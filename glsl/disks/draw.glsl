// Drawing of disks and spheres: `DrawParams` mirrors `disks::draw::DrawParams`. Six vertices an instance, pulled by number.

#include "disks/id.glsl"

struct DrawParams {
    vec4 size_m;      // the box
    vec4 origin_m;    // of the box, in the world; spheres only
    uint step;
    float dt_s;
    uvec2 reserved;
};

layout(push_constant, std430) uniform Push { DrawParams p; };

// Corners of a quad, -1 to 1.
vec2 corner_of(int vertex) {
    uint at = uint[6](0u, 1u, 2u, 2u, 1u, 3u)[vertex];
    return vec2(at & 1u, at >> 1u) * 2.0 - 1.0;
}

// The tutorial's "temperature": 1 when hit, gone with exp(-2 t).
float temperature_of(uint hit) { return hit == 0u ? 0.0 : exp(-2.0 * p.dt_s * float(p.step - hit)); }

// The tutorial's colours, cold and hot, as linear light.
vec3 color_of(float temperature) { return mix(vec3(0.0, 0.36, 0.79), vec3(1.0, 0.58, 0.0015), temperature); }
