// The box round the boxes of a workgroup of 64, in shared memory.
#ifndef PAINT_BOXES_GLSL
#define PAINT_BOXES_GLSL

const float FARTHEST = 3.0e38;

shared vec3 lows[64];
shared vec3 highs[64];
shared uint covers[64];

// True for the first invocation, which has the result in all three.
bool join(inout vec3 low, inout vec3 high, inout uint covered) {
    uint lane = gl_LocalInvocationIndex;
    lows[lane] = low;
    highs[lane] = high;
    covers[lane] = covered;
    barrier();
    for (uint half_way = 32u; half_way > 0u; half_way >>= 1u) {
        if (lane < half_way) {
            lows[lane] = min(lows[lane], lows[lane + half_way]);
            highs[lane] = max(highs[lane], highs[lane + half_way]);
            covers[lane] += covers[lane + half_way];
        }
        barrier();
    }
    low = lows[0];
    high = highs[0];
    covered = covers[0];
    return lane == 0u;
}

#endif
