// The first plane that a particle meets on a parabola: pieces of it no longer than a cell, in their order; of each piece the
// cells that its box touches, from the bits of whole rows; of each occupied cell its planes. A plane counts only where the
// foot of the particle on it is in its cell, so planes end with their triangles' cells.

const float NEVER_S = 3.0e38;
const uint MOST_PIECES = 4096u;
const float RIM = 1.0e-3;  // of a cell: cells are closed, and feet on a face of theirs are rounded

struct Hit {
    bool is_any;
    float after_s;      // from the start of the leg
    float distance_m;   // of the particle from the plane then: less than the radius if it came over a rim
    vec3 normal;        // towards the particle
    vec3 velocity_mps;  // of the surface
    uint triangle;
};

vec3 moved(vec3 at_m, vec3 velocity_mps, vec3 pull_mps2, float after_s) {
    precise vec3 to = at_m + (velocity_mps * after_s + pull_mps2 * (0.5 * after_s * after_s));
    return to;
}

// When c + w t + a t^2 / 2 comes down to 0, or at once if it is below and sinks. Written so that nothing cancels.
float fall_s(float c, float w, float a) {
    precise float square = w * w - 2.0 * a * c;
    if (w < 0.0) {
        if (c <= 0.0) return 0.0;
        if (square < 0.0) return NEVER_S;
        precise float down = 2.0 * c / (sqrt(square) - w);
        return down;
    }
    if (!(a < 0.0)) return NEVER_S;
    precise float back = (w + sqrt(max(square, 0.0))) / -a;  // below 0 all along: where it begins to sink
    return back;
}

// How far from the start the leg can lead along each axis.
vec3 farthest(vec3 velocity_mps, vec3 pull_mps2, float left_s) {
    precise vec3 far = abs(velocity_mps) * left_s + abs(pull_mps2) * (0.5 * left_s * left_s);
    return far;
}

// What a plane may reach beyond its cell: the particle's radius, and what the surface moves in the step.
float padding_m(float left_s, float elapsed_s) {
    precise float pad = ((law.radius_m + law.slack_m) + RIM * law.grid.cell_m) + law.surface_mps * (left_s + abs(elapsed_s));
    return pad;
}

// Whether nothing can be in the way: known by a single look at `near`, for all but a few.
bool flies_freely(vec3 at_m, vec3 velocity_mps, vec3 pull_mps2, float dt_s) {
    vec3 far = farthest(velocity_mps, pull_mps2, dt_s);
    precise float most = max(max(far.x, far.y), far.z) + padding_m(dt_s, law.lead_s);
    ivec3 cell = cell_of(law.grid, at_m);
    if (!in_grid(law.grid, cell) || !(most <= float(law.reach) * law.grid.cell_m)) return false;
    uint i = cell_index(law.grid, cell);
    return (near[i >> 5u] >> (i & 31u) & 1u) == 0u;
}

bool is_in_cell(vec3 from_centre_m) {
    return all(lessThanEqual(abs(from_centre_m), vec3((0.5 + RIM) * law.grid.cell_m)));
}

// The plane of the cell with its centre at `centre_m`, where it is felt in the cell at `window_m`. `deep_m` adds up what the
// particle lies in planes at the start, if it is asked for.
void meet(vec3 at_m, vec3 velocity_mps, vec3 pull_mps2, float elapsed_s, Plane plane, vec3 centre_m, vec3 window_m,
          bool asks_deep, inout Hit hit, inout vec3 deep_m) {
    vec3 u = plane.velocity_mps;
    precise vec3 from_centre = at_m - (centre_m + u * elapsed_s);
    precise float along = dotted(plane.normal, from_centre) + plane.distance_m;
    vec3 n = along < 0.0 ? -plane.normal : plane.normal;  // both sides are solid
    float d = abs(along), radius = law.radius_m, slack = law.slack_m;
    precise vec3 seen = velocity_mps - u;
    float w = dotted(n, seen), a = dotted(n, pull_mps2);
    precise vec3 from_window = at_m - (window_m + u * elapsed_s);
    precise float shallow = radius - slack;
    if (asks_deep && d < shallow) {
        precise vec3 foot = from_window - n * d;
        precise float more = (radius - d) - dotted(deep_m, n);
        if (more > 0.0 && is_in_cell(foot)) {
            precise vec3 sum = deep_m + n * more;
            deep_m = sum;
        }
    }
    // How low it comes until the leg ends or something else is hit.
    float until = hit.after_s;
    if (a > 0.0 && w < 0.0) until = min(until, -w / a);
    precise float lowest = d + (w * until + a * (0.5 * until * until));
    precise float deeper = d - 0.1 * slack;
    if (lowest >= (d < shallow ? deeper : shallow)) return;
    // Where it touches; where it is half in, or its centre would go through: over a rim it comes too late to touch.
    for (uint level = 0u; level < 3u; ++level) {
        precise float above = d - radius * (1.0 - 0.5 * float(level));
        float after = fall_s(above, w, a);
        if (!(after < hit.after_s)) return;
        precise float then = d + (w * after + a * (0.5 * after * after));
        precise vec3 foot = (from_window + (seen * after + pull_mps2 * (0.5 * after * after))) - n * then;
        if (!is_in_cell(foot)) continue;
        if (level == 2u) {  // before it, on this side
            after = min(after, fall_s(d - min(slack, d), w, a));
            precise float before = d + (w * after + a * (0.5 * after * after));
            then = before;
        }
        hit.is_any = true;
        hit.after_s = after;
        hit.distance_m = then;
        hit.normal = n;
        hit.velocity_mps = u;
        hit.triangle = plane.triangle;
        return;
    }
}

