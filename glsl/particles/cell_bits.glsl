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

// Planes that are met in a cell, by number: 0 and 1 are its own, then come two each of the cells beside it: -x, +x, -y, +y,
// -z, +z. The cell that plane `k` is stored in, in slot k & 1.
ivec3 cell_of_met(ivec3 cell, uint k) {
    if (k < 2u) return cell;
    uint face = (k >> 1u) - 1u;
    ivec3 beside = cell;
    beside[face >> 1u] += (face & 1u) == 0u ? -1 : 1;
    return beside;
}

// Whether a cell that holds `one` and `two` lacks `lent`, which the cell beside it has: it is like neither, and goes through.
bool is_missing(Plane lent, Plane one, Plane two, uint face, float cell_m) {
    if (is_alike(lent, one) || is_alike(lent, two)) return false;
    vec3 n = abs(lent.normal);
    precise float away = lent.distance_m + lent.normal[face >> 1u] * ((face & 1u) == 0u ? cell_m : -cell_m);
    precise float half_m = ((n.x + n.y) + n.z) * (0.501 * cell_m);
    return abs(away) <= half_m;
}
