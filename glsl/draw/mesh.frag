#version 460
#extension GL_GOOGLE_include_directive : require
#include "draw/view.glsl"
#include "draw/shadow.glsl"
#include "draw/mesh_params.glsl"
#include "draw/lit.glsl"
#include "draw/mesh_frag.glsl"
