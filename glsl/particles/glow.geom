#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/sprite.glsl"
#include "particles/glow.glsl"
#include "draw/sprites_geom.glsl"
