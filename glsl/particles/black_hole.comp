#version 460
#extension GL_GOOGLE_include_directive : require
#include "particles/black_hole.glsl"
#include "particles/advance.glsl"
