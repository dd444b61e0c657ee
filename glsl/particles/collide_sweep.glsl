// The first plane that a particle meets on a parabola: pieces of it no longer than a cell, in their order; of each piece the
// cells that its box touches, unless `near` says at one look that all are empty; of each occupied cell its planes. A plane
// counts only where the foot of the particle on it is in its cell, and on the side of the cell's other planes on which it
// goes on, so planes end with their triangles' cells and at edges.

const float NEVER_S = 3.0e38;
const float MOST_PIECES = 4096.0;
const float RIM = 1.0e-3;  // of a cell: cells are closed, and feet on a face of theirs are rounded

// A parabola, and when in the time of the cells it begins.
struct Leg {
    vec3 at_m;
    vec3 velocity_mps;
    vec3 pull_mps2;
    float elapsed_s;
};

// What is met. Of the plane only the number: who needs it loads it again, rather than carry it through all loops.
struct Hit {
    float after_s;     // from the start of the leg
    float distance_m;  // of the particle from the plane then: less than the radius if it came over a rim
    uint plane;        // number in `planes`; with IS_BACK the particle is behind it
};

const uint NO_PLANE = 0xffffffffu;
const uint IS_BACK = 0x80000000u;

// Towards the particle.
vec3 normal_of(uint plane) {
    vec3 n = planes[plane & ~IS_BACK].normal;
    return (plane & IS_BACK) != 0u ? -n : n;
}

vec3 velocity_of(uint plane) { return law.surface_mps > 0.0 ? planes[plane & ~IS_BACK].velocity_mps : vec3(0.0); }

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

// The cells of the grid that the way between two places, `pad_m` wide, touches; none: `first` is beyond `last`.
void cells_of_way(vec3 from_m, vec3 to_m, vec3 pad_m, out ivec3 first, out ivec3 last) {
    precise vec3 low = min(from_m, to_m) - pad_m;
    precise vec3 high = max(from_m, to_m) + pad_m;
    vec3 most = vec3(grid_cells(law.grid));
    first = ivec3(clamp(floor(cell_place(law.grid, low)), vec3(0.0), most));
    last = ivec3(clamp(floor(cell_place(law.grid, high)), vec3(-1.0), most - 1.0));
}

// By how many cells the box may move before it can touch an occupied one; -1: it touches one, or so it seems.
int room_of(ivec3 first, ivec3 last) {
    if (any(greaterThan(first, last))) return 0;
    ivec3 middle = (first + last) >> 1;
    ivec3 out_of = max(middle - first, last - middle);
    return gap_at(cell_index(law.grid, middle)) - 1 - max(max(out_of.x, out_of.y), out_of.z);
}

// Whether nothing can be in the way of a particle that goes to `to_m`: one look at `near`.
bool flies_freely(vec3 from_m, vec3 to_m, vec3 pull_mps2, float dt_s) {
    precise vec3 pad = vec3(padding_m(dt_s, elapsed_at(dt_s))) + abs(pull_mps2) * (0.125 * dt_s * dt_s);
    ivec3 first, last;
    cells_of_way(from_m, to_m, pad, first, last);
    return room_of(first, last) >= 0;
}

bool is_in_cell(vec3 from_centre_m) {
    return all(lessThanEqual(abs(from_centre_m), vec3((0.5 + RIM) * law.grid.cell_m)));
}

const float BEYOND = 0.1;  // of a cell: so far over an edge a plane is still felt

bool is_on_side(vec3 foot_m, uint plane, uint side) {
    if (side == 0u) return true;
    precise float over = dotted(planes[plane].normal, foot_m) + planes[plane].distance_m;
    return (side == IS_BEHIND ? over : -over) <= BEYOND * law.grid.cell_m;
}

// Whether a plane is there, at `foot_m` from the middle of the cell `home`: `sides` says where it goes on.
bool is_there(vec3 foot_m, uint home, uint sides) {
    return is_in_cell(foot_m) && is_on_side(foot_m, 2u * home, sides & 3u)
        && is_on_side(foot_m, 2u * home + 1u, sides >> 2u);
}

