#version 460
#extension GL_GOOGLE_include_directive : require
#define KINDLED_BINDING 1
#include "ballistic/effect.glsl"
#include "ballistic/dust.glsl"
#include "ballistic/materialise.glsl"
