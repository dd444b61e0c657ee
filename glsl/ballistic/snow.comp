#version 460
#extension GL_GOOGLE_include_directive : require
#define GROUND_BINDING 1
#include "ballistic/effect.glsl"
#include "ballistic/snow.glsl"
#include "ballistic/materialise.glsl"
