// The pass that calls a law, included after it: moves every particle, ends those whose time has come, takes in those that
// are born, and closes the gaps. A workgroup takes a tile of slots, and an invocation `items` of them.
//
// Stable: who lives at the start of the step is known when it is read, and how many live in the tiles before this one is
// what `particles.prepare` added up, so survivors go to their places in one pass, in their order. Who ends in this step is
// written once more, as old as a life, and left out by the next. The others know only at the end who has survived.
// Survivors of a tile are gathered in shared memory, a word at a time, so that they leave in whole lines.
// CPU twin: particles::cpu::Pool::advance.
#include "particles/step.glsl"
#ifdef SUBGROUPS
#extension GL_KHR_shader_subgroup_ballot : require
#endif
#extension GL_EXT_control_flow_attributes : require

layout(local_size_x_id = 0) in;
layout(constant_id = 2) const uint items = 4u;  // slots an invocation
layout(constant_id = 5) const uint group = 256u;  // invocations of a workgroup: constant 0 once more
layout(constant_id = 4) const bool gathers = true;  // survivors of a tile, in shared memory

#define POOL_ACCESS
#include "particles/pool.glsl"
#include "particles/layouts.glsl"
#include "particles/birth.glsl"
#include "particles/args.glsl"
#include "particles/numbers.glsl"
#ifdef LAW_DEFERS
#include "particles/deferred.glsl"
#endif

layout(set = 0, binding = 2, std430) writeonly buffer NewParticles { uint new_particles[]; };
layout(set = 0, binding = 3, std430) readonly buffer Emitters { Emitter emitters[]; };
layout(set = 0, binding = 4, std430) readonly buffer Births { EmitterState births[]; };
// Stable, ring: how many live in each tile, and (stable) in blocks of tiles. In place: nothing, a free slot has its place in
// the queue of free slots for a y.
layout(set = 0, binding = 6, std430) buffer Places { uint places[]; };

const uint tile = group * items;
const uint marks = (tile + 31u) / 32u;

shared uint gone[marks];         // a bit for each slot of the tile whose particle is not written
shared uint gone_before[marks];  // set bits in the words before
shared uint written;             // how many are
shared uint base;                // where the first goes
const uint PARTS = 32u;
shared uint counted[group];  // living particles of tiles before this one, in parts
shared uint parts[PARTS];
shared uint staged[2u * tile];
shared uint aged, ended, spoiled, low_count, high_count;

Particle born_at(uint j, out float left_s) {
    uint e = 0u;
    while (e + 1u < p.emitters && j >= births[e + 1u].first) ++e;
    return birth_of(emitters[e], births[e], j - births[e].first, left_s);
}

// Adds up the bits of `gone`, once every invocation has set its own, and `counted`.
void rank_tile() {
    barrier();
    for (uint part = gl_LocalInvocationIndex; part < PARTS; part += group) {
        uint sum = 0u;
        for (uint k = part; k < group; k += PARTS) sum += counted[k];
        parts[part] = sum;
    }
    for (uint w = gl_LocalInvocationIndex; w < marks; w += group) {
        uint before = 0u;
        for (uint k = 0u; k < marks; ++k) {
            if (k < w) before += bitCount(gone[k]);
        }
        gone_before[w] = before;
        if (w == marks - 1u) written = tile - before - bitCount(gone[w]);
    }
    barrier();
}

// How many are written before the one at `at` in the tile.
uint rank_of(uint at) {
    uint word = at / 32u;
    return at - gone_before[word] - bitCount(gone[word] & ((1u << (at & 31u)) - 1u));
}

#ifdef LAW_DEFERS
shared uint deferred_count, deferred_base;
#endif

uint law_tick() { return p.now; }
float law_step_s() { return p.dt_s; }
uint slot_now;  // set before each call of the law
uint law_slot() { return slot_now; }

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint t = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint sources = pool.sources, all = sources + pool.births - pool.taken;
    if (t * tile >= all) return;  // the whole workgroup
    uint start = p.now - p.dt_ticks;
    for (uint w = lane; w < marks; w += group) gone[w] = 0u;
    if (lane == 0u) aged = ended = spoiled = low_count = high_count = 0u;
#ifdef LAW_DEFERS
    if (lane == 0u) deferred_count = 0u;
