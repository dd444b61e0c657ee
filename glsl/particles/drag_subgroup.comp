#version 460
#extension GL_GOOGLE_include_directive : require
#define SUBGROUPS
#include "particles/drag.glsl"
#include "particles/advance.glsl"
