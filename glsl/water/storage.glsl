// Four columns of a row as memory holds them: floats, or with HALVES half as many bytes, rounded to 11 bits. What is
// computed is computed in floats.
#ifdef HALVES
#define FOUR uvec2
vec4 floats_of(uvec2 four) { return vec4(unpackHalf2x16(four.x), unpackHalf2x16(four.y)); }
uvec2 stored(vec4 four) { return uvec2(packHalf2x16(four.xy), packHalf2x16(four.zw)); }
#else
#define FOUR vec4
vec4 floats_of(vec4 four) { return four; }
vec4 stored(vec4 four) { return four; }
#endif
