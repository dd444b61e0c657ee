#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/sprite.glsl"
#include "ballistic/effect.glsl"
#include "ballistic/dust.glsl"
#include "ballistic/sprite.glsl"
#include "draw/sprites_vert.glsl"
