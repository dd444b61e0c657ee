// Calls `meet(k)` with every disk of the nine bins round `at_m`.

void walk(uint i, vec2 at_m) {
    ivec2 c = cell_of(at_m), lo = max(c - 1, ivec2(0)), hi = min(c + 1, box_cells() - 1);
    for (int y = lo.y; y <= hi.y; ++y) {
        for (int x = lo.x; x <= hi.x; ++x) {
            for (uint k = head[cell_index(ivec2(x, y))]; k != NONE; k = next[k]) {
                if (k != i) meet(k);
            }
        }
    }
}
