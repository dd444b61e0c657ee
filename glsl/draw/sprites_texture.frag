#version 460
#extension GL_GOOGLE_include_directive : require
#define TEXTURE
#include "draw/view.glsl"
#include "draw/sprite.glsl"
#include "draw/sprites_frag.glsl"
