// Marks a cell that the triangle overlaps: of several, the triangle nearest to the centre of the cell stays.
layout(set = 0, binding = MARK_KEYS, std430) buffer FirstKeys { uint first_keys[]; };  // one a cell

const float FARTHEST = 0.875;  // from the centre of a cell to what overlaps it: sqrt(3) / 2 and the slack (cells)

void mark(uint t, ivec3 cell) {
    uint i = cell_index(p.grid, cell);
    vec3 from_a = vec3(cell) + 0.5 - tri_a;
    // Keys only fall, so that one read late is one too high: at worst it lets pass what the atomic then refuses.
    uint before = first_keys[i];
    // No point of a triangle is nearer than its plane: where many meet in a cell, that is all that most are asked. A normal is
    // off by what edges are rounded by, and by more the flatter the corner between them.
    float off = tri_slack + 9.5367431640625e-7 * (largest(tri_ab) + largest(tri_ac) + 2.0) / tri_sine;
    if (key_of((abs(precise_dot(tri_normal, from_a)) - off) / FARTHEST, 0u) > before) return;
    if (!overlaps(cell)) return;
    vec2 shares = nearest_shares(from_a);
    uint key = key_of(length(from_a - shares.x * tri_ab - shares.y * tri_ac) / FARTHEST, t);
    if (key < before) atomicMin(first_keys[i], key);
}
