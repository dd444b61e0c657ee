#version 460
#extension GL_GOOGLE_include_directive : require
#define EFFECT_BINDING 2
#define GROUND_BINDING 3
#include "ballistic/effect.glsl"
#include "ballistic/rain.glsl"
#include "ballistic/land.glsl"
