// What every water kernel shares. `WaterParams` mirrors `water::Params`; tests/gpu.rs compares the two.
#include "water/land.glsl"

struct WaterParams {
    uvec2 cells;      // size of the grid
    uint pitch;       // cells from one row to the next
    float dt_s;       // step (s)
    float pull;       // c^2 dt / (dx^2 (1 + 2 w)) exp(gamma dt / 2), (1/s): what a unit of the stencil's sum adds to the
                      // velocity; the exponential keeps damped waves at their speed, whatever the step
    float keep;       // exp(-gamma dt): share of the flow kept per step, 1 = lossless
    float diagonal;   // w: weight of a diagonal pipe, 1/4 = isotropic, 1 = the book's
    uint folded;      // 1: a diagonal pipe that a wall cuts off is folded onto the pipe along the wall; 0: dropped
};