#endif

    uint own = 0u, block = t / BLOCK;
    if (compaction == COMPACT_STABLE) {
        uint end = min(t, (sources + tile - 1u) / tile), counts = counts_of_tiles(pool.turn, tile);
        for (uint k = block * BLOCK + lane; k < end; k += group) own += places[counts + k];
    }

    // Read all first: loads are under way together.
    Particle it[items];
    uint slot[items];
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        uint v = t * tile + k * group + lane;
        slot[k] = v;
        if (compaction == COMPACT_RING) {
            slot[k] += pool.first;
            if (slot[k] >= p.capacity) slot[k] -= p.capacity;
        }
        if (v < sources) it[k] = load_record(slot[k], start);
        else it[k] = Particle(vec3(0.0), vec3(0.0), start - p.life_ticks);
    }
    bool lives[items];
    float dt_s[items];
    uint free_first = pool.free_first + (pool.free_first < pool.taken ? 2u * p.capacity : 0u) - pool.taken;  // before this step
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        uint v = t * tile + k * group + lane;
        dt_s[k] = p.dt_s;
        if (v < sources) {
            lives[k] = is_alive(it[k].born, start, p.life_ticks);
            if (compaction == COMPACT_IN_PLACE && it[k].at_m.x == NOWHERE_M) {
                // Nobody: whoever holds the slot bears what takes it, as nobody else knows when it has been read.
                uint place = floatBitsToUint(it[k].at_m.y);
                uint j = place - free_first + (place < free_first ? 2u * p.capacity : 0u);
                lives[k] = j < pool.taken;
                if (lives[k]) it[k] = born_at(j, dt_s[k]);
            }
        } else {
            lives[k] = v < all;
            if (lives[k]) it[k] = born_at(pool.taken + (v - sources), dt_s[k]);
        }
    }

    // Stable: the place of each is known before it is moved.
    uint rank[items];
    uint to = 0u;
    if (compaction == COMPACT_STABLE) {
        barrier();
        [[unroll]] for (uint k = 0u; k < items; ++k) {
            uint at = k * group + lane;
            if (!lives[k]) atomicOr(gone[at / 32u], 1u << (at & 31u));
        }
        counted[lane] = own;
        rank_tile();
        // Survivors before the block, those of its tiles before this one, and the births among them.
        to = places[before_blocks(tile) + block] + clamp(t * tile, sources, all) - clamp(block * BLOCK * tile, sources, all);
        for (uint k = 0u; k < PARTS; ++k) to += parts[k];
        [[unroll]] for (uint k = 0u; k < items; ++k) rank[k] = rank_of(k * group + lane);
    } else {
        barrier();
    }

    bool goes_on[items];
#ifdef LAW_DEFERS
    bool waits[items];
#endif
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        slot_now = t * tile + k * group + lane;
#ifdef LAW_DEFERS
        goes_on[k] = lives[k];
        waits[k] = lives[k] && !advance_at_once(it[k], dt_s[k]);
#else
        goes_on[k] = lives[k] && advance(it[k], dt_s[k]);
#endif
    }

    bool stays[items];
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        stays[k] = lives[k];
        if (!lives[k]) {
            if (compaction == COMPACT_RING) it[k].born = p.now - p.life_ticks;  // it stays old on a clock that wraps
            continue;
        }
        bool is_sound = are_numbers(it[k].at_m) && are_numbers(it[k].velocity_mps);
        bool is_young = is_alive(it[k].born, p.now, p.life_ticks);
        stays[k] = goes_on[k] && is_sound && is_young;
        if (!stays[k]) {
            if (!is_sound) {
                it[k] = Particle(vec3(0.0), vec3(0.0), it[k].born);  // what is no number is not stored
                atomicAdd(spoiled, 1u);
            } else if (!goes_on[k]) {
                atomicAdd(ended, 1u);
            } else {
                atomicAdd(aged, 1u);
            }
            if (is_young) it[k].born = p.now - p.life_ticks;
            if (compaction == COMPACT_STABLE) {
                if ((to + rank[k]) / tile == to / tile) atomicAdd(low_count, 1u);
                else atomicAdd(high_count, 1u);
            }
            if (compaction == COMPACT_IN_PLACE) {
                uint place = (pool.free_first + atomicAdd(pool.free_count, 1u)) % (2u * p.capacity);
                it[k].at_m = vec3(NOWHERE_M, uintBitsToFloat(place), NOWHERE_M);
            }
        }
    }

    if (compaction == COMPACT_GROUP) {
        [[unroll]] for (uint k = 0u; k < items; ++k) {
            uint at = k * group + lane;
            if (!stays[k]) atomicOr(gone[at / 32u], 1u << (at & 31u));
        }
        rank_tile();
        if (lane == 0u) base = atomicAdd(pool.appended, written);
        barrier();
        to = base;
        [[unroll]] for (uint k = 0u; k < items; ++k) rank[k] = rank_of(k * group + lane);
    }

    bool is_ranked = compaction == COMPACT_STABLE || compaction == COMPACT_GROUP;
    if (is_ranked) {
        [[unroll]] for (uint k = 0u; k < items; ++k) {
            if (compaction == COMPACT_STABLE ? !lives[k] : !stays[k]) rank[k] = tile;  // not written
        }
    }
    if (is_ranked && gathers) {
        // Writing starts where a line of 32 words does; a line is no longer than the workgroup is wide.
        uint many = written, ahead = to & 31u;
        [[unroll]] for (uint w = 0u; w < 7u; ++w) {
            if (!has_word(w)) break;
            uint from = (w & 1u) * tile;
            [[unroll]] for (uint k = 0u; k < items; ++k) {
                if (rank[k] < tile) staged[from + rank[k]] = word_of(it[k], w);
            }
            barrier();
            [[unroll]] for (uint k = 0u; k <= items; ++k) {
                uint j = k * group + lane;
                if (j >= ahead && j < many + ahead) new_particles[place_of(w, to - ahead + j)] = staged[from + j - ahead];
            }
        }
    } else {
        [[unroll]] for (uint k = 0u; k < items; ++k) {
            bool is_written = is_ranked ? rank[k] < tile : stays[k];
            uint place = is_ranked ? to + rank[k] : slot[k];
            if (compaction == COMPACT_IN_PLACE) is_written = lives[k];  // a free slot is written by who is born there
            if (compaction == COMPACT_RING) is_written = t * tile + k * group + lane < all;
            if (compaction == COMPACT_ATOMIC && stays[k]) place = atomicAdd(pool.appended, 1u);
#ifdef SUBGROUPS
            if (compaction == COMPACT_SUBGROUP) {
                uvec4 votes = subgroupBallot(stays[k]);
                uint first = 0u;
                if (subgroupElect()) first = atomicAdd(pool.appended, subgroupBallotBitCount(votes));
                place = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(votes);
            }
#endif
            slot[k] = place;
            if (is_written) {
                [[unroll]] for (uint w = 0u; w < 7u; ++w) {
                    if (has_word(w)) new_particles[place_of(w, place)] = word_of(it[k], w);
                }
            }
        }
    }
