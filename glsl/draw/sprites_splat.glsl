// Sprites without triangles: one invocation a sprite adds its light to the pixels under it, and draw.splat_over lays the
// sums over the picture. For sprites of a few pixels; of a large one, one invocation would fill all of it.
// Needs draw/view.glsl, draw/sprite.glsl and an effect.

#include "draw/splats.glsl"

layout(local_size_x = 128) in;

layout(set = 0, binding = 4, std430) readonly buffer Depth { float scene_depth[]; };

const float LEAST_PX = 1.0;
const float PI = 3.14159265359;

// `chance`, 0 to 1, rounds up as often as there is a fraction: light below one unit is not lost.
void deposit(ivec2 c, float depth, vec4 light, float chance) {
    if (any(lessThan(c, ivec2(0))) || any(greaterThanEqual(c, ivec2(view.pixels)))) return;
    uint pixel = uint(c.y) * view.pixels.x + uint(c.x);
    if (depth < scene_depth[pixel]) return;  // behind the scene
    float way = 0.0;
    if (light.a > 0.0) {  // as much of its colour as it takes of the way
        float covers = min(light.a, 0.9995);
        way = -log(1.0 - covers);
        light.rgb *= way / covers;
    }
    splat_add(pixel, uvec4(max(vec4(light.rgb, way), 0.0) * SPLAT_ONE + chance * vec4(vec3(1.0), way > 0.0)));
}

// Where |a x + b| <= 1.
vec2 within(float a, float b) {
    if (abs(a) < 1e-12) return abs(b) <= 1.0 ? vec2(-1e9, 1e9) : vec2(1.0, -1.0);
    vec2 ends = vec2((-1.0 - b) / a, (1.0 - b) / a);
    return a > 0.0 ? ends : ends.yx;
}

void main() {
    // In rows: no device allows fewer than 65535 workgroups a dimension, and some no more.
    uint i = gl_GlobalInvocationID.y * (gl_NumWorkGroups.x * gl_WorkGroupSize.x) + gl_GlobalInvocationID.x;
    Sprite sprite;
    if (!sprite_of(i, sprite)) return;
    vec4 clip = view.clip_from_world * vec4(sprite.at_m, 1.0);
    if (!(clip.w > clip.z)) return;  // before the near plane, or not a number
    float depth = clip.z / clip.w, chance = float((i * 2654435769u) >> 8u) * (1.0 / 16777216.0);

    // Pixels from pixels, y down; axes by the derivative of the projection.
    vec2 scale = 0.5 * vec2(view.pixels) * vec2(1.0, -1.0);
    vec2 centre = (clip.xy / clip.w) * scale + 0.5 * vec2(view.pixels);
    Placed placed = place(sprite, 0.0);
    vec4 right = view.clip_from_world * vec4(placed.right_m, 0.0), up = view.clip_from_world * vec4(placed.up_m, 0.0);
    vec2 right_px = scale * (right.xy - clip.xy / clip.w * right.w) / clip.w;
    vec2 up_px = scale * (up.xy - clip.xy / clip.w * up.w) / clip.w;
    float reach = max(length(right_px), length(up_px));
    if (any(lessThan(centre, vec2(-reach - 2.0))) || any(greaterThan(centre, vec2(view.pixels) + reach + 2.0))) return;

    if (min(length(right_px), length(up_px)) < 0.5) {  // thinner than a pixel: all of it to those along its length
        float area = abs(right_px.x * up_px.y - right_px.y * up_px.x);
        float whole = area * (PI / 3.0 + (placed.stretch - 1.0) * (32.0 / 15.0)) / placed.stretch;
        vec2 along_px = length(up_px) > length(right_px) ? up_px : right_px;
        float many = min(ceil(2.0 * max(abs(along_px.x), abs(along_px.y))), float(view.pixels.x + view.pixels.y));
        for (float k = 0.5; k < many; k += 1.0) {
            deposit(ivec2(floor(centre + along_px * (2.0 * k / many - 1.0))), depth, placed.color * (whole / many), chance);
        }
        return;
    }
    placed = place(sprite, LEAST_PX);  // the quad that sprites_vert.glsl draws
    right = view.clip_from_world * vec4(placed.right_m, 0.0);
    up = view.clip_from_world * vec4(placed.up_m, 0.0);
    right_px = scale * (right.xy - clip.xy / clip.w * right.w) / clip.w;
    up_px = scale * (up.xy - clip.xy / clip.w * up.w) / clip.w;
    float det = right_px.x * up_px.y - right_px.y * up_px.x;
    if (abs(det) < 1e-9) return;
    mat2 at_of_px = mat2(up_px.y, -right_px.y, -up_px.x, right_px.x) / det;
    float high = abs(right_px.y) + abs(up_px.y);
    int first = max(int(ceil(centre.y - high - 0.5)), 0), last = min(int(floor(centre.y + high - 0.5)), int(view.pixels.y) - 1);
    for (int y = first; y <= last; ++y) {
        float dy = float(y) + 0.5 - centre.y;
        vec2 one = within(at_of_px[0].x, at_of_px[1].x * dy), other = within(at_of_px[0].y, at_of_px[1].y * dy);
        vec2 span = vec2(max(one.x, other.x), min(one.y, other.y)) + centre.x - 0.5;
        int from = max(int(ceil(span.x)), 0), to = min(int(floor(span.y)), int(view.pixels.x) - 1);
        for (int x = from; x <= to; ++x) {
            vec2 at = at_of_px * vec2(float(x) + 0.5 - centre.x, dy);
            float weight = soft_disc(at, placed.stretch);
            if (weight > 0.0) deposit(ivec2(x, y), depth, placed.color * weight, chance);
        }
    }
}
