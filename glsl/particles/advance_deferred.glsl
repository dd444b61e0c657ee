// Moves those whom a law has put off to where the advance has left room for them, an invocation each: who takes long holds up
// nobody else, and the registers that it needs are not those of the many. Included after the law.
// CPU twin: none of its own, as nothing depends on who is put off.
#include "particles/step.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 2) const uint tile = 1024u;  // slots that a workgroup of the advance takes

#define POOL_ACCESS
#include "particles/state.glsl"
#include "particles/layouts.glsl"
#include "particles/numbers.glsl"
#include "particles/deferred.glsl"

layout(set = 0, binding = 1, std430) writeonly buffer NewParticles { uint new_particles[]; };
layout(set = 0, binding = 2, std430) buffer Places { uint places[]; };

uint law_tick() { return p.now; }
float law_step_s() { return p.dt_s; }
uint slot_now;
uint law_slot() { return slot_now; }

// It lies where it lies, as old as a life, and the next step leaves it out: what its kind of pool knows of it is set right.
void end_at(uint place, bool is_sound, inout Particle it) {
    if (is_sound) {
        if (atomicAdd(pool.ended, 1u) == 0xffffffffu) atomicAdd(pool.ended_high, 1u);
    } else {
        it = Particle(vec3(0.0), vec3(0.0), it.born);  // what is no number is not stored
        if (atomicAdd(pool.spoiled, 1u) == 0xffffffffu) atomicAdd(pool.spoiled_high, 1u);
    }
    it.born = p.now - p.life_ticks;
    if (compaction == COMPACT_STABLE) {
        atomicAdd(places[counts_of_tiles(next_turn(pool.turn), tile) + place / tile], 0xffffffffu);
        atomicAdd(places[counts_of_blocks(next_turn(pool.turn), tile) + place / tile / BLOCK], 0xffffffffu);
    }
    if (compaction == COMPACT_RING) atomicAdd(places[place / tile], 0xffffffffu);
    if (compaction == COMPACT_IN_PLACE) {
        uint free = (pool.free_first + atomicAdd(pool.free_count, 1u)) % (2u * p.capacity);
        it.at_m = vec3(NOWHERE_M, uintBitsToFloat(free), NOWHERE_M);
    }
}

void main() {
    for (uint q = gl_GlobalInvocationID.x; q < deferred.count; q += gl_NumWorkGroups.x * gl_WorkGroupSize.x) {
        uint place;
        float dt_s;
        Particle it = deferred_at(q, place, slot_now, dt_s);
        bool goes_on = advance(it, dt_s);
        bool is_sound = are_numbers(it.at_m) && are_numbers(it.velocity_mps);
        if (!goes_on || !is_sound) end_at(place, is_sound, it);
        [[unroll]] for (uint w = 0u; w < 7u; ++w) {
            if (has_word(w)) new_particles[place_of(w, place)] = word_of(it, w);
        }
    }
}
