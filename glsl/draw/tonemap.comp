#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"

// Linear light to sRGB bytes: exposure, the filmic curve of Narkowicz ("ACES Filmic Tone Mapping Curve", 2015), sRGB
// transfer, and half a step of noise against bands. One word a pixel, red lowest.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, rgba16f) uniform readonly image2D color;
layout(set = 0, binding = 2, std430) writeonly buffer Pixels { uint rgba8[]; };

void main() {
    uvec2 c = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(c, view.pixels))) return;
    vec4 linear = imageLoad(color, ivec2(c));
    vec3 x = max(linear.rgb * view.to_sun.w, 0.0);
    x = clamp((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
    x = mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
    x += (hash2(ivec2(c)) - 0.5) / 255.0;
    rgba8[c.y * view.pixels.x + c.x] = packUnorm4x8(vec4(x, linear.a));
}
