// A texel takes a coat from each drop that is nearer than the radius, in the order of the drops:
//     |drop - texel|^2 < r^2
// (The document of 2010 has `>`, a lost `&lt;`; its program has `<`.) An impact paints only the mesh that it hit, and there
// at least the texel that it hit, however small its radius: who touched has painted. CPU twin: paint::cpu::gather.
#include "paint/drops.glsl"
#include "paint/texel.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Drops { Drop drops[]; };
layout(set = 0, binding = 1, std430) readonly buffer Homes { uint homes[]; };  // of an impact: the texel that it hit
layout(set = 0, binding = 2, std430) readonly buffer Coats { Coat coats[]; };
layout(set = 0, binding = 3, std430) readonly buffer WorkToDo { Work work; };
layout(set = 0, binding = 4, std430) readonly buffer Positions { Position positions[]; };
layout(set = 0, binding = 5, std430) readonly buffer Tiles { Box tiles[]; };
layout(set = 0, binding = 6, std430) buffer Paint { uvec2 paint[]; };

layout(push_constant, std430) uniform Push { GatherParams p; };

uint taking_part() {
    if (kind == IMPACTS) return work.drops;
    return p.first < p.total ? (p.total - p.first - 1u) / p.stride + 1u : 0u;
}

vec4 load(uint texel) {
    if (format == HALVES) return floats_of(paint[texel]);
    return uintBitsToFloat(uvec4(paint[2u * texel], paint[2u * texel + 1u]));
}

void store(uint texel, vec4 value) {
    if (format == HALVES) {
        paint[texel] = halves_of(value);
    } else {
        paint[2u * texel] = floatBitsToUint(value.xy);
        paint[2u * texel + 1u] = floatBitsToUint(value.zw);
    }
}

// Drop i on the texel, if it reaches.
void take(uint i, uint texel, vec3 at_m, uint mesh, inout vec4 value, inout bool is_painted) {
    Drop drop = drops[i];
    uint source = drop.source;
    float reach_sq_m2 = p.reach_sq_m2;
    bool is_home = false;
    if (kind == IMPACTS) {
        if (source >> 16u != mesh) return;
        source &= 0xffffu;
        reach_sq_m2 = coats[source].reach_sq_m2;
        is_home = homes[i] == texel;
    }
    if ((distance_sq(drop.at_m, at_m) < reach_sq_m2 || is_home) && source < p.coats) {
        value = over(value, coats[source].paint);
        is_painted = true;
    }
}
