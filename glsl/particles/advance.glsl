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

shared uint gone[marks];              // a bit for each slot of the tile whose particle is not written
shared uint gone_before[marks + 1u];  // set bits in the words before
shared uint base;                     // where the first goes
shared uint counted[group];           // living particles of tiles before this one, in parts
shared uint tiles_before;             // their sum
shared uint staged[2u * tile];
shared uint aged, ended, spoiled, low_count, high_count;

Particle born_at(uint j, out float left_s) {
    uint e = 0u;
    while (e + 1u < p.emitters && j >= births[e + 1u].first) ++e;
    return birth_of(emitters[e], births[e], j - births[e].first, left_s);
}

// Adds up the bits of `gone`, once every invocation has set its own, and `counted`: short sums, which all make at once.
void rank_tile() {
    barrier();
    const uint runs = (marks + 3u) / 4u;  // of four words
    for (uint i = gl_LocalInvocationIndex; i < marks * runs; i += group) {
        uint upto = i / runs + 1u, first = 4u * (i % runs), sum = 0u;
        [[unroll]] for (uint q = 0u; q < 4u; ++q) {
            if (first + q < upto) sum += bitCount(gone[first + q]);
        }
        if (sum > 0u) atomicAdd(gone_before[upto], sum);
    }
    const uint parts = 32u;
    uint part = group - 1u - gl_LocalInvocationIndex;  // by the last, as the first have the bits
    if (compaction == COMPACT_STABLE && part < parts) {
        uint sum = 0u;
        [[unroll]] for (uint k = 0u; k < (group + parts - 1u) / parts; ++k) {
            if (k * parts + part < group) sum += counted[k * parts + part];
        }
        if (sum > 0u) atomicAdd(tiles_before, sum);
    }
    barrier();
}

// How many are written.
uint written() { return tile - gone_before[marks]; }

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

uint slot_of(uint v) {
    if (compaction != COMPACT_RING) return v;
    uint slot = v + pool.first;
    return slot >= p.capacity ? slot - p.capacity : slot;
}

// Place of a free slot in the queue of free slots, from where this step has begun to take them.
uint queued(Particle nobody) {
    uint place = floatBitsToUint(nobody.at_m.y);
    uint first = pool.free_first + (pool.free_first < pool.taken ? 2u * p.capacity : 0u) - pool.taken;
    return place - first + (place < first ? 2u * p.capacity : 0u);
}

// Which birth of the step takes v.
uint birth_in(uint v, Particle holder) {
    bool is_free = compaction == COMPACT_IN_PLACE && v < pool.sources;
    return is_free ? queued(holder) : pool.taken + v - pool.sources;
}

// Word w of the survivors leaves shared memory. Writing starts where a line of 32 words does; a line is no longer than the
// workgroup is wide.
void leave(uint w, uint from, uint to) {
    uint ahead = to & 31u, end = written() + ahead, start = place_of(w, to - ahead);
    [[unroll]] for (uint k = 0u; k <= items; ++k) {
        uint j = k * group + gl_LocalInvocationIndex;
        if (j >= ahead && j < end) new_particles[start + j * (records == LAYOUT_RECORDS ? 7u : 1u)] = staged[from + j - ahead];
    }
}

void main() {
    uint lane = gl_LocalInvocationIndex;
    uint t = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint start = p.now - p.dt_ticks, sources = pool.sources;
    uint all = sources + pool.births - pool.taken, turn = pool.turn;
    if (t * tile >= all) return;  // the whole workgroup

    // Read all first: loads are under way together.
    Particle it[items];
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        uint v = t * tile + k * group + lane;
        if (v < sources) it[k] = load_record(slot_of(v), start);
    }
    uint own = 0u, block = t / BLOCK;
    if (compaction == COMPACT_STABLE) {
        uint end = min(t, (sources + tile - 1u) / tile), counts = counts_of_tiles(turn, tile);
        [[unroll]] for (uint k = 0u; k < (BLOCK + group - 1u) / group; ++k) {
            uint in_block = k * group + lane, one = block * BLOCK + in_block;
            if (in_block < BLOCK && one < end) own += places[counts + one];
        }
    }
    for (uint w = lane; w < marks; w += group) gone[w] = 0u;
    for (uint w = lane; w <= marks; w += group) gone_before[w] = 0u;
    if (lane == 0u) aged = ended = spoiled = low_count = high_count = tiles_before = 0u;
#ifdef LAW_DEFERS
    if (lane == 0u) deferred_count = 0u;
#endif

    bool lives[items];
    bool is_birth[items];
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        uint v = t * tile + k * group + lane;
        is_birth[k] = v >= sources && v < all;
        lives[k] = is_birth[k] || (v < sources && is_alive(it[k].born, start, p.life_ticks));
        if (compaction == COMPACT_IN_PLACE && v < sources && it[k].at_m.x == NOWHERE_M) {
            // Nobody: whoever holds the slot bears what takes it, as nobody else knows when it has been read.
            lives[k] = is_birth[k] = queued(it[k]) < pool.taken;
        }
    }

