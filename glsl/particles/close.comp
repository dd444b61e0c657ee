#version 460
#extension GL_GOOGLE_include_directive : require

// After an advance that counts its survivors as it goes: tells those who read and draw how many there are.

layout(local_size_x = 1) in;

#define POOL_ACCESS
#include "particles/state.glsl"
#include "particles/args.glsl"

void main() { tell_readers(min(pool.appended, pool.capacity)); }
