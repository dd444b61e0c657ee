#version 460
#extension GL_GOOGLE_include_directive : require
#define KINDLED_BINDING 1
#include "ballistic/effect.glsl"
#include "ballistic/sparks.glsl"
#include "ballistic/materialise.glsl"
