#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "water/surface.glsl"
#include "water/depth_surface.glsl"
#define HEIGHT(c) drawn_height(c, column_at(c))
#include "water/wire.glsl"
