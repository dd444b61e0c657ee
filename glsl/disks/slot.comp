#version 460
#extension GL_GOOGLE_include_directive : require

// disks/slot.glsl, of disks.
#define DIMENSIONS 2
#include "disks/slot.glsl"
