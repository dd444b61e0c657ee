#version 460
#extension GL_GOOGLE_include_directive : require
#define SHADOW_BINDING 0
#define SHADOW_CASTER
#define BALLS_BINDING 1
#include "draw/shadow.glsl"
#include "particles/balls.glsl"

// The outline of a ball as the sun sees it, at the depth of its middle.

layout(location = 0) out vec2 corner;

void main() {
    Particle particle;
    gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
    if (!ball_of(particle, corner)) return;
    vec3 across = shadow.right.xyz * corner.x + shadow.up.xyz * corner.y;
    gl_Position = vec4(shadow_place(particle.at_m + p.color.w * across), 1.0);
}
