// Layouts of a particle in memory, for the passes that write; readers outside know planes only (particles/pool.glsl).

const uint LAYOUT_PLANES = 0u;   // 7 planes of words, 28 bytes a particle
const uint LAYOUT_PACKED = 1u;   // 5 planes, 20 bytes: position in full, velocity in halves, birth to 2^-6 s
const uint LAYOUT_RECORDS = 2u;  // 7 words side by side, as the book has them

layout(constant_id = 3) const uint records = LAYOUT_PLANES;

bool has_word(uint w) { return w < 5u || records != LAYOUT_PACKED; }

// Where word w of the particle in slot i is.
uint place_of(uint w, uint i) { return records == LAYOUT_RECORDS ? 7u * i + w : w * p.stride + i; }

// Word w of a particle as it is stored. A packed birth is rounded down: nobody is younger than he was, and who has ended
// stays old enough.
uint word_of(Particle it, uint w) {
    if (w < 3u) return floatBitsToUint(it.at_m[w]);
    if (records == LAYOUT_PACKED) {
        return w == 3u ? packHalf2x16(it.velocity_mps.xy)
                       : (packHalf2x16(vec2(it.velocity_mps.z, 0.0)) & 0xffffu) | (it.born >> 10u) << 16u;
    }
    return w < 6u ? floatBitsToUint(it.velocity_mps[w - 3u]) : it.born;
}

#ifdef POOL_GLSL  // for passes that read them
// `now` tells to which of the rounds of a packed birth's 1024 s it belongs.
Particle load_record(uint i, uint now) {
    if (records == LAYOUT_PACKED) {
        uint w[5];
        for (uint k = 0u; k < 5u; ++k) w[k] = particles[place_of(k, i)];
        uint steps = ((now >> 10u) - (w[4] >> 16u)) & 0xffffu;
        return Particle(uintBitsToFloat(uvec3(w[0], w[1], w[2])),
                        vec3(unpackHalf2x16(w[3]), unpackHalf2x16(w[4] & 0xffffu).x), ((now >> 10u) - steps) << 10u);
    }
    uint w[7];
    for (uint k = 0u; k < 7u; ++k) w[k] = particles[place_of(k, i)];
    return particle_of(w);
}
#endif
