// Bits of up to 32 cells in a row, the first lowest. They lie in one word or two.
uint occupied_bits(uint first, uint count) {
    uint word = first >> 5u, shift = first & 31u;
    uint bits = occupied[word] >> shift;
    if (shift + count > 32u) bits |= occupied[word + 1u] << (32u - shift);
    return count < 32u ? bits & ((1u << count) - 1u) : bits;
}

float dotted(vec3 a, vec3 b) {
    precise float sum = (a.x * b.x + a.y * b.y) + a.z * b.z;
    return sum;
}

const float ALIKE = 0.985;      // cosine of 10 degrees
const float STANDS_FOR = 0.15;  // cells, as in volume/extend.glsl

// Half of the box in which something of a cell may be felt, as far as extents go, and what is rounded (cells).
const float FELT_HALF = 0.627;
const float BEYOND = 0.126;   // its part beyond the cell
const float RIM = 1.0e-3;     // what may be rounded otherwise elsewhere

// Of planes seen from the same centre: whether one stands for the other there.
bool is_alike(Plane one, Plane other, float cell_m) {
    float cosine = dotted(one.normal, other.normal);
    precise float apart = cosine < 0.0 ? one.distance_m + other.distance_m : one.distance_m - other.distance_m;
    return abs(cosine) > ALIKE && abs(apart) <= STANDS_FOR * cell_m;
}

// Unit; a component that is picked by a variable would be one in memory.
uvec3 axis_of(uint face) { return uvec3(face < 2u, face >> 1u == 1u, face >= 4u); }

// Planes that are met in a cell, by number: 0 and 1 are its own, then come two each of the cells beside it: -x, +x, -y, +y,
// -z, +z. The cell that plane `k` is stored in, in slot k & 1.
ivec3 cell_of_met(ivec3 cell, uint k) {
    if (k < 2u) return cell;
    uint face = (k >> 1u) - 1u;
    return cell + ivec3(axis_of(face)) * ((face & 1u) == 0u ? -1 : 1);
}

// `plane`, stored in a cell, as it is seen from the centre of another.
Plane seen_from(Plane plane, ivec3 stored, ivec3 cell, float cell_m) {
    precise float away = plane.distance_m + dotted(plane.normal, vec3(cell - stored) * cell_m);
    plane.distance_m = away;
    return plane;
}

// Whether a cell that holds `one` and `two` lacks `lent`, seen from there: it is like neither, and goes through.
bool is_missing(Plane lent, Plane one, Plane two, float cell_m) {
    vec3 n = abs(lent.normal);
    precise float half_m = ((n.x + n.y) + n.z) * (FELT_HALF * cell_m);
    return !is_alike(lent, one, cell_m) && !is_alike(lent, two, cell_m) && abs(lent.distance_m) <= half_m;
}

// What a cell has of planes: the extent in which its first is felt, that of its second, that of those that are lent, which are felt
// where it has what neither of its own stands for; and which are met, by number, as bits.
struct Met {
    uvec3 extents;
    uint planes;
};

uint extent_of_met(Met met, uint k) { return k == 0u ? met.extents.x : k == 1u ? met.extents.y : met.extents.z; }

bool has_any(uint extent) { return (extent & 0x3ffu) != 0u && (extent & 0xffc00u) != 0u && (extent >> 20u) != 0u; }

// Of it, what is felt somewhere in an extent.
Met met_where(Met met, uint extent) {
    if (!has_any(met.extents.x & extent)) met.planes &= ~1u;
    if (!has_any(met.extents.y & extent)) met.planes &= ~2u;
    if (!has_any(met.extents.z & extent)) met.planes &= 3u;
    return met;
}

// A slab round a corner of cells, in a word: its normal, scaled so that |x| + |y| + z = 1 and z >= 0, as x + y and x - y; and between
// what it lies along that, in cells from the corner.
//     bits 0 to 3: how many cells lie between the corner and the nearest occupied one, if more than one; else 1 if the slab has all
//         that is felt within a cell of the corner, 0 if only what the eight cells round it have
//     4 to 10, 11 to 17: x + y and x - y, in 1/63
//     18 to 24, 25 to 31: least and most, in 1/62; no slab if the least is more
const float SLAB_SIDES = 63.0;
const float SLAB_STEPS = 62.0;
const uint NO_SLAB = 0x80fc0000u;

vec3 normal_of_slab(uint slab) {
    vec2 sides = vec2(bitfieldExtract(int(slab), 4, 7), bitfieldExtract(int(slab), 11, 7)) / SLAB_SIDES;
    precise float x = 0.5 * (sides.x + sides.y);
    precise float y = 0.5 * (sides.x - sides.y);
    precise float z = (1.0 - abs(x)) - abs(y);
    return vec3(x, y, z);
}

vec2 bounds_of_slab(uint slab) { return vec2(bitfieldExtract(int(slab), 18, 7), int(slab) >> 25) / SLAB_STEPS; }

uint slab_normal(vec3 sum) {
    vec3 up = sum.z < 0.0 ? -sum : sum;
    precise float norm = (abs(up.x) + abs(up.y)) + up.z;
    if (!(norm > 0.0)) return 0u;
    precise vec2 sides = vec2(up.x + up.y, up.x - up.y) / norm;
    ivec2 steps = ivec2(roundEven(SLAB_SIDES * clamp(sides, -1.0, 1.0)));
    return (uint(steps.x) & 127u) << 4u | (uint(steps.y) & 127u) << 11u;
}

// A bound that does not fit is as good as 1: who asks lies within 1 of the corner.
uint slab_bounds(float least, float most) {
    int low = int(floor(SLAB_STEPS * clamp(least, -1.01, 1.0))), high = int(ceil(SLAB_STEPS * clamp(most, -1.0, 1.01)));
    return (uint(low) & 127u) << 18u | uint(high) << 25u;
}

#ifdef NEAR_BINDING
// What `particles.near` has found. First four bits for the least corner of each cell: how many cells lie between it and the
// nearest occupied one, the greatest of the three axes counting; one more than was looked at if there is none. Then of each cell
// its three extents, and the numbers of the planes that are met in it, as bits. Last the slab round each of those corners.
layout(set = 0, binding = NEAR_BINDING, std430) readonly buffer Near { uint near[]; };

int gap_at(uint corner) { return int(near[corner >> 3u] >> (4u * (corner & 7u)) & 15u); }

// Where the four words of a cell are.
uint met_from(Grid grid, uint cell) { return (grid.cells_x * grid.cells_y * grid.cells_z + 7u) / 8u + 4u * cell; }

Met met_of(Grid grid, uint cell) {
    uint word = met_from(grid, cell);
    return Met(uvec3(near[word], near[word + 1u], near[word + 2u]), near[word + 3u]);
}

uint slab_at(Grid grid, uint corner) {
    uint count = grid.cells_x * grid.cells_y * grid.cells_z;
    return near[(count + 7u) / 8u + 4u * count + corner];
}
#endif
