#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "water/surface.glsl"
#define HEIGHT(c) or_rest(surface_sample(c))
#include "water/wire.glsl"
