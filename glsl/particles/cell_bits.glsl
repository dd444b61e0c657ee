// Bits of up to 32 cells in a row, the first lowest. They lie in one word or two.
uint occupied_bits(uint first, uint count) {
    uint word = first >> 5u, shift = first & 31u;
    uint bits = occupied[word] >> shift;
    if (shift + count > 32u) bits |= occupied[word + 1u] << (32u - shift);
    return count < 32u ? bits & ((1u << count) - 1u) : bits;
}
