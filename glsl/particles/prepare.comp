#version 460
#extension GL_GOOGLE_include_directive : require
#include "particles/step.glsl"

// Before every step, one workgroup: how many are born and where they go, what the advance has to do, and what readers
// will find. CPU twin: particles::cpu::Pool::prepare.

layout(local_size_x_id = 0) in;

#define POOL_ACCESS
#include "particles/state.glsl"
#include "particles/args.glsl"
#include "prims/group.glsl"

layout(set = 0, binding = 1, std430) readonly buffer Emitters { Emitter emitters[]; };
layout(set = 0, binding = 2, std430) buffer Births { EmitterState births[]; };
// Stable, ring: how many live in each tile, and (stable) in blocks of tiles.
layout(set = 0, binding = 3, std430) buffer Places { uint places[]; };

#define DEFERRED_BINDING 4
#include "particles/deferred.glsl"

layout(constant_id = 2) const uint tile = 1024u;  // slots that a workgroup of the advance takes

shared uint drawn[256];
shared uint lead;

bool is_before(uvec2 a, uvec2 b) { return a.y < b.y || (a.y == b.y && a.x < b.x); }

uvec2 minus(uvec2 a, uvec2 b) {
    uint borrow, low = usubBorrow(a.x, b.x, borrow);
    return uvec2(low, a.y - b.y - borrow);
}

uvec2 times(uvec2 a, uint n) {
    uint high, low;
    umulExtended(a.x, n, high, low);
    return uvec2(low, high + a.y * n);
}

// floor(a / b), exactly, of fixed-point numbers whose quotient is below 2^31: guesses, and takes what the guess leaves.
uint quotient(uvec2 a, uvec2 b) {
    uint n = 0u;
    float divisor = float(b.y) * 4294967296.0 + float(b.x);
    for (int round = 0; round < 4 && !is_before(a, b); ++round) {
        float guess = (float(a.y) * 4294967296.0 + float(a.x)) / divisor * 0.999999;  // never too much
        uint part = max(uint(guess), 1u);
        n += part;
        a = minus(a, times(b, part));
    }
    while (!is_before(a, b)) {
        a = minus(a, b);
        n += 1u;
    }
    return n;
}

// Batches that an emitter throws up to the end of this step.
uint draw(uint e) {
    uvec2 period = uvec2(emitters[e].period_low, emitters[e].period_high);
    uvec2 next = uvec2(births[e].next_low, births[e].next_high);
    if (period == uvec2(0u)) {  // it begins anew when it is switched on
        births[e].next_low = 0u;
        births[e].next_high = p.now + 1u;
        births[e].births = 0u;
        return 0u;
    }
    uvec2 ahead = minus(uvec2(0u, p.now), next);  // of the end of the step, on a clock that wraps
    uint batches = ahead.y < 0x80000000u ? quotient(ahead, period) + 1u : 0u;
    uint count = batches * emitters[e].batch;
    births[e].from_low = next.x;
    births[e].from_high = next.y;
    births[e].from_serial = births[e].serial;
    births[e].births = count;
    births[e].serial += count;
    uint carry;
    uvec2 on = times(period, batches);
    births[e].next_low = uaddCarry(next.x, on.x, carry);
    births[e].next_high = next.y + on.y + carry;
    return count;
}

