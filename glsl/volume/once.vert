#version 460
// The scene into a volume in one instance: the fragment finds its slice. Otherwise as `volume.slices.vert`.
#include "volume/triangle.glsl"
#include "volume/slices.glsl"

layout(location = 0) flat out vec3 to_normal;
layout(location = 1) flat out vec3 to_a_m;
layout(location = 2) flat out uint to_triangle;

void main() {
    uint t = uint(gl_VertexIndex) / 3u, k = uint(gl_VertexIndex) % 3u;
    bool is_sound = load_triangle(t) == SOUND;
    vec3 place = tri_a + (k == 0u ? vec3(0.0) : k == 1u ? tri_ab : tri_ac);
    gl_Position = is_sound ? slice_position(place) : vec4(0.0, 0.0, -1.0, 1.0);  // else nowhere
    to_normal = tri_normal;
    to_a_m = tri_a_m;
    to_triangle = t;
}
