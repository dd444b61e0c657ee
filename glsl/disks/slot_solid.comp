#version 460
#extension GL_GOOGLE_include_directive : require

// disks/slot.glsl, of spheres.
#define DIMENSIONS 3
#include "disks/slot.glsl"
