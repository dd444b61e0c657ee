#version 460
#extension GL_GOOGLE_include_directive : require

// disks/gather.glsl, of disks.
#define DIMENSIONS 2
#include "disks/gather.glsl"
