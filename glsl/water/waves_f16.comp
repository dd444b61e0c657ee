#version 460
#extension GL_GOOGLE_include_directive : require

// The same with heights and velocities stored as halves, 8 bytes a column: a preview.
#define HALVES
#include "water/waves_pass.glsl"
