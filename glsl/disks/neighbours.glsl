// visit(i, place) calls `meet(k)`, which the pass defines, with every disk k other than i that may touch disk i. Needs
// `start[]`: what comes before a cell, of the disks that are in cells. Three runs of memory replace the nine lists of the
// tutorial, nine the 27 in 3D. CPU twin: disks::cpu::Disks::visit.

layout(constant_id = 2) const bool HAS_LARGE = false;

uint large() { return HAS_LARGE ? p.large : 0u; }

#if DIMENSIONS == 2
const int ROWS = 3;
ivecd row_of(ivecd c, int r) { return ivec2(0, c.y + r - 1); }
bool is_row(ivecd row, ivecd n) { return row.y >= 0 && row.y < n.y; }
#else
const int ROWS = 9;
ivecd row_of(ivecd c, int r) { return ivec3(0, c.y + r % 3 - 1, c.z + r / 3 - 1); }
bool is_row(ivecd row, ivecd n) { return row.y >= 0 && row.y < n.y && row.z >= 0 && row.z < n.z; }
#endif

void meet_run(uint i, uint first, uint last) {
    for (uint k = large() + first; k < large() + last; ++k) {
        if (k != i) meet(k);
    }
}

// The part of a row of cells from `lo` to `hi`, cut at the walls or led round.
void meet_row(uint i, uint row, int lo, int hi) {
    int n = int(p.cells.x);
    bool is_whole = PERIODIC && hi - lo + 1 >= n, is_led_round = PERIODIC && !is_whole;
    if (is_whole) lo = 0, hi = n - 1;
    if (is_led_round && lo < 0) meet_run(i, start[row + uint(lo + n)], start[row + uint(n)]);
    meet_run(i, start[row + uint(max(lo, 0))], start[row + uint(min(hi, n - 1) + 1)]);
    if (is_led_round && hi >= n) meet_run(i, start[row], start[row + uint(hi - n + 1)]);
}

// The cells from lo to hi along an axis of n: how many, and which is the j-th.
int extent(int lo, int hi, int n) {
    return PERIODIC ? min(hi - lo + 1, n) : min(hi, n - 1) - max(lo, 0) + 1;
}
int cell_along(int lo, int hi, int n, int j) {
    int wrapped = hi - lo + 1 >= n ? j : (lo + j + n) % n;
    return PERIODIC ? wrapped : max(lo, 0) + j;
}

void meet_far(uint i, ivecd c, ivecd reach) {
    ivecd n = box_cells(), lo = c - reach, hi = c + reach;
#if DIMENSIONS == 2
    for (int y = 0; y < extent(lo.y, hi.y, n.y); ++y) {
        meet_row(i, cell_index(ivec2(0, cell_along(lo.y, hi.y, n.y, y))), lo.x, hi.x);
    }
#else
    for (int z = 0; z < extent(lo.z, hi.z, n.z); ++z) {
        for (int y = 0; y < extent(lo.y, hi.y, n.y); ++y) {
            ivec3 row = ivec3(0, cell_along(lo.y, hi.y, n.y, y), cell_along(lo.z, hi.z, n.z, z));
            meet_row(i, cell_index(row), lo.x, hi.x);
        }
    }
#endif
}

// The large disks.
void visit_large(uint i) {
    for (uint k = 0u; k < large(); ++k) {
        if (k != i) meet(k);
    }
}

// The disks in cell c and in those round it.
void visit_cells(uint i, ivecd c) {
    ivecd n = box_cells();
    if (PERIODIC && (any(equal(c, ivecd(0))) || any(equal(c, n - 1)))) {
        meet_far(i, c, ivecd(1));
        return;
    }
    // Where runs begin and end is asked for at once, before any of them is walked.
    uvec2 run[ROWS];
    uint lo = uint(max(c.x - 1, 0)), hi = uint(min(c.x + 1, n.x - 1)) + 1u;
    [[unroll]] for (int r = 0; r < ROWS; ++r) {
        ivecd row = row_of(c, r);
        run[r] = uvec2(0u);
        if (is_row(row, n)) {
            uint first = cell_index(row);
            run[r] = uvec2(start[first + lo], start[first + hi]);
        }
    }
    [[unroll]] for (int r = 0; r < ROWS; ++r) meet_run(i, run[r].x, run[r].y);
}

void visit(uint i, vec4 place) {
    visit_large(i);
    ivecd c = cell_of(at_of(place));
    if (HAS_LARGE && i < p.large) {
        meet_far(i, c, ivecd(ceil((radius_of(place) + p.small_m) * cells_per_m())));
    } else {
        visit_cells(i, c);
    }
}
