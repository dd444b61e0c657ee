#version 460
#extension GL_GOOGLE_include_directive : require
// How many cells lie between a corner of cells and the nearest occupied one, the greatest of the three axes counting, as far as
// `reach`: four bits for the least corner of each cell. A particle whose way in a step does not come out of that many needs no
// other look. (Of a cell's middle it would tell less: most ways are in two cells of an axis.) Axis by axis: along x from the bits of
// `Occupied`, then the least, over the cells along y and z, of the greater of how far they are and what they have. Behind
// them two words a cell: which planes are met in it, its own and those it lacks and a cell beside it has, and where they
// end. Last a word a corner: how far away the nearest cell is once more, and the slab in which all lies that is met round it. An
// invocation has the eight cells of a word, but a single one where planes are looked at: that takes long for a few.
// CPU twin: particles::cpu_near::near.
#define CELLS_OCCUPIED 0
#define CELLS_PLANES 1
#include "cells/cells.glsl"
#include "particles/cell_bits.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint axis = 0u;  // 3: planes, 4: slabs

layout(set = 0, binding = 2, std430) readonly buffer From { uint from[]; };  // of the axes before
layout(set = 0, binding = 3, std430) writeonly buffer Near { uint near[]; };

// Mirrors `particles::NearParams`.
struct NearParams {
    uint cells_x;
    uint cells_y;
    uint cells_z;
    uint reach;  // cells, at most 14
    float cell_m;
};
layout(push_constant, std430) uniform Push { NearParams p; };

bool in_box(ivec3 cell) {
    return all(greaterThanEqual(cell, ivec3(0))) && all(lessThan(cell, ivec3(p.cells_x, p.cells_y, p.cells_z)));
}

uint index_of(ivec3 cell) { return uint(cell.x) + p.cells_x * (uint(cell.y) + p.cells_y * uint(cell.z)); }

ivec3 cell_at(uint i) { return ivec3(i % p.cells_x, i / p.cells_x % p.cells_y, i / p.cells_x / p.cells_y); }

const float OFF = 0.1;  // cells: planes that are alike and no farther apart are of one surface; nearer to one is on neither side

// Bits of the planes met in a cell that is full: its own, and of those beside it what is like none that it has.
uint met_in(ivec3 cell, Plane one, Plane two) {
    uint met = 3u;
    for (uint k = 2u; k < 14u; ++k) {
        ivec3 beside = cell_of_met(cell, k);
        if (!in_box(beside) || !is_occupied(index_of(beside))) continue;
        Plane lent = plane_of(index_of(beside), k & 1u);
        if (lent.triangle == 0u || !is_missing(lent, one, two, (k >> 1u) - 1u, p.cell_m)) continue;
        bool is_new = true;
        for (uint bits = met & ~3u; bits != 0u && is_new; bits &= bits - 1u) {
            uint other = uint(findLSB(bits));
            is_new = !is_alike(lent, plane_of(index_of(cell_of_met(cell, other)), other & 1u));
        }
        if (is_new) met |= 1u << k;
    }
    return met;
}

// The point of a plane that is nearest to the middle of its cell, as far as that reaches.
vec3 foot_in_cell(Plane plane, vec3 middle_m) {
    precise vec3 foot = middle_m - plane.normal * plane.distance_m;
    return min(max(foot, middle_m - 0.5 * p.cell_m), middle_m + 0.5 * p.cell_m);
}

float over(Plane plane, vec3 from_centre_m) {
    precise float sum = dotted(plane.normal, from_centre_m) + plane.distance_m;
    return sum;
}

// Whether `there`, of the cell round `middle_m`, is of one surface with `plane`, of the cell round `from_m`.
bool is_same(Plane there, vec3 middle_m, Plane plane, vec3 from_m) {
    if (there.triangle == 0u || !is_alike(there, plane)) return false;
    precise vec3 foot = foot_in_cell(there, middle_m) - from_m;
    return abs(over(plane, foot)) <= OFF * p.cell_m;
}

