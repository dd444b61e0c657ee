// Paint under texture coordinates, for whoever draws a painted mesh: between the four texels round it, linearly. What is seen is
//     paint.rgb + (1 - paint.a) * what is below
// The user declares `buffer Paint { uvec2 paint[]; }` and, as `format`, how it is stored (paint/texel.glsl). CPU twin:
// paint::cpu::lookup.
#include "paint/map.glsl"
#include "paint/texel.glsl"

vec4 paint_of(Map map, ivec2 at) {
    uint texel = texel_of(map, uvec2(clamp(at, ivec2(0), ivec2(map.width, map.height) - 1)));
    if (format == HALVES) return floats_of(paint[texel]);
    return uintBitsToFloat(uvec4(paint[2u * texel], paint[2u * texel + 1u]));
}

vec4 paint_at(Map map, vec2 uv) {
    vec2 place = clamp(uv, 0.0, 1.0) * vec2(map.width, map.height) - 0.5;
    ivec2 at = ivec2(floor(place));
    vec2 share = place - vec2(at);
    vec4 top = mix(paint_of(map, at), paint_of(map, at + ivec2(1, 0)), share.x);
    vec4 bottom = mix(paint_of(map, at + ivec2(0, 1)), paint_of(map, at + ivec2(1, 1)), share.x);
    return mix(top, bottom, share.y);
}