// Which planes are met in an occupied cell: behind the bits of cells that are near comes half a word for each.
uint met_in(uint cell) {
    if (method != METHOD_TWO) return 1u;
    uint words = (law.grid.cells_x * law.grid.cells_y * law.grid.cells_z + 31u) / 32u;
    return near[words + (cell >> 1u)] >> (16u * (cell & 1u)) & 0xffffu;
}

void meet_cell(vec3 at_m, vec3 velocity_mps, vec3 pull_mps2, float elapsed_s, ivec3 cell, bool asks_deep, inout Hit hit,
               inout vec3 deep_m) {
    vec3 centre = cell_centre_m(law.grid, cell);
    for (uint bits = met_in(cell_index(law.grid, cell)); bits != 0u; bits &= bits - 1u) {
        uint k = uint(findLSB(bits));
        ivec3 stored = cell_of_met(cell, k);
        Plane plane = plane_of(cell_index(law.grid, stored), k & 1u);
        meet(at_m, velocity_mps, pull_mps2, elapsed_s, plane, cell_centre_m(law.grid, stored), centre, asks_deep, hit, deep_m);
    }
}

Hit first_hit(vec3 at_m, vec3 velocity_mps, vec3 pull_mps2, float left_s, float elapsed_s, bool asks_deep, inout vec3 deep_m) {
    Hit hit;
    hit.is_any = false;
    hit.after_s = left_s;
    hit.distance_m = 0.0;
    hit.normal = vec3(0.0);
    hit.velocity_mps = vec3(0.0);
    hit.triangle = 0u;
    vec3 far = farthest(velocity_mps, pull_mps2, left_s);
    precise float cells = max(max(far.x, far.y), far.z) / law.grid.cell_m;
    if (!(cells < NEVER_S)) return hit;  // no number: the pool ends it
    uint pieces = uint(clamp(ceil(cells), 1.0, float(MOST_PIECES)));
    precise float piece_s = left_s / float(pieces);
    precise vec3 pad = vec3(padding_m(left_s, elapsed_s)) + abs(pull_mps2) * (0.125 * piece_s * piece_s);
    vec3 most = vec3(grid_cells(law.grid));
    vec3 to = at_m;
    for (uint piece = 0u; piece < pieces; ++piece) {
        precise float from_s = piece_s * float(piece);
        if (hit.after_s <= from_s) break;
        vec3 from = to;
        precise float to_s = piece_s * float(piece + 1u);
        to = moved(at_m, velocity_mps, pull_mps2, to_s);
        precise vec3 low = min(from, to) - pad;
        precise vec3 high = max(from, to) + pad;
        ivec3 first = ivec3(clamp(floor(cell_place(law.grid, low)), vec3(0.0), most));
        ivec3 last = ivec3(clamp(floor(cell_place(law.grid, high)), vec3(-1.0), most - 1.0));
        if (any(greaterThan(first, last))) continue;
        for (int z = first.z; z <= last.z; ++z) {
            for (int y = first.y; y <= last.y; ++y) {
                for (int x = first.x; x <= last.x; x += 32) {
                    uint count = uint(min(last.x - x + 1, 32));
                    for (uint bits = occupied_bits(cell_index(law.grid, ivec3(x, y, z)), count); bits != 0u; bits &= bits - 1u) {
                        ivec3 cell = ivec3(x + findLSB(bits), y, z);
                        meet_cell(at_m, velocity_mps, pull_mps2, elapsed_s, cell, asks_deep, hit, deep_m);
                    }
                }
            }
        }
    }
    return hit;
}
