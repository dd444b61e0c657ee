// Counts and arguments of a pool.
#ifndef STATE_GLSL
#define STATE_GLSL

#ifndef POOL_BINDING
#define POOL_BINDING 0
#endif
#ifndef POOL_ACCESS
#define POOL_ACCESS readonly
#endif

// Written on the GPU and read there. Mirrors `particles::PoolState`.
struct PoolState {
    uint groups_x;  // indirect dispatch of the advance
    uint groups_y;
    uint groups_z;
    uint slots;          // in use, from `first` on; in some a particle has ended
    uint quad_vertices;  // indirect draw of six vertices a slot: `gl_VertexIndex / 6` is the slot
    uint quad_instances;
    uint quad_first_vertex;
    uint quad_first_instance;
    uint point_vertices;  // indirect draw of one vertex a slot
    uint point_instances;
    uint point_first_vertex;
    uint point_first_instance;
    uint reader_groups_x;  // indirect dispatch of workgroups of 256, an invocation a slot
    uint reader_groups_y;
    uint reader_groups_z;
    uint first;        // slot of the first: not 0 in a ring
    uint capacity;     // most particles
    uint stride;       // words from one plane to the next
    uint now;          // tick that the particles are at
    uint life_ticks;   // of every particle: who is as old has ended
    uint sources;      // slots that this step reads
    uint births;       // of this step
    uint appended;     // slots written in this step by those who count them as they go
    uint free_first;   // queue of free slots: where it begins, after this step has taken
    uint free_count;   // its length
    uint taken;        // by the births of this step
    uint turn;         // which third of the counts of tiles this step reads: it counts in the next
    uint finished;     // workgroups of this step
    uint born;         // since the start: low words, then high words
    uint dropped;      // births for which there was no room
    uint aged;         // ends by age
    uint ended;        // ends by the law
    uint spoiled;      // ends because a number was none
    uint born_high;
    uint dropped_high;
    uint aged_high;
    uint ended_high;
    uint spoiled_high;
};

layout(set = 0, binding = POOL_BINDING, std430) POOL_ACCESS buffer Pool { PoolState pool; };

#endif