#ifdef LAW_DEFERS
    // A list of all workgroups together: each takes room for its own at once.
    uint turn[items];
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        if (waits[k] && stays[k]) turn[k] = atomicAdd(deferred_count, 1u);
    }
    barrier();
    if (lane == 0u && deferred_count > 0u) {
        deferred_base = atomicAdd(deferred.count, deferred_count);
        uint groups = (deferred_base + deferred_count + DEFERRED_GROUP - 1u) / DEFERRED_GROUP;
        atomicMax(deferred.groups_x, min(groups, MOST_DEFERRED_GROUPS));
    }
    barrier();
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        if (!waits[k] || !stays[k]) continue;
        uint place = is_ranked && gathers ? to + rank[k] : slot[k];
        deferred.list[deferred_base + turn[k]] = DeferredOne(place, t * tile + k * group + lane, dt_s[k]);
    }
#endif
    if (compaction == COMPACT_RING) {
        uint living = 0u;
        [[unroll]] for (uint k = 0u; k < items; ++k) living += uint(stays[k]);
        if (living > 0u) atomicAdd(low_count, living);
    }

    // What other invocations have appended comes before the word that this workgroup has finished.
    if (compaction == COMPACT_SUBGROUP || compaction == COMPACT_ATOMIC) memoryBarrierBuffer();
    barrier();
    if (lane != 0u) return;
    if (compaction == COMPACT_STABLE) {
        uint low = min(written, tile - to % tile), high = written - low, one = to / tile;
        uint tiles = counts_of_tiles(1u - pool.turn, tile), blocks = counts_of_blocks(1u - pool.turn, tile);
        if (low > 0u) atomicAdd(places[tiles + one], low - low_count);
        if (high > 0u) atomicAdd(places[tiles + one + 1u], high - high_count);
        if (low > 0u) atomicAdd(places[blocks + one / BLOCK], low - low_count);
        if (high > 0u) atomicAdd(places[blocks + (one + 1u) / BLOCK], high - high_count);
    }
    if (compaction == COMPACT_RING) {
        uint tiles = p.capacity / tile;
        places[(pool.first / tile + t) % tiles] = low_count;  // here, those who live: the tile is this workgroup's alone
    }
    if (aged > 0u && atomicAdd(pool.aged, aged) > 0xffffffffu - aged) atomicAdd(pool.aged_high, 1u);
    if (ended > 0u && atomicAdd(pool.ended, ended) > 0xffffffffu - ended) atomicAdd(pool.ended_high, 1u);
    if (spoiled > 0u && atomicAdd(pool.spoiled, spoiled) > 0xffffffffu - spoiled) atomicAdd(pool.spoiled_high, 1u);
    if (compaction >= COMPACT_GROUP && compaction <= COMPACT_ATOMIC) {
        // The last to finish tells those who read and draw how many there are.
        memoryBarrierBuffer();
        if (atomicAdd(pool.finished, 1u) == (all + tile - 1u) / tile - 1u) tell_readers(atomicAdd(pool.appended, 0u));
    }
}
