#version 460
#extension GL_GOOGLE_include_directive : require

// The same with heights and velocities stored as halves: a preview, rounded once a dispatch.
#define HALVES
#include "water/fused_pass.glsl"
