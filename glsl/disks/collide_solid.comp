#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

// disks/collide.glsl, of spheres.
#define DIMENSIONS 3
#include "disks/collide.glsl"