// The plane of the cell with its centre at `centre_m`, where it is felt in the cell `home` at `window_m`. `deep_m` adds up what the
// particle lies in planes at the start, if it is asked for.
void meet(Leg leg, uint plane, vec3 centre_m, vec3 window_m, uint home, uint sides, bool asks_deep, inout Hit hit,
          inout vec3 deep_m) {
    vec3 front = planes[plane].normal, u = velocity_of(plane);
    precise vec3 from_centre = leg.at_m - (centre_m + u * leg.elapsed_s);
    precise float along = dotted(front, from_centre) + planes[plane].distance_m;
    vec3 n = along < 0.0 ? -front : front;  // both sides are solid
    float d = abs(along), radius = law.radius_m, slack = law.slack_m;
    precise vec3 seen = leg.velocity_mps - u;
    float w = dotted(n, seen), a = dotted(n, leg.pull_mps2);
    precise vec3 from_window = leg.at_m - (window_m + u * leg.elapsed_s);
    precise float shallow = radius - slack;
    if (asks_deep && d < shallow) {
        precise vec3 foot = from_window - n * d;
        precise float more = (radius - d) - dotted(deep_m, n);
        if (more > 0.0 && is_there(foot, home, sides)) {
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
        precise vec3 foot = (from_window + (seen * after + leg.pull_mps2 * (0.5 * after * after))) - n * then;
        if (!is_there(foot, home, sides)) continue;
        if (level == 2u) {  // before it, on this side
            after = min(after, fall_s(d - min(slack, d), w, a));
            precise float before = d + (w * after + a * (0.5 * after * after));
            then = before;
        }
        hit = Hit(after, then, along < 0.0 ? plane | IS_BACK : plane);
        return;
    }
}

// All planes of the occupied cells of a box.
void meet_box(Leg leg, ivec3 first, ivec3 last, bool asks_deep, inout Hit hit, inout vec3 deep_m) {
    for (int z = first.z; z <= last.z; ++z) {
        for (int y = first.y; y <= last.y; ++y) {
            for (int x = first.x; x <= last.x; x += 32) {
                uint count = uint(min(last.x - x + 1, 32));
                for (uint cells = occupied_bits(cell_index(law.grid, ivec3(x, y, z)), count); cells != 0u; cells &= cells - 1u) {
                    ivec3 cell = ivec3(x + findLSB(cells), y, z);
                    uint home = cell_index(law.grid, cell);
                    uvec2 known = ONLY_ONE;
                    if (method == METHOD_TWO) known = known_at(law.grid, home);
                    for (uint met = met_of(known); met != 0u; met &= met - 1u) {
                        uint k = uint(findLSB(met));
                        ivec3 stored = cell_of_met(cell, k);
                        vec3 centre = cell_centre_m(law.grid, stored), window = cell_centre_m(law.grid, cell);
                        uint plane = 2u * cell_index(law.grid, stored) + (k & 1u);
                        meet(leg, plane, centre, window, home, sides_of(known, k), asks_deep, hit, deep_m);
                    }
                }
            }
        }
    }
}

Hit first_hit(Leg leg, float left_s, bool asks_deep, inout vec3 deep_m) {
    Hit hit = Hit(left_s, 0.0, NO_PLANE);
    precise vec3 fastest = abs(leg.velocity_mps) + abs(leg.pull_mps2) * left_s;
    precise float cells = max(max(fastest.x, fastest.y), fastest.z) * left_s / law.grid.cell_m;
    if (!(cells < NEVER_S)) return hit;  // no number: the pool ends it
    float pieces = clamp(ceil(cells), 1.0, MOST_PIECES);
    precise float piece_s = left_s / pieces;
    precise vec3 pad =
        vec3(padding_m(left_s, leg.elapsed_s)) + abs(leg.pull_mps2) * (0.125 * piece_s * piece_s);
    for (float piece = 0.0; piece < pieces; piece += 1.0) {
        precise float from_s = piece_s * piece;
        precise float to_s = piece_s * (piece + 1.0);
        if (hit.after_s <= from_s) break;
        ivec3 first, last;
        cells_of_way(moved(leg.at_m, leg.velocity_mps, leg.pull_mps2, from_s),
                     moved(leg.at_m, leg.velocity_mps, leg.pull_mps2, to_s), pad, first, last);
        int room = room_of(first, last);
        if (room < 0) meet_box(leg, first, last, asks_deep, hit, deep_m);
        else piece += float(room);  // no piece is longer than a cell
    }
    return hit;
}
