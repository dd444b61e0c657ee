#version 460
#extension GL_GOOGLE_include_directive : require

// Waves on water of even depth, one step a dispatch, 16 bytes a column: heights and velocities as floats.
#include "water/waves_pass.glsl"
