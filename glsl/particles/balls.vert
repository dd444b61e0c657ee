#version 460
#extension GL_GOOGLE_include_directive : require
#define BALLS_BINDING 3
#include "draw/view.glsl"
#include "particles/balls.glsl"

layout(location = 0) out vec3 at_m;
layout(location = 1) flat out vec4 ball_m;  // centre, radius
layout(location = 2) flat out vec3 albedo;

void main() {
    Particle particle;
    vec2 corner;
    at_m = vec3(0.0);
    ball_m = vec4(0.0);
    albedo = vec3(0.0);
    gl_Position = vec4(0.0, 0.0, 2.0, 1.0);  // beyond the near plane: nobody lives there
    if (!ball_of(particle, corner)) return;
    ball_m = vec4(particle.at_m, p.color.w);
    albedo = mix(p.color.rgb, p.far_color.rgb, random_units(random_bits(7u, 0u, particle.born, 0u)).x);
    vec3 from_eye = particle.at_m - view.eye_m.xyz;
    float far = max(length(from_eye), 1.001 * ball_m.w);
    vec3 ahead = from_eye / far, right = normalize(cross(ahead, normalize(view.ray_up.xyz))), up = cross(right, ahead);
    corner *= ball_m.w * far * inversesqrt(far * far - ball_m.w * ball_m.w);
    at_m = ball_m.xyz + right * corner.x + up * corner.y;
    gl_Position = view.clip_from_world * vec4(at_m, 1.0);
}
