// What the passes of a step share. Mirrors of `particles::{StepParams, Emitter, EmitterState}`.
#ifndef STEP_GLSL
#define STEP_GLSL

struct StepParams {
    uint now;         // tick at the end of the step
    uint dt_ticks;    // length of the step
    float dt_s;       // the same, as the law has it (s)
    uint life_ticks;  // of every particle
    uint seed;        // of the births
    uint capacity;    // most particles
    uint stride;      // words from one plane to the next
    uint emitters;
};

layout(push_constant, std430) uniform Push { StepParams p; };

// Throws particles from a point that may move.
struct Emitter {
    float at_x_m;  // at the end of the step
    float at_y_m;
    float at_z_m;
    float speed_mps;     // of what it throws, each in a direction of its own
    float velocity_x_mps;  // of the emitter, which its particles keep
    float velocity_y_mps;
    float velocity_z_mps;
    uint period_low;   // from one batch to the next: 2^-32 ticks
    uint period_high;  // ticks; 0 with `period_low` 0: it throws nothing
    uint batch;        // particles thrown at once
    uint corners;      // 1: eight in succession fly towards the corners of a cube, each cube turned at random
    uint stream;       // of random numbers: no other emitter's
};

// Where an emitter is in its series of births. Particle n is born at n periods, whatever the steps are.
struct EmitterState {
    uint next_low;  // when the next batch is born: 2^-32 ticks
    uint next_high;  // tick
    uint serial;     // of its first particle
    uint first;      // births of this step by the emitters before this one
    uint from_low;   // when the first batch of this step is born
    uint from_high;
    uint from_serial;
    uint births;  // of this step, before any is dropped
};

const uint COMPACT_STABLE = 0u;    // survivors keep their order: who ends is left out by the next step
const uint COMPACT_GROUP = 1u;     // survivors of a workgroup go together, one atomic for all
const uint COMPACT_SUBGROUP = 2u;  // one atomic a subgroup
const uint COMPACT_ATOMIC = 3u;    // one atomic a particle, as the book
const uint COMPACT_IN_PLACE = 4u;  // nobody moves; births fill free slots
const uint COMPACT_RING = 5u;      // nobody moves; births go to the end, and the beginning is freed

// Where the counts of a stable pool lie in `places`: living particles of each tile and of each block of tiles, in three
// parts by turns, then how many live in all blocks before each. A step reads one part, counts in the next, and clears the last,
// which the step before it has read.
const uint BLOCK = 256u;  // tiles

uint most_tiles(uint tile) { return (2u * p.capacity + tile - 1u) / tile; }
uint most_blocks(uint tile) { return (most_tiles(tile) + BLOCK - 1u) / BLOCK; }
uint counts_of_tiles(uint turn, uint tile) { return turn * (most_tiles(tile) + most_blocks(tile)); }
uint counts_of_blocks(uint turn, uint tile) { return counts_of_tiles(turn, tile) + most_tiles(tile); }
uint before_blocks(uint tile) { return counts_of_tiles(3u, tile); }
uint next_turn(uint turn) { return (turn + 1u) % 3u; }
uint last_turn(uint turn) { return (turn + 2u) % 3u; }

layout(constant_id = 1) const uint compaction = COMPACT_STABLE;

#endif
