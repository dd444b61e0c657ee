#version 460
#extension GL_GOOGLE_include_directive : require
#define SPLATS_PACKED
#include "draw/view.glsl"
#include "draw/splats.glsl"
#include "draw/splat_over.glsl"
