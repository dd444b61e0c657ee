#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "disks/draw.glsl"

// Spheres as quads that face the eye, as wide as their outline; the fragment shader finds the sphere.

layout(set = 0, binding = 1, std430) readonly buffer Place { vec4 place_m[]; };
layout(set = 0, binding = 2, std430) readonly buffer Motion { vec4 motion[]; };
layout(set = 0, binding = 3, std430) readonly buffer Hit { uint hit[]; };

layout(location = 0) out vec3 at_m;
layout(location = 1) flat out vec4 sphere_m;  // centre, radius
layout(location = 2) flat out float temperature;

void main() {
    vec4 place = place_m[gl_InstanceIndex];
    sphere_m = vec4(place.xyz + p.origin_m.xyz, place.w);
    temperature = temperature_of(hit[id_of_word(motion[gl_InstanceIndex].w)]);
    vec3 from_eye = sphere_m.xyz - view.eye_m.xyz;
    float far = max(length(from_eye), 1.001 * place.w);
    vec3 ahead = from_eye / far, right = normalize(cross(ahead, normalize(view.ray_up.xyz))), up = cross(right, ahead);
    vec2 corner = corner_of(gl_VertexIndex) * place.w * far * inversesqrt(far * far - place.w * place.w);
    at_m = sphere_m.xyz + right * corner.x + up * corner.y;
    gl_Position = view.clip_from_world * vec4(at_m, 1.0);
}
