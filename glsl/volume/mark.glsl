// Marks a cell that the triangle overlaps: of several, the triangle nearest to the centre of the cell stays.
layout(set = 0, binding = MARK_KEYS, std430) buffer FirstKeys { uint first_keys[]; };  // one a cell

const float FARTHEST = 0.875;  // from the centre of a cell to what overlaps it: sqrt(3) / 2 and the slack (cells)

void mark(uint t, ivec3 cell) {
    if (!overlaps(cell)) return;
    vec3 from_a = vec3(cell) + 0.5 - tri_a;
    vec2 shares = nearest_shares(from_a);
    uint key = key_of(length(from_a - shares.x * tri_ab - shares.y * tri_ac) / FARTHEST, t);
    uint i = cell_index(p.grid, cell);
    // Keys only fall, so that one read late is one too high: at worst it lets pass what the atomic then refuses.
    if (key < first_keys[i]) atomicMin(first_keys[i], key);
}
