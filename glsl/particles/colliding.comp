#version 460
#extension GL_GOOGLE_include_directive : require
#define LAW_DEFERS
#include "particles/colliding.glsl"
#include "particles/advance.glsl"
