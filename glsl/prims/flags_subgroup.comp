#version 460
#extension GL_GOOGLE_include_directive : require
#define SUBGROUPS
#define FLAGS
#include "prims/reduce.glsl"
