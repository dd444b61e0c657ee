#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/shadow.glsl"
#include "draw/lit.glsl"
#include "particles/ball_params.glsl"

// Where the ray of the pixel meets the ball.

layout(location = 0) in vec3 at_m;
layout(location = 1) flat in vec4 ball_m;
layout(location = 2) flat in vec3 albedo;
layout(location = 0) out vec4 color;

void main() {
    vec3 ray = normalize(at_m - view.eye_m.xyz), to_eye = view.eye_m.xyz - ball_m.xyz;
    float b = dot(to_eye, ray), c = dot(to_eye, to_eye) - ball_m.w * ball_m.w, disc = b * b - c;
    if (disc < 0.0) discard;
    vec3 hit_m = view.eye_m.xyz + ray * (-b - sqrt(disc)), n = (hit_m - ball_m.xyz) / ball_m.w;
    vec4 clip = view.clip_from_world * vec4(hit_m, 1.0);
    gl_FragDepth = clip.z / clip.w;
    color = vec4(surface_lit(albedo, p.far_color.w, hit_m, n), 1.0);
}
