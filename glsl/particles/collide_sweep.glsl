// The first plane that a particle meets on a parabola: pieces of it no longer than a cell, in their order; of each piece the
// cells that its box touches, unless `near` says at one look that all are empty; of each occupied cell the planes whose extent the
// box touches. A plane counts only where the foot of the particle on it is where the plane stands for triangles of its cell, so
// planes end where those do.

const float NEVER_S = 3.0e38;
const float MOST_PIECES = 4096.0;

// A parabola, and when in the time of the cells it begins.
struct Leg {
    vec3 at_m;
    vec3 velocity_mps;
    vec3 pull_mps2;
    float elapsed_s;
    float left_s;  // until the step ends
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

// Where a plane is felt: in a cell, an extent.
struct Window {
    vec3 centre_m;
    uint extent;
};

// Whether a plane is there, at `foot_m` from the middle of its window.
bool is_there(vec3 foot_m, Window window) { return is_in_extent(window.extent, foot_m, law.grid.cell_m); }

// Whether the foot of the particle on a plane can come into a cell during the leg, which sees it go from `from_m` to `to_m`: of
// the planes of a flat wall, one a cell, that leaves those whose cells it does come to. Wider than `is_there` by what
// rounding does.
bool may_enter(vec3 from_m, vec3 to_m, vec3 bulge_m) {
    vec3 reach = vec3((FELT_HALF + 2.0 * RIM) * law.grid.cell_m) + 0.25 * abs(bulge_m);
    return all(lessThanEqual(min(from_m, to_m), reach)) && all(greaterThanEqual(max(from_m, to_m), -reach));
}

// The plane of the cell with its centre at `centre_m`, in its window: `hit`, if it is met before that. At the start of a step it
// also asks whether the particle lies in it.
void meet(Leg leg, uint plane, vec3 centre_m, Window window, bool asks_deep, inout Hit hit, inout bool is_deep) {
    vec3 front = planes[plane].normal, u = velocity_of(plane);
    precise vec3 from_centre = leg.at_m - (centre_m + u * leg.elapsed_s);
    precise float along = dotted(front, from_centre) + planes[plane].distance_m;
    vec3 n = along < 0.0 ? -front : front;  // both sides are solid
    float d = abs(along), radius = law.radius_m, slack = law.slack_m;
    precise vec3 seen = leg.velocity_mps - u;
    float w = dotted(n, seen), a = dotted(n, leg.pull_mps2);
    precise float shallow = radius - slack;
    bool may_be_deep = asks_deep && d < shallow;
    // How low it comes: most do not come near, and are asked no more.
    float until = leg.left_s;
    if (a > 0.0 && w < 0.0) until = min(until, -w / a);
    precise float lowest = d + (w * until + a * (0.5 * until * until));
    precise float deeper = d - 0.1 * slack;
    bool is_near = lowest < (d < shallow ? deeper : shallow);
    if (!is_near && !may_be_deep) return;
    precise vec3 from_window = leg.at_m - (window.centre_m + u * leg.elapsed_s);
    precise vec3 start = from_window - n * d;
    vec3 way = (seen - n * w) * leg.left_s, bulge = (leg.pull_mps2 - n * a) * (0.5 * leg.left_s * leg.left_s);
    if (!may_enter(start, start + way + bulge, bulge)) return;
    if (may_be_deep && is_there(start, window)) is_deep = true;
    if (!is_near) return;
    // Where it touches; where it is half in, or its centre would go through: over a rim it comes too late to touch.
    for (uint level = 0u; level < 3u; ++level) {
        precise float above = d - radius * (1.0 - 0.5 * float(level));
        float after = fall_s(above, w, a);
        if (!(after < hit.after_s)) return;
        precise float then = d + (w * after + a * (0.5 * after * after));
        precise vec3 foot = (from_window + (seen * after + leg.pull_mps2 * (0.5 * after * after))) - n * then;
        if (!is_there(foot, window)) continue;
        if (level == 2u) {  // before it, on this side
            after = min(after, fall_s(d - min(slack, d), w, a));
            precise float before = d + (w * after + a * (0.5 * after * after));
            then = before;
        }
        hit = Hit(after, then, along < 0.0 ? plane | IS_BACK : plane);
        return;
    }
}

// What of an occupied cell may be felt by one who comes through a box. Most planes that are not felt are so left out before any is read.
Met met_in_box(ivec3 cell, Box box) {
    Met met = met_of(law.grid, cell_index(law.grid, cell));
    // Of several planes, the first alone is left to stand for all there is.
    if (method == METHOD_ONE) met = Met(uvec3(met.extents.x | met.extents.y | met.extents.z, 0u, 0u), 1u);
    vec3 centre = vec3(cell) + 0.5;
    return met_where(met, extent_of(box.low - centre, box.high - centre));
}

// Cells of a box that are looked at together: 2 x 2 rows of 8, a bit each, x counting fastest, and whose bits are read at once.
const ivec3 BLOCK_CELLS = ivec3(8, 2, 2);

ivec3 cell_in_block(ivec3 block, uint bit) { return block + ivec3(bit & 7u, bit >> 3u & 1u, bit >> 4u); }

uint occupied_in_block(ivec3 block, Box box) {
    uint count = uint(min(box.last.x - block.x + 1, 8)), cells = 0u;
    [[unroll]] for (int row = 0; row < 4; ++row) {
        ivec3 cell = block + ivec3(0, row & 1, row >> 1);
        if (cell.y <= box.last.y && cell.z <= box.last.z) cells |= occupied_bits(cell_index(law.grid, cell), count) << (8 * row);
    }
    return cells;
}

// The next block of a box: x counts fastest. After the last, `z` is beyond the box.
void to_next_block(inout ivec3 block, Box box) {
    block.x += BLOCK_CELLS.x;
    if (block.x > box.last.x) {
        block.x = box.first.x;
        block.y += BLOCK_CELLS.y;
    }
    if (block.y > box.last.y) {
        block.y = box.first.y;
        block.z += BLOCK_CELLS.z;
    }
}

// All planes of the occupied cells of a box.
void meet_box(Leg leg, Box box, bool asks_deep, inout Hit hit, inout bool is_deep) {
    for (ivec3 block = box.first; block.z <= box.last.z; to_next_block(block, box)) {
        for (uint cells = occupied_in_block(block, box); cells != 0u; cells &= cells - 1u) {
            ivec3 cell = cell_in_block(block, uint(findLSB(cells)));
            Met met = met_in_box(cell, box);
            for (uint left = met.planes; left != 0u; left &= left - 1u) {
                uint k = uint(findLSB(left));
                ivec3 stored = cell_of_met(cell, k);
                uint plane = 2u * cell_index(law.grid, stored) + (k & 1u);
                Window window = Window(cell_centre_m(law.grid, cell), extent_of_met(met, k));
                meet(leg, plane, cell_centre_m(law.grid, stored), window, asks_deep, hit, is_deep);
            }
        }
    }
}

// How far it lies in the planes of a box, which move it out one after the other. Few ask: kept out of the
// loop that all go through.
vec3 depth_in(Leg leg, Box box) {
    vec3 deep_m = vec3(0.0);
    for (ivec3 block = box.first; block.z <= box.last.z; to_next_block(block, box)) {
        for (uint cells = occupied_in_block(block, box); cells != 0u; cells &= cells - 1u) {
            ivec3 cell = cell_in_block(block, uint(findLSB(cells)));
            Met met = met_in_box(cell, box);
            for (uint left = met.planes; left != 0u; left &= left - 1u) {
                uint k = uint(findLSB(left));
                ivec3 stored = cell_of_met(cell, k);
                uint plane = 2u * cell_index(law.grid, stored) + (k & 1u);
                vec3 front = planes[plane].normal, u = velocity_of(plane);
                precise vec3 from_centre = leg.at_m - (cell_centre_m(law.grid, stored) + u * leg.elapsed_s);
                precise float along = dotted(front, from_centre) + planes[plane].distance_m;
                vec3 n = along < 0.0 ? -front : front;
                float d = abs(along);
                precise float more = (law.radius_m - d) - dotted(deep_m, n);
                precise float shallow = law.radius_m - law.slack_m;
                if (!(d < shallow) || !(more > 0.0)) continue;
                Window window = Window(cell_centre_m(law.grid, cell), extent_of_met(met, k));
                precise vec3 foot = (leg.at_m - (window.centre_m + u * leg.elapsed_s)) - n * d;
                if (!is_there(foot, window)) continue;
                precise vec3 sum = deep_m + n * more;
                deep_m = sum;
            }
        }
    }
    return deep_m;
}

// At the start of a step it asks how far the particle lies in planes, `deep_m`: if it does, no hit counts.
Hit first_hit(Leg leg, bool asks_deep, out vec3 deep_m) {
    deep_m = vec3(0.0);
    float left_s = leg.left_s;
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
        Box box = box_of(moved(leg.at_m, leg.velocity_mps, leg.pull_mps2, from_s),
                         moved(leg.at_m, leg.velocity_mps, leg.pull_mps2, to_s), pad);
        int room = room_of(box);
        if (room >= 0) {
            piece += float(room);  // no piece is longer than a cell
            continue;
        }
        bool is_deep = false;
        meet_box(leg, box, asks_deep && piece == 0.0, hit, is_deep);
        if (is_deep) {
            deep_m = depth_in(leg, box);
            break;
        }
    }
    return hit;
}
