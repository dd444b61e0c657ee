#version 460
#extension GL_GOOGLE_include_directive : require
// How many cells lie between a corner of cells and the nearest occupied one, the greatest of the three axes counting, as far as
// `reach`: four bits for the least corner of each cell. A particle whose way in a step does not come out of that many needs no
// other look. (Of a cell's middle it would tell less: most ways are in two cells of an axis.) Axis by axis: along x from the bits of
// `Occupied`, then the least, over the cells along y and z, of the greater of how far they are and what they have. Behind
// them four words a cell: its extents, which are copied so that a sweep has all it looks up in one buffer, and which planes are met
// in it, its own and those it lacks and a cell beside it has. Last a word a corner: how far away the nearest cell is once more,
// and the slab in which all lies that is felt round it. An invocation has the eight cells of a word, but a single one where
// planes are looked at: that takes long for a few.
// CPU twin: particles::cpu_near::near.
#define CELLS_OCCUPIED 0
#define CELLS_PLANES 1
#include "cells/cells.glsl"
#include "particles/cell_bits.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint axis = 0u;  // 3: planes, 4: slabs of eight cells, 5: slabs of all

layout(set = 0, binding = 2, std430) readonly buffer Extents { uint extents[]; };  // three a cell
layout(set = 0, binding = 3, std430) readonly buffer From { uint from[]; };  // of the axes before
layout(set = 0, binding = 4, std430) writeonly buffer Near { uint near[]; };

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

// Number k of the planes that may be met in a cell, seen from there. Not there: `triangle` is 0.
Plane plane_met(ivec3 cell, uint k) {
    ivec3 stored = cell_of_met(cell, k);
    Plane plane;
    plane.triangle = 0u;
    if (!in_box(stored) || !is_occupied(index_of(stored))) return plane;
    return seen_from(plane_of(index_of(stored), k & 1u), stored, cell, p.cell_m);
}

// Numbers of the planes that are met in an occupied cell, as bits: its own, and where something lies off both, those of the cells beside
// it that are like neither.
uint met_in(ivec3 cell) {
    uint i = index_of(cell);
    Plane one = plane_of(i, 0u), two = plane_of(i, 1u);
    if (two.triangle == 0u) return 1u;
    uint met = 3u;
    if (extents[3u * i + 2u] == 0u) return met;
    for (uint k = 2u; k < 14u; ++k) {
        Plane lent = plane_met(cell, k);
        if (lent.triangle == 0u || !is_missing(lent, one, two, p.cell_m)) continue;
        bool is_new = true;
        for (uint bits = met & ~3u; bits != 0u && is_new; bits &= bits - 1u)
            is_new = !is_alike(lent, plane_met(cell, uint(findLSB(bits))), p.cell_m);
        if (is_new) met |= 1u << k;
    }
    return met;
}

// A plane where it is felt within a cell of a corner, in cells from there.
struct Felt {
    vec3 normal;
    float distance;  // of the middle of the box from the plane, along the normal
    vec3 middle;     // of the box in which it is felt
    vec3 half_size;
};

// What is met in an occupied cell, for the corner of cells `corner`: planes of no extent there are left out.
Met met_round(ivec3 corner, ivec3 cell) {
    uint word = (p.cells_x * p.cells_y * p.cells_z + 7u) / 8u + 4u * index_of(cell);
    Met met = Met(uvec3(from[word], from[word + 1u], from[word + 2u]), from[word + 3u]);
    met.extents.x |= met.extents.y | met.extents.z;  // METHOD_ONE feels it there: one word is for both methods
    // Of cells that the corner is none of, only what reaches beyond them.
    ivec3 away = cell - corner;
    uvec3 bins = uvec3(away.x < -1 ? 0x200u : away.x > 0 ? 0x1u : 0x3ffu, away.y < -1 ? 0x200u : away.y > 0 ? 0x1u : 0x3ffu,
                       away.z < -1 ? 0x200u : away.z > 0 ? 0x1u : 0x3ffu);
    return met_where(met, bins.x | bins.y << 10u | bins.z << 20u);
}

// Whether plane `k` of those that are met in a cell is felt within a cell of a corner.
bool is_felt_round(ivec3 corner, ivec3 cell, uint k, uint extent, out Felt felt) {
    vec3 from_low, from_high, centre = vec3(cell - corner) + 0.5;
    bounds_of_extent(extent, from_low, from_high);
    precise vec3 low = max(from_low - 2.0 * RIM, -1.0 - centre);
    precise vec3 high = min(from_high + 2.0 * RIM, 1.0 - centre);
    if (any(greaterThan(low, high))) return false;
    Plane plane = plane_met(cell, k);
    precise vec3 middle = 0.5 * (low + high);
    precise vec3 half_size = 0.5 * (high - low);
    precise float distance = dotted(plane.normal, middle) + plane.distance_m / p.cell_m;
    precise vec3 from_corner = centre + middle;
    felt = Felt(plane.normal, distance, from_corner, half_size);
    return abs(distance) <= dotted(abs(plane.normal), half_size) + RIM;
}

// The 64 cells round a corner, x counting fastest, then y.
ivec3 cell_round(ivec3 corner, uint which) { return corner - 2 + ivec3(which & 3u, which >> 2u & 3u, which >> 4u); }

