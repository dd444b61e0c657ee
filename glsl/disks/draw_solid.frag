#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "disks/draw.glsl"

// Where the ray of the pixel meets the sphere, lit by sun and sky.

layout(location = 0) in vec3 at_m;
layout(location = 1) flat in vec4 sphere_m;
layout(location = 2) flat in float temperature;
layout(location = 0) out vec4 color;

void main() {
    vec3 ray = normalize(at_m - view.eye_m.xyz), to_eye = view.eye_m.xyz - sphere_m.xyz;
    float b = dot(to_eye, ray), c = dot(to_eye, to_eye) - sphere_m.w * sphere_m.w, disc = b * b - c;
    if (disc < 0.0) discard;
    vec3 from_eye = ray * (-b - sqrt(disc)), hit_m = view.eye_m.xyz + from_eye;
    vec3 n = (hit_m - sphere_m.xyz) / sphere_m.w;
    vec4 clip = view.clip_from_world * vec4(hit_m, 1.0);
    gl_FragDepth = clip.z / clip.w;
    vec3 light = SUN_LIGHT * max(dot(n, view.to_sun.xyz), 0.0) + SKY_LIGHT * (0.55 + 0.45 * n.y);
    vec3 shine = SUN_LIGHT * 0.25 * pow(max(dot(reflect(ray, n), view.to_sun.xyz), 0.0), 40.0);
    color = vec4(with_haze(view.daylight * (0.8 * color_of(temperature) * light + shine), from_eye), 1.0);
}
