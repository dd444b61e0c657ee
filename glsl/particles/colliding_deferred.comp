#version 460
#extension GL_GOOGLE_include_directive : require
#define LAW_BINDING 3
#define LAW_CONSTANT 4
#define LAW_BLOCKS 4
#include "particles/colliding.glsl"
#include "particles/colliding_flight.glsl"
#include "particles/advance_deferred.glsl"
