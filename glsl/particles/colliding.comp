#version 460
#extension GL_GOOGLE_include_directive : require
#include "particles/colliding.glsl"
#include "particles/advance.glsl"
