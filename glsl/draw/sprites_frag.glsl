// Light of a sprite: a soft disc (or line), or a texture with TEXTURE defined; with SOFT defined it fades over its own
// half width where it meets the scene, instead of ending in a line. Needs draw/view.glsl.

layout(location = 0) in vec2 at;
layout(location = 1) in flat vec4 color;
layout(location = 2) in flat vec2 shape;  // stretch, half width (m)
layout(location = 0) out vec4 light;

#ifdef TEXTURE
// Linear, premultiplied, row by row from the top; levels one after the other, each half as wide and high.
layout(set = 0, binding = 3, std430) readonly buffer Texture { uvec4 texture_size; vec4 texels[]; };  // width, height, levels

vec4 sample_level(uint first, ivec2 size, vec2 uv) {
    vec2 p = uv * vec2(size) - 0.5;
    ivec2 c = ivec2(floor(p));
    vec2 f = p - vec2(c);
    ivec2 lo = clamp(c, ivec2(0), size - 1), hi = clamp(c + 1, ivec2(0), size - 1);
    return mix(mix(texels[first + lo.y * size.x + lo.x], texels[first + lo.y * size.x + hi.x], f.x),
               mix(texels[first + hi.y * size.x + lo.x], texels[first + hi.y * size.x + hi.x], f.x), f.y);
}

vec4 sample_texture(vec2 uv) {
    vec2 texels_a_pixel = vec2(texture_size.xy) * vec2(length(vec2(dFdx(uv.x), dFdy(uv.x))), length(vec2(dFdx(uv.y), dFdy(uv.y))));
    float level = clamp(log2(max(max(texels_a_pixel.x, texels_a_pixel.y), 1.0)), 0.0, float(texture_size.z - 1u));
    uint first = 0u;
    ivec2 size = ivec2(texture_size.xy);
    for (uint l = 0u; l < uint(level); ++l) {
        first += uint(size.x * size.y);
        size = max(size / 2, 1);
    }
    vec4 fine = sample_level(first, size, uv);
    if (level == float(texture_size.z - 1u)) return fine;
    return mix(fine, sample_level(first + uint(size.x * size.y), max(size / 2, 1), uv), fract(level));
}
#endif

#ifdef SOFT
layout(set = 0, binding = 4, std430) readonly buffer Depth { float scene_depth[]; };  // of the first sample of a pixel
#endif

void main() {
#ifdef TEXTURE
    light = color * sample_texture(vec2(0.5 + 0.5 * at.x, 0.5 - 0.5 * at.y));
#else
    light = color * soft_disc(at, shape.x);
#endif
#ifdef SOFT
    uvec2 pixel = min(uvec2(gl_FragCoord.xy), view.pixels - 1u);
    float behind_m = distance_of_depth(scene_depth[pixel.y * view.pixels.x + pixel.x]) - distance_of_depth(gl_FragCoord.z);
    light *= clamp(behind_m / max(shape.y, 1e-6), 0.0, 1.0);
#endif
}
