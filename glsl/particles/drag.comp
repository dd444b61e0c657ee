#version 460
#extension GL_GOOGLE_include_directive : require
#include "particles/drag.glsl"
#include "particles/advance.glsl"
