#version 460
#extension GL_GOOGLE_include_directive : require
#define LAW_BINDING 4
#define LAW_CONSTANT 4
#define LAW_BLOCKS 5
#include "particles/colliding.glsl"
#include "particles/advance_deferred.glsl"