// Where the surface of plane k is seen, in this cell and those around it: bits 0 and 1 behind and before `one`, 2 and 3 `two`.
// In bits from 4 on, how often.
uint seen_of(ivec3 cell, uint k, Plane one, Plane two) {
    ivec3 stored = cell_of_met(cell, k);
    Plane own = plane_of(index_of(stored), k & 1u);
    precise vec3 from = vec3(stored - cell) * p.cell_m;
    float edge = OFF * p.cell_m;
    uint seen = 0u;
    for (uint n = 0u; n < 27u; ++n) {
        ivec3 by = ivec3(n % 3u, n / 3u % 3u, n / 9u) - 1;
        if (!in_box(cell + by) || !is_occupied(index_of(cell + by))) continue;
        precise vec3 middle = vec3(by) * p.cell_m;
        Plane a = plane_of(index_of(cell + by), 0u), b = plane_of(index_of(cell + by), 1u);
        // Where the two meet in that cell as well, its middle does not say which part of it is there.
        uint says = (is_same(a, middle, one, vec3(0.0)) || is_same(b, middle, one, vec3(0.0)) ? 0u : 3u)
                  | (is_same(a, middle, two, vec3(0.0)) || is_same(b, middle, two, vec3(0.0)) ? 0u : 12u);
        for (uint slot = 0u; slot < 2u; ++slot) {
            Plane there = slot == 0u ? a : b;
            if (!is_same(there, middle, own, from)) continue;
            vec3 foot = foot_in_cell(there, middle);
            float of_one = over(one, foot), of_two = over(two, foot);
            uint sides = (of_one < -edge ? 1u : of_one > edge ? 2u : 0u) | (of_two < -edge ? 4u : of_two > edge ? 8u : 0u);
            seen = (seen + 16u) | (sides & says);
        }
    }
    return seen;
}

// Two bits of two: 3, on both sides, says no more than 0.
uint side_of(uint bits) { return (bits & 3u) == 3u ? 0u : bits & 3u; }

uvec2 known_of(ivec3 cell) {
    uint i = index_of(cell);
    Plane one = plane_of(i, 0u), two = plane_of(i, 1u);
    if (two.triangle == 0u) return ONLY_ONE;
    uvec2 known = uvec2(0u);
    for (uint bits = met_in(cell, one, two); bits != 0u; bits &= bits - 1u) {
        uint k = uint(findLSB(bits)), seen = seen_of(cell, k, one, two);
        uint sides = side_of(seen) | side_of(seen >> 2u) << 2u;
        if (k == 0u) known.x |= (sides >> 2u) << 12u;
        else if (k == 1u) known.x |= (sides & 3u) << 14u;
        else if (seen >= 32u) {  // what is seen only where it is stored is no surface that goes through this cell
            known.x |= 1u << (k - 2u);
            if (k < 6u) known.x |= sides << (4u * k + 8u);
            else known.y |= sides << (4u * k - 24u);
        }
    }
    return known;
}

// What is met in a cell, as `known` has it: number k, seen from the middle of the cell that meets it.
Plane met_at(ivec3 cell, uint k) {
    ivec3 stored = cell_of_met(cell, k);
    Plane plane = plane_of(index_of(stored), k & 1u);
    precise float away = plane.distance_m + dotted(plane.normal, vec3(cell - stored) * p.cell_m);
    plane.distance_m = away;
    return plane;
}

// The slab in which all lies that is met in the eight cells round a corner: `flies_freely` in collide_look.glsl. Its normal is the
// mean of the planes'. How far a plane goes along it, no farther than its cell: n.y over all y with m.y = -d and |y| <= h is
// at most -l d + h |n - l m| (norm 1), whatever l is; n.m is a good one.
uint slab_round(ivec3 corner) {
    uint words = (p.cells_x * p.cells_y * p.cells_z + 7u) / 8u;
    vec3 sum = vec3(0.0), n = vec3(0.0);
    float least = 2.0, most = -2.0;
    uint packed = 0u;
    for (uint pass = 0u; pass < 2u; ++pass) {
        for (uint c = 0u; c < 8u; ++c) {
            ivec3 cell = corner - ivec3(c & 1u, c >> 1u & 1u, c >> 2u);
            if (!in_box(cell) || !is_occupied(index_of(cell))) continue;
            uvec2 known = uvec2(from[words + 2u * index_of(cell)], from[words + 2u * index_of(cell) + 1u]);
            for (uint bits = met_of(known); bits != 0u; bits &= bits - 1u) {
                Plane met = met_at(cell, uint(findLSB(bits)));
                if (pass == 0u) {
                    precise vec3 next = sum + (dotted(sum, met.normal) < 0.0 ? -met.normal : met.normal);
                    sum = next;
                    continue;
                }
                precise float along = dotted(n, met.normal);
                vec3 rest = abs(n - met.normal * along);
                precise float spread = (0.5 + 2.0 * RIM) * ((rest.x + rest.y) + rest.z);
                precise float middle = dotted(n, vec3(cell - corner) + 0.5) - along * met.distance_m / p.cell_m;
                least = min(least, middle - spread);
                most = max(most, middle + spread);
            }
        }
        if (pass == 0u) {
            packed = slab_normal(sum);
            n = normal_of_slab(packed);
        }
    }
    return packed | slab_bounds(least, most);
}

