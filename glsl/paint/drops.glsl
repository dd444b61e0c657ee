// What paints: drops, particles as they are or impacts in order, and what each leaves.
#ifndef PAINT_DROPS_GLSL
#define PAINT_DROPS_GLSL
#include "paint/map.glsl"

// Mirrors `paint::Drop`, 16 bytes.
struct Drop {
    vec3 at_m;
    uint source;  // low half: whose paint; high half, of an impact: the mesh that was hit
};

// What a source leaves. Mirrors `paint::Coat`, 32 bytes.
struct Coat {
    vec4 paint;         // colour times opacity, opacity
    float reach_sq_m2;  // of an impact: square of the radius
    uint first_order;   // of an impact: its place in the order is this and its `order`, which is
    uint orders;        // below this
    uint unused;
};

// Mirrors `paint::GatherParams`, 32 bytes.
struct GatherParams {
    uint total;         // drops in the buffer
    uint first;         // of them, `first`, `first + stride` and so on take part
    uint stride;
    uint blocks;
    uint words;         // of a block's mask
    uint coats;
    float reach_sq_m2;  // of a particle: square of the radius
    uint total_at;      // of impacts: the word of `Sums` that says how many
};

// Written on the GPU. Mirrors `paint::Work`, 48 bytes.
struct Work {
    uint drops;    // that take part
    uint sift_x;   // indirect dispatch of `paint.sift`
    uint sift_y;
    uint sift_z;
    uint tiles_x;  // indirect dispatch of `paint.sifted`
    uint touched;  // its y: blocks with a drop near
    uint tiles_z;
    uint lost;     // impacts of no source or of no order; since the start
    uint twice;    // impacts with the order of another; since the start
    uint unused0;
    uint unused1;
    uint unused2;
};

const uint PARTICLES = 0u;
const uint IMPACTS = 1u;
layout(constant_id = 0) const uint kind = PARTICLES;

const uint NO_HOME = 0xffffffffu;

#endif
