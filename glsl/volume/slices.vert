#version 460
// The scene into a volume: everything is drawn once for each slice, and each instance goes to its own (AdvancedParticles,
// DirectX SDK, 2007, "Populating the Volume Texture"; there the geometry shader says which, `volume.slices_world` here). The
// vertex pulls its whole triangle, as the plane is of all three corners.
#extension GL_ARB_shader_viewport_layer_array : require
#include "volume/triangle.glsl"
#include "volume/slices.glsl"
#include "volume/slices_cut.glsl"

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
    uint t = uint(gl_VertexIndex) / 3u, k = uint(gl_VertexIndex) % 3u;
    bool is_sound = load_triangle(t) == SOUND;
    vec3 place = tri_a + (k == 0u ? vec3(0.0) : k == 1u ? tri_ab : tri_ac);
    vec2 distances = slice_distances(place, gl_InstanceIndex);
    gl_Position = is_sound ? slice_position(place) : vec4(0.0, 0.0, -1.0, 1.0);  // else nowhere
    gl_ClipDistance[0] = is_sound ? distances.x : -1.0;
    gl_ClipDistance[1] = is_sound ? distances.y : -1.0;
    gl_Layer = gl_InstanceIndex;
    to_normal = tri_normal;
    to_a_m = tri_a_m;
    to_velocity_mps = corner_mps(tri_corners[k]);
    to_triangle = t;
    to_slice = gl_InstanceIndex;
}
