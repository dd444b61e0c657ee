// The box round the boxes of a workgroup of 64, in shared memory.
#ifndef PAINT_BOXES_GLSL
#define PAINT_BOXES_GLSL

const float FARTHEST = 3.0e38;

shared vec3 lows[64];
shared vec3 highs[64];
shared uint covers[64];

void join(uint with, inout vec3 low, inout vec3 high, inout uint covered) {
    low = min(low, lows[with]);
    high = max(high, highs[with]);
    covered += covers[with];
}

// True for the first invocation, which has the result in all three. Eights, then the eight of them: two barriers.
bool join_all(inout vec3 low, inout vec3 high, inout uint covered) {
    uint lane = gl_LocalInvocationIndex;
    lows[lane] = low;
    highs[lane] = high;
    covers[lane] = covered;
    barrier();
    if ((lane & 7u) == 0u) {
        for (uint k = 1u; k < 8u; ++k) join(lane + k, low, high, covered);
        lows[lane] = low;
        highs[lane] = high;
        covers[lane] = covered;
    }
    barrier();
    if (lane != 0u) return false;
    for (uint k = 8u; k < 64u; k += 8u) join(k, low, high, covered);
    return true;
}

#endif
