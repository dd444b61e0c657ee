#version 460
// Sends each triangle to the slice of its instance, with its plane: for devices on which vertex shaders cannot choose the
// layer. As in AdvancedParticles (DirectX SDK, 2007).
#include "volume/triangle.glsl"
#include "volume/slices.glsl"
#include "volume/slices_cut.glsl"

layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;

layout(location = 0) in vec3 from_at_m[];
layout(location = 1) in vec3 from_velocity_mps[];
layout(location = 2) flat in int from_slice[];

layout(location = 0) flat out vec3 to_normal;
layout(location = 1) flat out vec3 to_a_m;
layout(location = 2) out vec3 to_velocity_mps;
layout(location = 3) flat out uint to_triangle;
layout(location = 4) flat out int to_slice;

out gl_PerVertex {
    vec4 gl_Position;
    float gl_ClipDistance[2];
};

void main() {
    if (set_triangle(from_at_m[0], from_at_m[1], from_at_m[2]) != SOUND) return;
    for (int k = 0; k < 3; ++k) {
        vec3 place = tri_a + (k == 0 ? vec3(0.0) : k == 1 ? tri_ab : tri_ac);
        vec2 distances = slice_distances(place, from_slice[0]);
        gl_Position = slice_position(place);
        gl_ClipDistance[0] = distances.x;
        gl_ClipDistance[1] = distances.y;
        gl_Layer = from_slice[0];
        to_normal = tri_normal;
        to_a_m = tri_a_m;
        to_velocity_mps = from_velocity_mps[k];
        to_triangle = uint(gl_PrimitiveIDIn);
        to_slice = from_slice[0];
        EmitVertex();
    }
    EndPrimitive();
}
