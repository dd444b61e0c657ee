#version 460
#extension GL_GOOGLE_include_directive : require

// The gather of the seed: every texel looks at every drop that takes part. An invocation a texel. CPU twin:
// paint::cpu::gather.

layout(local_size_x_id = 2) in;
#include "paint/gather.glsl"

void main() {
    uint texel = gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x;
    if (texel >= TILE_TEXELS * BLOCK_TILES * p.blocks) return;
    vec3 at_m = positions[texel].at_m;
    if (positions[texel].triangle == 0u) return;
    uint mesh = kind == IMPACTS ? tiles[texel / TILE_TEXELS].mesh : 0u;
    vec4 value = load(texel);
    bool is_painted = false;
    uint count = taking_part();
    for (uint k = 0u; k < count; ++k) take(p.first + p.stride * k, texel, at_m, mesh, value, is_painted);
    if (is_painted) store(texel, value);
}
