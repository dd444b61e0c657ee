#version 460
#extension GL_GOOGLE_include_directive : require
#include "ballistic/effect.glsl"
#include "ballistic/dust.glsl"
#include "ballistic/materialise.glsl"
