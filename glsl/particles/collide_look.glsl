// Whether anything is near the way of a particle: one look at `near`.

const float RIM = 1.0e-3;  // of a cell: cells are closed, and feet on a face of theirs are rounded

vec3 moved(vec3 at_m, vec3 velocity_mps, vec3 pull_mps2, float after_s) {
    precise vec3 to = at_m + (velocity_mps * after_s + pull_mps2 * (0.5 * after_s * after_s));
    return to;
}

// When the step's leg begins whose `left_s` is left, in the time of the cells.
float elapsed_at(float left_s) {
    precise float elapsed = (law_step_s() - left_s) - law.lead_s;
    return elapsed;
}

// What a plane may reach beyond its cell: the particle's radius, and what the surface moves from where the cells have it.
float padding_m(float left_s, float elapsed_s) {
    precise float most_s = max(abs(elapsed_s), abs(elapsed_s + left_s));
    precise float pad = ((law.radius_m + law.slack_m) + RIM * law.grid.cell_m) + law.surface_mps * most_s;
    return pad;
}

// Cells of the grid, and the corner of cells that is nearest to their middle. None: `first` is beyond `last`.
struct Box {
    ivec3 first;
    ivec3 last;
    ivec3 corner;
};

// Those that the way between two places, `pad_m` wide, touches.
Box box_of(vec3 from_m, vec3 to_m, vec3 pad_m) {
    precise vec3 low = min(from_m, to_m) - pad_m;
    precise vec3 high = max(from_m, to_m) + pad_m;
    vec3 most = vec3(grid_cells(law.grid));
    vec3 from = clamp(cell_place(law.grid, low), vec3(0.0), most), to = clamp(cell_place(law.grid, high), vec3(-1.0), most);
    ivec3 first = ivec3(floor(from)), last = min(ivec3(floor(to)), grid_cells(law.grid) - 1);
    precise vec3 middle = 0.5 * (from + to) + 0.5;
    return Box(first, last, clamp(ivec3(floor(middle)), ivec3(0), grid_cells(law.grid) - 1));
}

// By how many cells the box may move before it can touch an occupied one; below 0: it touches one, or so it seems.
int room_of(Box box) {
    if (any(greaterThan(box.first, box.last))) return 0;
    ivec3 out_of = max(box.corner - box.first, box.last + 1 - box.corner);
    return gap_at(cell_index(law.grid, box.corner)) - max(max(out_of.x, out_of.y), out_of.z);
}

// Whether nothing can be in the way of a particle that goes to `to_m`: one look at `near`.
bool flies_freely(vec3 from_m, vec3 to_m, vec3 pull_mps2, float dt_s) {
    precise vec3 pad = vec3(padding_m(dt_s, elapsed_at(dt_s))) + abs(pull_mps2) * (0.125 * dt_s * dt_s);
    return room_of(box_of(from_m, to_m, pad)) >= 0;
}
