// Whether anything is near the way of a particle: one look at `near`.

vec3 moved(vec3 at_m, vec3 velocity_mps, vec3 pull_mps2, float after_s) {
    precise vec3 to = at_m + (velocity_mps * after_s + pull_mps2 * (0.5 * after_s * after_s));
    return to;
}

// When the step's leg begins whose `left_s` is left, in the time of the cells.
float elapsed_at(float left_s) {
    precise float elapsed = (law_step_s() - left_s) - law.lead_s;
    return elapsed;
}

// What a plane may reach beyond its cell: the particle's radius, what of it is felt there, and what the surface moves from where
// the cells have it.
float padding_m(float left_s, float elapsed_s) {
    precise float most_s = max(abs(elapsed_s), abs(elapsed_s + left_s));
    precise float pad = ((law.radius_m + law.slack_m) + BEYOND * law.grid.cell_m) + law.surface_mps * most_s;
    return pad;
}

// Cells of the grid, the corner of cells that is nearest to their middle, and where in them the foot of a particle on a plane can be
// (cells, 2 RIM to spare). None: `first` is beyond `last`.
struct Box {
    ivec3 first;
    ivec3 last;
    ivec3 corner;
    vec3 low, high;
};

// Those that the way between two places, `pad_m` wide, touches.
Box box_of(vec3 from_m, vec3 to_m, vec3 pad_m) {
    precise vec3 low = min(from_m, to_m) - pad_m;
    precise vec3 high = max(from_m, to_m) + pad_m;
    vec3 most = vec3(grid_cells(law.grid));
    vec3 from = clamp(cell_place(law.grid, low), vec3(0.0), most), to = clamp(cell_place(law.grid, high), vec3(-1.0), most);
    ivec3 first = ivec3(floor(from)), last = min(ivec3(floor(to)), grid_cells(law.grid) - 1);
    precise vec3 middle = 0.5 * (from + to) + 0.5;
    ivec3 corner = clamp(ivec3(floor(middle)), ivec3(0), grid_cells(law.grid) - 1);
    float spare = BEYOND - 2.0 * RIM;
    return Box(first, last, corner, cell_place(law.grid, low) + spare, cell_place(law.grid, high) - spare);
}

// By how many cells the box may move before it can touch an occupied one; below 0: it touches one, or so it seems.
int room_of(Box box) {
    if (any(greaterThan(box.first, box.last))) return 0;
    ivec3 out_of = max(box.corner - box.first, box.last + 1 - box.corner);
    return gap_at(cell_index(law.grid, box.corner)) - max(max(out_of.x, out_of.y), out_of.z);
}

// Whether nothing can be in the way of a particle in this step, by one word of the corner of cells that is nearest to the middle of its
// way: no occupied cell is in reach, or the way is on one side of the slab in which all is felt that is felt within a cell of the
// corner. Cells are wider than what they hold: of those near occupied ones, two in three pass by. Both sides are wider than `is_there`
// by 2 RIM, for what is rounded otherwise: who waits for nothing is moved the same.
bool flies_freely(vec3 from_m, vec3 to_m, vec3 pull_mps2) {
    float step_s = law_step_s(), per_m = 1.0 / law.grid.cell_m;
    float most_s = max(law.lead_s, abs(step_s - law.lead_s));
    float pad = ((law.radius_m + law.slack_m) + law.surface_mps * most_s) * per_m + 2.0 * RIM;
    vec3 bulge = abs(pull_mps2) * (0.125 * step_s * step_s * per_m), half_way = 0.5 * (to_m - from_m);
    vec3 place = ((from_m + half_way) - grid_low_m(law.grid)) * per_m;
    vec3 reach = abs(half_way) * per_m + (pad + bulge);
    ivec3 corner = clamp(ivec3(round(place)), ivec3(0), grid_cells(law.grid) - 1);
    vec3 from_corner = place - vec3(corner), out_of = abs(from_corner) + reach;
    float farthest = max(max(out_of.x, out_of.y), out_of.z);
    uint slab = slab_at(law.grid, cell_index(law.grid, corner));
    uint gap = slab & 15u;
    if (gap > 1u && float(gap) > farthest + BEYOND) return true;
    if (farthest + (gap == 0u ? BEYOND : 0.0) < 1.0) {
        vec3 n = normal_of_slab(slab);
        vec2 lies = bounds_of_slab(slab);
        float middle = dot(n, from_corner);
        float along = abs(dot(n, half_way)) * per_m + dot(abs(n), bulge) + pad * length(n);
        return middle - along > lies.y || middle + along < lies.x;
    }
    reach += BEYOND;
    return any(lessThan(place + reach, vec3(0.0))) || any(greaterThan(place - reach, vec3(grid_cells(law.grid))));
}
