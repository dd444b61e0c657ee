#version 460
#extension GL_GOOGLE_include_directive : require
#include "ballistic/effect.glsl"
#include "ballistic/smoke.glsl"
#include "ballistic/materialise.glsl"
