#version 460
#extension GL_GOOGLE_include_directive : require
#define SUBGROUPS
#include "prims/scan.glsl"