void main() {
    uint lane = gl_LocalInvocationIndex, lanes = 256u;
    // Read first, as the rest waits for it: one workgroup has nothing else to do meanwhile.
    uint sources = pool.slots, first = pool.first, turn = next_turn(pool.turn);  // the third that the last step counted in
    uint last_sources = pool.sources;
    uint alive = pool.born - pool.aged - pool.ended - pool.spoiled;  // low words: differences wrap
    uint in_block = compaction == COMPACT_STABLE && lane < most_blocks(tile) ? places[counts_of_blocks(turn, tile) + lane] : 0u;
    uint all;
    uint mine = lane < p.emitters ? draw(lane) : 0u;
    uint before = group_exclusive(mine, all);
    if (lane < p.emitters) births[lane].first = before;

    if (compaction == COMPACT_RING) {  // whole tiles at the beginning in which nobody lives are free again
        uint whole = sources / tile, tiles = p.capacity / tile;
        if (lane == 0u) lead = whole;
        barrier();
        for (uint t = lane; t < whole; t += lanes) {
            if (places[(first / tile + t) % tiles] > 0u) atomicMin(lead, t);
        }
        barrier();
        first += lead * tile;
        if (first >= p.capacity) first -= p.capacity;
        sources -= lead * tile;
    }
    uint room = p.capacity - (compaction == COMPACT_RING ? sources : alive);
    uint taken_in = min(all, room);

    if (compaction == COMPACT_STABLE) {
        // How many survive, or are born, before each block of tiles; the advance adds up the tiles of its own.
        uint all_in = sources + taken_in, span = BLOCK * tile, carried = 0u;
        uint living_blocks = (sources + span - 1u) / span, blocks = (all_in + span - 1u) / span;
        for (uint base = 0u; base < blocks; base += lanes) {
            uint block = base + lane, count = 0u;
            if (block < living_blocks) count = base == 0u ? in_block : places[counts_of_blocks(turn, tile) + block];
            if (block < blocks) {
                count += clamp((block + 1u) * span, sources, all_in) - clamp(block * span, sources, all_in);
            }
            uint total;
            uint to = carried + group_exclusive(count, total);
            if (block < blocks) places[before_blocks(tile) + block] = to;
            carried += total;
        }
        // The blocks of the next third, as far as this step will count in it. Its tiles are clear: each workgroup of the
        // advance clears its own tile of the last third, and those beyond the last workgroup are left to this pass.
        uint counted_blocks = (alive + taken_in + span - 1u) / span;
        for (uint block = lane; block < counted_blocks; block += lanes) {
            places[counts_of_blocks(next_turn(turn), tile) + block] = 0u;
        }
        uint cleared = (all_in + tile - 1u) / tile, last_tiles = (last_sources + tile - 1u) / tile;
        for (uint t = cleared + lane; t < last_tiles; t += lanes) places[counts_of_tiles(last_turn(turn), tile) + t] = 0u;
    }
    if (lane != 0u) return;

    uint taken = compaction == COMPACT_IN_PLACE ? min(taken_in, pool.free_count) : 0u;
    pool.free_first = (pool.free_first + taken) % (2u * p.capacity);  // the queue is a ring: a count would jump where it wraps
    pool.free_count -= taken;
    pool.taken = taken;
    // As many as there is work for if all wait: to count groups together with `count` would be one more atomic a workgroup.
    deferred.groups_x = min((sources + taken_in + DEFERRED_GROUP - 1u) / DEFERRED_GROUP, MOST_DEFERRED_GROUPS);
    deferred.groups_y = deferred.groups_z = 1u;
    deferred.count = 0u;
    pool.first = first;
    pool.sources = sources;
    pool.births = taken_in;
    pool.appended = 0u;
    pool.finished = 0u;
    if (compaction == COMPACT_STABLE) pool.turn = turn;
    pool.capacity = p.capacity;
    pool.stride = p.stride;
    pool.now = p.now;
    pool.life_ticks = p.life_ticks;
    uint carry;
    pool.born = uaddCarry(pool.born, taken_in, carry);
    pool.born_high += carry;
    pool.dropped = uaddCarry(pool.dropped, all - taken_in, carry);
    pool.dropped_high += carry;
    uvec2 groups = groups_of(sources + taken_in - taken, tile);
    pool.groups_x = groups.x;
    pool.groups_y = groups.y;
    pool.groups_z = 1u;
    tell_readers(compaction == COMPACT_STABLE ? alive + taken_in
                                              : compaction == COMPACT_IN_PLACE ? sources + (taken_in - taken)
                                                                               : sources + taken_in);
}
