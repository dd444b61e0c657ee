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

const float ALIKE = 0.985;  // cosine of 10 degrees: nearer planes count as one, as `cells` has it

bool is_alike(Plane one, Plane other) { return abs(dotted(one.normal, other.normal)) > ALIKE; }

// Unit; a component that is picked by a variable would be one in memory.
uvec3 axis_of(uint face) { return uvec3(face < 2u, face >> 1u == 1u, face >= 4u); }

// Planes that are met in a cell, by number: 0 and 1 are its own, then come two each of the cells beside it: -x, +x, -y, +y,
// -z, +z. The cell that plane `k` is stored in, in slot k & 1.
ivec3 cell_of_met(ivec3 cell, uint k) {
    if (k < 2u) return cell;
    uint face = (k >> 1u) - 1u;
    return cell + ivec3(axis_of(face)) * ((face & 1u) == 0u ? -1 : 1);
}

// Whether a cell that holds `one` and `two` lacks `lent`, which the cell beside it has: it is like neither, and goes through.
bool is_missing(Plane lent, Plane one, Plane two, uint face, float cell_m) {
    if (is_alike(lent, one) || is_alike(lent, two)) return false;
    vec3 n = abs(lent.normal);
    precise float away = lent.distance_m + dotted(lent.normal, vec3(axis_of(face))) * ((face & 1u) == 0u ? cell_m : -cell_m);
    precise float half_m = ((n.x + n.y) + n.z) * (0.501 * cell_m);
    return abs(away) <= half_m;
}

// Of a cell with two planes, two words: which planes are met beside its own, and of each on which side of those two it goes on
// round about. Who touches it on the other side touches nothing: a plane ends where it meets another at an edge, and only
// the cells around tell where that is.
//     x    bits 0 to 11: plane 2 + bit is met; 12, 13: where 0 is of 1, 3 if there is no plane 1; 14, 15: where 1 is of 0;
//          from 16 on four bits each: where 2 to 5 are, of 0 and of 1
//     y    likewise, 6 to 13
const uint IS_BEHIND = 1u;
const uint IS_BEFORE = 2u;  // neither: on both sides, or it is not known
const uvec2 ONLY_ONE = uvec2(3u << 12u, 0u);

// Numbers of the planes, as bits.
uint met_of(uvec2 known) { return (known.x & 0xfffu) << 2u | ((known.x >> 12u & 3u) == 3u ? 1u : 3u); }

// Where plane k goes on: of plane 0 in the low two bits, of plane 1 in the next.
uint sides_of(uvec2 known, uint k) {
    if (k == 0u) return (known.x >> 12u & 3u) == 3u ? 0u : (known.x >> 12u & 3u) << 2u;
    if (k == 1u) return known.x >> 14u & 3u;
    return (k < 6u ? known.x >> (4u * k + 8u) : known.y >> (4u * k - 24u)) & 15u;
}

const float RIM = 1.0e-3;  // of a cell: cells are closed, and feet on a face of theirs are rounded

// A slab round a corner of cells, in a word: its normal, scaled so that |x| + |y| + z = 1 and z >= 0, as x + y and x - y; and between
// what it lies along that, in cells from the corner.
//     bits 0 to 3: how many cells lie between the corner and the nearest occupied one
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

// What lies round a corner is no farther than 1 along the normal.
uint slab_bounds(float least, float most) {
    int low = int(floor(SLAB_STEPS * clamp(least, -1.01, 1.0))), high = int(ceil(SLAB_STEPS * clamp(most, -1.0, 1.01)));
    return (uint(low) & 127u) << 18u | uint(high) << 25u;
}

#ifdef NEAR_BINDING
// What `particles.near` has found. First four bits for the least corner of each cell: how many cells lie between it and the
// nearest occupied one, the greatest of the three axes counting; one more than was looked at if there is none. Then what is
// known of the planes of each cell, and the slab round each of those corners.
layout(set = 0, binding = NEAR_BINDING, std430) readonly buffer Near { uint near[]; };

int gap_at(uint corner) { return int(near[corner >> 3u] >> (4u * (corner & 7u)) & 15u); }

uvec2 known_at(Grid grid, uint cell) {
    uint from = (grid.cells_x * grid.cells_y * grid.cells_z + 7u) / 8u + 2u * cell;
    return uvec2(near[from], near[from + 1u]);
}

uint slab_at(Grid grid, uint corner) {
    uint count = grid.cells_x * grid.cells_y * grid.cells_z;
    return near[(count + 7u) / 8u + 2u * count + corner];
}
#endif
