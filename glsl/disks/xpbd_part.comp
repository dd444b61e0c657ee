#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

// disks/xpbd_part.glsl, of disks.
#define DIMENSIONS 2
#include "disks/xpbd_part.glsl"
