#version 460
#extension GL_GOOGLE_include_directive : require
#define FLAGS
#include "prims/reduce.glsl"
