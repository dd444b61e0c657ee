// Sprites as two triangles each, vertices pulled by their number: draw 6 n vertices once, or 6 vertices n times. Needs
// draw/view.glsl, draw/sprite.glsl and an effect.

layout(location = 0) out vec2 at;            // -1 to 1 over the sprite, y up
layout(location = 1) out flat vec4 color;
layout(location = 2) out flat vec2 shape;    // stretch; half width (m), over which it fades into what it meets

const float LEAST_PX = 1.0;

void main() {
    Sprite sprite;
    uint i = uint(gl_VertexIndex) / 6u + uint(gl_InstanceIndex), corner = uint(gl_VertexIndex) % 6u;
    at = vec2(0.0);
    color = vec4(0.0);
    shape = vec2(1.0, 0.0);
    gl_Position = vec4(0.0, 0.0, 2.0, 1.0);  // beyond the near plane: all three vertices are clipped away
    if (!sprite_of(i, sprite)) return;
    Placed placed = place(sprite, LEAST_PX);
    uint c = corner < 3u ? corner : corner - 2u;  // 0 1 2, 1 2 3
    at = vec2((c & 1u) == 0u ? -1.0 : 1.0, c < 2u ? -1.0 : 1.0);
    color = placed.color;
    shape = vec2(placed.stretch, sprite.half_m.x);
    gl_Position = view.clip_from_world * vec4(sprite.at_m + at.x * placed.right_m + at.y * placed.up_m, 1.0);
}