#ifdef LAW_DEFERS
    // Before ranks are known: what the law must look at is under way meanwhile.
    bool goes_on[items];
    bool waits[items];
    float dt_s[items];
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        slot_now = t * tile + k * group + lane;
        dt_s[k] = p.dt_s;
        if (is_birth[k]) it[k] = born_at(birth_in(slot_now, it[k]), dt_s[k]);
        goes_on[k] = lives[k];
        waits[k] = lives[k] && !advance_at_once(it[k], dt_s[k]) && is_alive(it[k].born, p.now, p.life_ticks)
                && are_numbers(it[k].at_m) && are_numbers(it[k].velocity_mps);
    }
#endif

    // Stable: the place of each is known before it is moved.
    uint to = 0u;
    barrier();
#ifdef LAW_DEFERS
    uint listed[items];
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        if (waits[k]) listed[k] = atomicAdd(deferred_count, 1u);
    }
    if (compaction != COMPACT_STABLE) barrier();
#endif
    if (compaction == COMPACT_STABLE) {
        [[unroll]] for (uint k = 0u; k < items; ++k) {
            uint at = k * group + lane;
            if (!lives[k]) atomicOr(gone[at / 32u], 1u << (at & 31u));
        }
        counted[lane] = own;
        rank_tile();
        // Survivors before the block, those of its tiles before this one, and the births among them.
        to = places[before_blocks(tile) + block] + clamp(t * tile, sources, all) - clamp(block * BLOCK * tile, sources, all);
        to += tiles_before;
    }
#ifdef LAW_DEFERS
    // A list of all workgroups together: each takes room for its own at once.
    uint room = 0u;
    if (lane == group - 1u && deferred_count > 0u) room = atomicAdd(deferred.count, deferred_count);
#else
    bool goes_on[items];
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        slot_now = t * tile + k * group + lane;
        float dt_s = p.dt_s;
        if (is_birth[k]) it[k] = born_at(birth_in(slot_now, it[k]), dt_s);
        goes_on[k] = lives[k] && advance(it[k], dt_s);
    }
#endif

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
                if ((to + rank_of(k * group + lane)) / tile == to / tile) atomicAdd(low_count, 1u);
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
        if (lane == 0u) base = atomicAdd(pool.appended, written());
        barrier();
        to = base;
    }

    bool is_ranked = compaction == COMPACT_STABLE || compaction == COMPACT_GROUP;
    bool is_written[items];
    uint place[items];
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        uint at = k * group + lane, v = t * tile + at;
        is_written[k] = stays[k];
        if (compaction == COMPACT_STABLE) is_written[k] = lives[k];    // who ends is left out by the next step
        if (compaction == COMPACT_IN_PLACE) is_written[k] = lives[k];  // a free slot is written by who is born there
        if (compaction == COMPACT_RING) is_written[k] = v < all;
        place[k] = is_ranked ? rank_of(at) : slot_of(v);
    }
    if (is_ranked && gathers) {
        [[unroll]] for (uint w = 0u; w < 7u; ++w) {
            uint from = (w & 1u) * tile;
            [[unroll]] for (uint k = 0u; k < items; ++k) {
                if (has_word(w) && is_written[k]) staged[from + place[k]] = word_of(it[k], w);
            }
            if (has_word(w)) {
                barrier();
                leave(w, from, to);
            }
        }
        [[unroll]] for (uint k = 0u; k < items; ++k) place[k] += to;
    } else {
        [[unroll]] for (uint k = 0u; k < items; ++k) {
            place[k] += to;
            if (compaction == COMPACT_ATOMIC && stays[k]) place[k] = atomicAdd(pool.appended, 1u);
#ifdef SUBGROUPS
            if (compaction == COMPACT_SUBGROUP) {
                uvec4 votes = subgroupBallot(stays[k]);
                uint first = 0u;
                if (subgroupElect()) first = atomicAdd(pool.appended, subgroupBallotBitCount(votes));
                place[k] = subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(votes);
            }
#endif
            if (is_written[k]) {
                [[unroll]] for (uint w = 0u; w < 7u; ++w) {
                    if (has_word(w)) new_particles[place_of(w, place[k])] = word_of(it[k], w);
                }
            }
        }
    }
#ifdef LAW_DEFERS
    if (lane == group - 1u) deferred_base = room;
    barrier();
    [[unroll]] for (uint k = 0u; k < items; ++k) {
        if (waits[k]) defer(deferred_base + listed[k], place[k], t * tile + k * group + lane, dt_s[k], it[k]);
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
        uint many = written(), low = min(many, tile - to % tile), high = many - low, one = to / tile;
        uint tiles = counts_of_tiles(next_turn(turn), tile), blocks = counts_of_blocks(next_turn(turn), tile);
        places[counts_of_tiles(last_turn(turn), tile) + t] = 0u;  // for the next step to count in
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