const uvec2 OWN = uvec2(0x06600000u, 0x00000660u);  // the eight that the corner is one of
const uint OWN_ROWS = 0x660u;

// Those that are occupied, as bits.
uvec2 occupied_round(ivec3 corner) {
    uvec2 cells = uvec2(0u);
    int first = max(corner.x - 2, 0), count = min(corner.x + 2, int(p.cells_x)) - first;
    for (uint row = 0u; row < 16u; ++row) {
        if (axis == 4u && (OWN_ROWS >> row & 1u) == 0u) continue;
        ivec3 cell = ivec3(first, cell_round(corner, 4u * row).yz);
        if (!in_box(cell)) continue;
        uint bits = occupied_bits(index_of(cell), uint(count)) << (4u * (row & 7u) + uint(first - corner.x + 2));
        if (row < 8u) cells.x |= bits;
        else cells.y |= bits;
    }
    return cells;
}

uint take_lowest(inout uvec2 bits) {
    uint at = uint(bits.x != 0u ? findLSB(bits.x) : 32 + findLSB(bits.y));
    bits = bits.x != 0u ? uvec2(bits.x & (bits.x - 1u), bits.y) : uvec2(0u, bits.y & (bits.y - 1u));
    return at;
}

// The slab in which all lies that is felt within a cell of a corner: `flies_freely` in collide_look.glsl. That may be of any of the 64
// cells around, as planes are felt an eighth of a cell beyond theirs; of the corner's own eight alone it is found in about half the time,
// and who asks must keep that eighth away. Its normal is the mean of what the corner's own eight have, or
// all where those have nothing. How far a plane goes along it: n.y over all y in a box of half sizes h round the origin with m.y = -d
// is at most -l d + h.|n - l m|, whatever l is; n.m is a good one.
uint slab_round(ivec3 corner) {
    uvec2 cells = occupied_round(corner), own = cells & OWN;
    if (axis == 4u) cells = own;
    vec3 sum = vec3(0.0);
    for (uvec2 rest = own != uvec2(0u) ? own : cells; rest != uvec2(0u);) {
        ivec3 cell = cell_round(corner, take_lowest(rest));
        Met met = met_round(corner, cell);
        for (uint bits = met.planes; bits != 0u; bits &= bits - 1u) {
            vec3 m = plane_met(cell, uint(findLSB(bits))).normal;
            precise vec3 next = sum + (dotted(sum, m) < 0.0 ? -m : m);
            sum = next;
        }
    }
    uint packed = slab_normal(sum);
    vec3 n = normal_of_slab(packed);
    float least = 2.0, most = -2.0;
    while (cells != uvec2(0u)) {
        ivec3 cell = cell_round(corner, take_lowest(cells));
        Met met = met_round(corner, cell);
        for (uint bits = met.planes; bits != 0u; bits &= bits - 1u) {
            uint k = uint(findLSB(bits));
            Felt felt;
            if (!is_felt_round(corner, cell, k, extent_of_met(met, k), felt)) continue;
            precise float along = dotted(n, felt.normal);
            vec3 rest = abs(n - felt.normal * along);
            precise float spread = dotted(rest, felt.half_size);
            precise float middle = dotted(n, felt.middle) - along * felt.distance;
            least = min(least, middle - spread);
            most = max(most, middle + spread);
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

// Where planes are looked at, each workgroup has a brick of 4 x 4 x 4 cells: what takes long lies on surfaces, and they fill bricks
// as they do not fill rows.
ivec3 cell_in_brick(uint group) {
    uvec3 bricks = (uvec3(p.cells_x, p.cells_y, p.cells_z) + 3u) / 4u;
    uvec3 brick = uvec3(group % bricks.x, group / bricks.x % bricks.y, group / bricks.x / bricks.y);
    uint lane = gl_LocalInvocationIndex;
    return ivec3(4u * brick + uvec3(lane & 3u, lane >> 2u & 3u, lane >> 4u));
}

void main() {
    uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
    uint count = p.cells_x * p.cells_y * p.cells_z, words = (count + 7u) / 8u;
    if (axis >= 3u) {
        ivec3 cell = cell_in_brick(group);
        if (!in_box(cell)) return;
        uint at = index_of(cell);
        if (axis == 3u) {
            bool has = is_occupied(at);
            for (uint k = 0u; k < 3u; ++k) near[words + 4u * at + k] = has ? extents[3u * at + k] : 0u;
            near[words + 4u * at + 3u] = has ? met_in(cell) : 0u;
        } else {
            uint gap = from[at >> 3u] >> (4u * (at & 7u)) & 15u;
            bool is_of_all = axis == 5u;
            uint slab = gap < (is_of_all ? 2u : 1u) ? slab_round(cell) : NO_SLAB;
            near[words + 4u * count + at] = slab | (gap > 1u ? gap : is_of_all ? 1u : 0u);
        }
        return;
    }
    uint at = 64u * group + gl_LocalInvocationIndex;
    if (at >= words) return;
    uint gaps = 0u;
    if (axis == 0u) {
        for (uint b = 0u; b < 8u && 8u * at + b < count; ++b) gaps |= gap_in_row(8u * at + b) << (4u * b);
    } else {
        gaps = gaps_across(at, count);
    }
    near[at] = gaps;
}