// Along x, of the least corner of a cell: that and those after it are on one side, those before it on the other.
uint gap_in_row(uint i) {
    uint x = i % p.cells_x, back = min(x, p.reach + 1u), ahead = min(p.cells_x - 1u - x, p.reach);
    uint bits = occupied_bits(i - back, back + 1u + ahead);
    uint before = bits & ((1u << back) - 1u), after = bits >> back;
    uint gap = p.reach + 1u;
    if (before != 0u) gap = min(gap, back - 1u - uint(findMSB(before)));
    if (after != 0u) gap = min(gap, uint(findLSB(after)));
    return gap;
}

// Of the eight cells from `first` on, which may begin anywhere.
uint gaps_from(uint first) {
    uint word = first >> 3u, shift = 4u * (first & 7u);
    uint gaps = from[word] >> shift;
    if (shift > 0u) gaps |= from[word + 1u] << (32u - shift);
    return gaps;
}

// Along y or z, of the eight cells of a word.
uint gaps_across(uint word, uint count) {
    uint stride = axis == 1u ? p.cells_x : p.cells_x * p.cells_y;
    int most = int(axis == 1u ? p.cells_y : p.cells_z);
    int place[8];
    for (uint b = 0u; b < 8u; ++b) place[b] = int(axis == 1u ? (8u * word + b) / p.cells_x % p.cells_y
                                                             : (8u * word + b) / p.cells_x / p.cells_y);
    uint gaps = from[word];
    for (int away = 0; away <= int(p.reach); ++away) {
        for (int side = away == 0 ? -1 : 1; side >= -1; side -= 2) {
            // The first cell before the corner is as near as that behind it.
            int by = side > 0 ? away : -1 - away, first = int(8u * word) + by * int(stride);
            if (first <= -8 || first >= int(count)) continue;
            // What lies before the first cell is asked of no cell: the place of each is looked at.
            uint there = first < 0 ? gaps_from(0u) << uint(-4 * first) : gaps_from(uint(first));
            uint least = 0u;
            for (uint b = 0u; b < 8u; ++b) {
                uint own = gaps >> (4u * b) & 15u, other = max(there >> (4u * b) & 15u, uint(away));
                int at = place[b] + by;
                least |= (at >= 0 && at < most ? min(own, other) : own) << (4u * b);
            }
            gaps = least;
        }
    }
    return gaps;
}

void main() {
    uint at = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    uint count = p.cells_x * p.cells_y * p.cells_z, words = (count + 7u) / 8u;
    if (axis == 3u) {
        if (at >= count) return;
        uvec2 known = is_occupied(at) ? known_of(cell_at(at)) : uvec2(0u);
        near[words + 2u * at] = known.x;
        near[words + 2u * at + 1u] = known.y;
        return;
    }
    if (axis == 4u) {
        if (at >= count) return;
        uint gap = from[at >> 3u] >> (4u * (at & 7u)) & 15u;
        near[words + 2u * count + at] = gap == 0u ? slab_round(cell_at(at)) : NO_SLAB | gap;
        return;
    }
    if (at >= words) return;
    uint gaps = 0u;
    if (axis == 0u) {
        for (uint b = 0u; b < 8u && 8u * at + b < count; ++b) gaps |= gap_in_row(8u * at + b) << (4u * b);
    } else {
        gaps = gaps_across(at, count);
    }
    near[at] = gaps;
}
