// The sums of draw/sprites_splat.glsl over the picture, and zero again for the next. Light that covers is taken as mixed
// evenly along its way w: (1 - exp(-w)) / w of it gets out. That is exact where it is of one colour, and no order is needed.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 1, rgba16f) uniform image2D color;

void main() {
    uvec2 c = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(c, view.pixels))) return;
    uvec4 sums = splat_take(c.y * view.pixels.x + c.x);
    if (sums == uvec4(0u)) return;
    vec4 light = vec4(sums) / SPLAT_ONE;
    float through = exp(-light.a);
    float out_of = light.a < 1e-3 ? 1.0 - 0.5 * light.a : (1.0 - through) / light.a;
    vec4 behind = imageLoad(color, ivec2(c));
    imageStore(color, ivec2(c), vec4(behind.rgb * through + light.rgb * out_of, behind.a * through + 1.0 - through));
}
