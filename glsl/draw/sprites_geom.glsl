// Sprites as the book draws them: points that a geometry shader takes apart into strips. Only where the device has the
// stage; sprites_vert.glsl draws the same triangles without it. Needs draw/view.glsl, draw/sprite.glsl and an effect.

layout(points) in;
layout(triangle_strip, max_vertices = 4) out;

layout(location = 0) in flat uint number[];
layout(location = 0) out vec2 at;
layout(location = 1) out flat vec4 color;
layout(location = 2) out flat vec2 shape;

const float LEAST_PX = 1.0;

void main() {
    Sprite sprite;
    if (!sprite_of(number[0], sprite)) return;
    Placed placed = place(sprite, LEAST_PX);
    for (uint c = 0u; c < 4u; ++c) {
        at = vec2((c & 1u) == 0u ? -1.0 : 1.0, c < 2u ? -1.0 : 1.0);
        color = placed.color;
        shape = vec2(placed.stretch, sprite.half_m.x);
        gl_Position = view.clip_from_world * vec4(sprite.at_m + at.x * placed.right_m + at.y * placed.up_m, 1.0);
        EmitVertex();
    }
    EndPrimitive();
}
