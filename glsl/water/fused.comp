#version 460
#extension GL_GOOGLE_include_directive : require

// Waves on water of even depth, several steps a dispatch: heights and velocities as floats.
#include "water/fused_pass.glsl"
